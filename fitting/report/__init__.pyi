"""Files written whole: JSON, PNG, TIFF, HTML."""

from fitting.report import output as output
from fitting.report import png as png
from fitting.report import tiff as tiff
from fitting.report.html import page as page

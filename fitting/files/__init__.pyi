"""Files written whole: JSON, PNG, TIFF, HTML."""

from fitting.files import output as output
from fitting.files import png as png
from fitting.files import tiff as tiff
from fitting.files.html import page as page

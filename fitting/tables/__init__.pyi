"""The verb `rings`: radii from tables of ring readings; and `wedge`, from positions of straight fringes."""

from fitting.tables.comparison import compare as compare
from fitting.tables.comparison_result import Comparison as Comparison
from fitting.tables.orders import rings as rings
from fitting.tables.result import RingsResult as RingsResult
from fitting.tables.sources import is_table as is_table
from fitting.tables.sources import text_of as text_of
from fitting.tables.wedge_line import wedge as wedge
from fitting.tables.wedge_result import WedgeResult as WedgeResult

"""The verb `rings`: radii from tables of ring readings."""

from fitting.tables import orders as orders
from fitting.tables.orders import rings as rings
from fitting.tables.result import RingsResult as RingsResult

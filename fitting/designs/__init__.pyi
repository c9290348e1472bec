"""Benches that measure best."""

from fitting.designs.design_result import Design as Design
from fitting.designs.designs import design as design
from fitting.designs.job import with_field as with_field

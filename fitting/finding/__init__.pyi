"""Rings in a photograph without a start, and what speaks for them."""

from fitting.finding.evidence import evidence_of as evidence_of
from fitting.finding.matched_filter import Rings as Rings
from fitting.finding.matched_filter import polish as polish
from fitting.finding.matched_filter import search as search
from fitting.finding.start import find_rings as find_rings
from fitting.finding.start import follow as follow
from fitting.finding.start import settled as settled
from fitting.finding.view import box_of as box_of
from fitting.finding.view import plane_wave as plane_wave
from fitting.finding.view import view_of as view_of

"""Rings in the channels of a colour photograph: one geometry, and for each channel the waveform of its light."""

from fitting.colour.colour_reasons import ColourReason as ColourReason
from fitting.colour.distortion import Distortion as Distortion
from fitting.colour.evidence import BANDS_ALONE as BANDS_ALONE
from fitting.colour.evidence import ONE_LINE as ONE_LINE
from fitting.colour.evidence import odds_of_lamps as odds_of_lamps
from fitting.colour.given_fit import misfit as misfit
from fitting.colour.given_light import Curves as Curves
from fitting.colour.images import fitted_images as fitted_images
from fitting.colour.measuring import ColourFit as ColourFit
from fitting.colour.measuring import Rings1D as Rings1D
from fitting.colour.measuring import gap_at_centre as gap_at_centre
from fitting.colour.measuring import measure as measure
from fitting.colour.measuring import rings_in as rings_in
from fitting.colour.palette import Lines as Lines
from fitting.colour.palette import lamp_of_line as lamp_of_line
from fitting.colour.palette import lines_of as lines_of
from fitting.colour.unknown_fit import SharedFit as SharedFit
from fitting.colour.unknown_fit import fit_unknown_light as fit_unknown_light
from fitting.colour.waveform import COLOURS as COLOURS

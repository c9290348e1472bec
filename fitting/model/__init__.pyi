"""From numbers to the phase of the fringes."""

from fitting.model import gap_phase as gap_phase
from fitting.model.basis import BACKGROUND as BACKGROUND
from fitting.model.basis import ENVELOPE as ENVELOPE
from fitting.model.basis import ENVELOPE_NODES as ENVELOPE_NODES
from fitting.model.basis import degrees as degrees
from fitting.model.basis import model_coefficients as model_coefficients
from fitting.model.bench_start import scene_start as scene_start
from fitting.model.microscope import Microscope as Microscope
from fitting.model.microscope import microscope_on as microscope_on
from fitting.model.parts import ADVICE as ADVICE
from fitting.model.parts import EDGES as EDGES
from fitting.model.parts import LEAVING_OUT as LEAVING_OUT
from fitting.model.parts import PARTS as PARTS
from fitting.model.parts import PRICES as PRICES
from fitting.model.parts import SEARCHED as SEARCHED
from fitting.model.parts import WARPS as WARPS
from fitting.model.parts import free_numbers as free_numbers
from fitting.model.parts import numbers_of as numbers_of
from fitting.model.phase import GapModel as GapModel
from fitting.model.phase import SceneModel as SceneModel
from fitting.model.phase import as_arrays as as_arrays
from fitting.model.phase import localize as localize
from fitting.model.phase import shown_of as shown_of
from fitting.model.warp import Distance as Distance
from fitting.model.warp import Frame as Frame

"""newtonjax: a differentiable simulator of Newton's rings and other fringes of equal thickness."""

from newtonjax.benches import air_wedge as air_wedge
from newtonjax.benches import load_scene as load_scene
from newtonjax.benches import newton_rings as newton_rings
from newtonjax.benches import save_scene as save_scene
from newtonjax.fields import meeting_height as meeting_height
from newtonjax.methods import Chebyshev as Chebyshev
from newtonjax.methods import ClosedForm as ClosedForm
from newtonjax.methods import Splat as Splat
from newtonjax.methods import Traced as Traced
from newtonjax.methods import splat as splat
from newtonjax.methods import spread as spread
from newtonjax.numerics import cos_turns as cos_turns
from newtonjax.numerics import sin_turns as sin_turns
from newtonjax.planning import Plan as Plan
from newtonjax.planning import PlanReason as PlanReason
from newtonjax.planning import plan as plan
from newtonjax.scene import Beam as Beam
from newtonjax.scene import Camera as Camera
from newtonjax.scene import CollectingLens as CollectingLens
from newtonjax.scene import Light as Light
from newtonjax.scene import Response as Response
from newtonjax.scene import Scene as Scene
from newtonjax.scene import Shield as Shield
from newtonjax.scene import Spectrum as Spectrum
from newtonjax.scene import Surface as Surface
from newtonjax.scene import black_body as black_body
from newtonjax.scene import choose_beams as choose_beams
from newtonjax.scene import cie_1931 as cie_1931
from newtonjax.scene import enumerate_beams as enumerate_beams
from newtonjax.scene import illuminant as illuminant
from newtonjax.scene import lamp as lamp
from newtonjax.scene import sampled_spectrum as sampled_spectrum
from newtonjax.scene import spectral_line as spectral_line
from newtonjax.scene import to_srgb as to_srgb
from newtonjax.verbs import Blocks as Blocks
from newtonjax.verbs import Explanation as Explanation
from newtonjax.verbs import NormalEquations as NormalEquations
from newtonjax.verbs import Omission as Omission
from newtonjax.verbs import blocks as blocks
from newtonjax.verbs import explain as explain
from newtonjax.verbs import normal_equations as normal_equations
from newtonjax.verbs import opd as opd
from newtonjax.verbs import render as render
from newtonjax.verbs import sweep as sweep

__version__: str

"""One ray, one beam, one point of the screen."""

from newtonjax.rays.aiming import Arrival as Arrival
from newtonjax.rays.aiming import arrive as arrive
from newtonjax.rays.aiming import arrive_all as arrive_all
from newtonjax.rays.aiming import arrive_without_derivative as arrive_without_derivative
from newtonjax.rays.aiming import is_small as is_small
from newtonjax.rays.fresnel import amplitudes as amplitudes
from newtonjax.rays.tracing import Landing as Landing
from newtonjax.rays.tracing import Leg as Leg
from newtonjax.rays.tracing import Ray as Ray
from newtonjax.rays.tracing import Route as Route
from newtonjax.rays.tracing import Setting as Setting
from newtonjax.rays.tracing import carry_field as carry_field
from newtonjax.rays.tracing import gather as gather
from newtonjax.rays.tracing import interact as interact
from newtonjax.rays.tracing import land as land
from newtonjax.rays.tracing import launched_field as launched_field
from newtonjax.rays.tracing import reflected as reflected
from newtonjax.rays.tracing import towards as towards
from newtonjax.rays.tracing import trace as trace
from newtonjax.rays.tracing import transmitted as transmitted
from newtonjax.rays.tube import foci as foci
from newtonjax.rays.wavefront import launched as launched

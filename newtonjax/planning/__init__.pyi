"""Which way to an image, and what it costs."""

from newtonjax.planning.cost import predicted_seconds as predicted_seconds
from newtonjax.planning.faces import end_warnings as end_warnings
from newtonjax.planning.planning import Plan as Plan
from newtonjax.planning.planning import beam_amplitudes as beam_amplitudes
from newtonjax.planning.planning import plan as plan
from newtonjax.planning.planning import planned as planned
from newtonjax.planning.reasons import PlanReason as PlanReason

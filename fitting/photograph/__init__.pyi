"""The verb `fit`, and stacks: choose, judge, report."""

from fitting.photograph.expected import expected_rings as expected_rings
from fitting.photograph.frame_fit import FrameFit as FrameFit
from fitting.photograph.measure import fit as fit
from fitting.photograph.result import FitResult as FitResult
from fitting.photograph.stack import fit_stack as fit_stack
from fitting.photograph.together import fit_together as fit_together
from fitting.photograph.together import ratio as ratio
from fitting.photograph.together_result import Together as Together

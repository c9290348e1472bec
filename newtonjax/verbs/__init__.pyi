"""What a user calls on a scene and a camera."""

from newtonjax.verbs.explaining import Explanation as Explanation
from newtonjax.verbs.explaining import explain as explain
from newtonjax.verbs.light_parts import Omission as Omission
from newtonjax.verbs.normal import NormalEquations as NormalEquations
from newtonjax.verbs.normal import from_changes as from_changes
from newtonjax.verbs.normal import normal_equations as normal_equations
from newtonjax.verbs.normal import with_changes as with_changes
from newtonjax.verbs.rendering import opd as opd
from newtonjax.verbs.rendering import render as render
from newtonjax.verbs.row_blocks import Blocks as Blocks
from newtonjax.verbs.row_blocks import blocks as blocks
from newtonjax.verbs.sweeping import sweep as sweep

"""Ways to an image, each with what it honours and what it errs by."""

from newtonjax.methods.base import PASS_PIXELS as PASS_PIXELS
from newtonjax.methods.base import AbstractMethod as AbstractMethod
from newtonjax.methods.base import is_single as is_single
from newtonjax.methods.base import require_method as require_method
from newtonjax.methods.base import require_two_beams as require_two_beams
from newtonjax.methods.base import unreached as unreached
from newtonjax.methods.closed_form import ClosedForm as ClosedForm
from newtonjax.methods.error_of_means import means_error as means_error
from newtonjax.methods.gap_paths import of_points as of_points
from newtonjax.methods.gap_paths import parallel as parallel
from newtonjax.methods.many_beams import change_by_orders as change_by_orders
from newtonjax.methods.many_wavelengths import has_channels as has_channels
from newtonjax.methods.many_wavelengths import one_line as one_line
from newtonjax.methods.nodes import Chebyshev as Chebyshev
from newtonjax.methods.over_source import OverSource as OverSource
from newtonjax.methods.pictures import AbstractPicture as AbstractPicture
from newtonjax.methods.source_directions import ORDERS as ORDERS
from newtonjax.methods.source_directions import error_between_directions as error_between_directions
from newtonjax.methods.source_directions import error_of_profile as error_of_profile
from newtonjax.methods.source_directions import summed_at_nodes as summed_at_nodes
from newtonjax.methods.splatting import Splat as Splat
from newtonjax.methods.splatting import Splatted as Splatted
from newtonjax.methods.splatting import splat as splat
from newtonjax.methods.splatting import spread as spread
from newtonjax.methods.splatting import why_unpaired as why_unpaired
from newtonjax.methods.traced import Traced as Traced

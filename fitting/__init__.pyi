"""fitting: the layer that turns an image of rings into a lens radius with a standard deviation."""

from fitting.designs import Design as Design
from fitting.designs import design as design
from fitting.photo import Photograph as Photograph
from fitting.photo import read as read
from fitting.photograph import FitResult as FitResult
from fitting.photograph import FrameFit as FrameFit
from fitting.photograph import Parameter as Parameter
from fitting.photograph import fit as fit
from fitting.photograph import fit_stack as fit_stack
from fitting.reticle import Scale as Scale
from fitting.reticle import scale as scale
from fitting.sampling import Chain as Chain
from fitting.sampling import sample as sample
from fitting.studies import Information as Information
from fitting.studies import Measurement as Measurement
from fitting.studies import Sensitivity as Sensitivity
from fitting.studies import Spread as Spread
from fitting.studies import Tradeoff as Tradeoff
from fitting.studies import derivative_images as derivative_images
from fitting.studies import information as information
from fitting.studies import measurement as measurement
from fitting.studies import sensitivity as sensitivity
from fitting.studies import spread as spread
from fitting.studies import tradeoff as tradeoff
from fitting.tables import RingsResult as RingsResult
from fitting.tables import rings as rings

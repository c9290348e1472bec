"""What an image would determine of a bench: information, sensitivity, spread, speed; the bench that measures best."""

from fitting.studies.design_job import with_field as with_field
from fitting.studies.design_result import Design as Design
from fitting.studies.designs import design as design
from fitting.studies.fisher import information as information
from fitting.studies.implicit import Measurement as Measurement
from fitting.studies.implicit import measurement as measurement
from fitting.studies.information_result import Information as Information
from fitting.studies.refusal import exit_status as exit_status
from fitting.studies.sensitivities import derivative_images as derivative_images
from fitting.studies.sensitivities import sensitivity as sensitivity
from fitting.studies.sensitivity_result import Sensitivity as Sensitivity
from fitting.studies.sobol import check_spread as check_spread
from fitting.studies.sobol import spread as spread
from fitting.studies.spread_result import Spread as Spread
from fitting.studies.timing import tradeoff as tradeoff
from fitting.studies.tradeoff_result import Tradeoff as Tradeoff

"""What an image would determine of a bench: information, sensitivity, spread, speed."""

from fitting.studies.bench_origin import says_its_bench as says_its_bench
from fitting.studies.electrons import Moves as Moves
from fitting.studies.electrons import moved as moved
from fitting.studies.electrons import tables as tables
from fitting.studies.fisher import information as information
from fitting.studies.implicit import Measurement as Measurement
from fitting.studies.implicit import measurement as measurement
from fitting.studies.information_result import Information as Information
from fitting.studies.refusal import UndeterminedError as UndeterminedError
from fitting.studies.refusal import exit_status as exit_status
from fitting.studies.sensitivities import derivative_images as derivative_images
from fitting.studies.sensitivities import sensitivity as sensitivity
from fitting.studies.sensitivity_result import Sensitivity as Sensitivity
from fitting.studies.sobol import check_spread as check_spread
from fitting.studies.sobol import spread as spread
from fitting.studies.spread_result import Spread as Spread
from fitting.studies.timing import tradeoff as tradeoff
from fitting.studies.tradeoff_result import Tradeoff as Tradeoff

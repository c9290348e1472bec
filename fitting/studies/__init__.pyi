"""What a bench would tell: information, sensitivity, spread, speed."""

from fitting.studies.electrons import Moves as Moves
from fitting.studies.electrons import moved as moved
from fitting.studies.electrons import tables as tables
from fitting.studies.fisher import FREE as FREE
from fitting.studies.fisher import Information as Information
from fitting.studies.fisher import information as information
from fitting.studies.implicit import measurement as measurement
from fitting.studies.refusal import UndeterminedError as UndeterminedError
from fitting.studies.refusal import exit_status as exit_status
from fitting.studies.sensitivities import Sensitivity as Sensitivity
from fitting.studies.sensitivities import derivative_images as derivative_images
from fitting.studies.sensitivities import free_beside as free_beside
from fitting.studies.sensitivities import sensitivity as sensitivity
from fitting.studies.sobol import Spread as Spread
from fitting.studies.sobol import errors as errors
from fitting.studies.sobol import spread as spread
from fitting.studies.timing import Way as Way
from fitting.studies.timing import tradeoff as tradeoff

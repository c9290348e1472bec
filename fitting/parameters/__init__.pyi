"""The numbers of a bench and of a photograph by name, and what may be given of them."""

from fitting.parameters.bench import Knob as Knob
from fitting.parameters.bench import change as change
from fitting.parameters.bench import chosen as chosen
from fitting.parameters.bench import curved_surface as curved_surface
from fitting.parameters.bench import knobs as knobs
from fitting.parameters.bench import quantities_of as quantities_of
from fitting.parameters.bench import raise_lens as raise_lens
from fitting.parameters.bench import still as still
from fitting.parameters.blas import one_blas_thread as one_blas_thread
from fitting.parameters.fringe_scale import EXPONENTS as EXPONENTS
from fitting.parameters.fringe_scale import Quantities as Quantities
from fitting.parameters.fringe_scale import check_deviation as check_deviation
from fitting.parameters.fringe_scale import check_quantity as check_quantity
from fitting.parameters.fringe_scale import checked_fixed as checked_fixed
from fitting.parameters.fringe_scale import checked_plate as checked_plate
from fitting.parameters.fringe_scale import checked_start as checked_start
from fitting.parameters.fringe_scale import held_turns as held_turns
from fitting.parameters.fringe_scale import lensless as lensless
from fitting.parameters.fringe_scale import number as number
from fitting.parameters.fringe_scale import quantities as quantities
from fitting.parameters.known import Known as Known
from fitting.parameters.known import deviation as deviation
from fitting.parameters.known import require_held as require_held

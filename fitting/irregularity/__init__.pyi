"""The verb `form`: from one picture of fringes to the form of a surface."""

from fitting.irregularity.measuring import form as form
from fitting.irregularity.result import Form as Form

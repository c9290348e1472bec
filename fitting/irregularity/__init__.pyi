"""The verb `form`: from one picture of fringes to the form of a surface."""

from fitting.irregularity.measuring import form as form
from fitting.irregularity.plate_measuring import plate_test as plate_test
from fitting.irregularity.plate_result import PlateTest as PlateTest
from fitting.irregularity.result import Form as Form
from fitting.irregularity.wedge_measuring import wedge_photo as wedge_photo
from fitting.irregularity.wedge_photo_result import WedgePhoto as WedgePhoto

"""From a file to light, mask and block means."""

from fitting.photo.frames import frames_of as frames_of
from fitting.photo.reading import Photograph as Photograph
from fitting.photo.reading import read as read
from fitting.photo.reading import read_again as read_again
from fitting.photo.reduction import DEGREES as DEGREES
from fitting.photo.reduction import NODES as NODES
from fitting.photo.reduction import Grid as Grid
from fitting.photo.reduction import Reduced as Reduced
from fitting.photo.reduction import block_size as block_size
from fitting.photo.reduction import reduce as reduce
from fitting.photo.smoothing import block_means as block_means
from fitting.photo.smoothing import flatten as flatten
from fitting.photo.smoothing import median as median
from fitting.photo.smoothing import noise_variance as noise_variance
from fitting.photo.smoothing import pixels_of as pixels_of
from fitting.photo.smoothing import taper as taper
from fitting.photo.smoothing import thin as thin

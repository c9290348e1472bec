"""From a file to light, mask and block means; and rings in it without a start, and what speaks for them."""

from fitting.photo.evidence import evidence_of as evidence_of
from fitting.photo.frames import frames_of as frames_of
from fitting.photo.matched_filter import Rings as Rings
from fitting.photo.matched_filter import polish as polish
from fitting.photo.matched_filter import search as search
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
from fitting.photo.smoothing import thin as thin
from fitting.photo.start import find_rings as find_rings
from fitting.photo.start import follow as follow
from fitting.photo.start import settled as settled
from fitting.photo.view import box_of as box_of
from fitting.photo.view import plane_wave as plane_wave
from fitting.photo.view import view_of as view_of

"""Ready scenes, and scenes in TOML files."""

from newtonjax.benches.arguments import ARGUMENTS as ARGUMENTS
from newtonjax.benches.arguments import Argument as Argument
from newtonjax.benches.lens_on_plate import air_wedge as air_wedge
from newtonjax.benches.lens_on_plate import newton_rings as newton_rings
from newtonjax.benches.toml_files import load_scene as load_scene
from newtonjax.benches.toml_files import save_scene as save_scene
from newtonjax.benches.toml_files import scene_from_text as scene_from_text
from newtonjax.benches.toml_files import scene_text as scene_text

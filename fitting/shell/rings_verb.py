"""The verb `rings`: from a table of ring readings, or of straight fringes, to an answer on the screen and in files."""

from pathlib import Path

import fitting
from fitting.shell.answer import Outputs
from fitting.tables import readings

# What a wedge takes of the options, by its own name.
_OF_WEDGE = {"wedge_length": "length", "wedge_length_sd": "length_sd"}
_COMMON = ("wavelength", "wavelength_sd", "gap_index", "gap_index_sd", "columns")


def run(table: Path, options: dict, outputs: Outputs) -> int:
    """Fit the line, report, write; the exit status."""
    if not table.is_file():
        raise FileNotFoundError(f"{table} is not a file; give the path of a table of ring readings (CSV with a header)")
    outputs.check((table,))
    is_wedge = readings(table, options["columns"]).is_wedge
    of_wedge = {_OF_WEDGE[name]: options.pop(name) for name in _OF_WEDGE}
    if not is_wedge:
        if of_wedge["length"] is not None:
            raise ValueError("--wedge-length goes with positions of straight fringes (position_mm); leave it out")
        return outputs.write(fitting.rings(table, **options))
    if options["wavelength"] is None:
        raise ValueError("positions of straight fringes give the wedge's angle by the wavelength; give --wavelength")
    refused = [name for name in ("pixel_size", "radius", "expected_radius") if options[name] is not None]
    if refused or options["bright"] or options["view_angle"]:
        named = ", ".join(f"--{name.replace('_', '-')}" for name in refused) or "--bright and --view-angle"
        raise ValueError(f"{named}: not of straight fringes; leave it out")
    return outputs.write(fitting.wedge(table, **{name: options[name] for name in _COMMON}, **of_wedge))

"""The verb `rings`: from a table of ring readings to an answer on the screen and in files."""

from pathlib import Path

from fitting.shell.answer import Outputs
from fitting.tables import orders


def run(table: Path, options: dict, outputs: Outputs) -> int:
    """Fit the line, report, write; the exit status."""
    if not table.is_file():
        raise FileNotFoundError(f"{table} is not a file; give the path of a table of ring readings (CSV with a header)")
    outputs.check((table,))
    return outputs.write(orders.rings(table, **options))

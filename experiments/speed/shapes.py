"""Claim: an image of a lens with an asphere and 36 Zernike terms costs less than twice that of a sphere.

Images of 1024 x 1024 pixels on the same nodes, reflected rings with the screen at 1 mm: CPU time of an image of an
asphere with 36 Zernike terms over that of the sphere, at 9 x 9 and 17 x 17 nodes; programs that a bench of a new kind
compiles once another shape was there; CPU time of the first image of each in a fresh process, over `import jax`.

    python -m experiments.speed.shapes [--quick]
"""

import statistics
import subprocess
import sys
from time import process_time

import jax
import numpy as np

import newtonjax as nj
from experiments import records

TERMS = tuple(np.r_[np.zeros(3), 2e-8 * np.sin(np.arange(33.0))].tolist())
KINDS = {
    "sphere": {},
    "asphere and 36 Zernikes": {"conic": -1.0, "asphere": (1e3, 1e7), "zernike": TERMS, "zernike_radius": 5e-3},
    "toroid": {"radius_across": 1.1, "axis": 0.3},
    "cylinder": {"radius_across": np.inf},
    "odd asphere": {"odd_asphere": (0.3,)},
}
FIRST = """
import time, jax
begin = time.process_time()
import newtonjax as nj
nj.render(nj.newton_rings(1.0, 550e-9, screen=1e-3, **{words}), nj.Camera((64, 64), 60e-6)).block_until_ready()
print(time.process_time() - begin)
"""


def bench(kind: str) -> nj.Scene:
    return nj.newton_rings(1.0, 550e-9, screen=1e-3, **KINDS[kind])


def cpu_seconds(kinds: tuple[str, ...], nodes: int, side: int, rounds: int) -> dict[str, float]:
    """Medians of images taken in turns."""
    camera, method, times = nj.Camera((side, side), 4e-3 / side), nj.Chebyshev(nodes), {kind: [] for kind in kinds}
    for number in range(rounds + 1):
        for kind in kinds:
            begin = process_time()
            jax.block_until_ready(nj.render(bench(kind), camera, method))
            if number:
                times[kind].append(process_time() - begin)
    return {kind: statistics.median(values) for kind, values in times.items()}


def programs_of_new_kinds() -> int:
    """Compiled by benches of the kinds beyond the first two."""
    count = 0

    def listen(event: str, duration: float, **_) -> None:
        nonlocal count
        count += event == "/jax/core/compile/backend_compile_duration"
        del duration

    jax.monitoring.register_event_duration_secs_listener(listen)
    camera = nj.Camera((64, 64), 60e-6)
    nj.render(bench("asphere and 36 Zernikes"), camera, nj.Chebyshev(9))
    count = 0
    for kind in KINDS:
        if kind != "sphere":
            nj.render(bench(kind), camera, nj.Chebyshev(9))
    return count


def first_seconds(kind: str) -> float:
    program = FIRST.replace("{words}", repr(KINDS[kind]).replace("inf", "float('inf')"))
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return float(done.stdout)


def main(quick: bool) -> None:
    side, rounds = (256, 3) if quick else (1024, 41)
    kinds = ("sphere", "asphere and 36 Zernikes")
    table = {"programs_of_new_kinds": programs_of_new_kinds()}
    for nodes in (9, 17):
        seconds = cpu_seconds(kinds, nodes, side, rounds)
        table[f"ratio_{nodes}_nodes"] = seconds[kinds[1]] / seconds[kinds[0]]
        table[f"milliseconds_{nodes}_nodes"] = {kind: 1e3 * value for kind, value in seconds.items()}
    if not quick:
        table["first_image_seconds"] = {
            kind: statistics.median(first_seconds(kind) for _ in range(3)) for kind in kinds
        }
    print(table, flush=True)
    assert table["programs_of_new_kinds"] == 0
    assert quick or max(table["ratio_9_nodes"], table["ratio_17_nodes"]) < 2
    if not quick:
        records.save("shapes", table)


if __name__ == "__main__":
    main(records.arguments(__doc__, "256 x 256 pixels, nothing written").quick)

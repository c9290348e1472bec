"""What every experiment shares: its options, and the files that it leaves in experiments/results."""

import argparse
import json
import multiprocessing
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import jax

RESULTS = Path(__file__).parent / "results"


def arguments(doc: str, quick: str) -> argparse.Namespace:
    """The command line: `--quick` (what it leaves out). Sets float64."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help=quick)
    jax.config.update("jax_enable_x64", True)
    return parser.parse_args()


def clock(function) -> float:
    """Seconds that a call takes, its arrays computed."""
    begin = perf_counter()
    jax.block_until_ready(function())
    return perf_counter() - begin


def medians(functions: dict, rounds: int) -> dict:
    """Median seconds of each function by its name, taking turns, the first call (compilation included) apart."""
    for function in functions.values():
        clock(function)
    times = {name: [] for name in functions}
    for _ in range(rounds):
        for name, function in functions.items():
            times[name].append(clock(function))
    return {name: median(values) for name, values in times.items()}


def cpu_and_wall(functions: dict, rounds: int) -> tuple[dict, dict]:
    """Median CPU seconds, of all threads, and wall seconds of each function by its name, as `medians`."""
    for function in functions.values():
        clock(function)
    cpu, wall = ({name: [] for name in functions} for _ in range(2))
    for _ in range(rounds):
        for name, function in functions.items():
            begin = process_time()
            wall[name].append(clock(function))
            cpu[name].append(process_time() - begin)
    return tuple({name: median(values) for name, values in times.items()} for times in (cpu, wall))


def each(run: Callable, jobs: list, processes: int, chunk: int = 1) -> Iterator:
    """What `run` makes of each job: in this process if it is one, else in fresh ones, each on a core of its own."""
    if processes == 1:
        yield from map(run, jobs)
        return
    context = multiprocessing.get_context("spawn")
    queue = context.Queue()
    for core in range(processes):
        queue.put(core % os.cpu_count())
    with context.Pool(processes, initializer=_pin, initargs=(queue,)) as pool:
        yield from pool.imap_unordered(run, jobs, chunksize=chunk)


def _pin(queue) -> None:
    os.sched_setaffinity(0, {queue.get()})


def save(name: str, table, figure=None, dpi: int = 100) -> None:
    """Write NAME.json, and NAME.png where there is a figure."""
    RESULTS.mkdir(exist_ok=True)
    (RESULTS / f"{name}.json").write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    if figure is not None:
        figure.savefig(RESULTS / f"{name}.png", dpi=dpi)


def show(axes, image, title: str, pixel_size: float, white: float | None = None) -> None:
    """An image in millimetres about its middle, black at 0 and white at its peak or at `white`."""
    half_y, half_x = (n * pixel_size / 2 * 1e3 for n in image.shape)
    extent = (-half_x, half_x, half_y, -half_y)
    axes.imshow(image, cmap="gray", vmin=0, vmax=image.max() if white is None else white, extent=extent)
    axes.set_title(title, fontsize=9)
    axes.tick_params(labelsize=7)

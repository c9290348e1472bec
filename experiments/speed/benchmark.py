"""Speed: an image on Chebyshev nodes costs one to two and a half copies of it, and large ones no more a pixel.

Claims (1024 x 1024, float64, two polarized beams, R = 2 m, 500 nm, 5 um pixels): see `TARGETS`, each a ratio to a
baseline that runs beside it, in CPU time of all threads; ratios of wall times stand beside. "Image" is of the
coefficients of the fields, as `render` makes it of a plan. Several fresh processes one after the other, because one
process's allocations can cost a factor of four; in each, contenders take turns; medians over turns, then over
processes. Compile times stand apart.

    python -m experiments.speed.benchmark [--quick] [--processes 5] [--size 1024]

Writes results/benchmark.json, .csv and .png (with --quick: benchmark-quick.*, where the limits, which are for
1024 x 1024, do not hold). Peers that are not installed are skipped.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
from functools import partial
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

RESULTS = Path(__file__).parents[1] / "results"
RADIUS, WAVELENGTH, PIXEL = 2.0, 500e-9, 5e-6
SIZES = (1024, 2048, 4096, 8192)

# claim: (contender, baseline, limit); the ratio contender / baseline may be at most the limit.
TARGETS = {
    "image on 3 nodes over a copy": ("image3", "copy", 1.6),
    "image on 5 nodes over a copy": ("image5", "copy", 1.6),
    "image on 9 nodes over a copy": ("image9", "copy", 2.4),
    "image on 17 nodes over a copy": ("image17", "copy", 2.5),
    "image on 5 nodes in float32 over a copy in float64": ("single5", "copy", None),
    "transmitted, planned nodes, over a copy": ("transmitted", "copy", 2.5),
    "reflected, planned nodes, over a copy": ("reflected", "copy", 2.5),
    "transmitted over one jnp.cos": ("transmitted", "cos", 0.25),
    "9 nodes in a program of the user's over a copy": ("nodes9", "copy", None),
    "17 nodes in a program of the user's over a copy": ("nodes17", "copy", None),
    "17 nodes in a program of the user's over one jnp.cos": ("nodes17", "cos", None),
    "nodes alone (rays and fields) over a copy": ("fields", "copy", None),
    "public render, method given, over a copy": ("render", "copy", None),
    "public render, planned, over a copy": ("render planned", "copy", None),
    "closed form over a copy": ("closed", "copy", 2.0),
    "Jacobian (R, gap, wavelength) over one render": ("jacobian", "one render", 5.0),
    "transmitted over batoid": ("transmitted", "batoid", 1 / 200),
    "transmitted over numba": ("transmitted", "numba", 1 / 5),
    "transmitted over Dr.Jit": ("transmitted", "drjit", 1 / 5),
}
# nodes: the limit of an image of 4096 x 4096 pixels and more, over a copy by NumPy.
LARGE, LARGE_FROM = {5: 3.3, 17: 4.5}, 4096
# Left out of the quick form, which is for CI: compiling is most of its time.
LONG = {"reflected", "nodes17", "fields", "render planned", "one render", "jacobian"}
SLOW = {"cos": 4, "batoid": 20, "numba": 20, "drjit": 20, "render planned": 4, "jacobian": 2, "one render": 2}


def median(values) -> float:
    return float(np.median(list(values)))


def contenders(size: int, nodes: dict[str, int]):
    """Name -> function without arguments, each returning what has to be waited for."""
    import jax
    import jax.numpy as jnp

    import newtonjax as nj
    from experiments.speed import peers
    from newtonjax.fields import image

    camera = nj.Camera((size, size), PIXEL)
    scenes = {
        view: nj.newton_rings(RADIUS, WAVELENGTH, view=view, screen=1e-3) for view in ("transmitted", "reflected")
    }
    focused = nj.newton_rings(RADIUS, WAVELENGTH, view="reflected", screen="gap")
    picture = jnp.asarray(np.random.default_rng(0).random((size, size)))
    radians = 2 * jnp.pi * nj.opd(scenes["transmitted"], camera, nj.Chebyshev(9)) / WAVELENGTH

    def kernel(method, scene):
        compiled = jax.jit(lambda scene, camera: method.image(scene, camera))
        return lambda: compiled(scene, camera)

    chosen = nj.Chebyshev(nodes["transmitted"])
    at_nodes = jax.jit(lambda scene, camera: chosen.fields(scene, camera))

    def of_parameters(theta):
        return chosen.image(
            nj.newton_rings(theta[0], WAVELENGTH * theta[2], 1e-6 * theta[1], view="transmitted", screen=1e-3), camera
        )

    theta = jnp.array([RADIUS, 0.3, 1.0])
    one, jacobian = jax.jit(of_parameters), jax.jit(jax.jacfwd(of_parameters))
    copy, cosine = jax.jit(lambda a: a.copy()), jax.jit(jnp.cos)
    found = {
        "copy": lambda: copy(picture),
        "cos": lambda: cosine(radians),
        "transmitted": kernel(chosen, scenes["transmitted"]),
        "reflected": kernel(nj.Chebyshev(nodes["reflected"]), scenes["reflected"]),
        "nodes9": kernel(nj.Chebyshev(9), scenes["transmitted"]),
        "nodes17": kernel(nj.Chebyshev(17), scenes["transmitted"]),
        **{f"image{n}": partial(image, at, camera.shape) for n, at in coefficients(size, (3, 5, 9, 17)).items()},
        "single5": partial(image, coefficients(size, (5,))[5], camera.shape, "float32"),
        "fields": lambda: at_nodes(scenes["transmitted"], camera),
        "closed": kernel(nj.ClosedForm(), focused),
        "render": lambda: nj.render(scenes["transmitted"], camera, method=chosen),
        "render planned": lambda: nj.render(scenes["transmitted"], camera),
        "one render": lambda: one(theta),
        "jacobian": lambda: jacobian(theta),
        "batoid": peers.batoid_paths(size, PIXEL, RADIUS),
        "numba": peers.numba_image(size, PIXEL, RADIUS, WAVELENGTH),
        "drjit": peers.drjit_image(size, PIXEL, RADIUS, WAVELENGTH),
    }
    return {name: function for name, function in found.items() if function is not None}


def coefficients(size: int, counts) -> dict:
    """Coefficients of the fields of the transmitted image, by numbers of nodes."""
    import newtonjax as nj

    scene, camera = nj.newton_rings(RADIUS, WAVELENGTH, view="transmitted", screen=1e-3), nj.Camera((size, size), PIXEL)
    return {count: nj.Chebyshev(count).picture(scene, camera).coefficients for count in counts}


def take_turns(functions: dict, rounds: int) -> dict[str, dict[str, float]]:
    """Median CPU and wall seconds of each function, taking turns, and of its first call (compilation included)."""
    import jax

    def clock(function):
        begin = process_time(), perf_counter()
        jax.block_until_ready(function())
        return process_time() - begin[0], perf_counter() - begin[1]

    first = {name: clock(function)[0] for name, function in functions.items()}
    for function in functions.values():
        clock(function)
    times = {name: [] for name in functions}
    for turn in range(rounds):
        for name, function in functions.items():
            if turn % SLOW.get(name, 1) == 0:
                times[name].append(clock(function))
    kinds = {"seconds": 0, "wall": 1}
    return {"first_call": first} | {
        kind: {name: median(pair[at] for pair in pairs) for name, pairs in times.items()} for kind, at in kinds.items()
    }


def planned_nodes(size: int, view: str) -> int:
    import newtonjax as nj

    return nj.plan(
        nj.newton_rings(RADIUS, WAVELENGTH, view=view, screen=1e-3), nj.Camera((size, size), PIXEL)
    ).method.nodes


def child_main(size: int, rounds: int) -> dict:
    nodes = {view: planned_nodes(size, view) for view in ("transmitted", "reflected")}
    functions = contenders(size, nodes)
    if size < SIZES[0]:
        functions = {name: function for name, function in functions.items() if name not in LONG}
    return {"nodes": nodes, **take_turns(functions, rounds)}


def child_size(size: int, rounds: int) -> dict:
    """Copies and images of one size, and nothing else: all find their arrays in the cache where it holds them."""
    import jax
    import jax.numpy as jnp

    from newtonjax.fields import image

    picture = jnp.asarray(np.random.default_rng(0).random((size, size)))
    copy, plain = jax.jit(lambda a: a.copy()), np.asarray(picture)
    images = {f"image{n}": partial(image, at, (size, size)) for n, at in coefficients(size, LARGE).items()}
    return take_turns({"copy": lambda: copy(picture), "np.copy": lambda: np.copy(plain), **images}, rounds)


def child_memory(size: int, rounds: int) -> dict:  # noqa: ARG001 (one signature for all children)
    """Memory of one image over its size: what the compiler reserves, and the growth of the resident set's peak."""
    import resource

    import jax

    import newtonjax as nj

    method, scene = nj.Chebyshev(9), nj.newton_rings(RADIUS, WAVELENGTH, view="transmitted", screen=1e-3)

    def peak():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

    compiled = jax.jit(lambda scene, camera: method.image(scene, camera))
    jax.block_until_ready(compiled(scene, nj.Camera((64, 64), PIXEL)))
    camera = nj.Camera((size, size), PIXEL)
    analysis = compiled.lower(scene, camera).compile().memory_analysis()
    before = peak()
    jax.block_until_ready(compiled(scene, camera))
    image = 8 * size * size
    return {
        "compiled": (analysis.output_size_in_bytes + analysis.temp_size_in_bytes) / image,
        "resident": (peak() - before) / image,
    }


CHILDREN = {"main": child_main, "size": child_size, "memory": child_memory}

# The C library gives an array over 32 MB back after use, so that the next one pays for fresh pages: this keeps them.
KEEP_PAGES = {"MALLOC_MMAP_MAX_": "0", "MALLOC_TRIM_THRESHOLD_": str(1 << 40), "MALLOC_ARENA_MAX": "1"}
PAGES = {"fresh": {}, "kept": KEEP_PAGES}


def spawn(kind: str, size: int, rounds: int, **more: str) -> dict:
    environment = {**os.environ, "JAX_PLATFORMS": "cpu", "JAX_ENABLE_X64": "1", **more}
    command = [
        sys.executable,
        "-m",
        "experiments.speed.benchmark",
        "--child",
        kind,
        "--size",
        str(size),
        "--rounds",
        str(rounds),
    ]
    done = subprocess.run(command, cwd=RESULTS.parents[1], env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def in_this_process(kind: str, size: int, rounds: int) -> dict:
    """As `spawn`, without a process of its own: for the quick form, whose times claim nothing."""
    import jax

    jax.config.update("jax_enable_x64", True)
    return CHILDREN[kind](size, rounds)


def compare(runs: list[dict]) -> list[dict]:
    """One row per claim: median ratio over processes, their spread, and the limit."""
    rows = []
    for claim, (contender, baseline, limit) in TARGETS.items():
        if not all({contender, baseline} <= run["seconds"].keys() for run in runs):
            print(f"skipped: {claim} (not installed, or not in the quick form)")
            continue
        ratios = [run["seconds"][contender] / run["seconds"][baseline] for run in runs]
        walls = [run["wall"][contender] / run["wall"][baseline] for run in runs]
        held = None if limit is None else median(ratios) <= limit
        rows.append(
            {
                "claim": claim,
                "ratio": median(ratios),
                "least": min(ratios),
                "most": max(ratios),
                "wall": median(walls),
                "limit": limit,
                "held": held,
            }
        )
    return rows


def by_size(sizes, processes: int, ask, kinds_of_pages: dict) -> list[dict]:
    """CPU time per pixel of images and copies, with fresh pages (the default) and with pages that a process keeps."""
    rows = []
    for size in sizes:
        for pages, environment in kinds_of_pages.items():
            rounds = max(5, 40 * 1024**2 // size**2)
            found = [ask("size", size, rounds, **environment) for _ in range(processes)]
            runs = [run["seconds"] for run in found]
            ratios = {
                f"image{nodes} over {copy}": median(run[f"image{nodes}"] / run[copy] for run in runs)
                for nodes in LARGE
                for copy in ("copy", "np.copy")
            }
            per_pixel = {f"{name}_ns_per_pixel": 1e9 * median(r[name] for r in runs) / size**2 for name in runs[0]}
            rows.append({"size": size, "pages": pages, **ratios, **per_pixel})
    return rows


def draw(rows: list[dict], sizes: list[dict], file: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(14, 4.5), layout="constrained")
    names = [row["claim"] for row in rows][::-1]
    left.barh(names, [row["ratio"] for row in rows][::-1], color="steelblue")
    limits = [row["limit"] for row in rows][::-1]
    left.plot([limit or float("nan") for limit in limits], names, "r|", markersize=14, label="limit")
    left.set(xscale="log", xlabel="ratio of times")
    left.legend()
    for pages, style in (("fresh", "-"), ("kept", "--")):
        some = [row for row in sizes if row["pages"] == pages]
        for name, colour in (("image5", "steelblue"), ("image17", "navy"), ("copy", "grey"), ("np.copy", "black")):
            values = [row[f"{name}_ns_per_pixel"] for row in some]
            right.plot(
                [r["size"] for r in some], values, style, color=colour, marker="o", label=f"{name}, {pages} pages"
            )
    right.set(xscale="log", yscale="log", xlabel="pixels to a side", ylabel="ns per pixel")
    right.minorticks_off()
    right.set_yticks([0.5, 1, 2, 5], ["0.5", "1", "2", "5"])
    right.set_xticks([row["size"] for row in sizes], [str(row["size"]) for row in sizes])
    figure.legend(*right.get_legend_handles_labels(), loc="outside right center")
    figure.savefig(file, dpi=110)


def main(quick: bool, processes: int, size: int) -> None:
    begin = perf_counter()
    ask = in_this_process if quick else spawn
    runs = [ask("main", size, 20 if quick else 80) for _ in range(processes)]
    rows = compare(runs)
    for row in rows:
        held = "" if quick else {None: "", True: "held", False: "MISSED"}[row["held"]]
        limit = "" if row["limit"] is None else f"at most {row['limit']:.4g}"
        spread = f"({row['least']:.4f} to {row['most']:.4f}, wall {row['wall']:.4f})"
        print(f"{row['claim']:52s} {row['ratio']:9.4f}  {spread}  {limit:14s} {held}")
    sizes = by_size((512,), 1, ask, {"fresh": {}}) if quick else by_size(SIZES, min(processes, 3), ask, PAGES)
    for row in sizes:
        print("  ".join(f"{key} {value:.3g}" if isinstance(value, float) else f"{value}" for key, value in row.items()))
        if not quick and row["size"] >= LARGE_FROM:
            missed = [n for n, limit in LARGE.items() if row[f"image{n} over np.copy"] > limit]
            print(f"over np.copy at most {LARGE}: {f'MISSED at {missed}' if missed else 'held'}")
    memory = spawn("memory", 512 if quick else 8192, 1)
    print(f"memory of one image over its size: {memory} (at most 4)")
    RESULTS.mkdir(exist_ok=True)
    name = "benchmark-quick" if quick else "benchmark"
    first = {key: median(run["first_call"][key] for run in runs) for key in runs[0]["first_call"]}
    milliseconds = {key: 1e3 * median(run["seconds"][key] for run in runs) for key in runs[0]["seconds"]}
    whole = {
        "size": size,
        "processes": processes,
        "nodes": runs[0]["nodes"],
        "claims": rows,
        "by_size": sizes,
        "memory_images": memory,
        "milliseconds": milliseconds,
        "first_call_seconds": first,
    }
    (RESULTS / f"{name}.json").write_text(json.dumps(whole, indent=1) + "\n")
    with (RESULTS / f"{name}.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, rows[0].keys())
        table.writeheader()
        table.writerows(rows)
    draw(rows, sizes, RESULTS / f"{name}.png")
    print(f"nodes {runs[0]['nodes']}, {perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="256 x 256, one process: for CI")
    parser.add_argument("--processes", type=int, default=None)
    parser.add_argument("--size", type=int, default=None)
    parser.add_argument("--child", choices=CHILDREN, help=argparse.SUPPRESS)
    parser.add_argument("--rounds", type=int, default=40, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        print(json.dumps(CHILDREN[given.child](given.size, given.rounds)))
    else:
        main(given.quick, given.processes or (1 if given.quick else 5), given.size or (256 if given.quick else 1024))

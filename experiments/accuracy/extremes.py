"""Claim: no extreme of a bench gives a NaN, an infinity, or an error beyond the one that is reported.

One number of an ordinary bench at a time, from a radius of 10 um to the plane, from 10 nm to 1 mm of wavelength, and so
on (`extreme_scenes.py`). For each: the method that the plan takes, or why the bench is refused; the phase of rays aimed
at nine pixels, and that of the planned method, against a ray trace at 50 digits, beside the bounds that are reported;
the slopes of the phase against differences at 50 digits, those of the intensity against differences in float64, by the
extreme number and by the curvature; and whether all derivatives by all numbers are finite. What is inaccurate and says
so is a known failure; what is inaccurate and does not is known dishonest, of which there is none.

    python -m experiments.accuracy.extremes [--quick]

Writes results/extremes.md and .json.
"""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

import newtonjax as nj
from experiments import records
from experiments.accuracy import extreme_scenes as scenes
from experiments.accuracy.extreme_scenes import NAMES, mpf
from newtonjax.fields import fields_at, intensity, opd_at
from newtonjax.fields.packed import OPTIONS
from newtonjax.numerics import chebyshev
from newtonjax.rays import gather
from newtonjax.rays.aiming import aim
from newtonjax.scene import node_points

TOLERANCE = 1e-3  # of the plan
GRADIENT = 1e-6  # of a slope, beside what rounding leaves of it
WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])  # central differences of eighth order (Fornberg 1988)
STEPS = 0.03 * 4.0 ** -np.arange(7)  # of the number's change that moves the phase by a turn
LARGEST = 2**22  # pixels of an image that is computed as a whole
QUICKLY = {"xla_backend_optimization_level": 0, **OPTIONS}
_compiled = partial(jax.jit, static_argnames="view", compiler_options=QUICKLY)


@_compiled
def seen(vector, points, view):
    """Path difference [turns] and fields at points, every ray traced; where the rays are launched [point, beam]."""
    scene = scenes.scene_of(vector, view)
    starts = jax.vmap(jax.vmap(aim, (0, None, None)), (None, None, 0))(*gather(scene), points).start
    return opd_at(scene, points)[0] / scene.wavelength, fields_at(scene, points), starts


@_compiled
def slopes(vector, points, view):
    """Derivatives by all numbers: of the path difference [turns], of intensities; reverse, of their weighted sum."""

    def both(v):
        scene = scenes.scene_of(v, view)
        return opd_at(scene, points)[0] / scene.wavelength, intensity(fields_at(scene, points))

    weights = jnp.cos(jnp.arange(len(points), dtype=float))
    return *jax.jacfwd(both)(vector), jax.grad(lambda v: weights @ both(v)[1])(vector)


@_compiled
def intensities(vectors, points, view):
    return jax.lax.map(lambda v: intensity(fields_at(scenes.scene_of(v, view), points)), vectors)


def pixels(row):
    """Rows and columns of nine pixels: corner, middle, and others that no node is near; their screen points [m]."""
    rows, columns = ([0, n // 2, min(int(n * part), n - 1)] for n, part in zip(row.shape, (0.8, 0.93), strict=True))
    x, y = (np.asarray(axis) for axis in row.camera().axes())
    return rows, columns, np.array([(x[j], y[i]) for i in rows for j in columns])


def away(turns, exact) -> float:
    """Largest difference [turns] where there is an exact value; -1 where there is none."""
    return max(
        (abs(float(e - mpf(float(t)))) for t, e in zip(turns, exact, strict=True) if e is not None), default=-1.0
    )


def planned(row, vector, chosen, places):
    """The planned method: path differences [turns] and intensities at the nine pixels, and whether all are finite."""
    scene, camera = scenes.scene_of(vector, row.view), row.camera()
    rows, columns, points = places
    if isinstance(chosen.method, nj.Traced):
        turns, fields, _ = seen(vector, points, row.view)
        return np.asarray(turns), np.asarray(intensity(fields)), bool(np.isfinite(intensity(fields)).all())
    if np.prod(row.shape) > LARGEST:  # the nodes' own polynomials, without the image
        fields = chosen.method.fields(scene, camera)
        path, _ = opd_at(scene, node_points(camera, chosen.method.nodes))
        parts = np.concatenate([path[None] / scene.wavelength, fields.background[None]])
        at = [2 * np.array(k) / (n - 1) - 1 for k, n in zip((rows, columns), row.shape, strict=True)]
        grid = np.polynomial.chebyshev.chebgrid2d(*at, np.moveaxis(np.asarray(chebyshev.coefficients(parts)), 0, -1))
        return grid[0].ravel(), None, bool(np.isfinite(grid).all())
    image = np.asarray(nj.render(scene, camera, chosen.method))
    turns = np.asarray(nj.opd(scene, camera, chosen.method)) / scene.wavelength
    at = np.ix_(rows, columns)
    return turns[at].ravel(), image[at].ravel(), bool(np.isfinite(image).all() and np.isfinite(turns).all())


def exact_slope(row, vector, points, starts, name):
    """Derivative of the phase [turns] at some points by differences at 50 digits; None where no two rays meet."""
    k, found = NAMES.index(name), []
    step = mpf(scenes.scale(vector, name)) * mpf("1e-12")
    for point, start in zip(points, starts, strict=True):
        ends = []
        for sign in (1, -1):
            moved = [mpf(float(value)) for value in vector]
            moved[k] += sign * step
            ends.append(scenes.turns(moved, row.view, point, start))
        found.append(None if None in ends else float((ends[0] - ends[1]) / (2 * step)))
    return found


def compare_slopes(row, vector, points, starts, rounding, exact, light):
    """Relative errors of the slopes of phase and of intensity, the same over what is allowed, and if all are finite."""
    path, image, reverse = (np.asarray(part) for part in slopes(vector, points, row.view))
    finite = bool(np.isfinite(path).all() and np.isfinite(image).all() and np.isfinite(reverse).all())
    weights = np.cos(np.arange(len(points)))
    both = np.abs(reverse - weights @ image) / (np.abs(weights) @ np.abs(image) + 1e-300)
    result = {"finite": finite, "phase": 0.0, "intensity": 0.0, "beyond": 0.0, "reverse": 0.0}
    some = [k for k, e in enumerate(exact) if e is not None]
    some = sorted({*some[:1], *some[len(some) // 2 :][:1], *some[-1:]})
    for name in dict.fromkeys((row.by, "curvature")):
        k = NAMES.index(name)
        unit = scenes.scale(vector, name)
        result["reverse"] = max(result["reverse"], float(both[k]))
        known = [
            (i, s)
            for i, s in zip(some, exact_slope(row, vector, points[some], starts[some], name), strict=True)
            if s is not None
        ]
        fastest = max([abs(s) for _, s in known] + [1e-3 / unit])
        for i, s in known:
            error = abs(path[i, k] - s)
            result["phase"] = max(result["phase"], error / fastest)
            result["beyond"] = max(result["beyond"], error / (GRADIENT * fastest + rounding / unit))
        error, allowed, largest = difference_error(
            row, vector, points, k, 1 / fastest, unit, rounding * light, image[:, k]
        )
        meet = np.array([e is not None for e in exact])  # elsewhere light may end, and has no slope
        error, allowed = (part[meet] if meet.any() else part for part in (error, allowed))
        result["beyond"] = max(result["beyond"], float((error / allowed).max()))
        if largest > 1e3 * allowed.max():
            result["intensity"] = max(result["intensity"], float(error.max()) / largest)
    return result


def difference_error(row, vector, points, k, turn, unit, rounding, slope):
    """Errors of an intensity's slope by number k against differences, what is allowed, and the largest slope."""
    steps = np.minimum(turn, unit) * STEPS
    reach = np.concatenate([np.arange(1, 5), -np.arange(1, 5)])
    vectors = np.repeat(vector[None], len(steps) * 8, axis=0)
    vectors[:, k] += (steps[:, None] * reach).ravel()
    values = np.asarray(intensities(vectors, points, row.view)).reshape(len(steps), 8, -1)
    found = np.einsum("j,sjp->sp", WEIGHTS, values[:, :4] - values[:, 4:]) / steps[:, None]
    doubt = np.abs(np.diff(found, axis=0)) + 2 * np.pi * rounding / steps[1:, None] + 1e-15 / steps[1:, None]
    best, each = doubt.argmin(axis=0), np.arange(len(points))
    found, doubt = found[best, each], doubt[best, each]
    largest = float(np.abs(found).max())
    return np.abs(slope - found), GRADIENT * largest + doubt + 1e-300, largest


def judge(line) -> tuple[str, str]:
    """The verdict on a row, and why."""
    if not (line["finite"] and line["gradient"]["finite"]):
        return "dishonest", "a NaN or an infinity"
    if line["missed"] and line["light_bound"] <= TOLERANCE:
        return "dishonest", f"rays and oracle disagree on whether light arrives at {line['missed']} of 9 pixels"
    if line["several"] and line["light_bound"] <= TOLERANCE:
        return "dishonest", f"{line['several']} rays of a beam meet at a pixel, of which one is followed"
    for what, bound in (("traced", "rounding"), ("error", "bound"), ("light_error", "light_bound")):
        if line[what] > line[bound]:
            return "dishonest", f"{what} {line[what]:.2g} above its bound {line[bound]:.2g}"
    if line["gradient"]["beyond"] > 1:
        return "dishonest", f"a derivative is off by {line['gradient']['beyond']:.2g} of what is allowed"
    if line["bound"] > 1e-2 or line["light_bound"] > TOLERANCE:
        return "failure", f"the plan states {line['bound']:.2g} turns and {line['light_bound']:.2g} of the peak"
    return "ok", ""


def measure(row) -> dict:
    """One line of the table."""
    line = {"quantity": row.quantity, "value": row.value, "view": row.view}
    try:
        vector, camera = row.vector(), row.camera()
        scene = scenes.scene_of(vector, row.view)
        chosen = nj.plan(scene, camera, TOLERANCE)
    except ValueError as refusal:
        return line | {"method": "refused", "verdict": "refused", "why": one_line(refusal)}
    places = pixels(row)
    points = places[2]
    turns, fields, starts = seen(vector, points, row.view)
    arrives, starts = np.asarray(fields.arrives), np.asarray(starts)
    exact = [scenes.turns(vector, row.view, point, start) for point, start in zip(points, starts, strict=True)]
    meet = np.array([e is not None for e in exact])
    found, image, finite = planned(row, vector, chosen, places)
    rounding, size = float(fields.rounding.max()), float(jnp.abs(fields.envelope).max())
    ours = [e if a else None for e, a in zip(exact, arrives, strict=True)]
    peak = float(fields.background.max()) + size
    line |= {
        "method": type(chosen.method).__name__ + str(getattr(chosen.method, "nodes", "")),
        "reason": chosen.reason,
        "points": int(meet.sum()),
        "missed": int((meet != arrives).sum()),
        "traced": away(turns, ours),
        "rounding": rounding,
        "error": off_whole(found, ours),
        "bound": chosen.phase_error,
        "light_bound": chosen.intensity_error,
        "light_error": light_error(row, turns, fields, exact, image) / (peak if peak > 1e-25 else 1.0),
        "finite": finite and all(bool(np.isfinite(part).all()) for part in fields),
        "gradient": compare_slopes(row, vector, points, starts, max(rounding, 1e-14), ours, max(peak, 1e-30)),
    }
    reach = 2 * float(np.hypot(*points.T).max())
    most = scenes.rays(vector, row.view, points, reach) if reach > 0 else None
    line["several"] = int(most) if most is not None and most > 1 else 0
    if row.quantity == "fringes":
        line["finest"] = finest(row, scene, camera, vector)
    line["verdict"], line["why"] = judge(line)
    return line


def off_whole(turns, exact) -> float:
    """As `away`, but whole turns, which no image shows, do not count."""
    wrong = [float(e - mpf(float(t))) for t, e in zip(turns, exact, strict=True) if e is not None]
    return max((abs(w - round(w)) for w in wrong), default=-1.0)


def light_error(row, turns, fields, exact, image) -> float:
    """Largest error of the intensities of the planned method: amplitudes as traced, phases at 50 digits."""
    if image is None:
        return -1.0
    if row.light is not None:
        return float(np.abs(image - row.light).max()) - 1e-12
    shift = np.asarray(fields.phase[0] - turns)  # quarter turns of the foci
    phase = [float(e - scenes.mpmath.nint(e)) if e is not None else 0.0 for e in exact]
    fringes = np.real(np.asarray(fields.envelope[0]) * np.exp(2j * np.pi * (np.array(phase) + shift)))
    return float(np.abs(image - np.asarray(fields.background) - fringes).max())


def finest(row, scene, camera, vector) -> dict:
    """The finest fringe [pixels] that `explain` finds, and that at the corner at 50 digits."""
    corner, h = pixels(row)[2][0], 1e-3 * row.half
    ends = [[scenes.turns(vector, row.view, corner + sign * h * e) for sign in (1, -1)] for e in np.eye(2)]
    slope = np.hypot(*(float(a - b) / (2 * h) for a, b in ends))
    return {"said": nj.explain(scene, camera).finest_fringe, "exact": 1 / (slope * float(camera.pixel_size))}


def one_line(error: Exception) -> str:
    return " ".join(str(error).split())[:160]


def refusals() -> list[dict]:
    """What no bench can have."""
    found = []
    for (quantity, value), build in scenes.REFUSED.items():
        line = {"quantity": quantity, "value": value, "view": "any", "method": "refused"}
        try:
            build()
        except ValueError as refusal:
            found.append(line | {"verdict": "refused", "why": one_line(refusal)})
        else:
            found.append(line | {"method": "taken", "verdict": "dishonest", "why": "taken as it stands"})
    return found


def closed_numbers() -> dict[str, dict]:
    """Extremes of the closed form: radius, wavelength, gap [m], index of the gap, and the corner in radii."""
    plain = {"radius": 2.0, "wavelength": 500e-9, "gap": 1e-6, "gap_index": 1.0, "reach": 1.13e-3}
    return {
        "radius 10 um, in water": plain | {"radius": 1e-5, "gap_index": 1.33, "reach": 0.9},
        "radius 10 km": plain | {"radius": 1e4, "reach": 1e-5},
        "r/R 0.9": plain | {"radius": 60e-6, "reach": 0.9},
        "r/R 0.99": plain | {"radius": 60e-6, "reach": 0.99},
        "r/R 0.999": plain | {"radius": 60e-6, "reach": 0.999},
        "r/R 0.999 of 20 mm": plain | {"radius": 0.02, "reach": 0.999},
        "gap -10 um (pressed)": plain | {"gap": -1e-5},
        "gap contact": plain | {"gap": 0.0},
        "gap 10 mm": plain | {"gap": 1e-2},
        "wavelength 10 nm": plain | {"wavelength": 1e-8},
        "wavelength 1 mm": plain | {"wavelength": 1e-3, "reach": 0.1},
        "index of the gap 4": plain | {"gap_index": 4.0},
    }


def closed_bench(n, view):
    """The scene focused on the gap, and a camera of 5 x 5 pixels; n: the four numbers and the pixel size."""
    radius, wavelength, gap, gap_index, pixel = n
    return nj.newton_rings(radius, wavelength, gap, view, screen="gap", gap_index=gap_index), nj.Camera((5, 5), pixel)


@_compiled
def closed_seen(n, view):
    def image(n):
        return nj.ClosedForm().image(*closed_bench(n, view)).ravel()

    def turns(n):
        scene, camera = closed_bench(n, view)
        return nj.ClosedForm().opd(scene, camera).ravel() / scene.wavelength

    total = jax.grad(lambda n: image(n) @ jnp.cos(jnp.arange(25, dtype=image(n).dtype)))
    return (
        *((turns(n), jax.jacfwd(turns)(n)) if n.dtype == jnp.float64 else ()),
        image(n),
        jax.jacfwd(image)(n),
        total(n),
    )


def closed_exact(n, pixels):
    """2 n t of the sphere [turns] at 50 digits."""
    radius, wavelength, gap, index, pixel = n
    r2 = [(i * i + j * j) * pixel**2 for j in pixels for i in pixels]
    return [2 * index * (gap + radius - scenes.mpmath.sqrt(radius**2 - r)) / wavelength for r in r2]


def measure_closed(name, numbers, view) -> list[dict]:
    """The closed form in float64 against its formula at 50 digits, and in a float32 program against float64."""
    given = {**numbers, "pixel": numbers["reach"] * numbers["radius"] / 2 / 2**0.5}
    n = np.float32([given[key] for key in ("radius", "wavelength", "gap", "gap_index", "pixel")]).astype(float)
    turns, by, image, image_by, reverse = (np.asarray(part) for part in closed_seen(jnp.asarray(n), view))
    pixels, start = range(-2, 3), [mpf(float(value)) for value in n]
    error = away(turns, closed_exact(start, pixels))
    relative = 0.0
    for k, value in enumerate(start):
        step = max(abs(value), start[1] if k == 2 else mpf(0)) * mpf("1e-12")
        ends = [closed_exact([*start[:k], value + sign * step, *start[k + 1 :]], pixels) for sign in (1, -1)]
        slope = np.array([float((a - b) / (2 * step)) for a, b in zip(*ends, strict=True)])
        relative = max(relative, float(np.abs(by[:, k] - slope).max() / np.abs(slope).max()))
    steep = 1 / (1 - numbers["reach"] ** 2) ** 0.5
    bound = 8 * np.finfo(float).eps * steep * float(np.abs(turns).max() + 2 * n[3] * abs(n[2]) / n[1])
    head, _, tail = name.partition(" ")
    line = {"quantity": head, "value": f"{tail}, closed form", "view": view, "method": "ClosedForm", "why": ""}
    gradient = {"phase": relative, "intensity": 0.0, "beyond": relative / (GRADIENT * steep**2)}
    fine = all(np.isfinite(part).all() for part in (turns, by, image, image_by, reverse))
    good = fine and error <= bound and gradient["beyond"] <= 1
    double = line | {"error": error, "bound": bound, "gradient": gradient, "verdict": "ok" if good else "dishonest"}
    with jax.enable_x64(False):
        single = [np.asarray(part, float) for part in closed_seen(jnp.asarray(n, jnp.float32), view)]
    fine = all(np.isfinite(part).all() for part in single)
    light = float(np.abs(single[0] - image).max() / image.max())
    scale = np.abs(image_by * n).max(axis=0)
    moved = np.abs((single[1] - image_by) * n).max(axis=0)
    relative = float((moved / np.where(scale > 0, scale, 1.0)).max())
    # The program is given a radius: its reciprocal, the curvature, is a float32.
    curvature = 2 * np.pi * np.finfo(np.float32).eps * steep * float(np.ptp(turns))
    good = fine and light <= 2e-5 and relative <= 1e-2
    stated = fine and light <= 2e-5 + curvature and relative <= 1e-2 + curvature
    verdict = "ok" if good else "failure" if stated else "dishonest"
    why = "" if good else f"{light:.2g} of the peak, slopes {relative:.2g}; 1 / radius in float32 costs {curvature:.2g}"
    more = {"light_error": light, "light_bound": 2e-5, "error": light / (2 * np.pi), "bound": 2e-5 / (2 * np.pi)}
    gradient = {"phase": 0.0, "intensity": relative, "beyond": relative / 1e-2}
    single = line | more | {"value": f"{tail}, closed form in float32", "gradient": gradient}
    return [double, single | {"verdict": verdict, "why": why}]


def measure_single(row) -> dict:
    """Pixels in float32 against float64; a statement is made up to 250 turns."""
    scene, camera = scenes.scene_of(row.vector(), row.view), row.camera()
    exact = np.asarray(nj.render(scene, camera, nj.Chebyshev(17, "float64")))
    image = np.asarray(nj.render(scene, camera, nj.Chebyshev(17, "float32")), float)
    turns = float(np.abs(nj.opd(scene, camera, nj.Chebyshev(17))).max() / scene.wavelength)
    light = float(np.abs(image - exact).max() / exact.max())
    line = {
        "quantity": row.quantity,
        "value": f"{row.value}, pixels in float32",
        "view": row.view,
        "method": "Chebyshev17",
    }
    good = np.isfinite(image).all() and light <= 2e-5
    verdict = "ok" if good else "failure" if turns > 250 and np.isfinite(image).all() else "dishonest"
    why = "" if good else f"{light:.2g} of the peak at {turns:.3g} turns; 2e-5 is promised up to 250"
    return line | {"error": light / (2 * np.pi), "bound": 2e-5 / (2 * np.pi), "verdict": verdict, "why": why}


def traced_in_single() -> dict:
    """Rays in a float32 program are refused."""
    line = {"quantity": "precision", "value": "rays in a float32 program", "view": "any", "method": "refused"}
    try:
        with jax.enable_x64(False):
            jax.jit(
                lambda r: nj.render(
                    nj.newton_rings(r, view="transmitted", screen=1e-3), nj.Camera((3, 3), 1e-4), nj.Traced()
                )
            )(2.0)
    except RuntimeError as refusal:
        return line | {"verdict": "refused", "why": one_line(refusal)}
    return line | {"method": "taken", "verdict": "dishonest", "why": "taken as it stands"}


def number(line, key: str) -> str:
    value = line.get(key, -1.0)
    return "" if value < 0 else f"{value:.1e}"


def gradient_of(line) -> str:
    found = line.get("gradient")
    return "" if found is None else f"{max(found['phase'], found['intensity']):.1e}"


def table(lines) -> str:
    """Markdown."""
    names = ("quantity", "value", "view", "method", "rays' error [turns]", "rounding", "method's error [turns]")
    names = (*names, "bound", "gradient", "verdict")
    rows = ["| " + " | ".join(names) + " |", "|" + "---|" * len(names)]
    for line in lines:
        cells = [line["quantity"], line["value"], line["view"], line["method"]]
        cells += [number(line, key) for key in ("traced", "rounding", "error", "bound")]
        cells += [gradient_of(line), line["why"] or line["verdict"]]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows) + "\n"


def report(lines) -> str:
    """The whole table, and the two that are kept apart."""
    parts = {
        "Known failures": [line for line in lines if line["verdict"] == "failure"],
        "Known dishonest": [line for line in lines if line["verdict"] == "dishonest"],
    }
    text = (
        "# Extremes\n\nMade by `python -m experiments.accuracy.extremes`. Errors of phases are in turns, against a ray "
        "trace at 50 digits; those of gradients are relative to the largest slope.\n\n"
    )
    for name, some in parts.items():
        text += f"## {name}\n\n{table(some) if some else 'None.' + chr(10)}\n"
    return text + "## All\n\n" + table(lines)


def finite_only(value):
    """What JSON can hold: None for an infinite bound."""
    if isinstance(value, dict | list):
        return {k: finite_only(v) for k, v in value.items()} if isinstance(value, dict) else [*map(finite_only, value)]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def shown(line) -> str:
    marks = [f"{key} {number(line, key)}" for key in ("traced", "rounding", "error", "bound") if number(line, key)]
    name = f"{line['quantity']} {line['value']}, {line['view']}"
    return f"{line['verdict']:9} {name:58} {line['method']:12} {' '.join(marks)} {gradient_of(line)} {line['why']}"


QUICK = ("10 km", "contact", "10 nm", "all media 1", "89.9 deg", "1 pixel", "face 2 0.1 rad")
SINGLE = ("10 km", "contact", "10 nm", "512 rings, 0.04 px")


def measured(quick: bool):
    """Line by line."""
    some = [row for row in scenes.rows() if not quick or (row.view == "reflected" and row.value in QUICK)]
    yield from map(measure, some)
    for name, numbers in closed_numbers().items():
        if not quick or name == "r/R 0.999":
            for view in scenes.VIEWS[: 1 if quick else 2]:
                yield from measure_closed(name, numbers, view)
    if not quick:
        yield from (measure_single(row) for row in scenes.rows() if row.value in SINGLE)
    yield traced_in_single()
    yield from refusals()


def main(quick: bool) -> None:
    lines = []
    for line in measured(quick):
        print(shown(line), flush=True)
        lines.append(line)
    counts = {v: sum(line["verdict"] == v for line in lines) for v in ("ok", "refused", "failure", "dishonest")}
    fine = [line for line in lines if line["verdict"] == "ok" and line.get("error", -1) >= 0 and line["bound"] > 0]
    worst = max(line["error"] / line["bound"] for line in fine)
    slope = max(max(line["gradient"][what] for what in ("phase", "intensity")) for line in fine if "traced" in line)
    print(f"{len(lines)} rows: {counts}; where ok, error at most {worst:.2g} of its bound, of a slope {slope:.1e}")
    if not quick:
        records.save(
            "extremes", {"counts": counts, "error_over_bound": worst, "slope": slope, "rows": finite_only(lines)}
        )
        (records.RESULTS / "extremes.md").write_text(report(lines), encoding="utf-8")
    assert not counts["dishonest"], [shown(line) for line in lines if line["verdict"] == "dishonest"]
    for line in lines:
        if "finest" in line:
            assert 0.97 < line["finest"]["said"] / line["finest"]["exact"] < 1.05, line


if __name__ == "__main__":
    main(records.arguments(__doc__, "seven benches of one view, nothing written").quick)

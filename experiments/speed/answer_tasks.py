"""What `answer_time` measures: `python -c "...; answer_tasks.main()" TASK ...`, a process each.

A task prints one JSON object. CPU seconds are those of the process, all threads.
"""

import json
import os
import resource
import sys
import time
from pathlib import Path

# Light, pixel size [m] and where a photograph lies under NEWTONJAX_SHARED; those not named have sodium light and no
# scale. Files of trials that are no single photograph of fringes are left out.
GIVEN = {
    "lens_1000mm_sodium.jpg": (589.3e-9, 12.75e-6),
    "lens_850mm_sodium.jpg": (589.3e-9, 12.745e-6),
    "surface_10mm_laser.png": (635e-9, 1.3612e-6),
    "white_light_154.5mm.tif": (555e-9, 5.305e-6),
    "air_film_not_a_sphere.tif": (555e-9, 5.305e-6),
    "fabry_perot_cadmium.tif": (643.8e-9, None),
    "led_red_scale_overlay.jpg": (625e-9, None),
    "hologram_of_a_bead.jpg": (660e-9, 0.0851e-6),
}
# Beams of every fifth bench; the others have the gap's two.
BEAMS = {4: ("R1", "R2", "R3"), 9: ("R0", "R1", "R2"), 14: ("R1", "R3"), 19: ("R0", "R1", "R2", "R3")}
PICTURES = (".jpg", ".png", ".tif", ".bmp")


def cpu(function, *arguments, **given):
    """What a call returns, and the CPU seconds that it takes."""
    begin = time.process_time()
    value = function(*arguments, **given)
    return value, time.process_time() - begin


def middle(values: list[float]) -> float:
    """The median, the upper one of an even number."""
    return sorted(values)[len(values) // 2]


def peak_mb() -> float:
    """Largest resident memory of this process so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


class Compilations:
    """Programs that JAX compiles (or takes from its cache) from now on."""

    def __init__(self):
        from jax import monitoring

        self.count = 0
        monitoring.register_event_duration_secs_listener(self._listen)

    def _listen(self, event: str, _seconds: float, **_more) -> None:
        self.count += event == "/jax/core/compile/backend_compile_duration"


def bench(number: int):
    """A bench and a camera, each with other lengths, tilts, beams and pixels than the one before."""
    import numpy as np

    import newtonjax as nj

    draw = np.random.default_rng(number)
    view = ("transmitted", "reflected")[number % 2]
    beams = BEAMS.get(number % 20)
    view = "reflected" if beams else view
    radius = 10 ** draw.uniform(-0.5, 0.5)
    scene = nj.newton_rings(
        radius,
        draw.uniform(450e-9, 650e-9),
        gap=draw.uniform(0, 2e-6),
        view=view,
        screen=10 ** draw.uniform(-3.5, -2),
        lens_tilt=tuple(draw.uniform(-1e-3, 1e-3, 2)),
        **({"beams": beams} if beams else {}),
    )
    rows, columns = (int(n) for n in draw.integers(300, 900, 2))
    half = np.sqrt(draw.uniform(5, 40) * 500e-9 * radius)
    return scene, nj.Camera((rows, columns), 2 * half / max(rows, columns))


def render_task(number: str = "1", pixels: str = "") -> dict:
    """Plan and render one bench."""
    import numpy as np

    import newtonjax as nj

    scene, camera = bench(int(number))
    camera = nj.Camera((int(pixels),) * 2, 5e-6) if pixels else camera
    plan = nj.plan(scene, camera)
    image = np.asarray(nj.render(plan.scene, camera, plan.method))  # a mean in JAX is one more program
    return {"mean": float(image.mean())}


def plan_task() -> dict:
    """Plan one bench."""
    import newtonjax as nj

    return {"reason": nj.plan(*bench(1)).reason}


def information_task() -> dict:
    """Fisher's information of one bench."""
    import fitting

    return {"sd": float(fitting.information(*bench(2)).sd("radius"))}


def design_task() -> dict:
    """The best wavelength and screen of one bench, from one start."""
    import fitting

    scene, camera = bench(2)
    vary = {"wavelength": (450e-9, 650e-9), "screen": (3e-4, 3e-3)}
    return {"sd": fitting.design(scene, camera, vary, starts=1).relative_sd}


def again_task(many: str = "20") -> dict:
    """After one render: other benches and shapes, the same shapes with other benches, one pixel, a plan alone."""
    import numpy as np

    import newtonjax as nj

    compiled = Compilations()

    def answer(scene, camera):
        plan = nj.plan(scene, camera)
        return np.asarray(nj.render(plan.scene, camera, plan.method))

    answer(*bench(0))
    first, others, known, plans = compiled.count, [], [], []
    for number in range(1, int(many) + 1):
        before = compiled.count
        _, seconds = cpu(answer, *bench(number))
        others.append((seconds, compiled.count - before))
    for number in range(1, int(many) + 1):
        scene, camera = bench(number)
        answer(scene, camera)
        known.append(cpu(answer, scene, camera)[1])
        plans.append(cpu(nj.plan, *bench(number + 1000))[1])
    before = compiled.count
    _, tiny = cpu(answer, bench(0)[0], nj.Camera((1, 1), 5e-6))
    return {
        "programs_first": first,
        "new_cpu_s": [seconds for seconds, _ in others],
        "new_programs": [programs for _, programs in others],
        "known_cpu_s": known,
        "plan_cpu_s": plans,
        "one_pixel_cpu_s": tiny,
        "one_pixel_programs": compiled.count - before,
    }


def photographs(shared: Path) -> list[Path]:
    """The photographs under the shared folder."""
    files = [path for folder in ("photos", "trials") for path in sorted((shared / folder).glob("*"))]
    return [path for path in files if path.suffix in PICTURES and path.name != "stepped_stack.tif"]


def megapixels(path: Path) -> float:
    """Size of a picture, which is not decoded for it."""
    import imageio.v3 as iio

    rows, columns = sorted(iio.improps(path).shape)[-2:]  # the other axes are channels
    return rows * columns / 1e6


def limit(row: dict) -> float:
    """Most CPU seconds for a photograph of its size and outcome."""
    if row["megapixels"] <= 3:
        return 0.5 if row["status"] == "refused" else 1.0
    return 1.5 if row["megapixels"] <= 12 else 2.0


def photograph_task(path: str, turns: str = "3") -> dict:
    """Fit one photograph, once and then again: the median of the later ones, and the memory that the first takes."""
    import fitting

    wavelength, pixel_size = GIVEN.get(Path(path).name, (589.3e-9, None))
    times, peak = [], 0.0
    for _ in range(int(turns) + 1):
        result, seconds = cpu(fitting.fit, path, wavelength=wavelength, pixel_size=pixel_size)
        times.append(seconds)
        peak = peak_mb() if len(times) == 1 else peak  # a later one has the pixels of the result before beside its own
    answer = result.radius if result.status == "ok" else result.fringe_scale_per_px2
    sd = result.radius_sd if result.status == "ok" else result.fringe_scale_sd
    return {
        "file": Path(path).name,
        "first_cpu_s": times[0],
        "cpu_s": middle(times[1:] or times),
        "status": result.status,
        "answer": answer,
        "sd": sd,
        "message": result.message[:90],
        "peak_mb": peak,
    }


def large_task(rows: str, columns: str, folder: str) -> dict:
    """Fit a made picture of a size, read from a file."""
    import numpy as np
    import png

    path, (height, width) = Path(folder) / f"{rows}.png", (int(rows), int(columns))
    x, random = np.arange(width) - width / 2, np.random.default_rng(0)

    def line(y: int):
        turns = ((y - height / 2) ** 2 + x * x) * 30 / (width / 2) ** 2
        light = 110 - 80 * np.cos(2 * np.pi * turns) + random.normal(0, 3, width)
        return np.rint(light).astype(np.uint8)

    if not path.exists():
        with path.open("wb") as file:
            png.Writer(width, height, greyscale=True, bitdepth=8).write_packed(file, (line(y) for y in range(height)))
        return {"made": True}
    return photograph_task(str(path)) | {"megapixels": height * width / 1e6}


def stack_task(many: str = "200", pixels: str = "256") -> dict:
    """Frames a second of a drifting stack, and how far each tenth frame is from a fit of it alone."""
    import numpy as np

    import fitting

    size, count = int(pixels), int(many)
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    given = {"wavelength": 589.3e-9, "pixel_size": 10e-6, "view": "reflected", "transfer": "linear"}
    random, drift = np.random.default_rng(1), np.linspace(0, 1, count)

    def frame(t: float):
        r2 = ((x - 8 - 6 * t) ** 2 + (y + 5 - 3 * t) ** 2) * given["pixel_size"] ** 2
        gap = r2 / (2 * 0.3 * (1 + 0.02 * t)) + 2e-6 * t
        light = 100 - 70 * np.cos(4 * np.pi * gap / given["wavelength"]) + random.normal(0, 4, x.shape)
        return np.clip(np.rint(light), 0, 255).astype(np.uint8)

    frames = np.stack([frame(t) for t in drift])
    list(fitting.fit_stack(frames[:3], **given))
    begin, wall = time.process_time(), time.perf_counter()
    rows = list(fitting.fit_stack(frames, **given))
    seconds, wall = time.process_time() - begin, time.perf_counter() - wall
    away, half = [], given["wavelength"] / 2
    for k in range(0, count, 10):
        alone = fitting.fit(frames[k], **given)
        gap_sd = alone.parameters["gap"].sd
        apart = (rows[k].gap - alone.gap + half / 2) % half - half / 2
        away.append((abs(rows[k].radius - alone.radius) / alone.radius_sd, abs(apart) / gap_sd))
    return {
        "frames_per_cpu_s": count / seconds,
        "frames_per_wall_s": count / wall,
        "measured": sum(row.status == "ok" for row in rows) / count,
        "radius_from_fit_sd": max(radius for radius, _ in away),
        "gap_from_fit_sd": max(gap for _, gap in away),
    }


def main() -> None:
    """Run the task that the arguments name."""
    import jax

    if "JAX_COMPILATION_CACHE_DIR" in os.environ:
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_enable_x64", True)
    name, *rest = sys.argv[1:]
    print(json.dumps(globals()[f"{name}_task"](*rest)))

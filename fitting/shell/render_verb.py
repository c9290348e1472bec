"""The verb `render`: from options to a scene, a camera, a method, and a file."""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

import newtonjax as nj
from fitting.parameters import curved_surface, output, png, quantities_of, tiff
from fitting.shell import developing, session
from fitting.shell.bench_options import SCENES, arguments_of_scene, option_name
from fitting.shell.progress import progress
from newtonjax.methods import AbstractMethod, Splatted, unreached, why_unpaired
from newtonjax.numerics import image_memory
from newtonjax.planning import end_warnings

# The methods by their names here.
_METHODS = {"closed-form": nj.ClosedForm, "chebyshev": nj.Chebyshev, "traced": nj.Traced, "splat": nj.Splat}
_TOLERANCE = 1e-3
_TIFF = (".tif", ".tiff")
_BYTES = 12  # of memory a pixel of an image that is not written block by block


class How(NamedTuple):
    """What the options say of the method; None for what was not given."""

    method: str | None
    nodes: int | None
    epsilon: float | None
    tolerance: float | None


class Request(NamedTuple):
    """The options of the verb; None for what was not given. `seed` is None for an image without noise.

    `bench`: arguments of a ready bench, those that were given.
    """

    scene: str
    output: Path
    bench: dict
    shape: tuple[int, int] | None
    pixel_size: float | None
    how: How
    seed: int | None
    bits: int | None
    colour: bool
    explain: bool
    force: bool


class Chosen(NamedTuple):
    """How the image is computed, with its estimated errors: phase [turns], intensity over the peak.

    `splatted`: the image with its books, of a method that knows its error only afterwards.
    """

    scene: nj.Scene
    method: AbstractMethod
    phase_error: float
    intensity_error: float
    reason: str
    warnings: tuple[str, ...]
    splatted: Splatted | None = None


def run(request: Request) -> int:
    """Render, write, say what was done; the exit status."""
    kind = request.output.suffix.lower()
    if kind not in (".png", *_TIFF):
        raise ValueError(f"--output {request.output}: give a name that ends in .png, or in .tif for a large image")
    if request.colour and (kind != ".png" or request.seed is not None or request.bits not in (None, 8)):
        raise ValueError("--colour makes an 8-bit PNG without noise; leave out --expose and --bits, and end with .png")
    output.check_free([request.output], request.force, keep=(Path(request.scene),))
    with progress("loading"):
        session.prepare()
        session.keep_rays()
        scene, camera, from_file = _scene_and_camera(request)
    is_photograph = request.seed is not None and developing.has_own_codes(camera)
    if is_photograph and kind in _TIFF:
        raise ValueError(f"--output {request.output}: a photograph of this camera is a PNG; end with .png")
    if kind not in _TIFF:
        image_memory(camera.shape, _BYTES)
    with progress("rendering"):
        chosen = _choose(scene, camera, request.how)
        parts = _parts(chosen, camera, in_memory=kind not in _TIFF)
        white = peak = developing.brightest(parts, chosen.splatted)
        if request.seed is not None:
            camera = developing.exposing(camera, peak, from_file)
            white = float(camera.full_well) / float(camera.exposure)
        bits = request.bits or (8 if request.colour or camera.jpeg is not None else 16)
        _write(request, camera, parts, peak, bits)
    _say(request, camera, chosen, white, bits)
    if request.explain:
        tolerance = _TOLERANCE if request.how.tolerance is None else request.how.tolerance
        with progress("comparing methods"):
            explanation = nj.explain(scene, camera, tolerance)
        print(f"\nwhat is chosen without --method:\n{explanation}")
    return 0


def _write(request: Request, camera: nj.Camera, parts: developing.Blocks, peak: float, bits: int):
    if request.seed is not None and developing.has_own_codes(camera):
        codes = developing.photograph(parts, camera, request.seed, bits)
        output.write(request.output, png.of_codes(codes), request.force)
        return
    blocks = developing.over_white(parts, camera, request.seed, peak, bits)
    if request.output.suffix.lower() in _TIFF:
        tiff.write(request.output, camera.shape, blocks, bits, request.force)
        return
    rows = [part for _, part in blocks]
    image = rows[0] if len(rows) == 1 else np.concatenate(rows)
    output.write(request.output, png.encode(image, bits), request.force)


def _scene_and_camera(request: Request) -> tuple[nj.Scene, nj.Camera, bool]:
    """The scene, the camera, and whether a file gave the camera."""
    camera = None
    if request.scene.endswith(".toml"):
        if request.bench:
            options = ", ".join(map(option_name, request.bench))
            raise ValueError(f"{options} with {request.scene}: the file gives the scene; change it there")
        scene, camera = nj.load_scene(request.scene)
    elif request.scene in SCENES:
        scene = _bench(request.scene, request.bench)
    else:
        raise ValueError(f"scene {request.scene!r}; give {', '.join(SCENES)}, or a file that ends in .toml")
    default = nj.Camera(shape=(1024, 1024), pixel_size=5e-6) if camera is None else camera
    shape = default.shape if request.shape is None else request.shape
    pixel_size = default.pixel_size if request.pixel_size is None else request.pixel_size
    response = nj.cie_1931() if request.colour else default.response
    changed = replace(default, shape=shape, pixel_size=pixel_size, response=response)
    return scene, changed, camera is not None


def _bench(name: str, values: dict) -> nj.Scene:
    offered = arguments_of_scene(name)
    if surplus := [option_name(argument) for argument in values if argument not in offered]:
        has = ", ".join(map(option_name, offered))
        raise ValueError(f"{', '.join(surplus)} with {name}: it has {has}")
    if "wavelength" in values:
        ambient = values.get("ambient_index", 1.0)
        values = {**values, "wavelength": values["wavelength"].within(ambient)}
    return nj.air_wedge(**values) if name == "wedge" else nj.newton_rings(view=name, **values)


def _choose(scene: nj.Scene, camera: nj.Camera, how: How) -> Chosen:
    """The planned method, or the one asked for if it keeps the tolerance asked for."""
    tolerance = _TOLERANCE if how.tolerance is None else how.tolerance
    name = how.method or ("chebyshev" if how.nodes else "splat" if how.epsilon else None)
    if name is None:
        plan = nj.plan(scene, camera, tolerance)
        return Chosen(plan.scene, plan.method, plan.phase_error, plan.intensity_error, plan.reason, plan.warnings)
    if how.nodes and name != "chebyshev":
        raise ValueError(f"--nodes with --method {name}: it has none; leave one of them out")
    if how.epsilon and name != "splat":
        raise ValueError(f"--epsilon with --method {name}: it has none; leave one of them out")
    if how.tolerance is not None and name == "splat":
        raise ValueError("--tolerance with --method splat: only the phase error of its pairs is known; leave one out")
    chosen = _asked_for(scene, camera, name, how)
    if how.tolerance is not None and not chosen.intensity_error <= tolerance:
        raise ValueError(
            f"--method {name}: its estimated error {chosen.intensity_error:.2g} of the peak is over --tolerance "
            f"{tolerance:g}; leave out --method, which then is chosen to fit"
        )
    return chosen


def _asked_for(scene: nj.Scene, camera: nj.Camera, name: str, how: How) -> Chosen:
    options = {"nodes": how.nodes, "epsilon": how.epsilon}
    chosen_options = {option: value for option, value in options.items() if value is not None}
    method = _METHODS[name](**chosen_options)
    method.check(scene)
    reason, ends = "as asked for", end_warnings(scene, camera)
    if name == "splat":
        splatted = nj.splat(scene, camera, method)
        return Chosen(scene, method, splatted.error, np.nan, reason, ends, splatted)
    phase, intensity = map(float, method.error(scene, camera))
    if np.isinf(phase) and method.needs_every_beam:
        raise unreached(method)
    if np.isinf(phase):
        reason = f"{reason}; where several rays of one beam reach a pixel, only one is traced"
    return Chosen(scene, method, phase, intensity, reason, ends)


def _parts(chosen: Chosen, camera: nj.Camera, in_memory: bool) -> developing.Blocks:
    """The image in blocks of rows; not kept but computed anew each time, where memory need not hold it."""
    if chosen.splatted:
        return [(0, np.asarray(chosen.splatted.image))]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # `_say` has them
        blocks = nj.blocks(chosen.scene, camera, chosen.method)
    return list(blocks) if in_memory or blocks.rows == camera.shape[0] else blocks


def _say(request: Request, camera: nj.Camera, chosen: Chosen, white: float, bits: int) -> None:
    rows, columns = camera.shape
    is_photograph = request.seed is not None and developing.has_own_codes(camera)
    coding = "linear" if bits == 16 else "sRGB"
    if is_photograph:
        coding = "sRGB" if camera.transfer == "srgb" else "linear"
    pixel_um = float(camera.pixel_size) * 1e6
    print(f"image: {request.output}, {rows} x {columns} pixels of {pixel_um:g} um")
    print(f"values: {bits} bits, {coding}, white is {white:.6g} of the incident irradiance")
    print(f"method: {chosen.method.describe()} ({chosen.reason})")
    if chosen.splatted:
        _say_pairs(chosen.splatted, len(chosen.scene.beams))
    else:
        print(f"estimated error: {chosen.phase_error:.2g} turns, {chosen.intensity_error:.2g} of the peak intensity")
    print(f"noise: {developing.noise_of(camera, request.seed)}")
    for words in chosen.warnings:
        print(f"warning: {words}")
    _say_few_fringes(chosen.scene, camera)


def _say_few_fringes(scene: nj.Scene, camera: nj.Camera) -> None:
    """That no ring fits into the picture, as where a radius in millimetres was typed for one in metres.

    Of faces without tilts, whose rings are about the axis.
    """
    try:
        numbers = quantities_of(scene, curved_surface(scene))
    except ValueError:
        return
    if any(np.any(np.asarray(surface.tilt) != 0) for surface in scene.surfaces):
        return
    corner = float(np.hypot(*camera.shape)) / 2 * float(camera.pixel_size)
    fringes = numbers["gap_index"] * corner**2 / (numbers["radius"] * numbers["wavelength"])
    if fringes < 1:
        print(
            f"warning: {fringes:.2g} of a fringe lies between middle and corner, of a radius of "
            f"{numbers['radius']:g} m: no ring is seen; check the units (scene files are in metres)"
        )


def _say_pairs(splatted: Splatted, beams: int) -> None:
    pairs = splatted.pairs
    nodes = " x ".join(map(str, splatted.source.nodes))
    print(f"phase error of its pairs: {splatted.error:.2g} turns; a pixel shows their mean, whatever their density")
    if beams > 2:
        print(f"warning: the mean of the pairs of {beams} beams is not the sum of their fields, which traced shows")
    print(
        f"pairs: {pairs.emitted} emitted, {pairs.paired} paired, {pairs.apart} too far apart, {pairs.outside} out of "
        f"the frame, {pairs.lost} lost, of {nodes} source nodes "
        f"{splatted.source.step * 1e6:g} um apart"
    )
    if splatted.unpaired.any():
        print(f"warning: {why_unpaired(splatted)}")

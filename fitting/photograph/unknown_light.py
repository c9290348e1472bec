"""Ratios of the lenses of one set-up from colour photographs of which neither lamp nor camera is known."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from fitting.colour import COLOURS, ColourReason, Rings1D, SharedFit, fit_unknown_light, rings_in
from fitting.parameters import one_blas_thread
from fitting.photo import Photograph, Rings, read_channels
from fitting.photograph.colours import NAMES, with_light
from fitting.photograph.finding import find
from fitting.photograph.result import FitResult
from fitting.photograph.task import Task, task_of
from fitting.photograph.together_result import PictureRow, Together
from fitting.photograph.verdict import RefusedError
from fitting.reasons import Reason
from newtonjax.numerics import Statement, shown, x64

UNKNOWN = "unknown"
# What goes with unknown light; all else says something of the light, or is of the fit of one channel.
_TAKEN = ("light", "view", "transfer", "mask", "page", "pixel_size")
_FEWEST = 2
# A picture that beside the others leaves over so many times the variance that it leaves alone has another light.
_OTHER_LIGHT = 10.0


class _Picture(NamedTuple):
    """A picture whose rings were found: its name, what was read, its lit channels, and its pixel size or 0 [m]."""

    name: str
    task: Task
    rings: Rings
    channels: tuple[Photograph, ...]
    pixel_size: float


def check_unknown_light(arguments: Mapping[str, Any], shared: frozenset[str]) -> None:
    """Raises ValueError for a light that is known, and for what does not go with an unknown one."""
    light = arguments["light"]
    if not (isinstance(light, str) and light == UNKNOWN):
        raise ValueError(
            f"light is {shown(light)}; allowed: {UNKNOWN!r}, of which lenses of one set-up have ratios; under a lamp "
            "fit each picture alone (fitting.fit), and compare the results"
        )
    for name, value in arguments.items():
        if value is not None and name not in _TAKEN:
            raise ValueError(f"light={UNKNOWN!r} and {name} do not go together; leave one of them out")
    if isinstance(arguments["pixel_size"], list | tuple):
        raise ValueError("pixel_size has several values under unknown light: pictures of one set-up have one scale")
    if single := sorted(shared & {"radius", "gap"}):
        raise ValueError(f"shared holds {single[0]}, which needs a wavelength; under unknown light leave it out")


def ratios_under_unknown_light(
    images: Sequence[Any], names: Sequence[str], arguments: Sequence[Mapping[str, Any]]
) -> Together:
    """Fringe scales of the pictures, and ratios of their lenses to the first one's; `arguments` of each, as of `fit`.

    Raises ValueError and FileNotFoundError as `fit` does.
    """
    pictures, warnings = [], []
    with x64(runs_programs=False), one_blas_thread():
        for image, name, own in zip(images, names, arguments, strict=True):
            try:
                pictures.append(_picture_of(image, name, own))
            except RefusedError as refusal:
                warnings.append(Reason.PICTURE_LEFT_OUT(name=name, why=refusal.reason))
        if len(pictures) < _FEWEST:
            return _refused(Reason.TOO_FEW_PICTURES(count=len(pictures), why="; ".join(warnings)), warnings)
        common = set.intersection(*({channel.channel for channel in each.channels} for each in pictures))
        if not common:
            return _refused(ColourReason.NO_COMMON_CHANNEL(), warnings)
        fit = fit_unknown_light(
            [_rings_of(each, common) for each in pictures], NAMES[pictures[0].task.photograph.channel]
        )
    warnings += [f"{each.name}: {text}" for each in pictures for text in each.task.photograph.warnings]
    for each, alone in zip(pictures, fit.alone, strict=True):
        if alone.worse > _OTHER_LIGHT:
            return _refused(ColourReason.OTHER_LIGHT(name=each.name, worse=alone.worse, most=_OTHER_LIGHT), warnings)
    return _together(fit, pictures, warnings)


def _refused(message: Statement, warnings: list[str]) -> Together:
    return Together("refused", message, "fringe_scale", warnings=warnings)


def _picture_of(image: Any, name: str, own: Mapping[str, Any]) -> _Picture:
    """A picture with its rings. Raises RefusedError where there are none."""
    arguments = {**own, "image": image, "scene": None, "free": None, "fixed": None, "start": None}
    task, rings = find(task_of(arguments))
    channels = read_channels(image, own["transfer"], own["mask"], own["page"])
    return _Picture(name, task, rings, with_light(channels), task.quantities.given.get("pixel_size", 0.0))


def _rings_of(picture: _Picture, common: set[str]) -> Rings1D:
    photographs = tuple(channel for channel in picture.channels if channel.channel in common)
    sign = -1.0 if picture.task.contact_phase else 1.0
    numbers = tuple(NAMES[channel.channel] for channel in photographs)
    return rings_in(photographs, picture.rings, picture.pixel_size, sign, numbers)


def _together(fit: SharedFit, pictures: Sequence[_Picture], warnings: list[str]) -> Together:
    """The answer of pictures of one light."""
    scales, spread = np.exp(fit.log_scales), fit.spread
    # What a picture alone does not leave over is of the pictures' differences: noise does not show it.
    apart = fit.noise * np.sqrt(max(max(alone.worse for alone in fit.alone) - 1, 0.0))
    deviations = np.sqrt(fit.noise**2 + spread**2 + apart**2)
    # A scale falls as the radius grows.
    ratios = scales[0] / scales
    if fit.clipped:
        colours = [name for name, number in NAMES.items() if number in fit.clipped and name != "grey"]
        warnings = [*warnings, ColourReason.CHANNELS_CLIPPED(channels=" and ".join(colours))]
    rows = []
    for k, (each, alone) in enumerate(zip(pictures, fit.alone, strict=True)):
        by_itself = float(np.exp(alone.log_scale))
        ratio_sd = float(ratios[k] * deviations[1, k]) if k else None
        rows.append(
            PictureRow(
                each.name, float(scales[k]), float(scales[k] * deviations[0, k]), by_itself,
                float(np.hypot(alone.deviation, spread[0, k])) * by_itself, float(ratios[k]), ratio_sd, None,
            )
        )  # fmt: skip
    sources = {"noise": fit.noise, "models of the light": spread, "differences of the pictures": apart}
    budget = [(source, float(ratios[1] * rows_of[1, 1])) for source, rows_of in sources.items()]
    fits = [_single(fit, each, row, k) for k, (each, row) in enumerate(zip(pictures, rows, strict=True))]
    pair = {"ratio": rows[1].ratio, "ratio_sd": rows[1].ratio_sd}
    message = ColourReason.RATIOS_ALONE()
    return Together(
        "no-scale", message, "fringe_scale", **pair, budget=budget, members=rows, warnings=warnings, fits=fits
    )


def _single(fit: SharedFit, source: _Picture, row: PictureRow, picture: int) -> FitResult:
    """What the fit of all says of one picture."""
    shares = zip(fit.problem.channels, fit.explained[picture], strict=True)
    changes = "; ".join(f"{name} {shift.change[1, picture]:+.2e}" for name, shift in fit.shifts.items())
    model = {
        "fringes": "2 n t at normal incidence, exact sphere, one for all channels",
        "light": f"powers of 0 or more at {fit.problem.light.waves} waves, free in each channel, one for all pictures",
        "explained": ", ".join(f"{COLOURS[channel]} {share:.2%}" for channel, share in shares),
        "blur": "a Gaussian one, the same in all pictures",
    }
    if picture:
        model["variants"] = f"relative change of the scale over the first picture's: {changes}"
    return FitResult(
        "no-scale",
        ColourReason.RATIOS_ALONE(),
        fringe_scale_per_px2=row.value,
        fringe_scale_sd=row.sd,
        centre_px=source.rings.centre,
        explained_variance=float(fit.explained[picture].mean()),
        model=model,
    )

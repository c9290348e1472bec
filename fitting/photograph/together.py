"""Several photographs in one answer: lenses under one camera, one lens in several pictures, the ratio of two radii."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fitting.parameters import EXPONENTS, Numbers, block_of, number, says_its_origin
from fitting.photo import check_no_picture_twice
from fitting.photograph.averaging import Averaging, Member
from fitting.photograph.combination import Logarithms, combined
from fitting.photograph.evidence import Evidence
from fitting.photograph.joint import view_of
from fitting.photograph.measure import fit
from fitting.photograph.priors import Priors
from fitting.photograph.result import FitResult
from fitting.photograph.shared_gap import SharedGap, fraction_of, shared_gap, window_of
from fitting.photograph.together_result import Together
from fitting.photograph.uncertainty import GAP_WAVES
from fitting.photograph.unknown_light import check_unknown_light, ratios_under_unknown_light
from fitting.reasons import Reason
from newtonjax.numerics import shown

# What pictures may share, and what each always has of its own.
_SHARED = ("radius", "wavelength", "pixel_size", "gap_index", "distortion", "gap")
_OWN = ("phase", "centre", "contact", "film", "view", "form", "illumination")
_FEWEST = 2
# Gaps beyond this [m] are sought in none: their orders are more than any phase tells.
_WIDEST = 1e-3
_OF_ALL = ("images", "shared", "each", "names", "gap_range")
# A value for all pictures, or a list with one for each.
PerPicture = float | str | None | Sequence[float | str | None]


@says_its_origin
def fit_together(
    images: Sequence[str | Path | np.ndarray],
    *,
    shared: str | Sequence[str] = ("pixel_size", "distortion"),
    each: str | Sequence[str] = (),
    names: Sequence[str] | None = None,
    wavelength: PerPicture = None,
    pixel_size: PerPicture = None,
    radius: PerPicture = None,
    gap_index: PerPicture = None,
    wavelength_sd: PerPicture = None,
    pixel_size_sd: PerPicture = None,
    radius_sd: PerPicture = None,
    gap_index_sd: PerPicture = None,
    plate_radius: PerPicture = None,
    plate_radius_sd: PerPicture = None,
    view: PerPicture = None,
    transfer: PerPicture = None,
    mask: Any = None,
    parts: Any = None,
    page: PerPicture = None,
    scale: Any = None,
    priors: Any = None,
    axis_px: Any = None,
    axis_px_sd: PerPicture = None,
    view_angle: PerPicture = None,
    view_angle_sd: PerPicture = None,
    channel: PerPicture = None,
    noise: Any = None,
    light: str | None = None,
    gap_range: tuple[float, float] | None = None,
) -> Together:
    """One answer from several photographs of rings, with one likelihood and one covariance.

    Each picture is fitted once by `fit`; its normal equations, in which its own numbers are eliminated, are added to
    those of the others. What the pictures share is one set of numbers, with one prior: the distortion of the camera and
    where its axis is (in frames of one shape), and with it whether the camera distorts at all. Where the pictures' own
    values of these scatter beyond their deviations, all variances grow by that chi-squared over its degrees of freedom
    (Birge 1932). Of three pictures and more, a standard deviation is no smaller than that by leaving out pictures
    (Tukey's jackknife).

    Args:
      images: two photographs or more, as `fit` reads them.
      shared: what is one in all pictures: "distortion" (of the camera); "radius" (one lens, in several pictures: one
        value comes out); "pixel_size", "wavelength", "gap_index": their errors are common, and cancel in ratios. What
        is given once, for all pictures, is shared. "gap": one lens in one place in several wavelengths, whose phases
        together tell the gap at the centre beyond half a wavelength (`gap` of the result), with the probability of each
        order; no contact is fitted then.
      each: what has an error of its own in each picture though it is given once. Phase, centre, contact, film, view,
        form and illumination are always each picture's own, and so is the gap where it is not shared.
      names: of the pictures; their files' where they are not given.
      wavelength, ...: as in `fit`, lengths in metres; a list has one value for each picture: `[589.3e-9, 546.1e-9]`.
      light: "unknown" for colour photographs of one set-up of which neither lamp nor camera is known: all channels of
        all pictures have one spectrum, free but for powers of 0 or more (section `Unknown light` of the manual); with
        it go `view`, `transfer`, `mask`, `page` and one `pixel_size`. Ratios of radii come out, and fringe scales of
        the mean wave.
      gap_range: lowest and highest gap at the centre that may be [m]; half of the synthetic wavelength, 1 over the
        least difference of two wavenumbers, where it is not given.

    A picture that is refused is left out with a warning; one that contradicts the others is named. Refused is one value
    of pictures of which one lies more than ten standard deviations, and a hundredth, from the others. Raises ValueError
    and FileNotFoundError for input that cannot be used, such as one picture twice.

    """
    arguments = {name: value for name, value in locals().items() if name not in _OF_ALL}
    common = _checked_names(shared, each)
    if light is not None:
        check_unknown_light(arguments, common)
    has_gap = "gap" in common
    window = _checked_range(gap_range, has_gap)
    pictures, labels = _checked_pictures(images, names)
    by_picture = [_arguments_of(arguments, place, len(pictures)) for place in range(len(pictures))]
    if has_gap:
        by_picture = [own | {"parts": _open(own["parts"])} for own in by_picture]
    # Another page, channel or wavelength of a file is another picture.
    chosen = [[shown(own[name]) for name in ("page", "channel", "wavelength", "mask")] for own in by_picture]
    check_no_picture_twice(pictures, labels, chosen)
    if light is not None:
        return ratios_under_unknown_light(pictures, labels, by_picture)
    fits = [fit(image, **own) for image, own in zip(pictures, by_picture, strict=True)]
    numbers = [_logarithms(result) for result in fits]
    usable = [k for k, number in enumerate(numbers) if number is not None]
    warnings: list[str] = [
        Reason.PICTURE_LEFT_OUT(name=labels[k], why=fits[k].message) for k in range(len(fits)) if k not in usable
    ]
    if len(usable) < _FEWEST:
        message = Reason.TOO_FEW_PICTURES(count=len(usable), why="; ".join(warnings))
        return Together("refused", message, warnings=warnings, fits=fits)
    results = [fits[k] for k in usable]
    if len({(result.status, result.measured) for result in results}) > 1:
        raise ValueError("the pictures measure different quantities; give the same ones for each")
    own = {each} if isinstance(each, str) else set(each)
    once = {name for name in EXPONENTS if not isinstance(arguments.get(name), list | tuple)} | {"plate_radius"}
    alike = frozenset((once | common) - own)
    linear = [number for number in numbers if number is not None]
    answer = combined(linear, [labels[k] for k in usable], alike, common - {"gap"}, warnings, results)
    if not has_gap:
        return answer
    return replace(answer, gap=_gap_of(results, window))


def ratio(
    first: str | Path | np.ndarray,
    second: str | Path | np.ndarray,
    *,
    names: Sequence[str] | None = None,
    wavelength: PerPicture = None,
    pixel_size: PerPicture = None,
    radius: PerPicture = None,
    gap_index: PerPicture = None,
    wavelength_sd: PerPicture = None,
    pixel_size_sd: PerPicture = None,
    radius_sd: PerPicture = None,
    gap_index_sd: PerPicture = None,
    plate_radius: PerPicture = None,
    plate_radius_sd: PerPicture = None,
    view: PerPicture = None,
    transfer: PerPicture = None,
    mask: Any = None,
    parts: Any = None,
    page: PerPicture = None,
    scale: Any = None,
    priors: Any = None,
    axis_px: Any = None,
    axis_px_sd: PerPicture = None,
    view_angle: PerPicture = None,
    view_angle_sd: PerPicture = None,
    channel: PerPicture = None,
    noise: Any = None,
    light: str | None = None,
) -> Together:
    """The radius of the second picture's lens over that of the first, seen by one camera at one scale.

    The scale cancels, with its standard deviation: it may be unknown. `names` and what follows, lengths
    in metres: as in `fit_together`.

    Raises ValueError and FileNotFoundError as it does.
    """
    arguments = {name: value for name, value in locals().items() if name not in ("first", "second")}
    return fit_together([first, second], **arguments)


def _checked_names(shared: Any, each: Any) -> frozenset[str]:
    """What is shared. Raises ValueError for other names, and for what is both shared and each picture's own."""
    groups = []
    for argument, names, allowed in (("shared", shared, _SHARED), ("each", each, (*_SHARED, *_OWN))):
        words = (names,) if isinstance(names, str) else names
        if not isinstance(words, list | tuple | set | frozenset) or not all(isinstance(word, str) for word in words):
            raise ValueError(f"{argument} is {shown(names)}; allowed: names among {', '.join(allowed)}")
        if unknown := [word for word in words if word not in allowed]:
            hint = "; frames of one surface, stepped in phase, are for fitting.form" if unknown[0] in _OWN else ""
            raise ValueError(f"{argument} holds {shown(unknown[0])}; allowed: {', '.join(allowed)}{hint}")
        groups.append(frozenset(words))
    if twice := sorted(groups[0] & groups[1] - {"pixel_size", "distortion"}):
        raise ValueError(f"{twice[0]} is both shared and each picture's own; leave it out of one")
    return groups[0] - groups[1]


def _checked_pictures(images: Any, names: Any) -> tuple[list, list[str]]:
    """The pictures and their names. Raises ValueError for fewer than two, or another number of names."""
    pictures = list(images) if isinstance(images, list | tuple) else []
    if len(pictures) < _FEWEST:
        raise ValueError(f"images is {shown(images)}; allowed: a list of two photographs or more")
    if names is None:
        files = [Path(image).name if isinstance(image, str | Path) else "" for image in pictures]
        return pictures, [file or f"picture {k}" for k, file in enumerate(files, 1)]
    labels = list(names) if isinstance(names, list | tuple) else []
    if len(labels) != len(pictures) or not all(isinstance(label, str) for label in labels):
        raise ValueError(f"names is {shown(names)}; allowed: a text for each of the {len(pictures)} pictures")
    return pictures, labels


def _arguments_of(arguments: dict[str, Any], place: int, count: int) -> dict[str, Any]:
    """The arguments of one picture's fit. Raises ValueError for a list of another length."""
    own = {}
    for name, value in arguments.items():
        is_list = isinstance(value, list | tuple)
        # An axis is itself two numbers, and so may noise be.
        is_list = is_list and not (name in ("axis_px", "noise") and all(isinstance(at, int | float) for at in value))
        if is_list and len(value) != count:
            raise ValueError(f"{name} has {len(value)} values for {count} pictures; give one for each, or one")
        own[name] = value[place] if is_list else value
    return own


def _checked_range(gap_range: Any, has_gap: bool) -> tuple[float, float] | None:
    """Lowest and highest gap [m]. Raises ValueError for what is no range, and for one without a gap that is shared."""
    if gap_range is None:
        return None
    if not has_gap:
        raise ValueError('gap_range is that of a gap in all pictures; add "gap" to shared, or leave gap_range out')
    ends = np.asarray(gap_range, dtype=object)
    low, high = (number("gap_range", end) for end in ends) if ends.shape == (2,) else (np.nan, np.nan)
    if not -_WIDEST <= low < high <= _WIDEST:
        raise ValueError(
            f"gap_range is {shown(gap_range)}; allowed: the lowest and the highest gap in metres, up to {_WIDEST:g} m"
        )
    return low, high


def _open(parts: Any) -> Any:
    """The wishes without a contact: faces that touch have no gap between them."""
    if parts is None or (isinstance(parts, Mapping) and not parts.get("contact") and not parts.get("film")):
        return {**(parts or {}), "contact": False, "film": False}
    if isinstance(parts, Mapping):
        raise ValueError("shared holds gap, and parts a contact, in which the gap is 0; leave one of them out")
    return parts


def _gap_of(fits: Sequence[FitResult], window: tuple[float, float] | None) -> SharedGap:
    """The gap of all pictures. Raises ValueError where their wavelengths are one, or not given."""
    quantities = [fit.evidence.known for fit in fits if fit.evidence is not None]
    if missing := [name for name in ("wavelength", "gap_index") if any(name not in each.given for each in quantities)]:
        raise ValueError(f"shared holds gap, which takes the {missing[0]} of each picture; give it")
    fractions = [fraction for fit in fits if (fraction := fraction_of(fit)) is not None]
    wavelengths = [fraction.wavelength for fraction in fractions]
    usual = window_of(wavelengths)
    # The gap under a blur b is that at the centre and s² b² / R.
    shift = wavelengths[0] * float(fits[0].fringe_scale_per_px2 or 0.0)
    index = quantities[0]
    return shared_gap(fractions, window or usual, shift, index.sd.get("gap_index", 0.0) / index.given["gap_index"])


def _logarithms(result: FitResult) -> Logarithms | None:
    """What is combined of a fit, None of one without an answer.

    The logarithm of its number, and the deviations of what is beside the image's own.
    """
    evidence, scale = result.evidence, result.fringe_scale_per_px2
    if evidence is None or result.picture is None or not scale or not result.fringe_scale_sd:
        return None
    averaging = evidence.averaging or _of_one_set(evidence)
    average = averaging.mean(evidence.variance, ratio=evidence.ratio)
    curvature = float(Numbers(*average.numbers).curvature)
    own = float(block_of(average.covariance, ["curvature"]).item()) / curvature**2
    beside = float(np.sqrt(max((result.fringe_scale_sd / scale) ** 2 - own, 0.0)))
    view = view_of(averaging, evidence.variance, evidence.ratio, result.picture.photograph.image.shape[:2])
    known, unknown = evidence.known, evidence.known.unknown
    if unknown is None or (answer := result.parameters.get(unknown)) is None:
        given = sum(EXPONENTS[name] * np.log(value) for name, value in known.given.items())
        return Logarithms(view, curvature, float(given - np.log(scale)), scale, -1.0, beside, 0.0, {})
    value = float(answer.value)
    slope = 1 / EXPONENTS[unknown]
    if known.plate is not None:
        slope *= 1 + value / known.plate[0]
    quantities = {name: sd / value for name, sd in result.budget if name in EXPONENTS or name == "plate_radius"}
    waves = min(dict(result.budget).get(GAP_WAVES, 0.0) / abs(value * slope), beside)
    beside = float(np.sqrt(beside**2 - waves**2))
    return Logarithms(view, curvature, float(np.log(value)), value, slope, beside, waves, quantities)


def _of_one_set(evidence: Evidence) -> Averaging:
    """A fit beside which no part was averaged."""
    return Averaging((Member(evidence.found, Priors(0.0, {}), [frozenset()]),))

"""What a worker process does with one photograph of a batch."""

import time
import warnings
from contextlib import suppress
from datetime import datetime
from functools import cache
from pathlib import Path
from typing import Any

import fitting
from fitting.batches import FAILED, Job
from fitting.parameters import TABLE
from fitting.reasons import Reason
from fitting.shell import session

# EXIF: where a camera's own entries stand, and when the photograph was taken.
_EXIF, _TAKEN = 0x8769, 0x9003


@cache
def prepare() -> None:
    """Load what a fit needs, once in a process, with compiled programs shared between processes and runs."""
    session.prepare()
    from fitting.photograph import fit

    del fit


def measure(job: Job) -> dict[str, Any]:
    """What the row of a photograph holds besides its identity; whatever goes wrong is a row too."""
    prepare()
    began = time.perf_counter()
    try:
        result = fitting.fit(job.path, page=job.page, **job.arguments)
    except Exception as error:  # one photograph of thousands must not end the others, whatever its decoder raises
        about = {"status": FAILED, "reason": type(error).__name__, "message": " ".join(str(error).split())}
        seconds = time.perf_counter() - began
        return {**about, "taken": taken(Path(job.path)), "seconds": seconds}
    return {**_answer(result), **_pages(result), "taken": taken(Path(job.path)), "seconds": result.seconds}


def _answer(result: fitting.FitResult) -> dict[str, Any]:
    """The measured quantity, or the fringe scale where a quantity for it is missing, and all that the result says."""
    about = {"status": result.status, "reason": result.reason, "message": str(result.message)}
    number = result.parameters.get(result.measured)
    quantity, unit, value, sd = result.measured, TABLE[result.measured].unit, None, None
    if result.status == "ok" and number is not None:
        value, sd = number.value, number.sd
    elif result.status == "no-scale":
        scale = TABLE["fringe_scale"]
        quantity, unit, value, sd = scale.name, scale.unit, result.fringe_scale_per_px2, result.fringe_scale_sd
    noise = dict(result.budget).get("noise")
    numbers = {"quantity": quantity, "unit": unit, "value": value, "sd": sd, "sd_noise": noise}
    return {
        **about,
        **({} if value is None else numbers),
        "warning_codes": result.warning_codes,
        "result": result.to_dict(),
    }


def _pages(result: fitting.FitResult) -> dict[str, int]:
    """The pages of a file of which the first was measured; those that follow are jobs of their own."""
    for warning in result.warnings:
        if getattr(warning, "code", "") == Reason.FIRST_PAGE.name:
            return {"pages": getattr(warning, "values", {})["pages"]}
    return {}


def taken(path: Path) -> str:
    """When a photograph was taken: local time by its camera, else that of the file; ISO 8601, empty where unknown."""
    # Whatever a damaged head makes Pillow raise, the measurement has met it before, and said so.
    with suppress(Exception), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from PIL import Image

        with Image.open(path) as picture:
            text = picture.getexif().get_ifd(_EXIF)[_TAKEN]
            return datetime.strptime(text, "%Y:%m:%d %H:%M:%S").isoformat()
    with suppress(OSError):
        return datetime.fromtimestamp(path.stat().st_mtime).isoformat(timespec="milliseconds")
    return ""

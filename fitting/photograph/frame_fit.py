"""The row of one frame of a stack, and how its numbers become quantities."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from fitting.estimate import Fitted
from fitting.parameters import EXPONENTS, UNITS, Numbers, Parameter, Quantities, block_of
from fitting.photograph.averaging import variance_of
from fitting.photograph.meridians import View, meridians_of
from fitting.photograph.result import FitResult


@dataclass(frozen=True, slots=True)
class FrameFit:
    """A row of `fit_stack`: what one frame says. Lengths in metres; None is what it does not give.

    - `index`: of the frame, from 0; `status`, `message`: as those of `fit`; a frame without an answer says why.
    - `measured`: the quantity that is not given; `parameters`: it by name, with its standard deviation.
    - `radius`, `radius_sd` (total; what is given is the same for all frames), `radius_sd_image` (of the frame alone).
    - `gap`, `gap_sd`: at the rings' centre, followed from frame to frame, so that it leaves half a wavelength.
    - `centre_px` (x, y), `centre_sd_px`; `fringe_scale_per_px2`, `fringe_scale_sd`; `contact_radius`.
    - `explained_variance`: as in `FitResult`.
    - `searched`: whether the rings were searched, as in the first frame, and not followed from the last one. After the
      first, the gap then is the one nearest to the last.
    """

    index: int
    status: str
    message: str = ""
    measured: str = "radius"
    radius: float | None = None
    radius_sd: float | None = None
    radius_sd_image: float | None = None
    gap: float | None = None
    gap_sd: float | None = None
    centre_px: tuple[float, float] | None = None
    centre_sd_px: tuple[float, float] | None = None
    fringe_scale_per_px2: float | None = None
    fringe_scale_sd: float | None = None
    contact_radius: float | None = None
    explained_variance: float | None = None
    searched: bool = False
    parameters: Mapping[str, Parameter] = field(default_factory=dict)

    @property
    def reason(self) -> str | None:
        """The name of `message` in `fitting.Reason`, None where there is no message."""
        return getattr(self.message, "code", None)

    def to_dict(self) -> dict[str, Any]:
        """The row by name, the parameters as plain dictionaries: for a table or JSON."""
        row = {name: getattr(self, name) for name in self.__slots__ if name != "parameters"}
        row |= {"message": str(self.message), "reason": self.reason}
        return row | {"parameters": {name: asdict(parameter) for name, parameter in self.parameters.items()}}


@dataclass(frozen=True)
class FrameScale:
    """From a frame's numbers to quantities; what a searched frame's budget adds to the noise goes for all after it.

    - `half`: turns at a gap of nothing; `plate`: radius of the plate [m]; `gap`: the one that is held [m]; `view`: what
      is given of its angle.
    - `beside`: relative standard deviation of the fringe scale by the image apart from noise; `given`: of the answer by
      what is given; `message`: of a fit without a scale.
    """

    known: Quantities
    half: float
    plate: float | None
    gap: float | None
    beside: float = 0.0
    given: float = 0.0
    message: str = ""
    view: View | None = None

    def counted(self, fitted: Fitted, last: Fitted | None) -> Fitted:
        """A searched fit whose phase is the one next to the last frame's, or to a gap of nothing."""
        phase = Numbers(*fitted.numbers).phase
        near = self.half if last is None else Numbers(*last.numbers).phase
        numbers = np.array(Numbers(*fitted.numbers)._replace(phase=phase + np.round(near - phase)))
        return replace(fitted, solution=replace(fitted.solution, numbers=numbers))

    def calibrated(self, result: FitResult, fitted: Fitted) -> "FrameScale":
        """With the relative deviations of a result of `fit`."""
        relative = (result.fringe_scale_sd or 0.0) / (result.fringe_scale_per_px2 or 1.0)
        noise = _deviations(fitted).curvature / abs(Numbers(*fitted.numbers).curvature)
        answer = result.parameters.get(result.measured)
        rows = [sd for source, sd in result.budget if source in self.known.sd or source == "plate_radius"]
        return replace(
            self,
            beside=float(np.sqrt(max(relative**2 - noise**2, 0.0))),
            given=float(np.linalg.norm(rows)) / answer.value if answer and rows else 0.0,
            message=result.message,
        )

    def row(self, number: int, fitted: Fitted, searched: bool = False) -> FrameFit:
        """The row of a fit."""
        frame, sds, numbers = fitted.model.frame, _deviations(fitted), Numbers(*fitted.numbers)
        scale = numbers.curvature / frame.unit**2
        relative = np.hypot(sds.curvature / abs(numbers.curvature), self.beside)
        x, y = frame.middle
        row = FrameFit(
            number,
            "no-scale",
            self.message,
            self.known.unknown or "radius",
            centre_px=(float(x + numbers.centre_x * frame.unit), float(y + numbers.centre_y * frame.unit)),
            centre_sd_px=(float(sds.centre_x * frame.unit), float(sds.centre_y * frame.unit)),
            fringe_scale_per_px2=float(scale),
            fringe_scale_sd=float(relative * abs(scale)),
            explained_variance=float(fitted.explained),
            searched=searched,
        )
        return row if self.known.unknown is None else self._scaled(row, fitted, sds.phase, float(relative))

    def _scaled(self, row: FrameFit, fitted: Fitted, phase_sd: float, relative: float) -> FrameFit:
        """The row with the quantities that follow from its fringe scale."""
        quantities, measured = self.known, self.known.measured
        values = quantities.values(row.fringe_scale_per_px2 or np.nan)
        exponent = EXPONENTS[measured]
        relative /= abs(exponent)
        radii: dict[str, Parameter] = {}
        if self.view is not None and "oblique_view" in fitted.parts:
            meridians = meridians_of(fitted.numbers, _covariance(fitted), self.view)
            if measured == "radius" and self.plate is None:
                radii = meridians.parameters(values["radius"], values["radius"] * float(np.hypot(relative, self.given)))
            flattening, deviation = meridians.flattening
            values[measured] *= np.exp(flattening / exponent)
            relative = float(np.hypot(relative, deviation / abs(exponent)))
        if self.plate is not None:
            effective = values["radius"]
            values["radius"] = 1 / (1 / effective - 1 / self.plate)
            relative *= values["radius"] / effective
        value = float(values[measured])
        image, total = value * relative, value * float(np.hypot(relative, self.given))
        period = values["wavelength"] / (2 * values["gap_index"])
        numbers = Numbers(*fitted.numbers)
        gap = (numbers.phase - self.half) * period if self.gap is None else self.gap
        wave_sd, index_sd = (quantities.sd.get(name, 0.0) / values[name] for name in ("wavelength", "gap_index"))
        disc = float(np.sqrt(max(numbers.contact, 0.0))) * fitted.model.frame.unit * values["pixel_size"]
        is_radius = measured == "radius"
        return replace(
            row,
            status="ok",
            message="",
            radius=float(values["radius"]),
            radius_sd=total if is_radius else quantities.sd.get("radius"),
            radius_sd_image=image if is_radius else None,
            gap=float(gap),
            gap_sd=float(np.linalg.norm([phase_sd * period, gap * wave_sd, gap * index_sd])),
            contact_radius=disc if "contact" in fitted.parts else None,
            parameters={measured: Parameter(value, total, False, measured, UNITS[measured])} | radii,
        )


def _deviations(fitted: Fitted) -> Numbers:
    """Standard deviations of the numbers by the frame's noise, and by errors that its neighbouring pixels share."""
    return Numbers(*np.sqrt(np.clip(np.diag(block_of(_covariance(fitted))), 0.0, None)))


def _covariance(fitted: Fitted) -> np.ndarray:
    return fitted.matrix.covariance(variance_of(fitted)[0])

"""What a fit returns: numbers with their standard deviations, the reason where there are none, and a report."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from fitting.parameters import (
    TABLE,
    AbstractMeasurement,
    Origin,
    Parameter,
    common_from,
    parameters_from,
    with_unit,
)
from fitting.photograph.evidence import Evidence
from fitting.photograph.picture import DrawnPicture, Picture
from fitting.photograph.report_text import dominant_of, headline_of, report_of, unstated_of
from fitting.photograph.ring_radii import KEYS, KINDS, FittedRing, table_of
from fitting.photograph.rival import Finding
from newtonjax.numerics import require_choice


@dataclass(frozen=True, repr=False, eq=False)
class FitResult(AbstractMeasurement):
    """The outcome of `fitting.fit`. Lengths in metres; `None` is what the data do not give.

    - `status`: "ok", "no-scale" (rings, but a quantity is missing for a radius), "refused" or "not-converged";
      `message`: the reason.
    - `radius`, `radius_sd` (total), `radius_interval` (95 %), `radius_sd_noise`.
    - `fringe_scale_per_px2`: s²/(R λ) times the gap's index, what the image alone says; where there is a distortion,
      on the camera's axis; `fringe_scale_sd`: all but what is given.
    - `centre_px` (x, y); `gap`: at the centre, known modulo half a wavelength in the gap; `contact_radius`: of the disc
      that is pressed flat, None without.
    - `explained_variance`: share of the variance about a smooth background that the fringes explain.
    - `budget`: (source, standard deviation) of the measured quantity, `measured` by name.
    - `per_percent`: by how much 1 % of a given quantity moves the measured one, for those without standard deviation.
    - `parameters` by name; `covariance` of those free, from noise, in the order `names`.
    - `rings`: dark and bright ones by order with their radii, from the centre outwards; `ring_table` for `rings`.
    - `residual` [rows, columns]: photograph less model, in units of the photograph's brightest pixels.
    - `priors`: by number of a part that may be there: value and standard deviation before the image is seen, and why.
    - `rivals`: what else may have made the rings, by name: value of a statistic, its limit, and the consequence
      ("refusal", "budget" or "warning").
    - `evidence`: what `fitting.sample` draws from.
    """

    status: str
    message: str = ""
    measured: str = "radius"
    radius: float | None = None
    radius_sd: float | None = None
    radius_interval: tuple[float, float] | None = None
    radius_sd_noise: float | None = None
    fringe_scale_per_px2: float | None = None
    fringe_scale_sd: float | None = None
    centre_px: tuple[float, float] | None = None
    gap: float | None = None
    contact_radius: float | None = None
    explained_variance: float | None = None
    budget: list[tuple[str, float]] = field(default_factory=list)
    per_percent: dict[str, float] = field(default_factory=dict)
    warnings: list[str] = field(default_factory=list)
    model: dict[str, str] = field(default_factory=dict)
    priors: dict[str, dict[str, Any]] = field(default_factory=dict)
    rivals: list[Finding] = field(default_factory=list)
    rings: list[FittedRing] = field(default_factory=list)
    seconds: float = 0.0
    parameters: dict[str, Parameter] = field(default_factory=dict)
    names: tuple[str, ...] = ()
    covariance: np.ndarray | None = None
    picture: Picture | DrawnPicture | None = None
    evidence: Evidence | None = None
    origin: Origin | None = None

    @property
    def residual(self) -> np.ndarray | None:
        """Photograph less model [rows, columns], None without a fit."""
        return None if self.picture is None else self.picture.photograph.image - self.picture.fitted

    @property
    def radius_along(self) -> float | None:
        """Radius of the steeper meridian [m], None where the rings are round or give no radius."""
        return self._value("radius_along")

    @property
    def radius_across(self) -> float | None:
        """Radius of the flatter meridian [m]."""
        return self._value("radius_across")

    @property
    def astigmatism_axis(self) -> float | None:
        """Angle of the steeper meridian [rad], from the image's x axis towards its y axis, 0 to pi."""
        return self._value("astigmatism_axis")

    def _value(self, name: str) -> float | None:
        return self.parameters[name].value if name in self.parameters else None

    def ring_table(self, kind: str = "dark") -> dict[str, list]:
        """Order and radius of the "dark" or "bright" rings in columns that `fitting.rings` reads: mm, or px unscaled.

        Raises ValueError for another kind.
        """
        require_choice("kind", kind, KINDS)
        return table_of(self.rings, kind)

    def figure(self, ax=None) -> Any:
        """Photograph with the fitted dark rings over it, residual, unwrapped view and profile, as a matplotlib figure.

        In the unwrapped view a good fit is straight vertical lines; the fit's own fringes are drawn under the data's.
        Without an answer it is the reason. With `ax` the photograph and its rings alone are drawn into these axes.

        Raises ValueError for a loaded result, which has no photograph, and with `ax` for one without rings.
        """
        from fitting.photograph import figure

        if ax is None and (self.picture is None or self.centre_px is None):
            if self.centre_px is not None:
                raise ValueError("a loaded result has no photograph to draw; fit the photograph again")
            return self._reason_figure()
        if self.picture is None or self.centre_px is None:
            raise ValueError(f"a result of status {self.status!r} has no photograph with rings; a loaded one has none")
        if ax is None:
            return figure.of_picture(self.picture, self.centre_px, self._title())
        figure.draw_photograph(self.picture, self.centre_px, ax)
        return ax.figure

    def unwrapped_figure(self, ax=None) -> Any:
        """The order across against the angle down, in which a good fit is straight lines; into `ax` where it is given.

        Raises ValueError for a result without rings, and for a loaded one, which has no photograph.
        """
        from matplotlib.figure import Figure

        from fitting.photograph import figure

        if self.picture is None or self.centre_px is None:
            raise ValueError(f"a result of status {self.status!r} has no photograph with rings; a loaded one has none")
        axes = Figure(figsize=(8, 6), layout="constrained").subplots() if ax is None else ax
        figure.draw_unwrapped(self.picture, self.centre_px, axes)
        return axes.figure

    headline, dominant, unstated, report = headline_of, dominant_of, unstated_of, report_of

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """The budget of what is measured."""
        return {with_unit(self.measured, TABLE[self.measured].unit): self.budget} if self.budget else {}

    def tried_figure(self) -> Any:
        """The photograph with the rings of the fit that was refused; None without such a fit."""
        from fitting.photograph import figure

        return None if self.picture is None else figure.of_trial(self.picture)

    def alternatives(self) -> list[tuple[str, str]]:
        """The rivals of the rings, each with its statistic and limit."""
        return [
            (finding.rival, f"{finding.value:.3g}, limit {finding.limit:.3g}: {finding.words}")
            for finding in self.rivals
        ]

    def _title(self) -> str:
        if self.status == "ok":
            return self.headline()
        scale = self.fringe_scale_per_px2
        return f"{self.status}" + (f", fringe scale {scale:.6g} per px²" if scale else "")

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell: units in the keys, null for what is not determined."""
        radius, scale = TABLE["radius"], TABLE["fringe_scale"]
        answer = {
            "status": self.status,
            "message": str(self.message),
            radius.key(): self.radius,
            radius.key("sd"): self.radius_sd,
            radius.key("interval"): self.radius_interval and list(self.radius_interval),
            radius.key("sd_noise"): self.radius_sd_noise,
            scale.key(): self.fringe_scale_per_px2,
            scale.key("sd"): self.fringe_scale_sd,
            "centre_px": self.centre_px and list(self.centre_px),
            TABLE["gap"].key(): self.gap,
            TABLE["contact_radius"].key(): self.contact_radius,
            "explained_variance": self.explained_variance,
            "budget": [{"source": source, TABLE[self.measured].sd_key: sd} for source, sd in self.budget],
            "per_percent": dict(self.per_percent),
            "model": dict(self.model),
            "priors": {name: dict(prior) for name, prior in self.priors.items()},
            "rivals": [finding._asdict() | {"words": str(finding.words)} for finding in self.rivals],
            "rings": [dict(zip(KEYS, ring, strict=True)) for ring in self.rings],
            "measured": self.measured,
            "parameters": {name: asdict(parameter) for name, parameter in self.parameters.items()},
            "names": list(self.names),
            "covariance": None if self.covariance is None else self.covariance.tolist(),
            "seconds": self.seconds,
            **self._common(),
        }
        if self.measured != "radius" and self.measured in self.parameters:
            spec, parameter = TABLE[self.measured], self.parameters[self.measured]
            answer |= {spec.key(): parameter.value, spec.key("sd"): parameter.sd}
        return answer

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "FitResult":
        """The result that `to_dict` was called of, without its pixels."""
        radius, scale = TABLE["radius"], TABLE["fringe_scale"]
        interval, centre, covariance = saved[radius.key("interval")], saved["centre_px"], saved["covariance"]
        status, message, warnings, origin = common_from(saved)
        return cls(
            status,
            message,
            measured=saved["measured"],
            radius=saved[radius.key()],
            radius_sd=saved[radius.key("sd")],
            radius_interval=interval and (interval[0], interval[1]),
            radius_sd_noise=saved[radius.key("sd_noise")],
            fringe_scale_per_px2=saved[scale.key()],
            fringe_scale_sd=saved[scale.key("sd")],
            centre_px=centre and (centre[0], centre[1]),
            gap=saved[TABLE["gap"].key()],
            contact_radius=saved[TABLE["contact_radius"].key()],
            explained_variance=saved["explained_variance"],
            budget=[(row["source"], row[TABLE[saved["measured"]].sd_key]) for row in saved["budget"]],
            per_percent=dict(saved.get("per_percent", {})),
            warnings=warnings,
            model=dict(saved["model"]),
            priors=dict(saved.get("priors", {})),
            rivals=[Finding(**finding) for finding in saved.get("rivals", ())],
            rings=[FittedRing(*(ring[key] for key in KEYS)) for ring in saved.get("rings", ())],
            seconds=saved["seconds"],
            parameters=parameters_from(saved),
            names=tuple(saved["names"]),
            covariance=None if covariance is None else np.array(covariance, float),
            origin=origin,
        )

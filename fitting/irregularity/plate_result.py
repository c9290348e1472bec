"""What fringes under a test plate say of a part: power, irregularity, radius."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from fitting.irregularity.plate_radius import PartRadius, PlateLengths
from fitting.irregularity.result import Form
from fitting.parameters import AbstractMeasurement, Origin, Parameter, between, common_from, with_sd

_NUMBERS = ("visibility", "blur_px", "rings_move")
_POWER = 2 * np.sqrt(3)


@dataclass(frozen=True, repr=False, eq=False)
class PlateTest(AbstractMeasurement):
    """The outcome of `fitting.plate_test`.

    - `status`: "ok", "refused" or "not-converged" with a `message`, which names the picture that would help.
    - `form`: the form of the gap as of `fitting.form`: terms, covariance, maps, words of ISO 10110-5, budget.
    - `power`, `irregularity`, `irregularity_rms`: (value, standard deviation) in fringes of λ/2; None for a refusal.
      Power is peak to valley, positive where the gap grows outwards; its sign counts where `form.sign` is not None.
    - `part`: the part's radius, its difference from the plate's and their budget; None where it is not determined.
    - `visibility`, `blur_px`: of one picture's fringes, standard deviation of the blur in its pixels.
    - `lengths`, `rings_move`: what was given.
    """

    status: str
    message: str = ""
    form: Form = field(default_factory=lambda: Form("refused"))
    part: PartRadius | None = None
    visibility: float | None = None
    blur_px: float | None = None
    lengths: PlateLengths = field(default_factory=PlateLengths)
    rings_move: str | None = None
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None

    @property
    def power(self) -> tuple[float, float] | None:
        """Power in fringes, peak to valley, with its sign, and its standard deviation."""
        if self.form.coefficients is None or self.form.sds is None:
            return None
        return float(_POWER * self.form.coefficients[3]), float(_POWER * self.form.sds[3])

    @property
    def irregularity(self) -> tuple[float, float] | None:
        """Irregularity in fringes, peak to valley (B of ISO 10110-5), and its standard deviation."""
        return self.form.indications.get("B")

    @property
    def irregularity_rms(self) -> tuple[float, float] | None:
        """Irregularity in fringes, rms (RMSi of ISO 10110-5), and its standard deviation."""
        return self.form.indications.get("RMSi")

    @property
    def parameters(self) -> dict[str, Parameter]:
        """What was measured, and given, by name; what was measured is empty for a refusal."""
        rows: dict[str, Parameter] = {}
        for name, pair in (
            ("power", self.power),
            ("irregularity", self.irregularity),
            ("irregularity_rms", self.irregularity_rms),
        ):
            if pair is not None:
                rows[name] = Parameter(*pair, False, name, "fringe")
        if self.part is not None:
            rows["radius"] = Parameter(self.part.radius, self.part.radius_sd, False, "radius", "m")
            pair = self.part.difference, self.part.difference_sd
            rows["radius_difference"] = Parameter(*pair, False, "radius_difference", "m")
        for name in ("plate_radius", "wavelength", "diameter"):
            value = getattr(self.lengths, name)
            if value is not None:
                rows[name] = Parameter(value, getattr(self.lengths, f"{name}_sd"), True, name, "m")
        return rows

    @property
    def model(self) -> dict[str, str]:
        """What was fitted; empty for a refusal."""
        if self.form.coefficients is None:
            return {}
        light = "one illumination of degree 2, one visibility, one blur" if self.visibility else "free at every pixel"
        sign = (
            "open: power is shown positive" if self.form.sign is None else "power positive where the gap grows outwards"
        )
        return {"light": light, "form": self.form.model["form"], "sign": sign}

    def headline(self) -> str:
        """Power, irregularity and radius in one line, or why there are none."""
        if self.power is None or self.irregularity is None:
            return super().headline()
        text = f"power = {with_sd(*self.power)}, irregularity = {with_sd(*self.irregularity)} fringes"
        return text if self.part is None else f"{text}, radius = {with_sd(self.part.radius, self.part.radius_sd, 'm')}"

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """That of the radius, and those of the form."""
        of_radius = {} if self.part is None else {"radius [m]": self.part.budget}
        return of_radius | self.form.budgets()

    def tried_figure(self) -> Any:
        """The picture with the aperture in which fringes were looked for; None without one."""
        return self.form.tried_figure()

    def to_dict(self) -> dict[str, Any]:
        """The JSON object of the shell; `form` is that of `Form`."""
        pairs = {"power": self.power, "irregularity": self.irregularity, "irregularity_rms": self.irregularity_rms}
        numbers = {f"{name}_fringe": pair and pair[0] for name, pair in pairs.items()}
        numbers |= {f"{name}_sd_fringe": pair and pair[1] for name, pair in pairs.items()}
        part = self.part
        return {
            "status": self.status,
            "message": str(self.message),
            **numbers,
            "radius_m": part and part.radius,
            "radius_sd_m": part and part.radius_sd,
            "part": part and {**part._asdict(), "budget": [list(row) for row in part.budget]},
            **{name: getattr(self, name) for name in _NUMBERS},
            "lengths_m": self.lengths._asdict(),
            "form": self.form.to_dict(),
            "parameters": {name: asdict(parameter) for name, parameter in self.parameters.items()},
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "PlateTest":
        """The result that `to_dict` was called of."""
        status, message, warnings, origin = common_from(saved)
        part = saved["part"]
        if part is not None:
            rows = [(name, float(sd)) for name, sd in part["budget"]]
            part = PartRadius(**{**part, "radius_interval": tuple(part["radius_interval"]), "budget": rows})
        return cls(
            status,
            message,
            form=Form.from_dict(saved["form"]),
            part=part,
            lengths=PlateLengths(**saved["lengths_m"]),
            warnings=warnings,
            origin=origin,
            **{name: saved[name] for name in _NUMBERS},
        )

    def figure(self, ax=None) -> Any:
        """As that of `fitting.form`: the picture with its fringes, the departure from a sphere and its deviation.

        With `ax` the picture with its fringes alone. Raises ValueError where there is no photograph.
        """
        if self.form.photograph is not None and self.form.coefficients is None:
            return self._reason_figure()
        return self.form.figure(ax)

    def report(self) -> str:
        """The result as text."""
        lines = [f"[[Test plate]]  {self.status}" + (f": {self.message}" if self.message else "")]
        if self.power and self.irregularity and self.irregularity_rms:
            wavelength = self.lengths.wavelength
            scale = None if wavelength is None else wavelength * 5e8
            for name, pair, words in (
                ("power", self.power, "peak to valley"),
                ("irregularity", self.irregularity, "peak to valley"),
                ("", self.irregularity_rms, "rms"),
            ):
                nm = "" if scale is None else f" = {with_sd(scale * pair[0], scale * pair[1], 'nm')}"
                lines.append(f"    {name:<12} {with_sd(*pair)} fringes{nm}, {words}")
        lines += self._radius_lines()
        if self.visibility is not None and self.blur_px is not None:
            lines.append(f"    visibility   {self.visibility:.2f}, blur {self.blur_px:.2g} px")
        if self.form.coefficients is not None:
            lines += self.form.report().split("[[Warnings]]")[0].rstrip().splitlines()[1:]
        if self.warnings:
            lines += ["[[Warnings]]"] + [f"    {text}" for text in self.warnings]
        return "\n".join(lines)

    def _radius_lines(self) -> list[str]:
        part = self.part
        if part is None:
            return []
        ends = between(part.radius_interval, part.radius_sd, "m")
        difference = with_sd(part.difference, part.difference_sd, "m")
        return [
            f"    radius       {with_sd(part.radius, part.radius_sd, 'm')} (95 %: {ends})",
            f"    difference   {difference} from the plate's",
        ]

"""What `design` returns: the designed bench, what it attains and what limits it, as text, JSON and picture."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from fitting.parameters import AbstractResult, Origin, common_from
from fitting.studies.design_search import Binding
from newtonjax.benches import scene_from_text, scene_text
from newtonjax.scene import Camera, Scene


@dataclass(frozen=True, repr=False, eq=False)
class Design(AbstractResult):
    """A designed bench.

    - `target`, `unit`, `over`: what is measured, and the values of it that count.
    - `values`, `units`: of the design's numbers, by name; `before`: of the bench at the start.
    - `relative_sd`: largest (or mean) expected relative deviation of the target over its values; `noise_sd`: by noise
      alone; `before_sd`: of the bench at the start, None where that exceeds a limit.
    - `scene`, `camera`: the designed bench, its camera cropped to the field.
    - `bindings`: the active constraints; `used`: fraction of each limit that is used.
    - `evaluations`: of the objective with its derivatives; `starts`: relative deviation that each start ended with.
    """

    target: str
    unit: str
    over: tuple[float, ...]
    values: dict[str, float]
    units: dict[str, str]
    before: dict[str, float]
    relative_sd: float
    noise_sd: float
    before_sd: float | None
    scene: Scene
    camera: Camera
    bindings: tuple[Binding, ...]
    used: dict[str, float]
    evaluations: int
    starts: tuple[float, ...]
    status: str = "ok"
    message: str = ""
    warnings: list[str] = field(default_factory=list)
    origin: Origin | None = None

    def figure(self, ax=None) -> Any:
        """The image of the designed bench, what its limits use, and what each start ended with; a matplotlib figure.

        With `ax` the image alone.
        """
        from fitting.studies.design_figure import of_design

        return of_design(self, ax)

    def to_dict(self) -> dict[str, Any]:
        """The design for JSON: units beside the numbers, the designed bench as TOML."""
        return {
            "status": self.status,
            "message": str(self.message),
            "target": self.target,
            "unit": self.unit,
            "over": list(self.over),
            "values": dict(self.values),
            "units": dict(self.units),
            "before": dict(self.before),
            "relative_sd": self.relative_sd,
            "noise_sd": self.noise_sd,
            "before_sd": self.before_sd,
            "bindings": [asdict(binding) for binding in self.bindings],
            "used": dict(self.used),
            "evaluations": self.evaluations,
            "starts": list(self.starts),
            "shape": list(self.camera.shape),
            "pixel_size_m": float(self.camera.pixel_size),
            "scene_toml": scene_text(self.scene, self.camera),
            **self._common(),
        }

    @classmethod
    def from_dict(cls, saved: Mapping[str, Any]) -> "Design":
        """The design that `to_dict` was called of."""
        scene, camera = scene_from_text(saved["scene_toml"])
        if camera is None:
            raise ValueError("scene_toml has no camera")
        return cls(
            saved["target"],
            saved["unit"],
            tuple(saved["over"]),
            dict(saved["values"]),
            dict(saved["units"]),
            dict(saved["before"]),
            saved["relative_sd"],
            saved["noise_sd"],
            saved["before_sd"],
            scene,
            camera,
            tuple(Binding(**binding) for binding in saved["bindings"]),
            dict(saved["used"]),
            saved["evaluations"],
            tuple(saved["starts"]),
            *common_from(saved),
        )

    def report(self) -> str:
        """A table of the design's numbers, beside those at the start, and the active constraints."""
        over = f"{self.over[0]:.6g}" if len(self.over) == 1 else f"{self.over[0]:.4g} to {self.over[-1]:.4g}"
        before = "exceeds a limit" if self.before_sd is None else f"{self.before_sd:.2g}"
        lines = [
            f"{self.target} of {over} {self.unit}: relative sd {self.relative_sd:.2g} "
            f"(noise alone {self.noise_sd:.2g}; the bench at the start: {before})",
            f"{'':<14} {'designed':>12} {'before':>12} unit",
        ]
        for name, value in self.values.items():
            lines.append(f"{name:<14} {value:>12.6g} {self.before[name]:>12.6g} {self.units[name]}".rstrip())
        rows, columns = self.camera.shape
        lines.append(f"camera: {rows} x {columns} pixels of {float(self.camera.pixel_size) * 1e6:.4g} um on the screen")
        for binding in self.bindings:
            side = "" if binding.side == "limit" else f" ({binding.side} bound)"
            lines.append(
                f"active constraint: {binding.name}{side}; relaxing it by 1 % lowers the sd by {binding.gain:.2g} %"
            )
        return "\n".join([*lines, *([] if self.bindings else ["no active constraint"])])

"""What a design is asked for: names, bounds, choices, values of the target, and what is known; checked."""

from dataclasses import replace

import numpy as np

from fitting.parameters import (
    Knob,
    ParameterSpec,
    check_not_free,
    chosen,
    knobs,
    relative_or_absolute_sd,
    still,
    target_first,
)
from fitting.studies.prospects import FIELD, Bench, Layout, Limits
from newtonjax.numerics import finite, require, require_size, shown
from newtonjax.scene import Camera, Scene, middle


class DesignTask:
    """What is asked for, checked and by position."""

    def __init__(self, scene, camera, vary, choose, target, free, given_sd, over):
        self.scene, self.camera, self.vary, self.choose = scene, camera, vary, choose
        every_knob = knobs(scene, camera)
        self.free = target_first(every_knob, target, free)
        target, *_ = self.free
        self.target = target
        self.names = (*vary, *choose)
        may_vary = with_field(camera, every_knob)
        if not vary and not choose:
            raise ValueError(f"nothing varies; allowed: {', '.join(may_vary)}")
        if twice := (set(vary) & set(choose)) | ({target} & set(self.names)):
            raise ValueError(f"{sorted(twice)[0]} is given twice (target, vary, choose); give it once")
        self.numbers = chosen(may_vary, self.names)
        check_not_free(given_sd, self.free)
        self.given = tuple(given_sd)
        self.moved = chosen(every_knob, (*self.free, *self.given))
        deviations = [relative_or_absolute_sd(self.moved[name], sd) for name, sd in given_sd.items()]
        self.relative = tuple(is_relative for is_relative, _ in deviations)
        self.deviations = tuple(sd for _, sd in deviations)
        for name, ends in vary.items():
            require(name, ends, "two finite numbers, the low and the high end", finite)
            require_size(name, ends, 2, "two finite numbers, the low and the high end")
            low, high = ends
            if not -np.inf < low < high < np.inf:
                raise ValueError(f"{name} varies from {low} to {high}; allowed: a low and a higher finite number")
        for knob in self.numbers.values():
            for value in (*vary.get(knob.name, ()), *choose.get(knob.name, ())):
                if not np.isfinite(value):
                    raise ValueError(f"{knob.name} is to be {value}; allowed: finite numbers")
                if knob.positive and not value * knob.value > 0:
                    side = "above" if knob.value > 0 else "below"
                    raise ValueError(f"{knob.name} is to be {value}; allowed: {side} zero")
        of_scene = self.moved[target].value
        if over is not None and self.moved[target].move is still:
            raise ValueError(f"over: {target} is a property of the image and cannot be varied; omit over")
        if over is not None:
            require("over", over, f"values of the {target}, none of them 0", lambda values: values != 0)
        self.over = np.array([of_scene] if over is None else over, dtype=float)
        if self.over.ndim != 1 or not len(self.over) or not np.all(np.isfinite(self.over) & (self.over != 0)):
            raise ValueError(f"over is {shown(over)}; allowed: values of the {target}, none of them 0")
        self.before = np.array([knob.value for knob in self.numbers.values()])

    def bench(self, limits: Limits) -> Bench:
        moving = list(self.moved.values())
        return Bench(
            self.scene,
            self.camera,
            self.before,
            np.array([knob.value for knob in moving]),
            np.array([knob.scale for knob in moving]),
            np.array(self.deviations, dtype=float),
            limits,
        )

    def layout(self, nodes: int, samples: int, shifts: int = 1) -> Layout:
        varied = tuple((knob.name, knob.move) for knob in self.numbers.values())
        moves = tuple((knob.name, knob.move) for knob in self.moved.values())
        return Layout(varied, moves, len(self.free), tuple(self.relative), nodes, samples, shifts)

    def bench_of(self, design: np.ndarray, target: float) -> tuple[Scene, Camera]:
        """The bench of a design, its camera cropped to the field."""
        scene, camera = self.scene, self.camera
        for varied, value in zip(self.numbers.values(), design, strict=True):
            scene, camera = varied.move(scene, camera, value - varied.value)
        knob: Knob = self.moved[self.target]
        scene, camera = knob.move(scene, camera, target - knob.value)
        camera = replace(camera, pixel_size=float(camera.pixel_size), exposure=float(camera.exposure))
        if FIELD not in self.names:
            return scene, camera
        share = design[self.names.index(FIELD)] / (min(self.camera.shape) * float(camera.pixel_size))
        rows, columns = (min(max(round(n * share), 2), n) for n in self.camera.shape)
        centre = camera.centre_px
        if centre is not None:
            centre = np.asarray(centre) - np.array(middle(camera.shape)) + np.array(middle((rows, columns)))
        return scene, replace(camera, shape=(rows, columns), centre_px=centre)


def with_field(camera: Camera, every_knob: dict[str, Knob]) -> dict[str, Knob]:
    """What may vary: the field, which is no number of scene or camera, before those that are.

    What is of the image alone cannot be designed.
    """
    field = min(camera.shape) * float(camera.pixel_size)
    return {
        FIELD: Knob(ParameterSpec(FIELD, "L", "m", positive=True), field, field, still),
        **{k: v for k, v in every_knob.items() if v.move is not still},
    }

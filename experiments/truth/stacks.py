"""Claim: a row of `fit_stack` and a `fit` of its frame differ by the mean over sets of parts alone, in no direction.

Stacks of four frames of rings without a scale, through a camera that distorts by 0.4 or 0.8 % at half a diagonal: with
noise of 0.36 of the fringes' amplitude the parts beside the distortion are doubtful. Differences of the fringe scale in
standard deviations: row less fit, both from the truth, and row less fit where the first frame's difference is taken off
all frames of its stack.

    python -m experiments.truth.stacks [--quick]
"""

import json

import numpy as np

from experiments import records

WAVELENGTH, SIZE, ORDERS, NOISE, FRAMES = 589.3e-9, 128, 14, 25.0, 4
UNIT = np.hypot(SIZE - 1, SIZE - 1) / 2


def frame(kappa: float, seed: int) -> np.ndarray:
    """Rings of ORDERS r² in half diagonals, distorted about the middle, in eight bits."""
    y, x = (np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2) / UNIT
    point, origin = (at * (1 + kappa * np.abs(at) ** 2) for at in (x + 1j * y, 0.1 - 0.08j))
    light = 110 - 70 * np.cos(2 * np.pi * ORDERS * np.abs(point - origin) ** 2)
    light = light + np.random.default_rng(seed).normal(0, NOISE, light.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def differences(stack: int) -> np.ndarray:
    """Of each frame of a stack: row less fit, row less truth, fit less truth, in standard deviations."""
    import fitting

    given = {"wavelength": WAVELENGTH, "view": "reflected", "transfer": "linear"}
    frames = np.stack([frame((0.004, 0.008)[stack % 2], 10 * stack + k) for k in range(FRAMES)])
    truth, rows = ORDERS / UNIT**2, []
    for row, image in zip(fitting.fit_stack(frames, **given), frames, strict=True):
        result = fitting.fit(image, **given)
        scales = row.fringe_scale_per_px2, result.fringe_scale_per_px2
        sds = row.fringe_scale_sd, result.fringe_scale_sd
        from_truth = [(scale - truth) / sd for scale, sd in zip(scales, sds, strict=True)]
        rows.append([(scales[0] - scales[1]) / sds[1], *from_truth])
    return np.array(rows)


def summary(stacks: np.ndarray) -> dict:
    """Mean, its standard deviation and root mean square of each difference, of stacks [stacks, frames, differences]."""
    columns = dict(zip(("row - fit", "row - truth", "fit - truth"), stacks.reshape(-1, 3).T, strict=True))
    columns["row - fit, less the first frame's"] = (stacks[:, 1:, 0] - stacks[:, :1, 0]).ravel()
    return {
        name: {
            "mean": float(values.mean()),
            "mean_sd": float(values.std() / np.sqrt(len(values))),
            "rms": float(np.sqrt((values**2).mean())),
        }
        for name, values in columns.items()
    }


def main() -> None:
    """Measure eight stacks, or one."""
    quick = records.arguments(__doc__, "one stack, nothing written").quick
    table = summary(np.stack([differences(stack) for stack in range(1 if quick else 8)]))
    print(json.dumps(table, indent=1))
    assert table["row - fit"]["rms"] < 0.5, "rows and fits differ by more than half a standard deviation"
    if not quick:
        records.save("stacks", table)
        for name in ("row - fit", "row - truth", "fit - truth"):
            assert abs(table[name]["mean"]) < 3 * table[name]["mean_sd"], f"{name} has a direction"


if __name__ == "__main__":
    main()

"""The picture of a `Design`."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from newtonjax.verbs import render


def of_design(result: Any, ax=None) -> Any:
    """The image of the designed bench, what its limits use, and what each start ended with."""
    if ax is not None:
        _image(result, ax)
        return ax.figure
    canvas = Figure(figsize=(11, 3.8), layout="constrained")
    image, limits, starts = canvas.subplots(1, 3)
    _image(result, image)
    names = [name for name, used in result.used.items() if used > 0.01][::-1]
    used = [100 * result.used[name] for name in names]
    colors = ["tab:red" if value > 99.9 else "tab:blue" for value in used]
    limits.barh(range(len(names)), used, color=colors, height=0.6)
    limits.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    limits.axvline(100, color="0.4", lw=1)
    limits.set(title="limits", xlabel="used [%] (red: active)", xlim=(0, 110))
    starts.semilogy(range(1, len(result.starts) + 1), result.starts, "o", color="tab:blue", label="ends of searches")
    if result.before_sd is not None:
        starts.axhline(result.before_sd, color="0.5", ls="--", label="the bench at the start")
    starts.axhline(result.relative_sd, color="tab:red", lw=1, label="the design")
    starts.set(title=f"expected relative sd of the {result.target}", xlabel="search, best first")
    starts.legend(fontsize=8)
    return canvas


def _image(result: Any, axes) -> None:
    rows, columns = result.camera.shape
    extent = 1e3 * float(result.camera.pixel_size) * np.array([-columns, columns, -rows, rows]) / 2
    axes.imshow(np.asarray(render(result.scene, result.camera)), cmap="gray", extent=extent)
    axes.set(title=f"the designed image, {rows} x {columns} pixels", xlabel="x on the screen [mm]")

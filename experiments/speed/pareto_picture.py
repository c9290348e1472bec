"""The picture of `pareto.py`: error over cost, a panel a scene."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

# Of the axis: smaller errors are shown at its foot.
FLOOR, CEILING = 1e-12, 5.0
TOLERANCES = (1e-2, 1e-4, 1e-6)
PEERS = {"batoid": ("s", "tab:orange"), "Optiland": ("D", "tab:green"), "prysm": ("^", "tab:red"),
         "numba by hand": ("v", "tab:purple"), "Dr.Jit by hand": ("P", "tab:brown"), "LightPipes": ("X", "tab:pink"),
         "tmm": ("h", "tab:olive")}  # fmt: skip
OTHERS = {"ClosedForm": ("*", "closed form"), "Chebyshev(17), float32": ("x", "17 nodes, float32"),
          "Traced": ("o", "a ray at every pixel"), "Splat": (">", "algorithm of 2021")}  # fmt: skip
OURS = "tab:blue"


def draw(rows: list[dict]) -> Figure:
    """Two rows of panels, one legend below."""
    scenes = list(dict.fromkeys(row["scene"] for row in rows))
    figure = Figure(figsize=(15, 8.4), layout="constrained")
    grid = figure.subplots(2, -(-len(scenes) // 2), sharex=True, sharey=True)
    for panel, scene in zip(grid.ravel(), scenes, strict=False):
        some = [row for row in rows if row["scene"] == scene]
        panel.set(xscale="log", yscale="log", ylim=(FLOOR / 3, CEILING))
        for tolerance in TOLERANCES:
            panel.axhline(tolerance, color="0.75", linewidth=0.8, zorder=0)
        (bound,) = (row["bound"] for row in some if row["way"] == "Traced")
        panel.axhspan(FLOOR / 3, bound, color="0.93", zorder=0)
        _ours(panel, [row for row in some if not row["peer"]])
        for name, (marker, colour) in PEERS.items():
            places = [_place(row) for row in some if row["peer"] and row["way"].split(",")[0] == name]
            if places:
                panel.plot(*zip(*places, strict=True), ":", marker=marker, color=colour, markersize=7, linewidth=1)
        panel.set_title(scene, fontsize=12)
    for panel in grid[-1]:
        panel.set_xlabel("time, in copies of the image", fontsize=11)
    for panel in grid[:, 0]:
        panel.set_ylabel("largest error of intensity, over the peak", fontsize=11)
    figure.legend(handles=_legend(), loc="outside lower center", ncols=5, fontsize=11, frameon=False)
    return figure


def _place(row: dict) -> tuple[float, float]:
    return row["copies"], float(np.clip(row["intensity_error"], FLOOR, CEILING / 2))


def _ours(panel, rows: list[dict]) -> None:
    """Nodes joined by a line, with their numbers; the other ways as they are; rings round what is planned."""
    nodes = sorted((row for row in rows if row["way"] == f"Chebyshev({row['nodes']})"), key=lambda row: row["nodes"])
    panel.plot(*zip(*map(_place, nodes), strict=True), "-", marker=".", color=OURS, markersize=9, zorder=3)
    above = np.inf
    for row in nodes:
        if row is nodes[-1]:
            _write(panel, row, row["nodes"], (0, 5), "center", "bottom")
        elif _place(row)[1] < above / 4:
            above = _place(row)[1]
            _write(panel, row, row["nodes"], (-9, 0), "right", "center")
    for row in rows:
        if row["way"] in OTHERS:
            panel.plot(*_place(row), OTHERS[row["way"]][0], color=OURS, markersize=8, zorder=4)
        elif "beams" in row["way"]:
            panel.plot(*_place(row), ".", color=OURS, markersize=9, zorder=3)
            _write(panel, row, row["way"].split(", ")[1], (10, 0), "left", "center")
        if row["planned_for"]:
            panel.plot(*_place(row), "o", color="black", fillstyle="none", markersize=13, zorder=5)


def _write(panel, row: dict, text, offset: tuple[float, float], across: str, along: str) -> None:
    panel.annotate(str(text), _place(row), offset, textcoords="offset points", ha=across, va=along, fontsize=9,
                   color=OURS)  # fmt: skip


def _legend() -> list:
    lines = [Line2D([], [], color=OURS, marker=".", markersize=9, label="ours, by nodes to a side")]
    for marker, label in OTHERS.values():
        lines.append(Line2D([], [], color=OURS, marker=marker, linestyle="", markersize=8, label=f"ours, {label}"))
    for name, (marker, colour) in PEERS.items():
        lines.append(Line2D([], [], color=colour, marker=marker, linestyle="", markersize=7, label=name))
    ring = Line2D([], [], color="black", marker="o", fillstyle="none", linestyle="", markersize=12,
                  label="planned for 1e-2, 1e-4, 1e-6 (lines)")  # fmt: skip
    dots = Line2D([], [], linestyle=":", color="0.3", label="peers, aimed by 0, 1, 3 rounds")
    return [*lines, ring, dots, Patch(color="0.93", label="rounding of the paths")]

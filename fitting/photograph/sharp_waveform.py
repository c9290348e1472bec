"""Waveform of rings of many beams, its slopes by the numbers of the model, and its finesse.

It is Σ ρ^(m-1) exp(-m² v / 2) cos(2π m φ) over m from 1 on, Airy's sum (Born and Wolf, Principles of Optics, section
7.6.1) of lines with the variance v. The phase φ is that of `phase_at`.
"""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float
from numpy.polynomial.chebyshev import chebder, chebval

# Harmonics of lines that have a width.
_HARMONICS = 60
# Half of the waveform's period is looked at in so many steps.
_STEPS = 4001
# Numbers of the model, in units of the half diagonal of the field, in their order.
NAMES = (
    "log_scale", "centre_x", "centre_y", "phase", "ratio", "stretch", "shear", "u2", "u3", "coma_x", "coma_y",
    "variance",
)  # fmt: skip


def waveform(numbers: Mapping[str, float], x: np.ndarray, y: np.ndarray) -> Float[np.ndarray, " places"]:
    """The waveform at places; `numbers` by the names of `NAMES`."""
    turns, _ = _turns(numbers, x, y)
    return _airy(np.cos(2 * np.pi * turns), numbers["ratio"], numbers["variance"])


def slopes(
    numbers: Mapping[str, float], x: np.ndarray, y: np.ndarray, names: tuple[str, ...]
) -> Float[np.ndarray, "places names"]:
    """Derivatives of the waveform by the numbers of these names; that by the variance where it is not zero."""
    turns, phase_slopes = _turns(numbers, x, y)
    by_turns, own_slopes = _airy_slopes(turns, numbers["ratio"], numbers["variance"])
    columns = [own_slopes[name] if name in own_slopes else by_turns * phase_slopes[name] for name in names]
    return np.stack(columns, axis=1)


def finesse_of(ratio: float, variance: float) -> float:
    """Period over the full width half way between the brightest and the darkest."""
    turns = np.linspace(0.0, 0.5, _STEPS)
    wave = _airy(np.cos(2 * np.pi * turns), ratio, variance)
    level = (wave[0] + wave[-1]) / 2
    after = int(np.argmax(wave < level))
    share = (wave[after - 1] - level) / (wave[after - 1] - wave[after])
    return float(1 / (2 * (turns[after - 1] + share * (turns[1] - turns[0]))))


def _turns(numbers: Mapping[str, float], x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The phase k u (1 + u2 u + u3 u² + coma · d) + ψ [turns] of an ellipse u, and its derivatives by its numbers."""
    dx, dy = x - numbers["centre_x"], y - numbers["centre_y"]
    stretch, shear, u2, u3 = (numbers[name] for name in ("stretch", "shear", "u2", "u3"))
    lean_x, lean_y = (1 + stretch) * dx + shear * dy, shear * dx + (1 - stretch) * dy
    u = lean_x * dx + lean_y * dy
    coma = numbers["coma_x"] * dx + numbers["coma_y"] * dy
    scale = float(np.exp(numbers["log_scale"]))
    bent = scale * u * (1 + u * (u2 + u * u3) + coma)
    by_u = scale * (1 + u * (2 * u2 + 3 * u * u3) + coma)
    scaled_u = scale * u
    return bent + numbers["phase"], {
        "log_scale": bent,
        "centre_x": -(2 * by_u * lean_x + scaled_u * numbers["coma_x"]),
        "centre_y": -(2 * by_u * lean_y + scaled_u * numbers["coma_y"]),
        "phase": np.ones_like(u),
        "stretch": by_u * (dx**2 - dy**2),
        "shear": 2 * by_u * dx * dy,
        "u2": scaled_u * u,
        "u3": scaled_u * u**2,
        "coma_x": scaled_u * dx,
        "coma_y": scaled_u * dy,
    }


def _airy(cosine: np.ndarray, ratio: float, variance: float) -> np.ndarray:
    """Closed for sharp lines."""
    if variance == 0:
        return (cosine - ratio) / (1 - 2 * ratio * cosine + ratio**2)
    return chebval(cosine, _amplitudes(ratio, variance))


def _airy_slopes(turns: np.ndarray, ratio: float, variance: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Derivatives by the phase, and by its own numbers."""
    cosine, falling = np.cos(2 * np.pi * turns), -2 * np.pi * np.sin(2 * np.pi * turns)
    if variance == 0:
        denominator, above = 1 - 2 * ratio * cosine + ratio**2, cosine - ratio
        by_ratio = (2 * above**2 - denominator) / denominator**2
        return falling * (1 - ratio**2) / denominator**2, {"ratio": by_ratio}
    orders, amplitudes = np.arange(_HARMONICS + 1), _amplitudes(ratio, variance)
    by_ratio = amplitudes * np.maximum(orders - 1, 0) / max(ratio, 1e-300)
    own = np.stack([by_ratio, -0.5 * orders**2 * amplitudes], axis=1)
    by_ratio, by_variance = chebval(cosine, own)
    return falling * chebval(cosine, chebder(amplitudes)), {"ratio": by_ratio, "variance": by_variance}


def _amplitudes(ratio: float, variance: float) -> np.ndarray:
    """Of the harmonics from 0 on, which are Chebyshev's polynomials of the first one."""
    orders = np.arange(_HARMONICS + 1)
    return np.where(orders > 0, ratio ** np.maximum(orders - 1, 0) * np.exp(-0.5 * orders**2 * variance), 0.0)

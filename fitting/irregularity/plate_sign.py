"""The sign of power by the order of pictures that were pressed."""

from dataclasses import replace

import numpy as np

from fitting.irregularity.result import Form
from fitting.plate_reasons import PlateReason

# Steps [turns] beyond which it is not clear which way the gap went.
_LEAST, _MOST = 0.03, 0.42


def signed_by_steps(form: Form, sign: int | None) -> Form:
    """A form whose steps, in the order of the pictures, make the gap smaller; that which `sign` gives goes before."""
    steps = np.diff(np.array(form.steps or [0.0]))
    steps = steps - np.round(steps)
    clear = bool(len(steps)) and bool((np.abs(steps) > _LEAST).all() and (np.abs(steps) < _MOST).all())
    if not clear or abs(np.sign(steps).sum()) != len(steps):
        return form
    # Pressing makes the gap, and the phase, smaller.
    is_turned = bool(steps[0] > 0)
    if sign is not None:
        text = PlateReason.PLATE_SIGN_CONTRADICTS()
        return replace(form, warnings=[*form.warnings, text]) if is_turned else form
    flip = -1.0 if is_turned else 1.0
    coefficients = [flip * value for value in form.coefficients or []]
    return replace(
        form,
        coefficients=coefficients,
        steps=[flip * step for step in form.steps or []],
        sign=4 if coefficients[3] >= 0 else -4,
    )

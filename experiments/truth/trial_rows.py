"""A shared file that went wrong, or that must stay right: how it is measured, and what its outcome must be."""

from typing import NamedTuple

SODIUM = 589.3e-9


class Row(NamedTuple):
    """One file: verb and options that measure it, the outcome before, and what is right.

    `statuses` that are right; `value` that is known, with `value_sd`, and the number of standard deviations within
    which the answer may lie; `words` of which one must stand in message or warnings.
    """

    file: str
    verb: str
    options: dict
    before: str
    right: str
    statuses: tuple[str, ...]
    value: float | None = None
    value_sd: float = 0.0
    words: tuple[str, ...] = ()
    reach: float = 2.5

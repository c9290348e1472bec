"""What may speak against a finished fit: the abstract rival, and what one of them says."""

import abc
from typing import NamedTuple

from fitting.photograph.remainder import Remainder

# What may follow from a finding.
CONSEQUENCES = ("refusal", "budget", "warning")


class Finding(NamedTuple):
    """What a rival says of a fit that it contradicts.

    - `rival`: its name; `value` of its statistic, and the `limit` that this exceeds.
    - `consequence`: "refusal", "budget" (a row is added) or "warning"; `words`: for the reader.
    - `deviation`: relative standard deviation of the fringe scale that it adds; 0 for none.
    """

    rival: str
    value: float
    limit: float
    consequence: str
    words: str
    deviation: float = 0.0


class AbstractRival(abc.ABC):
    """Another cause of what a fit leaves over: a statistic, its limit, and what follows beyond it.

    Limits are those of `experiments/truth/rivals.py`: of pictures on the model at most one in a hundred exceeds one.
    """

    name: str

    @abc.abstractmethod
    def finding(self, remainder: Remainder) -> Finding | None:
        """What it says of a fit; None where nothing speaks for it."""

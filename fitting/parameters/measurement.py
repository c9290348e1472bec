"""What the verbs return that measure something: the words that a page shows of each, whatever was measured."""

from typing import Any

from fitting.parameters.result import AbstractResult


class AbstractMeasurement(AbstractResult):
    """A result with `parameters` (what was measured and given, by name) and `model` (its parts, each with why)."""

    def headline(self) -> str:
        """The answer in one line, or why there is none."""
        return f"{self.status}: {self.message}" if self.message else self.status

    def budgets(self) -> dict[str, list[tuple[str, float]]]:
        """Rows of source and standard deviation, by what they are the uncertainty of, with its unit."""
        return {}

    def dominant(self) -> str:
        """The largest row of the first budget and its share of the variance; empty without."""
        rows = next(iter(self.budgets().values()), [])
        total = sum(sd**2 for _, sd in rows)
        if not total:
            return ""
        source, sd = max(rows, key=lambda row: row[1])
        return f"largest: {source}, {sd**2 / total:.0%} of the variance"

    def unstated(self) -> str:
        """Which given quantities the standard deviation does not contain, for they have none; empty without."""
        return ""

    def tried_figure(self) -> Any:
        """Of a refusal the photograph with what was tried on it; None where nothing was."""
        return None

    def alternatives(self) -> list[tuple[str, str]]:
        """What else may have made the data: its name, and what came of the test for it."""
        return []

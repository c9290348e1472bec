"""The verb `selftest`: bias, scatter, coverage and speed here, against limits, as a table for a quality file.

A limit is as far out as chance alone reaches with a probability of `FALSE_ALARM`, if errors are normal and their
standard deviations and intervals are right; wider ones than need be, as those of photographs are, miss it less often.
"""

import csv
import io
import os
import platform
from collections.abc import Callable
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from time import monotonic
from typing import NamedTuple

import numpy as np
from scipy import stats

from fitting.parameters import output, progress_of
from fitting.shell import selftest, session, stopping

FALSE_ALARM = 1e-4
# Trials of each kind, and the seconds after which no other one is begun: on slower machines the limits are wider.
_PHOTOGRAPHS, _TABLES = (48, 40.0), (400, 8.0)
# Median processor seconds of a photograph of 256 x 256 pixels, ten times those of an ordinary computer.
_SLOWEST = 2.0
_FILES = ("selftest.csv", "selftest.json")
_COVERAGE = 0.95


class Check(NamedTuple):
    """A figure of some trials with the limits that it must keep, None where it has none.

    `false_alarm`: the probability that chance alone misses them, 0 where chance has no part in it.
    """

    kind: str
    figure: str
    value: float
    low: float | None
    high: float | None
    false_alarm: float
    trials: int

    @property
    def is_kept(self) -> bool:
        """Whether the value is within its limits; one that is no number is not."""
        low = -np.inf if self.low is None else self.low
        high = np.inf if self.high is None else self.high
        return bool(low <= self.value <= high)


def run(seed: int, folder: Path | None, force: bool) -> int:
    """Measure, print the table, write the files; 1 if a limit is missed, else 0."""
    files = output.files_of(folder, _FILES, force, ())
    session.prepare()
    facts = _facts(seed)
    photographs: list[selftest.Trial] = []
    tables: list[selftest.Trial] = []

    def checks() -> list[Check]:
        of_tables = checks_of("table", tables) if tables else []
        return [*checks_of("photograph", photographs), speed_of(photographs), *of_tables]

    def contents() -> dict[Path, str]:
        whole = {**facts, "checks": [_entry(check) for check in checks()]}
        return dict(zip(files, (table(facts, checks()), output.json_text(whole)), strict=False))

    def so_far() -> stopping.Unfinished:
        words = f"the limits for {len(photographs)} photographs and {len(tables)} tables"
        return stopping.Unfinished(words, report(facts, checks()), contents())

    with stopping.keeping() as keep:
        _try("photographs", selftest.photograph_trial, seed, *_PHOTOGRAPHS, photographs, lambda: keep(so_far))
        _try("tables", selftest.table_trial, seed, *_TABLES, tables, lambda: keep(so_far))
    print(report(facts, checks()))
    for file, content in contents().items():
        output.write(file, content, force)
    return int(not all(check.is_kept for check in checks()))


def _try(
    task: str,
    trial: Callable[[int, int], selftest.Trial],
    seed: int,
    count: int,
    seconds: float,
    trials: list[selftest.Trial],
    after_each: Callable[[], None],
) -> None:
    began = monotonic()
    with progress_of(True, task) as tell:
        while not trials or (len(trials) < count and monotonic() - began < seconds):
            trials.append(trial(seed, len(trials)))
            tell(len(trials), count)
            after_each()


def checks_of(kind: str, trials: list[selftest.Trial]) -> list[Check]:
    """Bias and scatter of the errors over their stated deviations, and coverage, which counts refusals as misses."""
    count = len(trials)
    deviations = np.array([trial.deviations for trial in trials if trial.measured is not None])
    answered = len(deviations)
    half = float(stats.norm.isf(FALSE_ALARM / 2) / np.sqrt(max(answered, 1)))
    widest = float(np.sqrt(stats.chi2.isf(FALSE_ALARM, max(answered, 1)) / max(answered, 1)))
    # The largest count that chance falls below no more often than that.
    fewest = float(stats.binom.ppf(FALSE_ALARM, count, _COVERAGE))
    bias = float(deviations.mean()) if answered else np.nan
    scatter = float(np.sqrt((deviations**2).mean())) if answered else np.nan
    coverage = sum(trial.is_covered for trial in trials) / count
    return [
        Check(kind, "bias_over_sd", bias, -half, half, FALSE_ALARM, count),
        Check(kind, "rms_error_over_sd", scatter, None, widest, FALSE_ALARM, count),
        Check(kind, "coverage_of_95_percent", coverage, fewest / count, None, FALSE_ALARM, count),
    ]


def speed_of(trials: list[selftest.Trial]) -> Check:
    """Median processor seconds of a trial: the first few, which compile, have no part in it."""
    seconds = float(np.median([trial.seconds for trial in trials]))
    return Check("photograph", "processor_seconds", seconds, None, _SLOWEST, 0.0, len(trials))


def report(facts: dict[str, str | int], checks: list[Check]) -> str:
    """The table as text."""
    lines = ["[[Self-test]]", *(f"    {name:<10} {value}" for name, value in facts.items())]
    lines += ["[[Limits]]", f"    {'':<34} {'value':>8} {'least':>8} {'most':>8}  trials"]
    for check in checks:
        low, high = ("" if limit is None else f"{limit:.3f}" for limit in (check.low, check.high))
        verdict = "" if check.is_kept else "  MISSED"
        name = f"{check.kind}: {check.figure}"
        lines.append(f"    {name:<34} {check.value:>8.3f} {low:>8} {high:>8}  {check.trials}{verdict}")
    missed = sum(not check.is_kept for check in checks)
    chance = sum(check.false_alarm for check in checks)
    lines.append(f"limits missed: {missed}; by chance alone one or more are in {chance:.2%} of seeds")
    return "\n".join(lines)


def table(facts: dict[str, str | int], checks: list[Check]) -> str:
    """The checks as CSV; every row has all facts, so that rows of many days make one file."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, [*facts, *_entry(checks[0])])
    writer.writeheader()
    writer.writerows({**facts, **_entry(check)} for check in checks)
    return text.getvalue()


def _entry(check: Check) -> dict:
    return {**check._asdict(), "kept": check.is_kept}


def _facts(seed: int) -> dict[str, str | int]:
    """What the figures belong to; nothing that names a user or a computer."""
    import jax

    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "version": version("newtonjax"),
        "seed": seed,
        "python": platform.python_version(),
        "jax": jax.__version__,
        "numpy": np.__version__,
        "system": f"{platform.system()} {platform.machine()}",
        "device": jax.devices()[0].device_kind,
        "cores": os.cpu_count() or 0,
    }

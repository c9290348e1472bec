"""The verb `selftest`: its table, limits that chance misses as often as it says, and errors that it notices."""

import csv
import getpass
import json
import platform

import numpy as np
import pytest

from fitting.shell import selftest, selftest_verb
from fitting.shell.cli import main
from fitting.shell.selftest import Trial


def trials_of(deviations, seconds: float = 0.2) -> list[Trial]:
    """Trials of a lens of 1 m with these errors, in standard deviations of 1 mm."""
    measured = (1.0 + 1e-3 * np.asarray(deviations)).tolist()
    return [Trial(1.0, radius, 1e-3, (radius - 1.96e-3, radius + 1.96e-3), seconds, "ok") for radius in measured]


def three_deviations_off(seed: int, number: int) -> Trial:
    return trials_of([3.0])[0]


def normal(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=count)


def missed(trials: list[Trial]) -> set[str]:
    return {check.figure for check in selftest_verb.checks_of("table", trials) if not check.is_kept}


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(selftest_verb, "_PHOTOGRAPHS", (3, 60.0))
    monkeypatch.setattr(selftest_verb, "_TABLES", (60, 60.0))


@pytest.mark.usefixtures("few")
def test_it_measures_keeps_its_limits_and_leaves_a_table_without_private_data(tmp_path, capsys):
    assert main(["selftest", "--output-dir", str(tmp_path)]) == 0
    assert "limits missed: 0" in capsys.readouterr().out
    text = (tmp_path / "selftest.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    answer = json.loads((tmp_path / "selftest.json").read_text(encoding="utf-8"))
    assert [row["figure"] for row in rows] == [check["figure"] for check in answer["checks"]]
    assert {(row["version"], row["date"]) for row in rows} == {(answer["version"], answer["date"])}
    assert {(row["kind"], row["trials"]) for row in rows} == {("photograph", "3"), ("table", "60")}
    assert float(rows[-1]["value"]) == answer["checks"][-1]["value"] > 0.8
    for private in (platform.node(), getpass.getuser(), str(tmp_path)):
        assert private not in text


@pytest.mark.usefixtures("few")
def test_a_limit_that_is_missed_is_the_exit_status(monkeypatch, capsys):
    monkeypatch.setattr(selftest, "photograph_trial", three_deviations_off)
    monkeypatch.setattr(selftest, "table_trial", three_deviations_off)
    assert main(["selftest"]) == 1
    printed = capsys.readouterr().out
    assert "photograph: bias_over_sd" in printed
    # All six but one: chance leaves the truth out of three intervals once in 8000 times.
    assert "limits missed: 5" in printed


def test_a_trial_is_the_same_for_the_same_seed_and_another_for_another():
    first, again, another = (selftest.table_trial(seed, 7) for seed in (1, 1, 2))
    assert first.measured == again.measured
    assert first.radius != another.radius


def test_chance_misses_a_limit_as_often_as_it_says(monkeypatch):
    monkeypatch.setattr(selftest_verb, "FALSE_ALARM", 0.05)
    counts = dict.fromkeys(("bias_over_sd", "rms_error_over_sd", "coverage_of_95_percent"), 0)
    sets = 1000
    for seed in range(sets):
        for figure in missed(trials_of(normal(48, seed))):
            counts[figure] += 1
    # 5 % and four standard deviations of a count of 1000; a count of intervals has steps, and reaches less.
    assert counts["bias_over_sd"] / sets == pytest.approx(0.05, abs=0.028)
    assert counts["rms_error_over_sd"] / sets == pytest.approx(0.05, abs=0.028)
    assert 0 < counts["coverage_of_95_percent"] / sets <= 0.078


@pytest.mark.parametrize(
    ("deviations", "figure"),
    [
        (normal(400) + 0.3, "bias_over_sd"),
        (normal(400) * 1.2, "rms_error_over_sd"),
        (np.where(np.arange(400) % 8, normal(400) * 0.8, 2.2), "coverage_of_95_percent"),
    ],
)
def test_a_bias_or_a_standard_deviation_that_is_too_small_is_noticed(deviations, figure):
    assert missed(trials_of(normal(400))) == set()
    assert figure in missed(trials_of(deviations))


def test_refusals_count_as_misses_and_slowness_has_a_limit():
    refused = Trial(1.0, None, np.nan, (np.inf, -np.inf), 0.1, "refused")
    assert missed([*trials_of(normal(40)), *[refused] * 20]) == {"coverage_of_95_percent"}
    assert len(missed([refused] * 10)) == 3
    assert selftest_verb.speed_of(trials_of([0.0], seconds=0.5)).is_kept
    assert not selftest_verb.speed_of(trials_of([0.0], seconds=5.0)).is_kept


def test_a_slow_machine_has_fewer_trials_and_at_least_one():
    trials: list[Trial] = []
    selftest_verb._try("tables", three_deviations_off, 0, 5, 0.0, trials, lambda: None)
    assert len(trials) == 1

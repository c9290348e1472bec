"""Several results in one question: a liquid's index, lenses, repeats, and what they share."""

import numpy as np
import pytest
from ring_tables import WAVELENGTH, table

import fitting
from experiments.truth.liquids import covered
from fitting.shell.cli import main


def tables(index=1.29):
    return [table(orders=range(1, 21)), table(orders=range(1, 21), wavelength=WAVELENGTH / index)]


def test_the_ratio_of_slopes_is_the_index_of_the_liquid():
    results = [fitting.rings(rows, wavelength=700e-9) for rows in tables()]
    result = fitting.compare(results, "gap_index")
    assert result.value == pytest.approx(1.29, rel=1e-5)
    assert fitting.compare(list(reversed(results)), "gap_index").value == pytest.approx(1 / 1.29, rel=1e-5)


def test_the_index_needs_no_scale():
    pixels = [{"order": rows["order"], "diameter_px": 31.7 * rows["diameter_mm"]} for rows in tables()]
    results = [fitting.rings(rows, wavelength=WAVELENGTH) for rows in pixels]
    assert {result.status for result in results} == {"no-scale"}
    assert fitting.compare(results, "gap_index").value == pytest.approx(1.29, rel=1e-5)
    with pytest.raises(ValueError, match="some results have a scale and others have none"):
        fitting.compare([fitting.rings(tables()[0], wavelength=WAVELENGTH), results[1]], "gap_index")


def test_the_interval_covers_the_index():
    inside = sum(covered(seed, 1.29)[0] for seed in range(1000, 1100))
    # 95 % of 100, three standard deviations of a binomial to either side.
    assert 88 <= inside <= 100


def test_what_results_share_is_not_averaged_and_cancels_in_their_ratio():
    given = {"wavelength": WAVELENGTH, "wavelength_sd": "1%"}
    results = [fitting.rings(table(noise=0.003, seed=seed), **given) for seed in range(6)]
    result = fitting.compare(results, "radius")
    budget = dict(result.budget)
    assert budget["wavelength"] == pytest.approx(0.01 * result.value, rel=1e-6)
    own = [dict(one.budget)["reading"] for one in results]
    assert budget["reading"] == pytest.approx(np.mean(own) / np.sqrt(6), rel=0.5)
    assert all(row.ratio_sd < 0.005 < row.sd for row in result.rows[1:])
    assert not result.warnings


def test_lenses_that_differ_put_their_spread_into_the_budget():
    results = [fitting.rings(table(radius, noise=0.003), wavelength=WAVELENGTH) for radius in (1.0, 1.2, 0.9)]
    result = fitting.compare(results, "radius", names=["a", "b", "c"])
    assert dict(result.budget)["spread"] == pytest.approx(np.std([1.0, 1.2, 0.9], ddof=1) / np.sqrt(3), rel=0.2)
    assert "the results differ in the radius" in result.warnings[0]
    assert [row.ratio for row in result.rows] == pytest.approx([1.0, 1.2, 0.9], rel=0.01)


def test_a_comparison_is_saved_and_drawn(tmp_path):
    result = fitting.compare([fitting.rings(rows, wavelength=WAVELENGTH) for rows in tables()], "gap_index")
    result.save(tmp_path / "index.json")
    assert fitting.Comparison.load(tmp_path / "index.json") == result
    assert result.figure().axes


@pytest.mark.parametrize("of", ["gap_index", "radius"])
def test_results_of_photographs_and_tables_compare_after_they_were_saved(tmp_path, of):
    """As they were: slopes in the ratio 1.29 give an index of 1.29, or a radius 1.29 times as large."""
    y, x = np.mgrid[-100:101, -120:121]
    photographs = [0.5 + 0.3 * np.cos(2 * np.pi * (x**2 + y**2) * n / 1200) for n in (1.0, 1.29)]
    given = {"wavelength": WAVELENGTH, "pixel_size": 10e-6, "transfer": "linear", "view": "reflected"}
    fits = [fitting.fit(image, **given) for image in photographs]
    lines = [fitting.rings(rows, wavelength=WAVELENGTH) for rows in tables()]
    for kind, results in ((fitting.FitResult, fits), (fitting.RingsResult, lines)):
        paths = [tmp_path / f"{kind.__name__}{k}.json" for k in range(2)]
        for result, path in zip(results, paths, strict=True):
            result.save(path)
        comparison = fitting.compare([kind.load(path) for path in paths], of, names=["air", "liquid"])
        before = fitting.compare(results, of, names=["air", "liquid"])
        assert (comparison.value, comparison.sd) == pytest.approx((before.value, before.sd), rel=1e-12)
        ratio = comparison.value if of == "gap_index" else 1 / comparison.rows[1].ratio
        assert ratio == pytest.approx(1.29, rel=1e-3)


@pytest.mark.parametrize(("results", "words"), [([], "give a list of two results"), ("ab", "give a list")])
def test_what_cannot_be_compared_is_refused(results, words):
    with pytest.raises(ValueError, match=words):
        fitting.compare(results, "radius")


@pytest.mark.usefixtures("untyped")
@pytest.mark.parametrize("names", [3.0, "ab", ["a"], [None, "b"]])
def test_names_are_a_text_for_each_result(names):
    results = [fitting.rings(table(noise=0.003, seed=seed), wavelength=WAVELENGTH) for seed in (0, 1)]
    with pytest.raises(ValueError, match=r"names is .*; allowed: a text for each of the 2 results"):
        fitting.compare(results, "radius", names=names)


def test_no_result_counts_twice():
    results = [fitting.rings(table(noise=0.003, seed=seed), wavelength=WAVELENGTH) for seed in (0, 1, 0)]
    with pytest.raises(ValueError, match="results 1 and 3 are one, result 1; give different ones"):
        fitting.compare(results, "radius")


def test_the_shell_compares_tables_and_saved_results(tmp_path, capsys):
    paths = []
    for name, rows in zip(("air", "water"), tables(), strict=True):
        paths.append(tmp_path / f"{name}.csv")
        lines = [f"{m:g},{d:.4f}" for m, d in zip(rows["order"], rows["diameter_mm"], strict=True)]
        paths[-1].write_text("\n".join(["order,diameter_mm", *lines]))
    command = ["rings", *map(str, paths), "--wavelength", "589.3nm"]
    assert main([*command, "--compare", "gap-index"]) == 0
    assert "gap index = 1.29" in capsys.readouterr().out
    assert main(command) == 2
    assert "say what is asked of them" in capsys.readouterr().err
    saved = [str(path.with_suffix(".json")) for path in paths]
    for path, answer in zip(paths, saved, strict=True):
        assert main(["rings", str(path), "--wavelength", "589.3nm", "--json", answer]) == 0
    capsys.readouterr()
    assert main(["compare", *saved, "--of", "gap-index"]) == 0
    assert "gap index = 1.29" in capsys.readouterr().out

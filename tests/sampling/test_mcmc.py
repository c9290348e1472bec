"""Chains: they agree with the Laplace covariance where the posterior is normal, and say where they are too short."""

from dataclasses import replace

import emcee
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.polynomial.chebyshev import chebval
from rings_data import WAVELENGTH, added_path, rings

import fitting
import newtonjax as nj
from fitting.sampling.chain import split_rhat
from fitting.sampling.density import log_density, posterior
from fitting.sampling.mcmc import MOVES

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 5e-6}


@pytest.fixture(scope="module")
def fitted():
    return fitting.fit(rings(noise=0.05), **GIVEN, pixel_size_sd=1e-8, wavelength_sd=1e-10)


@pytest.fixture(scope="module")
def chain(fitted):
    return fitting.sample(fitted, steps=1400)


def test_mean_and_deviation_of_the_radius_are_those_of_the_fit(fitted, chain):
    drawn = chain.of("radius")
    error = np.sqrt(2 / chain.effective)  # of a standard deviation, relative; of the mean, in standard deviations
    assert chain.message == ""
    assert abs(drawn.mean() - fitted.radius) < 4 * error * fitted.radius_sd
    assert drawn.std() == pytest.approx(fitted.radius_sd, rel=4 * error)
    assert chain.interval("radius")[0] == pytest.approx(fitted.radius_interval[0], abs=0.3 * fitted.radius_sd)


def test_given_quantities_are_drawn_from_their_priors(chain):
    error = 4 * np.sqrt(2 / chain.effective)
    for name, value, sd in (("pixel_size", 5e-6, 1e-8), ("wavelength", WAVELENGTH, 1e-10)):
        drawn = chain.of(name)
        assert drawn.std() == pytest.approx(sd, rel=error)
        assert abs(drawn.mean() - value) < error * sd


def test_diagnostics_of_a_good_chain_are_good(chain):
    assert chain.effective > 500
    assert 0.15 < chain.acceptance < 0.9
    assert np.all(chain.split_rhat < 1.05)
    assert chain.values.shape == (1050, 32, len(chain.names))


def test_a_short_chain_quotes_no_quantile(fitted):
    short = fitting.sample(fitted, steps=40)
    with pytest.raises(ValueError, match="shorter than 50 autocorrelation times"):
        short.interval("radius")


def test_a_bench_and_few_rings_have_posteriors_too():
    scene = nj.newton_rings(2.0, 500e-9, view="reflected", screen=5e-3)
    image = np.asarray(nj.render(scene, nj.Camera((96, 128), 30e-6), nj.Chebyshev()))
    image = image / image.max() + 0.05 * np.random.default_rng(0).normal(size=image.shape)
    result = fitting.fit(image, scene=nj.newton_rings(1.9, 500e-9, view="reflected", screen=5e-3), pixel_size=30e-6)
    drawn = fitting.sample(result, steps=250)
    assert drawn.effective > 500  # a mean off by 0.25 standard deviations, or these by a quarter, is seen
    error = 4 * np.sqrt(2 / drawn.effective)
    assert drawn.names == ("radius", "centre_x_px", "centre_y_px", "gap_turns")
    assert abs(drawn.of("radius").mean() - result.radius) < error * result.radius_sd
    assert drawn.of("radius").std() == pytest.approx(result.radius_sd, rel=error)
    held = fitting.fit(rings(noise=0.05), **GIVEN, fixed={"gap": 0.0})
    assert fitting.sample(held, steps=40).names == ("radius", "centre_x_px", "centre_y_px")


# Beyond a few micrometres the formula of what a microscope adds leaves out the gap's square.
@pytest.mark.parametrize("gap", [None, 2e-6])
def test_the_density_is_the_all_pixel_likelihood_with_the_illumination_integrated_out(fitted, gap):
    """Against NumPy on every pixel: the same differences of log-density between points, priors included.

    A held gap is so many half wavelengths of the light that is drawn, and no phase of its own.
    """
    if gap is not None:
        sds = {"pixel_size_sd": 1e-8, "wavelength_sd": 3e-6 * WAVELENGTH}
        fitted = fitting.fit(rings(gap=gap, noise=0.05), **GIVEN, **sds, fixed={"gap": gap})
    found, known, variance, covariance, *_ = fitted.evidence
    target = posterior(found, known, variance, covariance)
    points = np.random.default_rng(3).normal(size=(4, target.dimensions))
    ours = np.asarray(log_density(target, jnp.asarray(points)))
    rows, columns = found.reduced.light.shape  # noise alone: every pixel for itself
    y, x = np.meshgrid(2 * np.arange(rows) / (rows - 1) - 1, 2 * np.arange(columns) / (columns - 1) - 1, indexing="ij")

    def basis(degree):
        return [chebval(y, np.eye(7)[j]) * chebval(x, np.eye(7)[total - j])
                for total in range(degree + 1) for j in range(total + 1)]  # fmt: skip

    theirs = []
    for point in points:
        (turns, dx, dy, phase, *_), factors = target.numbers(jnp.asarray(point))
        frame, given = found.model.frame, {n: known.given[n] * f for n, f in zip(target.given, factors, strict=True)}
        px, py = frame.middle[0] * (1 + x), frame.middle[1] * (1 + y)
        r2 = (px - frame.middle[0] - dx * frame.unit) ** 2 + (py - frame.middle[1] - dy * frame.unit) ** 2
        k = turns / frame.unit**2
        curvature = k * given["wavelength"] / given["pixel_size"]  # s/R in 1/px: k λ / s
        phase = phase if gap is None else 0.5 + 2 * gap / given["wavelength"]
        steepness, sphere = curvature**2 * r2, 2 * k * r2 / (1 + np.sqrt(1 - curvature**2 * r2))
        wave, apex = given["wavelength"], (phase - 0.5) * given["wavelength"] / 2
        seen = added_path(np.asarray(steepness), np.asarray(sphere) * wave / 2 + apex, apex, "reflected") / wave
        angle = 2 * np.pi * (sphere + phase + seen)
        cosine = np.cos(np.asarray(angle))
        columns = [*basis(found.shape[0]), *(b * cosine for b in basis(found.shape[1]))]
        design = np.stack([column.ravel() for column in columns], axis=1)
        normal = design.T @ design
        best = np.linalg.solve(normal, design.T @ fitted.picture.photograph.image.ravel())
        chi2 = np.sum((fitted.picture.photograph.image.ravel() - design @ best) ** 2)
        steps = point[len(target.moving) :]
        theirs.append(-0.5 * (chi2 / variance + np.linalg.slogdet(normal)[1] + steps @ steps))
    np.testing.assert_allclose(np.diff(ours), np.diff(theirs), atol=1e-4)


def test_a_posterior_wider_than_the_moments_quotes_no_quantile(fitted):
    seen = fitted.evidence
    wide = replace(fitted, evidence=seen._replace(variance=seen.variance * 1e9, covariance=seen.covariance * 1e9))
    drawn = fitting.sample(wide, steps=60)
    with pytest.raises(ValueError, match="the likelihood is accurate to"):
        drawn.interval("radius")


def test_moves_leave_a_normal_distribution_as_it_is():
    """Deviations to 1.5 %: 25 000 effective draws give 0.5 %, and moves with a wrong acceptance were off by 4 %."""
    generator = np.random.default_rng(0)
    sampler = emcee.EnsembleSampler(32, 6, lambda x: -0.5 * (x**2).sum(axis=1), moves=MOVES, vectorize=True)
    sampler.random_state = np.random.RandomState(1).get_state()
    sampler.run_mcmc(generator.normal(size=(32, 6)), 3000)
    drawn = sampler.get_chain(discard=500, flat=True)
    assert drawn.std(axis=0).mean() == pytest.approx(1.0, abs=0.015)
    assert np.abs(drawn.mean(axis=0)).max() < 0.06


def test_rhat_sees_chains_that_differ():
    random = np.random.default_rng(0).normal(size=(400, 8, 2))
    random[:, :4, 1] += 3
    good, bad = split_rhat(random)
    assert good < 1.02
    assert bad > 1.5


def test_what_cannot_be_drawn_from_is_refused(fitted):
    with pytest.raises(ValueError, match="has no posterior: it is refused"):
        fitting.sample(fitting.fit(np.zeros((64, 64)) + np.eye(64), **GIVEN))
    with pytest.raises(ValueError, match="walkers is 3"):
        fitting.sample(fitted, walkers=3)
    with pytest.raises(ValueError, match="steps is 2"):
        fitting.sample(fitted, steps=2)


def test_nuts_agrees_with_emcee_and_with_the_covariance(fitted, chain):
    pytest.importorskip("blackjax", reason="the extra nuts is not installed")
    drawn = fitting.sample(fitted, sampler="nuts", steps=800)
    error = 4 * np.sqrt(2 / drawn.effective + 2 / chain.effective)
    assert drawn.message == ""
    for name in drawn.names:
        assert abs(drawn.of(name).mean() - chain.of(name).mean()) < error * chain.of(name).std()
        assert drawn.of(name).std() == pytest.approx(chain.of(name).std(), rel=error)


def test_a_file_keeps_every_step_and_the_chain_goes_on_from_it(fitted, tmp_path):
    file = tmp_path / "chain.h5"
    done = []
    short = fitting.sample(fitted, steps=60, path=file, progress=lambda step, total: done.append((step, total)))
    assert done[-1] == (60, 60)
    longer = fitting.sample(fitted, steps=100, path=file)
    assert (len(short.values), len(longer.values)) == (45, 75)
    np.testing.assert_array_equal(longer.log_prob[: 60 - 25], short.log_prob[10:])
    other = fitting.fit(rings(noise=0.05, seed=9), **GIVEN)
    with pytest.raises(ValueError, match="chain of another fit"):
        fitting.sample(other, steps=60, path=file)
    (tmp_path / "text.h5").write_text("no chain")
    with pytest.raises(ValueError, match="is not a chain written by newtonjax"):
        fitting.sample(fitted, steps=60, path=tmp_path / "text.h5")


def test_an_interrupted_chain_keeps_what_is_there(fitted, tmp_path):
    def interrupt(step, total):
        if step == 40:
            raise KeyboardInterrupt

    drawn = fitting.sample(fitted, steps=1000, progress=interrupt)
    assert len(drawn.values) == 30
    assert "shorter than 50 autocorrelation times" in drawn.message


def test_a_chain_holds_the_numbers_of_the_parts():
    result = fitting.fit(rings(noise=0.03), **GIVEN, parts={"distortion": True})
    drawn = fitting.sample(result, steps=120)
    assert "distortion" in drawn.names
    assert abs(drawn.of("distortion").mean()) < 6 * drawn.of("distortion").std()


def test_report_and_pictures_of_a_chain(chain):
    assert "effective draws" in chain.report()
    assert chain.to_dict()["parameters"]["radius"]["interval"][0] == chain.interval("radius")[0]
    assert len(chain.figure().axes) == len(chain.names) ** 2
    assert len(chain.trace_figure().axes) == len(chain.names)


def test_the_log_posterior_is_a_function_of_points_about_the_optimum(fitted):
    function = fitting.log_posterior(fitted)
    assert {"radius", "centre_x_px", "gap_turns", "pixel_size", "wavelength"} <= set(function.names)
    optimum = np.zeros((1, function.dimensions))
    assert function.values(optimum)["radius"][0] == pytest.approx(fitted.radius, rel=1e-6)
    # Normal near the optimum: a standard deviation along any axis costs a half.
    steps = np.eye(function.dimensions)
    for sign in (1, -1):
        np.testing.assert_allclose(function(optimum) - function(sign * steps), 0.5, atol=0.05)
    with pytest.raises(ValueError, match="the fit has no posterior"):
        fitting.log_posterior(fitting.fit(np.ones((40, 40))))

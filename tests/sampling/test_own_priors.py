"""Priors of a user's own in chains, and the log-density as a function of named numbers."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from rings_data import WAVELENGTH, rings
from scipy import stats

import fitting
from fitting.sampling import OtherChainError
from fitting.sampling.naming import Naming

GIVEN = {"wavelength": WAVELENGTH, "pixel_size": 5e-6}


@pytest.fixture(scope="module")
def fitted():
    return fitting.fit(rings(noise=0.05), **GIVEN, pixel_size_sd=1e-8, wavelength_sd=1e-10)


@pytest.fixture(scope="module")
def density(fitted):
    return fitting.log_posterior(fitted)


@pytest.fixture(scope="module")
def distorted():
    """A fit of every kind of number: what is measured, centres, phase, numbers of parts, and what is given."""
    parts = dict.fromkeys(("oblique_view", "distortion", "fifth_order", "lens_form"), True)
    return fitting.fit(rings(noise=0.05), **GIVEN, pixel_size_sd=1e-8, parts=parts)


class Normal:
    """A prior of a user's own class, as those of NumPyro are."""

    def __init__(self, centre, scale):
        self.centre, self.scale = centre, scale

    def log_prob(self, value):
        return -0.5 * ((value - self.centre) / self.scale) ** 2


def even(value, low, high):
    """A function of plain Python, which JAX cannot trace."""
    return 0.0 if low < value < high else -np.inf


# Of a posterior that is normal without the prior, in its own standard deviations: mean and deviation with it.
LAWS = {
    "pair": (lambda r, sd: (r + sd, sd), 0.5, np.sqrt(0.5)),
    "scipy": (lambda r, sd: stats.uniform(r, 2 * sd), *(stats.truncnorm(0, 2).mean(), stats.truncnorm(0, 2).std())),
    "log_prob": (lambda r, sd: Normal(r + sd, sd), 0.5, np.sqrt(0.5)),
    "jax": (lambda r, sd: lambda value: -0.5 * ((value - r + sd) / sd) ** 2, -0.5, np.sqrt(0.5)),
    "python": (lambda r, sd: lambda value: even(value, r, r + 2 * sd), stats.truncnorm(0, 2).mean(), None),
}


@pytest.mark.parametrize("law", LAWS)
def test_a_prior_of_ones_own_multiplies_the_posterior(fitted, density, law):
    make, mean, deviation = LAWS[law]
    radius, sd = density.optimum["radius"], density.sd["radius"]
    chain = fitting.sample(fitted, steps=300, priors={"radius": make(radius, sd)})
    drawn, error = (chain.of("radius") - radius) / sd, 4 * np.sqrt(2 / chain.effective)
    assert abs(drawn.mean() - mean) < error
    if deviation is not None:
        assert drawn.std() == pytest.approx(deviation, rel=error)
    assert not chain.warnings
    assert f"prior of radius: {chain.priors['radius']}" in chain.report()


def test_a_prior_replaces_that_of_a_given_quantity(fitted):
    chain = fitting.sample(fitted, steps=300, priors={"pixel_size": stats.norm(5.01e-6, 2e-9)})
    drawn, error = chain.of("pixel_size"), 4 * np.sqrt(2 / chain.effective)
    assert abs(drawn.mean() - 5.01e-6) < error * 2e-9
    assert drawn.std() == pytest.approx(2e-9, rel=error)
    assert chain.draws()["pixel_size"].shape == (32, 225)
    assert chain.priors == {"pixel_size": "5.01e-06 ± 2e-09"}
    assert fitting.Chain.from_dict(chain.to_dict()).priors == chain.priors


def test_a_prior_that_the_image_contradicts_is_spoken_of(fitted, density):
    """Two normal distributions are as many sd apart as their distance over the root of the sum of their variances."""
    phase, sd = density.optimum["gap_turns"], density.sd["gap_turns"]
    chain = fitting.sample(fitted, steps=60, priors={"gap_turns": (phase + 40 * sd, "0.01%")})
    (warning,) = chain.warnings
    apart = 40 / np.hypot(1, 1e-4 * (phase + 40 * sd) / sd)
    assert f"{apart:.1f} sd from its prior" in warning
    assert warning.code == "CHAIN_PRIOR_TENSION"
    assert warning in chain.report()
    with pytest.raises(ValueError, match=r"contradict each other: the fit has gap_turns = 0.49.*uniform\(0.9, 0.1\)"):
        fitting.sample(fitted, steps=60, priors={"gap_turns": stats.uniform(0.9, 0.1)})


@pytest.mark.parametrize(
    ("priors", "words"),
    [
        (3, "allowed: a mapping of names to priors"),
        ({"gap": (0, 1)}, "'gap' is not drawn; allowed: radius, .*where fit was told its sd"),
        ({"radius": 3}, r"radius is 3; allowed: \(value, sd\), a distribution"),
        ({"radius": (1, 2, 3)}, r"radius is \(1, 2, 3\); allowed"),
        ({"radius": (0.3, 0)}, "radius has the sd 0; allowed: a number above zero"),
        ({"radius": lambda value: jnp.stack([value, value])}, "at one value; allowed: one number"),
        ({"radius": stats.norm([0.3, 0.4], 0.1)}, r"radius, norm\(\[0.3, 0.4\], 0.1\), fails at 0.2999"),
        ({"radius": lambda value: value.nothing}, "fails at 0.2999.*nothing"),
    ],
)
@pytest.mark.usefixtures("untyped")
def test_what_is_no_prior_is_refused_in_one_line(fitted, priors, words):
    with pytest.raises(ValueError, match=words) as refusal:
        fitting.log_posterior(fitted, priors=priors)
    assert "\n" not in str(refusal.value)


def test_a_fit_takes_a_normal_distribution_and_names_sample_for_others():
    image = rings(noise=0.05)
    by_pair, by_scipy = (
        fitting.fit(image, **GIVEN, priors={"distortion": prior}) for prior in ((0.0, 0.02), stats.norm(0.0, 0.02))
    )
    assert by_scipy.priors == by_pair.priors
    assert by_scipy.radius == by_pair.radius
    with pytest.raises(ValueError, match=r"a fit takes normal ones, \(value, sd\); sample\(result, priors=...\)"):
        fitting.fit(image, **GIVEN, priors={"distortion": stats.uniform(0.0, 0.02)})
    with pytest.raises(ValueError, match=r"'radius' has no prior; .*; sample takes priors of all that is drawn"):
        fitting.fit(image, **GIVEN, priors={"radius": (1.0, 0.1)})


def test_a_file_of_other_priors_is_another_chain(fitted, tmp_path):
    chains = [fitting.sample(fitted, steps=16, path=tmp_path / "c.h5", priors={"radius": (0.3, 1e-3)}) for _ in "12"]
    np.testing.assert_array_equal(chains[0].values, chains[1].values)
    with pytest.raises(OtherChainError):
        fitting.sample(fitted, steps=16, path=tmp_path / "c.h5", priors={"radius": (0.3, 2e-3)})


def test_nuts_takes_a_prior_that_jax_cannot_trace(fitted, density):
    pytest.importorskip("blackjax", reason="the extra nuts is not installed")
    radius, sd = density.optimum["radius"], density.sd["radius"]
    drawn = fitting.sample(fitted, sampler="nuts", steps=400, priors={"radius": stats.norm(radius + sd, sd)})
    error = 4 * np.sqrt(2 / drawn.effective)
    assert abs((drawn.of("radius").mean() - radius) / sd - 0.5) < error


# The function of named numbers


def test_its_gradient_is_that_of_differences_for_every_number(distorted):
    """Of likelihood and prior, with a prior that JAX cannot trace; aside from the optimum, where none of them is 0."""
    plain = fitting.log_posterior(distorted)
    sd = plain.sd
    assert {"radius", "centre_x_px", "gap_turns", "stretch", "distortion", "coma_x", "pixel_size"} <= set(sd)
    radius = plain.optimum["radius"]
    prior = fitting.log_posterior(distorted, priors={"radius": stats.t(5, radius, sd["radius"])})
    at = {name: jnp.asarray(value + 0.1 * sd[name]) for name, value in plain.optimum.items()}
    for function in (prior.log_likelihood, prior.log_prior):
        slopes = jax.jit(jax.grad(function))(at)
        for name in sd:
            step = 1e-3 * sd[name]
            ahead, behind = (float(function({**at, name: at[name] + way})) for way in (step, -step))
            # Of one standard deviation; rounding of a chi-squared of 1e6 leaves 1e-9 of it in a difference.
            assert float(slopes[name]) * sd[name] == pytest.approx((ahead - behind) / 2e-3, rel=1e-4, abs=1e-4), name


def test_it_goes_through_jit_and_vmap_and_wants_float64(density):
    at = {name: value + np.linspace(-0.5, 0.5, 5) * density.sd[name] for name, value in density.optimum.items()}
    each = [float(density.log_density({name: values[k] for name, values in at.items()})) for k in range(5)]
    np.testing.assert_allclose(jax.jit(jax.vmap(density.log_density))(at), each, rtol=1e-12)
    with jax.enable_x64(False):
        assert float(density.log_density({name: float(values[0]) for name, values in at.items()})) == each[0]
        with pytest.raises(RuntimeError, match="a log-density needs float64"):
            jax.grad(density.log_density)(density.optimum)
    with pytest.raises(ValueError, match="missing: centre_x_px"):
        density.log_density({"radius": 0.3})
    with pytest.raises(ValueError, match="unknown: width"):
        density.log_density({**density.optimum, "width": 1.0})


def test_it_is_a_density_of_the_named_numbers(density):
    """Beside that of points, which is flat in n s²/(R λ): its derivative by R is s²/(R² λ), but for constants."""
    points = np.random.default_rng(1).normal(size=(4, density.dimensions))
    values = density.values(points)
    named = [float(density.log_density({name: column[k] for name, column in values.items()})) for k in range(4)]
    slope = np.log(values["pixel_size"] ** 2 / (values["radius"] ** 2 * values["wavelength"]))
    np.testing.assert_allclose(np.diff(named), np.diff(density(points) + slope), atol=1e-6)


@pytest.mark.parametrize(("unknown", "parts"), [("radius", ("contact",)), ("radius", ()), ("pixel_size", ("contact",))])
def test_names_lead_to_numbers_and_back(fitted, unknown, parts):
    found, known = fitted.evidence.found, fitted.evidence.known
    values = {**known.given, "radius": 0.3}
    known = replace(known, given={name: v for name, v in values.items() if name != unknown}, unknown=unknown)
    naming = Naming(replace(found, parts=parts), known, ("curvature", "centre_y", "phase", *parts), ("wavelength",))
    start = jnp.asarray(found.numbers)
    free = start.at[7].set(0.01) if parts else start
    named = naming.values(free, jnp.asarray([1.001]))
    back, factors = naming.numbers(named, start)
    np.testing.assert_allclose(back, free, rtol=1e-12)
    np.testing.assert_allclose(factors, [1.001], rtol=1e-12)
    if parts:  # a disc of a tenth of half a diagonal, in metres of the pixel size that is measured
        pixel = named.get("pixel_size", known.given.get("pixel_size"))
        assert float(named["contact_radius"]) == pytest.approx(0.1 * found.model.frame.unit * float(pixel))

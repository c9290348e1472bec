"""Strictness for every test: float64, no silent promotion, shapes and types checked at run time."""

import gc
import inspect
import os
import signal
import tempfile
from pathlib import Path

import pytest

# A shell's background job ignores Ctrl-C, and so would every command that a test starts and sends one.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Before JAX is imported, and inherited by worker processes and by programs under test. Compiled code is shared within
# one run of the suite, and with the runs before where a folder is named, as `make test` does. Small programs too: where
# a worker has dropped its compiled code, it loads it again.
if not os.environ.get("JAX_COMPILATION_CACHE_DIR"):
    _CACHE = tempfile.TemporaryDirectory(prefix="newtonjax-tests-")
    os.environ["JAX_COMPILATION_CACHE_DIR"] = _CACHE.name
os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0")

import costs
import jax
import jaxtyping
import memory
from hypothesis import settings
from jaxtyping import install_import_hook

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_numpy_dtype_promotion", "strict")

# Tracing makes many small objects, which a collection every 700 of them goes through again and again: 1/7 of the time.
gc.set_threshold(50_000, 20, 100)

# The same examples in every run; no deadline, since a first example may compile.
settings.register_profile("suite", deadline=None, derandomize=True, database=None)
# What `--hypothesis-profile long` searches through: more examples, others in every run.
settings.register_profile("long", deadline=None, database=None, max_examples=5000)
settings.load_profile("suite")


def _unless_without_annotations(checked_by):
    """The hook's decorator, but for functions that annotate nothing, of which there is nothing to check.

    It takes half a millisecond a function, each time that one is defined: within another one, at every call of that.
    """

    def decorator_of(*, typechecker):
        decorate = checked_by(typechecker=typechecker)
        return lambda item: decorate(item) if inspect.isclass(item) or inspect.get_annotations(item) else item

    return decorator_of


jaxtyping.jaxtyped = _unless_without_annotations(jaxtyping.jaxtyped)
_HOOK = install_import_hook(("newtonjax", "fitting"), "beartype.beartype")


def pytest_configure(config):
    """Count compiled programs and memory for the summary."""
    costs.register(config)


# The modules that take longest where nothing is compiled yet, longest first, so that no worker begins one of them when
# the other has nothing left to do.
LONGEST = (
    *("mcmc", "implicit", "sharding", "awkward", "render_verb", "gradients", "splatting", "derivatives", "design"),
    *("pages", "spread", "architecture", "extended_sources", "photographs", "methods", "fit", "reticle", "parts"),
    *("together", "wrong_arguments", "colour_fit", "single", "many_beams", "few_fringes", "stepped", "wedge_photo"),
    *("tradeoff", "html", "packed", "imaging", "batch_verb", "ruler_and_disc", "page", "worker", "program_count"),
)


def pytest_collection_finish():
    """Leave what is imported by now, a million objects that stay, out of every later collection of garbage."""
    gc.collect()
    gc.freeze()


def pytest_collection_modifyitems(items):
    """Put the longest modules first; the Makefile gives each module to one worker, in this order."""
    order = {f"test_{name}": place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: order.get(item.path.stem, len(order)))


@pytest.fixture(scope="module")
def untyped():
    """Without the type checker, as users have the library: what they pass meets our own checks."""
    jaxtyping.config.update("jaxtyping_disable", True)
    yield
    jaxtyping.config.update("jaxtyping_disable", False)


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of shared photographs, tables and the paper; a test that takes it skips where there is none."""
    folder = Path(os.environ.get("NEWTONJAX_SHARED", Path(__file__).resolve().parents[2] / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no shared material in {folder} (NEWTONJAX_SHARED)")
    return folder


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item):
    """Note in its report that a test looked at the shared material: .ci/run wants to see one that did."""
    report = yield
    uses = "shared" in getattr(item, "fixturenames", ()) or item.get_closest_marker("shared")
    if uses and report.when == "call" and not report.skipped:
        report.user_properties.append(("shared", "yes"))
    return report


def pytest_terminal_summary(terminalreporter):
    """Count them for .ci/run, also when worker processes ran them."""
    reports = [report for outcome in ("passed", "failed") for report in terminalreporter.stats.get(outcome, ())]
    ran = sum(["shared", "yes"] in map(list, report.user_properties) for report in reports)
    terminalreporter.write_line(f"shared material: {ran} tests ran")


# A worker stays below 2.5 GiB: one compilation, and what the largest test makes, come on top of these.
AFTER_A_MODULE, AFTER_A_TEST = 1.5, 1.8  # GiB


@pytest.fixture(autouse=True, scope="module")
def _room_after_a_module():
    yield
    memory.release(AFTER_A_MODULE, memory.MOST_MAPS)


@pytest.fixture(autouse=True)
def _room_after_a_test():
    yield
    memory.release(AFTER_A_TEST)


@pytest.fixture(autouse=True, scope="module")
def _rays_of_this_process():
    """Take back what the command under test keeps: the program of the rays, loaded from its cache folder."""
    from newtonjax.fields import packed

    own = packed.rays
    yield
    packed.rays = own

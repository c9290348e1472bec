"""What `doctor` asks JAX, in a process of its own: a broken JAX may raise, end the process, or never answer.

A line of JSON a step, written as soon as the step is done, so that what is missing says where it ended.
"""

import faulthandler
import json
import subprocess
import sys
from importlib import import_module
from typing import Any, NamedTuple

from fitting.shell import stopping

# Steps in their order, and what is being done until each has answered.
STEPS = {
    "jax": "importing jax",
    "devices": "looking for devices",
    "float64": "compiling a program",
    "imports": "importing the packages that newtonjax needs",
}
# How long all steps together may take [s].
LIMIT = 60.0
# Packages whose module has another name than theirs with _ for -.
_MODULES = {"scikit-image": "skimage", "pypng": "png"}


class Probe(NamedTuple):
    """What JAX answered: facts by step; the exit status, None after the time limit; the last line on stderr."""

    facts: dict[str, Any]
    status: int | None
    last_line: str

    def ended_in(self) -> str:
        """The first step without an answer, empty if all have one."""
        return next((step for step in STEPS if step not in self.facts), "")


def probe(packages: list[str], limit: float = LIMIT) -> Probe:
    """Ask a process of its own, which ends after `limit` seconds whatever it waits for."""
    program = (
        f"import sys; sys.path[:] = {sys.path!r}; "
        f"from fitting.shell.jax_probe import answer; answer({packages!r}, {limit + 5!r})"
    )
    command = [sys.executable, "-c", program]
    # Without an input: what waits for one would wait for ever.
    with subprocess.Popen(  # noqa: S603 (our own interpreter)
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8"
    ) as process:
        stopping.ends_with_us(process)
        try:
            printed, errors = process.communicate(timeout=limit)
            status = process.returncode
        except subprocess.TimeoutExpired:
            process.kill()
            printed, errors = process.communicate()
            status = None
    return Probe(_facts(printed), status, next(iter(errors.strip().splitlines()[-1:]), ""))


def answer(packages: list[str], limit: float) -> None:
    """Do the steps, and print what each gave."""
    # Ends this process also where the parent was killed, and where the interpreter itself is held up.
    faulthandler.dump_traceback_later(limit, exit=True)
    import jax

    _say("jax", jax.__version__)
    _say("devices", [f"{device.platform}: {device.device_kind}" for device in jax.devices()])
    from fitting.shell import session

    session.prepare()
    import jax.numpy as jnp

    # 1 + 2^-40 is 1 in float32; a jitted sum, so that a program is compiled and run.
    step = jax.jit(lambda x: (x + 2.0**-40) - x)(jnp.ones((), "float64"))
    _say("float64", float(step) == 2.0**-40)
    _say("imports", {name: error for name in packages if (error := _error_of(name))})


def _error_of(package: str) -> str:
    """Why a package cannot be imported, empty if it can."""
    try:
        import_module(_MODULES.get(package, package.replace("-", "_")))
    except Exception as error:  # a broken package may raise anything
        return f"{type(error).__name__}: {error}".splitlines()[0]
    return ""


def _say(step: str, fact: Any) -> None:
    print(json.dumps({step: fact}), flush=True)


def _facts(printed: str) -> dict[str, Any]:
    facts = {}
    for line in printed.splitlines():
        try:
            facts |= json.loads(line)
        except (ValueError, TypeError):  # a package printed something else
            continue
    return facts

"""What the suite costs beside its seconds: compiled programs, time spent on them, memory; summed over workers."""

import resource
import sys
import threading
from collections import Counter, defaultdict

import jax
import pytest

KEY = "newtonjax costs"
# Of JAX's compilation: tracing (which nests), lowering, and XLA, which on a hit of the cache on disk only loads.
STEPS = {
    "/jax/core/compile/jaxpr_trace_duration": "tracing",
    "/jax/core/compile/jaxpr_to_mlir_module_duration": "lowering",
    "/jax/core/compile/backend_compile_duration": "compiling",
}
CACHE_HIT = "/jax/compilation_cache/cache_hits"
KIBIBYTES = 1 if sys.platform.startswith("linux") else 1024  # ru_maxrss counts bytes elsewhere


class Costs:
    """A plugin that counts in each process, and prints the sums where the summary is printed."""

    def __init__(self):
        self.programs = Counter()
        self.seconds = Counter()
        self.workers = []
        self._spans = defaultdict(list)
        jax.monitoring.register_event_listener(self._count_hit)
        jax.monitoring.register_event_time_span_listener(self._add_span)

    def _count_hit(self, event, **_):
        self.programs["loaded"] += event == CACHE_HIT

    def _add_span(self, event, start, end, **_):
        """Add a span's own seconds: those of the spans within it, which ended before it, are counted already."""
        if event not in STEPS:
            return
        self.programs["all"] += STEPS[event] == "compiling"
        spans = self._spans[threading.get_ident()]
        inner = 0.0
        while spans and spans[-1][0] >= start:
            first, last = spans.pop()
            inner += last - first
        spans.append((start, end))
        self.seconds[STEPS[event]] += end - start - inner

    def of_this_process(self) -> dict:
        """Programs and seconds so far, and the largest memory of this process and of any program that it started."""
        peaks = [resource.getrusage(who).ru_maxrss / KIBIBYTES / 1024**2 for who in
                 (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]  # fmt: skip
        return {"programs": dict(self.programs), "seconds": dict(self.seconds), "peaks": peaks}

    def pytest_sessionfinish(self, session):
        """Hand a worker's costs to the process that prints."""
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput[KEY] = self.of_this_process()

    @pytest.hookimpl(optionalhook=True)  # of pytest-xdist
    def pytest_testnodedown(self, node):
        """Keep the costs of a worker that ended; one that crashed has none."""
        if KEY in getattr(node, "workeroutput", {}):
            self.workers.append(node.workeroutput[KEY])

    def pytest_terminal_summary(self, terminalreporter):
        """Print the sums over all workers, and the memory of each."""
        workers = self.workers or [self.of_this_process()]
        programs = sum((Counter(worker["programs"]) for worker in workers), Counter())
        seconds = sum((Counter(worker["seconds"]) for worker in workers), Counter())
        steps = ", ".join(f"{step} {seconds[step]:.0f} s" for step in STEPS.values())
        terminalreporter.write_line(
            f"programs: {programs['all'] - programs['loaded']} compiled, {programs['loaded']} loaded; {steps}"
        )
        own, started = ([f"{worker['peaks'][k]:.1f}" for worker in workers] for k in (0, 1))
        terminalreporter.write_line(f"peak memory: {', '.join(own)} GiB; of programs started: {', '.join(started)} GiB")


def register(config):
    """Count from here on, in this process and, by way of their own conftest, in its workers."""
    config.pluginmanager.register(Costs())

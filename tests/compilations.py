"""How many programs a piece of a test compiles, and for how long."""

from contextlib import contextmanager
from dataclasses import dataclass, field

import jax

from newtonjax.fields.packed import OPTIONS

# Recorded once a program, whether the compiler makes it or a persistent cache has it.
_EVENT = "/jax/core/compile/backend_compile_duration"

# For programs of which the numbers are tested and not the speed: a third of the time to compile, and of the memory.
QUICKLY = {"xla_backend_optimization_level": 0, **OPTIONS}


@dataclass
class Compilations:
    """Seconds that each program took, in order."""

    seconds: list[float] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Programs compiled."""
        return len(self.seconds)


@contextmanager
def compilations():
    """Counts the programs that are compiled inside, into `count` and `seconds` of what it gives."""
    compiled = Compilations()

    def listen(event: str, duration: float, **_) -> None:
        if event == _EVENT:
            compiled.seconds.append(duration)

    jax.monitoring.register_event_duration_secs_listener(listen)
    try:
        yield compiled
    finally:
        jax.monitoring.unregister_event_duration_listener(listen)

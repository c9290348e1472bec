"""Where the command starts and ends: outside of its own handlers of signals there is nothing to break off.

Nothing is written before `stopping.watched` takes over. Python's own handler answers Ctrl-C with a traceback while this
file and what it needs are imported, so it needs next to nothing: `signal` itself takes longer than all the rest.
"""

import _signal  # pyright: ignore[reportMissingImports] (the part of `signal` in C, in sys.modules from the start)


def main() -> None:
    """Run the command `newtonjax`, and end the process with its exit status."""
    # Where a parent has Ctrl-C ignored (`nohup`, a job in the background), it stays so.
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)
    import os
    import sys
    from contextlib import suppress

    from fitting.shell import cli

    status = cli.main()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):  # nobody reads it, or it is closed
            stream.flush()
    # Everything is written: to take the interpreter down takes a quarter of a second, and a signal in that time
    # would make a failure of it.
    os._exit(status)

"""The process that measures for the page: it can be killed at any time, and another one takes its place."""

import asyncio
import multiprocessing
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from fitting.shell.page.serving import ANSWERED, ENDED, FAILED, READY, serve

# Between the end of a process that was cancelled and the start of the next [s].
_MOMENT = 0.1
Listener = Callable[[str, Any], None]


class WorkError(ValueError):
    """What the worker said of input that it could not use, or that it ended without an answer."""


class Worker:
    """One process that does one thing after the other; a call that is cancelled ends it at once.

    `files`: a folder of the process alone, for what its libraries read from files only; it is emptied when the process
    ends, however that comes about. `warm_up`: "photographs" or "bench", to load what
    these need before the first call.
    """

    def __init__(self, files: Path, warm_up: str = ""):
        self._files, self._warm_up = files, warm_up
        self._one_at_a_time = asyncio.Lock()
        self._process: Any = None
        self._pipe: Any = None
        self._started, self._is_ready, self._is_closed = asyncio.Event(), False, False
        self._answer: asyncio.Future | None = None
        self._listener: Listener | None = None
        self.waiting = 0
        self.started = 0.0

    @property
    def is_ready(self) -> bool:
        """Whether it answers without having to load anything."""
        return self._is_ready

    @property
    def pid(self) -> int | None:
        """The number of the process, None before the first start."""
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the process, unless it runs; wants a running event loop."""
        if self._is_closed or (self._process is not None and self._process.is_alive()):
            return
        # A process that runs JAX has threads, and must not fork; nor may its children inherit them.
        context = multiprocessing.get_context("spawn")
        self._pipe, remote = context.Pipe()
        arguments = (remote, self._files, self._warm_up)
        self._process = context.Process(target=serve, args=arguments, daemon=True, name="newtonjax-page")
        self._process.start()
        remote.close()
        self._started.clear()
        self._is_ready = False
        self.started = time.monotonic()
        listening = (self._pipe, asyncio.get_running_loop())
        threading.Thread(target=self._listen, args=listening, daemon=True, name="page-listener").start()

    def stop(self) -> None:
        """Kill the process, if there is one, and empty its folder."""
        process, self._process, self._pipe = self._process, None, None
        self._is_ready = False
        if process is not None:
            process.kill()
            process.join()
        for path in self._files.glob("*"):
            path.unlink(missing_ok=True)

    def close(self) -> None:
        """Stop, and start no other process."""
        self._is_closed = True
        self.stop()
        self._started.set()

    async def call(self, task: str, *arguments: Any, listener: Listener | None = None) -> Any:
        """What a task of `serving.TASKS` returns; `listener` is called with the kind and content of what it tells.

        Raises WorkError with the task's own text. Cancelled while it runs, it kills the process and starts another.
        """
        self.waiting += 1
        try:
            async with self._one_at_a_time:
                return await self._call(task, arguments, listener)
        finally:
            self.waiting -= 1

    async def _call(self, task: str, arguments: tuple, listener: Listener | None) -> Any:
        self.start()
        answer = asyncio.get_running_loop().create_future()
        self._answer, self._listener = answer, listener
        try:
            await self._started.wait()
            pipe = self._pipe
            if pipe is None or not self._is_ready:
                raise WorkError("the worker process could not start; `newtonjax doctor` says what is amiss")
            if any(isinstance(argument, bytes) for argument in arguments):
                # A photograph fills the pipe: in this thread it would hold up every other person's page.
                await asyncio.to_thread(pipe.send, (task, arguments))
            else:
                pipe.send((task, arguments))
            return await answer
        except asyncio.CancelledError:
            await asyncio.to_thread(self.stop)
            # The person sees first that it has ended: to start another one takes a moment.
            asyncio.get_running_loop().call_later(_MOMENT, self.start)
            raise
        except OSError as error:
            raise WorkError(f"the worker process has ended ({error}); try again") from None
        finally:
            self._answer = self._listener = None

    def _listen(self, pipe: Any, loop: asyncio.AbstractEventLoop) -> None:
        """In a thread: hand on what one process sends, until it ends."""
        kind = ""
        while kind != ENDED:
            try:
                kind, content = pipe.recv()
            except (EOFError, OSError):
                kind, content = ENDED, "the worker process ended without an answer; try again"
            # The page may be over.
            with suppress(RuntimeError):
                loop.call_soon_threadsafe(self._receive, pipe, kind, content)

    def _receive(self, pipe: Any, kind: str, content: Any) -> None:
        if pipe is not self._pipe:  # of a process that was killed
            return
        if kind == ENDED:
            self.stop()
            self._started.set()
        if kind == READY:
            self._is_ready = True
            self._started.set()
        elif kind not in (ANSWERED, FAILED, ENDED):
            if self._listener is not None:
                self._listener(kind, content)
        elif self._answer is not None and not self._answer.done():
            if kind == ANSWERED:
                self._answer.set_result(content)
            else:
                self._answer.set_exception(WorkError(content))

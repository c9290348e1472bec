"""The page served in a thread of this process, and what the tests ask it by."""

import asyncio
import socket
import threading
import time
from contextlib import contextmanager
from typing import NamedTuple

# A machine with ten other jobs may need this long for what takes seconds alone [s].
PATIENCE = 300.0


class Served(NamedTuple):
    """The page's parts, its loop, its address."""

    page: object
    loop: asyncio.AbstractEventLoop
    host: str

    @property
    def url(self) -> str:
        return f"http://{self.host}"

    def headers(self) -> dict:
        """What the page's own scripts send."""
        return {"origin": self.url}

    def wait(self, work, seconds: float = PATIENCE):
        """What a coroutine of the page returns."""
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(seconds)

    def call(self, function, *arguments):
        """What a function returns in the page's thread."""

        async def called():
            return function(*arguments)

        return self.wait(called())


@contextmanager
def served(folder):
    """The page at a free port of this machine; its processes end with it."""
    import uvicorn

    from fitting.shell.page.server import parts

    listening = socket.socket()
    listening.bind(("127.0.0.1", 0))
    host = f"127.0.0.1:{listening.getsockname()[1]}"
    page = parts(folder, (host,))
    server = uvicorn.Server(uvicorn.Config(page.app, log_level="error", server_header=False))
    loop = asyncio.new_event_loop()

    def run():
        asyncio.set_event_loop(loop)
        loop.run_until_complete(server.serve(sockets=[listening]))

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    while not server.started:
        assert thread.is_alive()
        time.sleep(0.01)
    try:
        yield Served(page, loop, host)
    finally:
        server.should_exit = True
        thread.join(PATIENCE)
        assert not thread.is_alive()

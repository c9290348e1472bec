"""The server of the page: on this machine alone unless asked otherwise."""

import contextlib
import socket
import sys
import tempfile
from collections.abc import AsyncGenerator
from pathlib import Path
from typing import NamedTuple

import uvicorn  # pyright: ignore[reportMissingImports]  # an extra
from fastapi import FastAPI  # pyright: ignore[reportMissingImports]
from nicegui import app as framework  # pyright: ignore[reportMissingImports]
from nicegui import ui  # pyright: ignore[reportMissingImports]

from fitting.shell import stopping
from fitting.shell.page.guard import LIMIT, Guard
from fitting.shell.page.routes import with_routes
from fitting.shell.page.sessions import Sessions
from fitting.shell.page.view import show
from fitting.shell.page.worker import Worker

# A phone that was laid aside may come back for its answer [s].
_PATIENCE = 60


class Address(NamedTuple):
    """Where the page listens, and by what other names it may be asked for ("name:port")."""

    host: str = "127.0.0.1"
    port: int = 0
    names: tuple[str, ...] = ()


class Parts(NamedTuple):
    """What the page is made of: the guarded application, open tabs, and the two processes."""

    app: Guard
    sessions: Sessions
    photographs: Worker
    bench: Worker


def parts(folder: Path, hosts: tuple[str, ...], says: str = "") -> Parts:
    """The application that answers at `hosts`; its processes keep their files in `folder`.

    `says`: what is printed when signals end it in order.
    """
    folders = folder / "photographs", folder / "bench"
    for path in folders:
        path.mkdir(mode=0o700)
    photographs, bench = Worker(folders[0], "photographs"), Worker(folders[1], "bench")
    sessions = Sessions(photographs)

    @contextlib.asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncGenerator[None, None]:
        photographs.start()
        if says:
            print(says, flush=True)
        yield
        photographs.close()
        bench.close()

    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan)
    with_routes(app, sessions, bench)
    # A bar over the page for every picture would only distract, and it has no name for a screen reader.
    framework.config.quasar_config["loadingBar"]["skipHijack"] = True

    @ui.page("/", title="newtonjax")  # pyright: ignore[reportUntypedFunctionDecorator]  # where the extra is not there
    def page(session: str = "") -> None:
        show(sessions, photographs, bench, session)

    ui.run_with(app, language="en-US", dark=None, reconnect_timeout=_PATIENCE, show_welcome_message=False)
    return Parts(Guard(app, hosts, LIMIT), sessions, photographs, bench)


def serve(address: Address) -> int:
    """Serve the page until Ctrl-C; the exit status. Raises OSError for an address that cannot be had."""
    listening = socket.socket(socket.AF_INET)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((address.host, address.port))
        listening.listen(128)
    except OSError as error:
        listening.close()
        raise OSError(
            f"the page cannot listen at {address.host}:{address.port} ({error.strerror}); name another --port"
        ) from None
    port = listening.getsockname()[1]
    hosts = (f"127.0.0.1:{port}", f"localhost:{port}", f"{address.host}:{port}", *address.names)
    says = f"the page is at http://{address.host}:{port}/ (Ctrl-C ends it)"
    if not address.host.startswith("127."):
        print("newtonjax: others in this network may reach the page by this address", file=sys.stderr)
    with tempfile.TemporaryDirectory(prefix="newtonjax-page-") as folder:
        page = parts(Path(folder), hosts, says)
        # A picture is compressed already: to try it again takes longer than to make it.
        settings = uvicorn.Config(
            page.app,
            log_level="warning",
            server_header=False,
            ws_max_size=LIMIT,
            ws_per_message_deflate=False,
            timeout_graceful_shutdown=1,
        )
        with stopping.left_to_a_server():
            uvicorn.Server(settings).run(sockets=[listening])
    return 0

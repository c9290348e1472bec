"""The verb `app`: the page for a browser. What is heavy is imported inside it."""

from typing import Annotated

import typer


def app(
    port: Annotated[int, typer.Option(min=0, max=65535, help="Port to listen at; 0 for any that is free.")] = 8080,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Address to listen at: this machine's own, which only it can reach.")
    ] = "127.0.0.1",
    allow_host: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME:PORT", help="Another name that browsers may ask for; may be repeated."),
    ] = None,
) -> int:
    """Serve a page for the browser: a radius from a photograph, a virtual bench, tables of rings.

    It answers this machine alone, and contacts no other. Photographs are kept in memory until
    their tab is closed. Wants the extra `app`.
    """
    from fitting.shell.progress import waiting

    try:
        with waiting("loading the page"):
            from fitting.shell.page.server import Address, serve
    except ModuleNotFoundError as error:
        if str(error.name).split(".")[0] not in ("nicegui", "fastapi", "uvicorn", "starlette"):
            raise
        raise ValueError(f"{error.name} is not installed; pip install 'newtonjax[app]'") from None
    return serve(Address(host, port, tuple(allow_host or ())))

"""The page's own routes: photographs come in as they are, answers and pictures go out. All by a tab's token."""

import json
from pathlib import PurePath
from typing import Any

from fastapi import FastAPI, Request, WebSocket  # pyright: ignore[reportMissingImports]  # an extra
from fastapi.responses import JSONResponse, Response  # pyright: ignore[reportMissingImports]
from starlette.websockets import WebSocketDisconnect  # pyright: ignore[reportMissingImports]

from fitting.shell.page.sessions import MEDIA, Sessions
from fitting.shell.page.worker import Worker, WorkError

# Of the slider's message to the bench [bytes].
_LONGEST_MESSAGE = 4096
# What the page shows in its own frame; all else is offered as a file to keep.
_SHOWN = (".jpg",)


def with_routes(app: FastAPI, sessions: Sessions, bench: Worker) -> FastAPI:
    """The application with the routes of the page's own."""

    async def receive(token: str, request: Request, name: str = "photograph") -> Response:
        session = sessions.get(token)
        if session is None:
            return _refused(404, "this page is closed; load it again")
        try:
            about = await session.take(name, await request.body())
        except WorkError as error:
            return _refused(422, str(error))
        return JSONResponse({key: value for key, value in about.items() if key != "pictures"} | {"name": session.name})

    async def receive_reticle(token: str, request: Request, name: str = "photograph") -> Response:
        session = sessions.get(token)
        if session is None:
            return _refused(404, "this page is closed; load it again")
        try:
            await session.take_reticle(name, await request.body())
        except WorkError as error:
            return _refused(422, str(error))
        return JSONResponse({"name": session.reticle.name})

    async def send(token: str, name: str) -> Response:
        session = sessions.get(token)
        content = None if session is None else session.file(name)
        suffix = PurePath(name).suffix
        if content is None or suffix not in MEDIA:
            return _refused(404, "there is no such file")
        headers = {"cache-control": "no-store"}
        if suffix not in _SHOWN:
            headers["content-disposition"] = f'attachment; filename="{name}"'
        return Response(content, media_type=MEDIA[suffix], headers=headers)

    async def draw(socket: WebSocket, token: str) -> None:
        if sessions.get(token) is None:
            await socket.close(1008)
            return
        await socket.accept()
        try:
            while True:
                text = await socket.receive_text()
                await _draw(socket, text, bench)
        except WebSocketDisconnect:
            return

    app.add_api_route("/photograph/{token}", receive, methods=["POST"])
    app.add_api_route("/reticle/{token}", receive_reticle, methods=["POST"])
    app.add_api_route("/files/{token}/{name}", send, methods=["GET"])
    app.add_api_websocket_route("/bench/{token}", draw)
    return app


async def _draw(socket: WebSocket, text: str, bench: Worker) -> None:
    """The picture of a bench as JPEG; what cannot be drawn is said in a text."""
    try:
        values: Any = json.loads(text) if len(text) <= _LONGEST_MESSAGE else None
        if not isinstance(values, dict):
            raise WorkError("a bench is an object of numbers and names")
        await socket.send_bytes(await bench.call("draw", values))
    except (WorkError, ValueError) as error:
        await socket.send_text(str(error))


def _refused(status: int, message: str) -> Response:
    return JSONResponse({"message": message}, status_code=status)

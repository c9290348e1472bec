"""What stands before every route of the page: who may ask, how much may be sent, and what the browser may load.

It is plain ASGI, so that it sees websockets and the framework's own socket too.
"""

from collections import defaultdict
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from typing import Any

# Of one request [bytes]: photographs of cameras are smaller as files.
LIMIT = 64_000_000
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Message, Receive, Send], Awaitable[None]]

# The browser itself refuses every other address. The framework compiles its templates, hence 'unsafe-eval'.
_POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
    "script-src 'self' 'unsafe-inline' 'unsafe-eval'; frame-ancestors 'none'; base-uri 'none'; form-action 'self'; "
    "object-src 'none'"
)
_HEADERS = {
    "content-security-policy": _POLICY,
    "x-frame-options": "DENY",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
}
_FORBIDDEN, _TOO_LARGE = 403, 413
_WHY = {
    _FORBIDDEN: "This page answers only at its own address and to itself.",
    _TOO_LARGE: "This is larger than the page takes.",
}
# What a websocket is closed with: the policy's own code.
_POLICY_VIOLATION = 1008


class TooLargeError(Exception):
    """More was sent than its length said, or than is allowed."""


class Guard:
    """An application that answers at `hosts` ("127.0.0.1:8080") alone, and takes at most `limit` bytes a request.

    A page of another site can neither send a form, open a socket (Origin), nor point its own name at this machine
    (Host).
    """

    def __init__(self, app: Application, hosts: Iterable[str], limit: int):
        self._app, self._hosts, self._limit = app, frozenset(hosts), limit

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
        elif status := self._refusal(scope):
            await _refuse(scope["type"], status, send)
        else:
            await self._pass_on(scope, receive, send)

    async def _pass_on(self, scope: Message, receive: Receive, send: Send) -> None:
        request = _Request(receive, send, self._limit)
        try:
            await self._app(scope, request.receive, request.send)
        except Exception:
            # What the application made of a body that broke off is no news.
            if not request.is_too_large:
                raise
        if request.is_too_large and not request.is_answered:
            await _refuse(scope["type"], _TOO_LARGE, send)

    def _refusal(self, scope: Message) -> int:
        """The status to refuse a request with, 0 for one that may pass."""
        headers: dict[bytes, list[str]] = defaultdict(list)
        for name, value in scope["headers"]:
            headers[name.lower()].append(value.decode("latin-1"))
        hosts, origins = headers[b"host"], headers[b"origin"]
        only_reads = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return _FORBIDDEN
        if any(origin != f"http://{hosts[0]}" for origin in origins) or not (origins or only_reads):
            return _FORBIDDEN
        length = (headers[b"content-length"] or ["0"])[0]
        is_small = length.isascii() and length.isdecimal() and int(length[:20]) <= self._limit
        return 0 if is_small else _TOO_LARGE


class _Request:
    """What passes between the server and the application: counted on the way in, with headers on the way out.

    A body in chunks states no length. Where it grows too large, nothing that the application says of it goes out.
    """

    def __init__(self, receive: Receive, send: Send, limit: int):
        self._receive, self._send, self._limit = receive, send, limit
        self._size = 0
        self.is_answered, self.is_too_large = False, False

    async def receive(self) -> Message:
        """The next part. Raises TooLargeError."""
        message = await self._receive()
        if message["type"] == "http.request":
            self._size += len(message.get("body", b""))
        if self._size > self._limit:
            self.is_too_large = True
            raise TooLargeError
        return message

    async def send(self, message: Message) -> None:
        """Send a part of the answer."""
        if self.is_too_large and not self.is_answered:
            return
        if message["type"] == "http.response.start":
            self.is_answered = True
            message["headers"] = [*message.get("headers", ()), *_header_lines()]
        await self._send(message)


def _header_lines() -> list[tuple[bytes, bytes]]:
    return [(name.encode(), value.encode()) for name, value in _HEADERS.items()]


async def _refuse(kind: str, status: int, send: Send) -> None:
    if kind == "websocket":
        return await send({"type": "websocket.close", "code": _POLICY_VIOLATION})
    body = _WHY[status].encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": status, "headers": [*headers, *_header_lines()]})
    return await send({"type": "http.response.body", "body": body})

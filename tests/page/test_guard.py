"""The guard before the page: hosts, origins and sizes that it refuses, and the headers of what passes."""

import asyncio

import pytest

from fitting.shell.page.guard import Guard

OWN = "127.0.0.1:8080"
EVIL = "http://evil.example"


async def behind(scope, receive, send):
    """An application that reads the whole body and answers 200, or accepts a websocket."""
    if scope["type"] == "websocket":
        return await send({"type": "websocket.accept"})
    while (await receive()).get("more_body"):
        pass
    await send({"type": "http.response.start", "status": 200, "headers": []})
    return await send({"type": "http.response.body", "body": b"done"})


def answer_of(headers, kind="http", method="GET", chunks=(b"",), limit=100) -> dict:
    """The first message that comes back."""
    sent, waiting = [], list(chunks)

    async def receive():
        return {"type": "http.request", "body": waiting.pop(0), "more_body": bool(waiting)}

    async def send(message):
        sent.append(message)

    lines = [(name.encode(), value.encode()) for name, value in headers]
    scope = {"type": kind, "method": method, "headers": lines}
    asyncio.run(Guard(behind, [OWN], limit)(scope, receive, send))
    return sent[0]


def status_of(*headers, **request) -> int:
    return answer_of(headers, **request)["status"]


def test_its_own_host_passes_with_headers_that_keep_the_browser_here():
    first = answer_of([("host", OWN)])
    headers = {name.decode(): value.decode() for name, value in first["headers"]}
    assert first["status"] == 200
    assert headers["x-frame-options"] == "DENY"
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["cross-origin-resource-policy"] == "same-origin"
    assert headers["cross-origin-opener-policy"] == "same-origin"
    assert headers["content-security-policy"].startswith("default-src 'self'; ")
    assert "http" not in headers["content-security-policy"]


@pytest.mark.parametrize("host", ["evil.example", f"{OWN}.evil.example", "127.0.0.1", "", "127.0.0.1:8081"])
def test_another_host_is_refused(host):
    assert status_of(("host", host)) == 403


def test_two_hosts_and_none_are_refused():
    assert status_of(("host", OWN), ("host", OWN)) == 403
    assert status_of() == 403


@pytest.mark.parametrize("origin", [EVIL, "null", f"https://{OWN}", f"http://{OWN}.evil.example"])
def test_another_origin_is_refused(origin):
    for method in ("GET", "POST"):
        assert status_of(("host", OWN), ("origin", origin), method=method) == 403


def test_what_changes_something_must_say_its_own_origin():
    assert status_of(("host", OWN), method="POST") == 403
    assert status_of(("host", OWN), ("origin", f"http://{OWN}"), method="POST") == 200


def test_a_websocket_must_say_its_own_origin():
    for origins in ([], [("origin", EVIL)], [("origin", "null")]):
        assert answer_of([("host", OWN), *origins], kind="websocket") == {"type": "websocket.close", "code": 1008}
    first = answer_of([("host", OWN), ("origin", f"http://{OWN}")], kind="websocket")
    assert first["type"] == "websocket.accept"


@pytest.mark.parametrize("length", ["101", "-1", "1e2", "٣", "9" * 5000])
def test_a_length_that_is_too_large_or_no_number_is_refused(length):
    scope = [("host", OWN), ("origin", f"http://{OWN}"), ("content-length", "100")]
    assert status_of(*scope, method="POST") == 200
    scope[2] = ("content-length", length) if length.isascii() else ("content-length", "3\u00b2")
    assert status_of(*scope, method="POST") == 413


def test_a_body_in_chunks_is_counted():
    headers = ("host", OWN), ("origin", f"http://{OWN}")
    assert status_of(*headers, method="POST", chunks=(b"x" * 50, b"x" * 50)) == 200
    assert status_of(*headers, method="POST", chunks=(b"x" * 60, b"x" * 60)) == 413

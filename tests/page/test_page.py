"""The page by HTTP and in its own loop: from a photograph to files, and all that it must refuse."""

import socket
import struct
import tomllib
import zlib
from importlib.resources import files

import pytest
from report_sources import noise, picture_bytes
from serving_page import PATIENCE

from fitting.shell.page.guard import LIMIT
from fitting.shell.page.pictures import region_mask
from fitting.shell.page.sessions import clean_name
from fitting.shell.page.worker import WorkError

httpx = pytest.importorskip("httpx", reason="the extra app is not installed")
nicegui = pytest.importorskip("nicegui", reason="the extra app is not installed")
SAMPLE = files("fitting") / "data" / "sample.png"


@pytest.fixture
def session(page):
    opened = page.call(page.page.sessions.open)
    yield opened
    page.call(page.page.sessions.close, opened.token)


@pytest.fixture
def client(page):
    with httpx.Client(base_url=page.url, timeout=PATIENCE) as connected:
        yield connected


def sent(page, client, session, data: bytes, name: str = "rings.png"):
    """The answer to a photograph that a page sends."""
    return client.post(f"/photograph/{session.token}", params={"name": name}, content=data, headers=page.headers())


def ignore(*_):
    """Listen to nothing."""


def test_a_photograph_becomes_a_radius_and_files_to_keep(page, client, session):
    about = sent(page, client, session, SAMPLE.read_bytes()).json()
    assert (about["rows"], about["columns"], about["name"]) == (480, 640, "rings.png")
    assert client.get(f"/files/{session.token}/region.jpg").content.startswith(b"\xff\xd8")
    steps = []
    settings = page.wait(session.take_sample())
    page.wait(session.measure(settings, lambda kind, content: steps.append((kind, content))))
    truth = tomllib.loads((files("fitting") / "data" / "sample.toml").read_text())["truth"]["radius"]
    assert abs(session.answer["radius_m"] - truth) < 3 * session.answer["radius_sd_m"]
    assert [content for kind, content in steps if kind == "progress"] == [(step, 4) for step in (1, 2, 3, 4)]
    saved = {name: client.get(f"/files/{session.token}/{name}") for name in session.files}
    assert saved["report.html"].headers["content-disposition"] == 'attachment; filename="report.html"'
    assert saved["result.json"].json()["radius_m"] == session.answer["radius_m"]
    assert saved["result.png"].content.startswith(b"\x89PNG")
    assert saved["dark_rings.csv"].text.startswith("order,")
    assert saved["rings.jpg"].headers["content-type"] == "image/jpeg"
    assert saved["repeat.sh"].text.startswith("newtonjax fit sample.png --view reflected --wavelength 589.294nm ")
    assert 'fitting.fit("sample.png", ' in saved["repeat.py"].text


def test_the_same_lines_of_python_give_the_same_radius(page, session, tmp_path, monkeypatch):
    settings = page.wait(session.take_sample())
    page.wait(session.narrow(({"x": 350.0, "y": 220.0, "radius": 180.0},)))
    page.wait(session.measure(settings, ignore))
    for name, content in session.files.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "sample.png").write_bytes(SAMPLE.read_bytes())
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(session.files["repeat.py"].decode().replace("print(result)", ""), names)  # noqa: S102  # what the page itself wrote
    assert "mask" in session.files["repeat.py"].decode()
    assert names["result"].radius == pytest.approx(session.answer["radius_m"], rel=1e-9)


def test_two_clicks_on_a_known_length_are_a_scale(page, session):
    scale = page.wait(page.page.photographs.call("scale", ["100,200", "400,600"], "5mm", "1%"))
    assert scale["pixel_size_m"] == pytest.approx(1e-5)
    with pytest.raises(WorkError, match="two places"):
        page.wait(page.page.photographs.call("scale", ["100", "400,600"], "5mm", ""))


@pytest.mark.parametrize(
    ("texts", "words"),
    [
        ({"wavelength": "589"}, "has no unit"),
        ({"wavelength": "/etc/lamp.csv"}, "names a file"),
        ({"scene": "/etc/passwd"}, "cannot be given on the page"),
        ({"mask": "/etc/passwd"}, "cannot be given on the page"),
    ],
)
def test_what_is_typed_wrongly_is_said_before_the_fit(page, session, texts, words):
    settings = page.wait(session.take_sample())
    with pytest.raises(ValueError, match=words):
        page.wait(session.measure(settings._replace(texts=texts), ignore))


def test_two_users_do_not_see_each_other(page, client, session):
    page.wait(session.take_sample())
    neighbour = page.call(page.page.sessions.open)
    assert neighbour.token != session.token
    assert client.get(f"/files/{neighbour.token}/photograph.jpg").status_code == 404
    assert not neighbour.data
    page.call(page.page.sessions.close, neighbour.token)


def test_nothing_stays_of_a_tab_that_is_closed(page, client):
    opened = page.call(page.page.sessions.open)
    page.wait(opened.take_sample())
    address = f"/files/{opened.token}/photograph.jpg"
    assert client.get(address).status_code == 200
    page.call(page.page.sessions.close, opened.token)
    assert client.get(address).status_code == 404
    assert sent(page, client, opened, SAMPLE.read_bytes()).status_code == 404
    assert not list(page.page.photographs._files.iterdir())


def png_of(rows: int, columns: int) -> bytes:
    """A 16-bit RGB PNG of zeros: a thousand times smaller than its pixels."""
    packer = zlib.compressobj(9)
    line = bytes(1 + 6 * min(columns, 20_000))
    data = b"".join(packer.compress(line) for _ in range(min(rows, 200))) + packer.flush()
    chunks = (b"IHDR", struct.pack(">IIBBBBB", columns, rows, 16, 2, 0, 0, 0)), (b"IDAT", data), (b"IEND", b"")
    lines = (
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body)) for name, body in chunks
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(lines)


def tiff_of(side: int) -> bytes:
    """A 16-bit RGB TIFF whose head promises so many pixels to a side, in one packed strip of zeros."""
    strip = zlib.compress(bytes(10_000_000), 9)
    # Width, height, bits, packing, colours, strip, samples, rows and bytes of the strip.
    entries = [(256, side), (257, side), (258, 16), (259, 8), (262, 2), (273, 8), (277, 3), (278, side)]
    entries.append((279, len(strip)))
    start = 8 + len(strip)
    table = b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in entries)
    return struct.pack("<2sHI", b"II", 42, start) + strip + struct.pack("<H", len(entries)) + table + bytes(4)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("bomb.png", png_of(20_000, 20_000)),
        ("bomb.tif", tiff_of(20_000)),
        ("wide.png", png_of(2, 2**31 - 1)),
        ("text.png", b"not a picture"),
        ("drawing.svg", b"<svg xmlns='http://www.w3.org/2000/svg'><script>alert(1)</script></svg>"),
        ("cut.png", SAMPLE.read_bytes()[:2000]),
        ("empty.png", b""),
        ("array.npy", b"\x93NUMPY\x01\x00" + b"\xff" * 50),
    ],
)
def test_what_is_no_photograph_is_refused_in_one_line(page, client, session, name, data):
    answer = sent(page, client, session, data, name)
    assert answer.status_code == 422
    message = answer.json()["message"]
    assert name in message
    assert "\n" not in message
    assert str(page.page.photographs._files) not in message
    assert not session.data


@pytest.mark.parametrize(
    ("name", "cleaned"),
    [
        ("<img src=x onerror=alert(1)>.png", "_img src_x onerror_alert(1)_.png"),
        ("../../etc/passwd.png", "passwd.png"),
        ("..\\..\\windows\\x.png", "x.png"),
        ("..", "photograph"),
        ("", "photograph"),
        ("a\u202egnp.exe", "a_gnp.exe"),
        ("x" * 300 + ".png", "x" * 80 + ".png"),
    ],
)
def test_a_name_is_cleaned_of_folders_and_of_script(page, client, session, name, cleaned):
    assert clean_name(name) == cleaned
    sent(page, client, session, SAMPLE.read_bytes(), name)
    assert session.name in (cleaned, "photograph.png", "")


def test_more_than_the_limit_is_refused_with_and_without_a_length(page, client, session):
    address, headers = f"/photograph/{session.token}", page.headers()
    with socket.create_connection(page.host.split(":")) as raw:
        head = f"POST {address} HTTP/1.1\r\nHost: {page.host}\r\nOrigin: {page.url}\r\n"
        raw.sendall(f"{head}Content-Length: {LIMIT + 1}\r\n\r\n".encode())
        assert raw.recv(100).startswith(b"HTTP/1.1 413")
    chunk = bytes(1_000_000)
    answer = client.post(address, content=(chunk for _ in range(LIMIT // len(chunk) + 2)), headers=headers)
    assert answer.status_code == 413


def test_a_photograph_of_a_known_size_is_as_guarded_as_one_of_rings(page, client, session):
    address = f"/reticle/{session.token}"
    assert client.post(address, content=b"x", headers={"origin": "http://evil.example"}).status_code == 403
    assert client.post("/reticle/unknown", content=b"x", headers=page.headers()).status_code == 404
    refused = client.post(
        address, params={"name": "../bomb.png"}, content=png_of(20_000, 20_000), headers=page.headers()
    )
    assert refused.status_code == 422
    assert refused.json()["message"].startswith("bomb.png")
    assert not session.reticle.data


def test_a_photograph_without_rings_shows_what_was_tried(page, session):
    picture = picture_bytes(noise())
    page.wait(session.take("noise.png", picture))
    settings = page.wait(session.take_sample())
    page.wait(session.take("noise.png", picture))
    page.wait(session.measure(settings, ignore))
    assert session.answer["status"] == "refused"
    assert session.answer["message"]
    assert "report.txt" in session.files


def test_an_address_with_a_session_that_is_not_open_gets_a_new_one(page):
    opened = page.call(page.page.sessions.open, "guessed")
    assert not opened.token.startswith("guess")
    page.call(page.page.sessions.close, opened.token)


def test_a_session_lasts_as_long_as_a_page_shows_it(page):
    opened = page.call(page.page.sessions.open)
    again = page.call(page.page.sessions.open, opened.token)
    assert again is opened
    page.call(page.page.sessions.close, opened.token)
    assert page.page.sessions.get(opened.token) is opened
    page.call(page.page.sessions.close, opened.token)
    assert page.page.sessions.get(opened.token) is None


def test_shapes_of_a_region_add_up_and_those_left_out_are_taken_away():
    circle, hole = {"x": 50.0, "y": 50.0, "radius": 40.0}, {"x": 50.0, "y": 50.0, "radius": 20.0, "leaves_out": 1.0}
    strip = {"x": 0.0, "y": 0.0, "to_x": 99.0, "to_y": 4.0}
    mask = region_mask((circle, hole, strip), (100, 100))
    assert (mask[50, 50], mask[50, 80], mask[95, 95], mask[2, 95]) == (False, True, False, True)
    assert region_mask((hole,), (100, 100))[0, 0]
    assert not region_mask((hole,), (100, 100))[50, 50]
    with pytest.raises(ValueError, match="holds no pixel"):
        region_mask((hole, hole | {"leaves_out": 0.0}), (100, 100))


def test_what_is_held_and_where_a_fit_starts_stands_in_both_ways_to_repeat_it(page, session):
    settings = page.wait(session.take_sample())
    texts = {"fix": "gap=0nm centre=352,218", "start": "centre=352,218 radius=0.9m", "prior": "stretch=0:8e-07"}
    settings = settings._replace(texts={**settings.texts, **texts})
    page.wait(session.measure(settings, ignore))
    assert session.answer["parameters"]["centre_x_px"]["value"] == 352.0
    assert session.answer["gap_m"] == 0.0
    assert abs(session.answer["parameters"]["stretch"]["value"]) < 1e-6
    command, lines = (session.files[name].decode() for name in ("repeat.sh", "repeat.py"))
    assert "--fix 'gap=0nm centre=352,218'" in command
    assert "fixed={'gap': 0.0, 'centre_px': (352.0, 218.0)}" in lines
    assert "start={'centre_px': (352.0, 218.0), 'radius': 0.9}" in lines


@pytest.mark.parametrize("path", ["/docs", "/redoc", "/openapi.json", "/files/x/y.png", "/photograph/x"])
def test_what_is_not_the_page_is_not_there(client, path):
    assert client.get(path).status_code in (404, 405)


def raw_status(page, path: str, *headers: str) -> int:
    """The status of a request that no client would send."""
    with socket.create_connection(page.host.split(":")) as raw:
        raw.sendall("\r\n".join([f"GET {path} HTTP/1.1", *headers, "", ""]).encode())
        return int(raw.recv(100).split()[1])


@pytest.mark.parametrize(
    "path",
    [
        "{own}/static/../../../../etc/passwd",
        "{own}/static/%2e%2e/%2e%2e/%2e%2e/etc/passwd",
        "{own}/static/..%2f..%2f..%2fetc%2fpasswd",
        "{own}/resources/x/../../../etc/passwd",
        "{own}/libraries/../../etc/passwd",
        "{own}/esm/x/../../../../etc/passwd",
        "/files/../../etc/passwd",
    ],
)
def test_no_path_leads_out_of_the_page(page, path):
    assert raw_status(page, path.format(own=f"/_nicegui/{nicegui.__version__}"), f"Host: {page.host}") == 404


def test_another_host_or_origin_is_refused_by_every_route(page, client, session):
    socket_path = "/_nicegui_ws/socket.io/?EIO=4&transport=polling"
    for path in ("/", f"/files/{session.token}/photograph.jpg", socket_path, f"/bench/{session.token}"):
        assert raw_status(page, path, "Host: evil.example") == 403
        assert raw_status(page, path, f"Host: {page.host}", "Host: evil.example") in (400, 403)
        assert raw_status(page, path, f"Host: {page.host}", "Origin: http://evil.example") == 403
    for origin in ({}, {"origin": "null"}, {"origin": "http://evil.example"}):
        answer = client.post(f"/photograph/{session.token}", content=b"x", headers=origin)
        assert answer.status_code == 403
        assert "access-control-allow-origin" not in answer.headers
    upgrade = (
        "Upgrade: websocket",
        "Connection: Upgrade",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Key: " + "A" * 22 + "==",
    )
    for path in (f"/bench/{session.token}", "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"):
        for origin in ((), ("Origin: http://evil.example",)):
            assert raw_status(page, path, f"Host: {page.host}", *origin, *upgrade) == 403


def test_the_page_comes_with_its_headers_and_knows_no_other_address(page, client):
    answer = client.get("/")
    assert answer.status_code == 200
    assert answer.headers["content-security-policy"].startswith("default-src 'self'; ")
    assert 'lang="en-US"' in answer.text
    addresses = {word for word in answer.text.split('"') if word.startswith(("http:", "https:", "//"))}
    assert addresses <= {"http://www.w3.org/2000/svg"}

"""The page, served once for all its tests, and windows of a browser that show it."""

import pytest
from browsing import BROWSER, SIZES, opened
from serving_page import served


@pytest.fixture(scope="session")
def page(tmp_path_factory):
    pytest.importorskip("nicegui", reason="the extra app is not installed")
    with served(tmp_path_factory.mktemp("page")) as running:
        yield running


@pytest.fixture(scope="module")
def browser():
    """A browser for one module: while its driver runs, this thread has a running loop, and can have no other."""
    playwright = pytest.importorskip("playwright.sync_api", reason="the extra browser is not installed (make browser)")
    pytest.importorskip("axe_playwright_python", reason="the extra browser is not installed (make browser)")
    if BROWSER is None:
        pytest.skip("there is no chromium here (make browser)")
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=BROWSER)
        yield chromium
        chromium.close()


@pytest.fixture
def view(browser, page, request):
    """The page in a new window, which asks no other address and complains of nothing."""
    size, scheme = getattr(request, "param", ("desktop", "light"))
    window = browser.new_page(viewport=SIZES[size], color_scheme=scheme)
    complaints, addresses = [], []
    window.on("console", lambda line: complaints.append(line.text) if line.type in ("error", "warning") else None)
    window.on("dialog", lambda dialog: complaints.append(dialog.message))
    window.on("request", lambda sent: addresses.append(sent.url))
    window.on("websocket", lambda opened: addresses.append(opened.url.replace("ws://", "http://")))
    opened(window, page)
    yield window
    assert {url for url in addresses if not url.startswith((page.url, "blob:", "data:"))} == set()
    # A refused photograph is an answer of 422, which the browser notes; and so are pixels that a test reads back.
    assert [text for text in complaints if "422" not in text and "getImageData" not in text] == []
    window.close()

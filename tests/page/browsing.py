"""What the tests in a browser share: which one, its windows, and what every page must keep to."""

import shutil
from importlib.resources import files

import pytest
from serving_page import PATIENCE

BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
SAMPLE = files("fitting") / "data" / "sample.png"
SIZES = {"desktop": {"width": 1200, "height": 900}, "phone": {"width": 390, "height": 844}}
BOTH = pytest.mark.parametrize("view", [("desktop", "light"), ("phone", "dark")], ids="-".join, indirect=True)


def opened(window, page) -> None:
    """The page in a window, ready for its first click."""
    window.set_default_timeout(1000 * PATIENCE)
    window.goto(page.url)
    # The server's answer to the first socket: what is clicked before is lost.
    window.wait_for_function("location.search.startsWith('?session=')")


def check_access(window) -> None:
    """Nothing that is serious or worse by the rules of axe, and nothing wider than the screen."""
    from axe_playwright_python.sync_playwright import Axe

    found = Axe().run(window).response["violations"]
    serious = [
        (rule["id"], [node["html"][:200] for node in rule["nodes"]])
        for rule in found
        if rule["impact"] in ("serious", "critical")
    ]
    assert serious == []
    assert window.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0


def take_sample(window) -> None:
    """The sample, its light and its scale."""
    window.click("text=Use the sample")
    window.wait_for_selector("text=640 x 480 pixels")


def fit(window) -> None:
    """The fit, up to its files."""
    window.click("text=Fit the rings")
    window.wait_for_selector("text=To keep")

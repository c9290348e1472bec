"""The page in a browser: the whole flow at desktop and phone width, the bench and its rate, tables, and wrong files."""

import re
import shutil
from importlib.resources import files

import pytest

playwright = pytest.importorskip("playwright.sync_api", reason="the extra browser is not installed (make browser)")
pytest.importorskip("axe_playwright_python", reason="the extra browser is not installed (make browser)")
pytest.importorskip("nicegui", reason="the extra app is not installed")
BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(BROWSER is None, reason="there is no chromium here (make browser)")
SAMPLE = files("fitting") / "data" / "sample.png"
SIZES = {"desktop": {"width": 1200, "height": 900}, "phone": {"width": 390, "height": 844}}
BOTH = pytest.mark.parametrize("view", [("desktop", "light"), ("phone", "dark")], ids="-".join, indirect=True)
# A loaded machine may need this long for what takes a second [ms].
PATIENCE = 60_000


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=BROWSER)
        yield chromium
        chromium.close()


@pytest.fixture
def view(browser, page, request):
    """The page in a new window, which asks no other address and complains of nothing."""
    size, scheme = getattr(request, "param", ("desktop", "light"))
    window = browser.new_page(viewport=SIZES[size], color_scheme=scheme)
    window.set_default_timeout(PATIENCE)
    complaints, addresses = [], []
    window.on("console", lambda line: complaints.append(line.text) if line.type in ("error", "warning") else None)
    window.on("request", lambda sent: addresses.append(sent.url))
    window.on("websocket", lambda opened: addresses.append(opened.url.replace("ws://", "http://")))
    window.goto(page.url)
    window.wait_for_selector("text=Use the sample")
    yield window
    assert {url for url in addresses if not url.startswith((page.url, "blob:", "data:"))} == set()
    # A refused photograph is an answer of 422, which the browser notes; and so are pixels that a test reads back.
    assert [text for text in complaints if "422" not in text and "getImageData" not in text] == []
    window.close()


def check_access(window) -> None:
    """Nothing that is serious or worse by the rules of axe, and nothing wider than the screen."""
    from axe_playwright_python.sync_playwright import Axe

    found = Axe().run(window).response["violations"]
    assert [rule["id"] for rule in found if rule["impact"] in ("serious", "critical")] == []
    assert window.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0


@BOTH
def test_a_photograph_is_measured_and_its_files_are_kept(view, tmp_path):
    (tmp_path / "no <b>picture.png").write_bytes(b"text")
    view.set_input_files("#photograph", tmp_path / "no <b>picture.png")
    view.wait_for_selector("text=cannot be read as an image")
    view.set_input_files("#photograph", str(SAMPLE))
    view.wait_for_selector("text=640 x 480 pixels")
    view.get_by_label("Lamp or wavelength", exact=True).fill("sodium")
    view.click("text=Fit the rings")
    view.wait_for_selector("text=no-scale")
    view.get_by_label("Pixel size", exact=True).fill("8")
    view.click("text=Fit the rings")
    view.wait_for_selector("text=has no unit")
    view.get_by_label("Pixel size", exact=True).fill("8um")
    view.click("text=Fit the rings")
    view.wait_for_selector("text=To keep")
    assert re.match(r"radius = 0\.846\d* ± \S+ m", view.inner_text(".nj-headline"))
    for name in ("the photograph with the fitted dark rings", "photograph less model"):
        assert view.get_by_alt_text(name).evaluate("image => image.complete && image.naturalWidth") == 640
    with view.expect_download() as kept:
        view.click("text=All numbers (JSON)")
    assert kept.value.suggested_filename == "result.json"
    check_access(view)


def test_a_region_and_two_clicks_narrow_and_scale_the_sample(view):
    view.click("text=Use the sample")
    view.wait_for_selector("text=640 x 480 pixels")
    view.get_by_label("The fit uses").select_option("rectangle")
    picture = view.get_by_alt_text("the photograph; what the fit leaves out is red")
    box = picture.bounding_box()
    picture.click(position={"x": box["width"] / 4, "y": box["height"] / 4})
    view.wait_for_selector("text=And the second click")
    picture.click(position={"x": box["width"] * 3 / 4, "y": box["height"] * 3 / 4})
    view.wait_for_selector("text=/2[45]% of the pixels are used/")
    view.get_by_label("The scale is").select_option("clicked")
    ruler = view.get_by_alt_text("the photograph", exact=True)
    ruler.click(position={"x": 10, "y": 100})
    ruler.click(position={"x": 210, "y": 100})
    view.get_by_label("Distance", exact=True).fill("2mm")
    view.click("text=Fit the rings")
    view.wait_for_selector("text=To keep")
    assert view.get_by_label("Shell command").inner_text().startswith("newtonjax scale --point ")
    check_access(view)


@BOTH
def test_the_bench_follows_its_sliders(view):
    view.get_by_role("tab", name="Virtual bench").click()
    view.wait_for_function("Number(document.getElementById('bench')?.dataset.drawn) > 0")
    view.wait_for_selector("text=order")
    before = view.evaluate("document.getElementById('bench').toDataURL()")
    pictures = view.evaluate(
        """async () => {
          const slider = document.getElementById("bench-radius"), bench = document.getElementById("bench");
          const first = Number(bench.dataset.drawn), began = performance.now();
          for (let step = 0; performance.now() - began < 1000; step++) {
            slider.value = 0.5 + 0.01 * (step % 150);
            slider.dispatchEvent(new Event("input"));
            await new Promise((done) => setTimeout(done, 5));
          }
          return Number(bench.dataset.drawn) - first;
        }"""
    )
    # On two idle cores 59 a second; here the browser, the server and other tests share them.
    assert pictures >= 5
    assert view.evaluate("document.getElementById('bench').toDataURL()") != before
    view.get_by_label("Light", exact=True).select_option("white:5500K")
    view.wait_for_function(
        "(() => { const p = document.getElementById('bench').getContext('2d').getImageData(300, 256, 1, 1).data; "
        "return Math.max(p[0], p[1], p[2]) - Math.min(p[0], p[1], p[2]) > 8; })()"
    )
    check_access(view)


def test_a_pasted_table_gives_a_radius(view):
    view.get_by_role("tab", name="Table of rings").click()
    view.click("text=Compute the radius")
    view.wait_for_selector("text=no table yet")
    view.click("text=Fill in an example")
    view.click("text=Compute the radius")
    view.wait_for_selector("text=/radius = 1.000/")
    check_access(view)

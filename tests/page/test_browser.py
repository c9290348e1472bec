"""The page in a browser: the whole flow at desktop and phone width, the bench and its rate, tables, and wrong files."""

import re

import pytest
from browsing import BOTH, SAMPLE, SIZES, check_access, fit, opened, take_sample
from report_sources import grid, picture_file
from serving_page import PATIENCE

pytest.importorskip("nicegui", reason="the extra app is not installed")


@BOTH
def test_a_photograph_is_measured_and_its_files_are_kept(view, tmp_path):
    (tmp_path / "<img src=x onerror=alert(1)>.png").write_bytes(b"text")
    view.set_input_files("#photograph", tmp_path / "<img src=x onerror=alert(1)>.png")
    view.wait_for_selector("text=cannot be read as an image")
    view.set_input_files("#photograph", str(SAMPLE))
    view.wait_for_selector("text=640 x 480 pixels")
    view.get_by_label("Lamp or wavelength", exact=True).fill("sodium")
    view.click("text=Fit the rings")
    view.wait_for_selector("text=/^fringe scale n s²/")
    view.wait_for_selector("text=To keep")
    view.get_by_label("Pixel size", exact=True).fill("8")
    view.click("text=Fit the rings")
    view.wait_for_selector("text=has no unit")
    assert view.inner_text(".nj-headline").startswith("fringe scale")
    view.get_by_label("Pixel size", exact=True).fill("8um")
    view.click("text=Fit the rings")
    view.wait_for_selector("text=To keep")
    assert re.match(r"radius = 0\.846\d* ± \S+ m", view.inner_text(".nj-headline"))
    for name in ("the photograph with the fitted dark rings", "photograph less model"):
        picture = view.get_by_alt_text(name).element_handle()
        view.wait_for_function("image => image.complete && image.naturalWidth == 640", arg=picture)
    picture = view.get_by_alt_text("unwrapped view: the order across, the angle down").element_handle()
    view.wait_for_function("image => image.complete && image.naturalWidth > 500", arg=picture)
    with view.expect_download() as kept:
        view.click("text=All numbers (JSON)")
    assert kept.value.suggested_filename == "result.json"
    check_access(view)


def test_a_region_and_two_clicks_narrow_and_scale_the_sample(view):
    take_sample(view)
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
    fit(view)
    assert view.get_by_label("Shell command").inner_text().startswith("newtonjax scale --point ")
    check_access(view)


@BOTH
def test_the_bench_follows_its_sliders(view):
    view.get_by_role("tab", name="Virtual bench").click()
    view.wait_for_function("Number(document.getElementById('bench')?.dataset.drawn) > 0")
    view.wait_for_selector("text=order")
    before = view.evaluate("document.getElementById('bench').toDataURL()")
    pictures = view.evaluate(
        """async (longest) => {
          const slider = document.getElementById("bench-radius"), bench = document.getElementById("bench");
          const first = Number(bench.dataset.drawn), began = performance.now();
          for (let step = 0; Number(bench.dataset.drawn) < first + 3; step++) {
            slider.value = 0.5 + 0.01 * (step % 150);
            slider.dispatchEvent(new Event("input"));
            await new Promise((done) => setTimeout(done, 5));
            if (performance.now() - began > longest) throw new Error("no picture came");
          }
          return Number(bench.dataset.drawn) - first;
        }""",
        arg=1000 * PATIENCE,
    )
    assert pictures >= 3
    assert view.evaluate("document.getElementById('bench').toDataURL()") != before
    view.get_by_label("Light", exact=True).select_option("white:5500K")
    view.wait_for_function(
        "(() => { const p = document.getElementById('bench').getContext('2d').getImageData(300, 256, 1, 1).data; "
        "return Math.max(p[0], p[1], p[2]) - Math.min(p[0], p[1], p[2]) > 8; })()"
    )
    check_access(view)


def test_pictures_follow_a_slider_that_moves_and_their_rate_is_stated(view, record_property):
    view.get_by_role("tab", name="Virtual bench").click()
    view.wait_for_function("Number(document.getElementById('bench')?.dataset.drawn) > 0")
    drawn, seconds = view.evaluate(
        """async () => {
          const slider = document.getElementById("bench-radius"), bench = document.getElementById("bench");
          const first = Number(bench.dataset.drawn), began = performance.now();
          for (let step = 0; performance.now() - began < 3000; step++) {
            slider.value = 0.5 + 0.005 * (step % 400);
            slider.dispatchEvent(new Event("input"));
            await new Promise(requestAnimationFrame);
          }
          return [Number(bench.dataset.drawn) - first, (performance.now() - began) / 1000];
        }"""
    )
    record_property("bench pictures a second", round(drawn / seconds, 1))
    print(f"bench: {drawn / seconds:.1f} pictures a second (512 x 512)")
    assert drawn > 3


def test_faces_of_other_forms_change_the_rings_and_the_ways_to_them_are_compared(view):
    view.get_by_role("tab", name="Virtual bench").click()
    view.wait_for_function("Number(document.getElementById('bench')?.dataset.drawn) > 0")
    seen = {view.evaluate("document.getElementById('bench').toDataURL()")}
    for name, value in (("across", 1.5), ("plate", 0.5), ("across", 1.0), ("conic", 50)):
        drawn = view.evaluate("Number(document.getElementById('bench').dataset.drawn)")
        slider = view.locator(f"#bench-{name}")
        slider.evaluate("(slider, value) => { slider.value = value; slider.dispatchEvent(new Event('input')); }", value)
        view.wait_for_function(f"Number(document.getElementById('bench').dataset.drawn) > {drawn}")
        seen.add(view.evaluate("document.getElementById('bench').toDataURL()"))
    assert len(seen) == 5
    view.wait_for_selector("text=/Drawn by/")
    view.click("text=Compare the ways")
    view.get_by_label("Speed against accuracy", exact=True).last.get_by_text("Chebyshev").first.wait_for()
    check_access(view)


@BOTH
def test_a_pasted_table_gives_a_radius(view):
    view.get_by_role("tab", name="Table of rings").click()
    view.click("text=Compute the radius")
    view.wait_for_selector("text=no table yet")
    view.click("text=Fill in an example")
    view.click("text=Compute the radius")
    view.wait_for_selector("text=/radius = 1.000/")
    check_access(view)


@BOTH
def test_numbers_show_their_rings_and_are_held(view):
    take_sample(view)
    view.click("text=Numbers: see their rings, hold them")
    rings = view.locator(".nj-rings path")
    view.wait_for_selector(".nj-rings path[d^=M]")
    before = rings.get_attribute("d")
    view.get_by_label("Radius of the lens [m]").fill("0.9")
    view.wait_for_function("d => document.querySelector('.nj-rings path').getAttribute('d') != d", arg=before)
    view.get_by_label("Centre, x [px]").fill("352")
    view.get_by_label("Centre, y [px]").fill("218")
    view.get_by_text("hold the centre").click()
    fit(view)
    command = view.get_by_label("Shell command").inner_text()
    assert "--fix centre=352,218" in command
    row = view.get_by_role("row", name="centre x px")
    assert "352" in row.inner_text()
    assert "given" in row.inner_text()
    view.click("text=Parts of the model: switch them on and off")
    view.wait_for_selector("text=/last fit: /")
    check_access(view)


def test_a_photograph_of_a_grid_is_a_scale(view, tmp_path):
    take_sample(view)
    view.get_by_label("The scale is").select_option("reticle")
    view.set_input_files("#reticle", picture_file(tmp_path / "grid.png", grid()))
    view.wait_for_selector("text=grid.png; what is measured in it is drawn.")
    view.get_by_label("Known size", exact=True).fill("160um")
    view.get_by_role("button", name="Measure its pixel size").click()
    view.wait_for_selector("text=/pixel size = 8.0\\d* ± .* um/")
    fit(view)
    command = view.get_by_label("Shell command").inner_text()
    assert command.startswith("newtonjax scale grid.png --division 160um --json scale.json\nnewtonjax fit sample.png")
    assert re.match(r"radius = 0\.84\d* ± \S+ m", view.inner_text(".nj-headline"))
    check_access(view)


def test_a_page_that_is_loaded_again_has_its_photograph_its_fields_and_its_answer(view):
    take_sample(view)
    fit(view)
    headline = view.inner_text(".nj-headline")
    view.reload()
    view.wait_for_selector("text=To keep")
    assert view.inner_text(".nj-headline") == headline
    assert view.get_by_label("Lamp or wavelength", exact=True).input_value() == "589.294nm"
    view.wait_for_selector("text=640 x 480 pixels")
    with view.expect_download() as kept:
        view.click("text=Report (HTML)")
    assert kept.value.suggested_filename == "report.html"


def test_two_browsers_do_not_see_each_other(view, browser, page):
    take_sample(view)
    other = browser.new_context(viewport=SIZES["phone"])
    neighbour = other.new_page()
    opened(neighbour, page)
    assert neighbour.url != view.url
    neighbour.wait_for_selector("text=No photograph yet.")
    assert neighbour.get_by_label("Lamp or wavelength", exact=True).input_value() == ""
    other.close()


def test_a_fit_that_waits_for_its_turn_is_cancelled(view, page):
    take_sample(view)
    turn = page.page.photographs._one_at_a_time
    page.wait(turn.acquire())
    try:
        view.click("text=Fit the rings")
        view.wait_for_selector("text=/waiting for its turn/")
        view.get_by_role("button", name="Cancel").click()
        view.wait_for_selector("text=Cancelled.")
    finally:
        page.call(turn.release)
    assert view.locator(".nj-headline").count() == 0
    view.wait_for_function("document.activeElement.innerText === 'Fit the rings'")
    fit(view)
    assert view.locator(".nj-headline").count() == 1

"""The pages in a real browser, the system's Chromium, at the width of a desktop and of a phone.

No script fails, no text is covered or leaves the page, and the wave page's play button plays and pauses.
"""

import shutil
from pathlib import Path

import pytest

from studies.__main__ import main

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
OPTIONS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking")
WIDTHS = {"desktop": 1280, "phone": 390}
COVERED = """() => {
  const found = [];
  for (const each of document.querySelectorAll("h1, h2, p, td, th, li, button, label, figcaption, img")) {
    let box = each.getBoundingClientRect();
    if (!box.width || !box.height || getComputedStyle(each).visibility === "hidden") continue;
    window.scrollTo(0, box.top + window.scrollY - 200);
    box = each.getBoundingClientRect();
    const top = document.elementFromPoint(box.left + box.width / 2, box.top + Math.min(box.height / 2, 300));
    const free = !top || each.contains(top) || top.contains(each);
    if (!free) found.push(`${each.tagName} ${each.textContent.slice(0, 40)}`);
  }
  window.scrollTo(0, 0);
  return found;
}"""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(BROWSER is None, reason="needs Chromium: install the system's package chromium"),
]


@pytest.fixture(scope="module")
def pages(tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    scene = str(Path(__file__).parent / "scenes" / "small.toml")
    assert main(["run", scene, "--report", "--no-plot", "--out", str(folder / "run")]) == 0
    assert main(["view", str(folder / "run"), "--html", str(folder / "wave.html")]) == 0
    assert main(["datasheet", scene, "--out", str(folder / "sheet")]) == 0
    return {
        "report": folder / "run" / "report.html",
        "wave": folder / "wave.html",
        "datasheet": folder / "sheet" / "datasheet.html",
    }


@pytest.fixture(scope="module")
def browser():
    api = pytest.importorskip("playwright.sync_api", reason="pip install 'sawmotor[browser]'")
    with api.sync_playwright() as play:
        opened = play.chromium.launch(executable_path=BROWSER, args=list(OPTIONS))
        yield opened
        opened.close()


@pytest.fixture
def opened(browser):
    """Return a function that opens a page at a width, and the list of its errors."""
    made = []

    def page_of(file: Path, width: int):
        page, errors = browser.new_page(viewport={"width": width, "height": 900}), []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
        page.goto(file.as_uri())
        page.wait_for_timeout(500)
        made.append(page)
        return page, errors

    yield page_of
    for page in made:
        page.close()


@pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS)
@pytest.mark.parametrize("name", ["report", "wave", "datasheet"])
def test_page_opens_without_errors_and_covers_nothing(pages, opened, name, width):
    page, errors = opened(pages[name], width)
    assert errors == []
    assert page.evaluate(COVERED) == []
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
    if width == WIDTHS["desktop"]:  # the last column of the points was cut
        assert page.evaluate("() => [...document.querySelectorAll('.wide')].every(e => e.scrollWidth <= e.clientWidth)")


def test_the_play_button_pauses_and_plays(pages, opened):
    page, _ = opened(pages["wave"], 1280)

    def phase():
        return page.evaluate("() => Number(document.getElementById('phase').value)")

    def moves():
        before = phase()
        page.wait_for_timeout(300)
        return phase() != before

    page.wait_for_function("() => document.body.dataset.ready === 'yes'")
    assert moves()
    page.click("#play")
    assert not moves()
    page.click("#play")
    assert moves()


def test_an_error_and_a_covered_line_are_seen(pages, opened, tmp_path):
    spoiled = tmp_path / "spoiled.html"
    cover = '<div style="position: fixed; inset: 0; background: red"></div><script>nothing();</script></body>'
    spoiled.write_text(pages["datasheet"].read_text(encoding="utf-8").replace("</body>", cover), encoding="utf-8")
    page, errors = opened(spoiled, 1280)
    assert any("nothing" in each for each in errors)
    assert page.evaluate(COVERED)

"""The built pages in a real browser, as wide as a screen and as a phone: nothing is cut off.

Build them first: python -m sphinx -W --keep-going -b html docs build/docs
"""

import re

import pytest

from tests.docs.browser import Browser, find_browser
from tests.documents import DOCS, ROOT

BUILT = ROOT / "build" / "docs"
SCREEN, PHONE = 1280, 390  # CSS pixels
FEW_COLUMNS = 3  # of tables that have to fit a phone; wider ones move within their frame

# What is wider than its place: of the page, of code, and of tables with the number of their columns.
OVERFLOWS = """(() => {
    const page = document.documentElement, lost = {};
    if (page.scrollWidth > innerWidth) lost.page = page.scrollWidth - innerWidth;
    lost.code = [...document.querySelectorAll("pre")]
        .filter(code => code.scrollWidth > code.clientWidth).map(code => code.textContent.slice(0, 80));
    lost.tables = [...document.querySelectorAll("table")]
        .filter(table => table.offsetWidth > table.parentElement.clientWidth + 1)
        .map(table => [table.rows[0].cells.length, table.textContent.slice(0, 80).replace(/\\s+/g, " "),
                       getComputedStyle(table.parentElement).overflowX]);
    lost.pictures = [...document.querySelectorAll("article img, article svg")]
        .filter(one => one.getBoundingClientRect().right > innerWidth || one.naturalWidth === 0)
        .map(one => one.src || one.ariaLabel);
    return lost;
})()"""


def why_not():
    """What is missing here; empty if nothing is."""
    if find_browser() is None:
        return "there is no Chromium (Debian: apt-get install chromium)"
    index = BUILT / "index.html"
    if not index.exists():
        return "the pages are not built: python -m sphinx -b html docs build/docs"
    sources = [path for folder in (DOCS, DOCS / "static") for path in folder.glob("*.*") if path.is_file()]
    if max(path.stat().st_mtime for path in sources) > index.stat().st_mtime:
        return "the pages that are built are older than their sources"
    return ""


pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    one = Browser(tmp_path_factory.mktemp("profile"))
    yield one
    one.close()


def pages():
    return [page for page in sorted(BUILT.rglob("*.html")) if not {"_modules", "_static"} & {*page.parts}]


def overflows(browser, width):
    """Page -> what is cut off there, or sticks out."""
    browser.set_width(width)
    found = {}
    for page in pages():
        browser.open(page)
        lost = browser.ask(OVERFLOWS)
        most = FEW_COLUMNS if width == PHONE else 100
        lost["tables"] = [table for table in lost["tables"] if table[0] <= most or table[2] != "auto"]
        found[str(page.relative_to(BUILT))] = {key: what for key, what in lost.items() if what}
    assert len(found) > 30
    return {page: lost for page, lost in found.items() if lost}


@pytest.mark.parametrize("width", [SCREEN, PHONE])
def test_nothing_is_cut_off_or_wider_than_its_place(browser, width):
    assert overflows(browser, width) == {}


def test_code_and_tables_that_are_too_wide_are_noticed(browser, tmp_path):
    wide = "<pre style='width: 99px; overflow: auto'>" + "x" * 200 + "</pre>"
    table = "<div style='width: 99px'><table><tr><td>" + "x" * 200 + "</td></tr></table></div>"
    (tmp_path / "page.html").write_text(f"<body>{wide}{table}</body>")
    browser.set_width(SCREEN)
    browser.open(tmp_path / "page.html")
    lost = browser.ask(OVERFLOWS)
    assert len(lost["code"]) == len(lost["tables"]) == 1 and lost["page"] > 0


def test_code_has_a_button_that_copies_it_and_outputs_have_none(browser):
    browser.set_width(SCREEN)
    browser.open(BUILT / "tutorial" / "first_cable.html")
    count = "document.querySelectorAll('div.highlight-{} {}').length"
    of_code, buttons, of_outputs = (
        browser.ask(count.format(*asked))
        for asked in (("python", "pre"), ("python", "button.copybtn"), ("text", "button.copybtn"))
    )
    assert (of_code, of_outputs) == (buttons, 0) and of_code > 2


def test_dark_pages_have_light_text_and_equations(browser):
    browser.set_width(SCREEN, dark=True)
    browser.open(BUILT / "method.html")
    colors = (
        browser.ask(f"getComputedStyle({where}).{what}")
        for where, what in (
            ("document.body", "backgroundColor"),
            ("document.querySelector('article p')", "color"),
            ("document.querySelector('.equation svg')", "color"),
        )
    )
    page, text, equation = (sum(map(int, re.findall(r"\d+", color)[:3])) for color in colors)
    assert page < 100 and text > 500 and equation == text

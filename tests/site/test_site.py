"""The site as its readers meet it: names and links lead somewhere, both languages say the same, pages fit a desk and a hand."""

import dataclasses
import functools
import html
import http.server
import re
import shutil
import threading
from pathlib import Path
from urllib.parse import unquote, urljoin, urlsplit

import pytest

import vibroimpact as vi

SITE = Path(__file__).parents[2] / "target" / "site"
RUST = SITE / "rust"
PAGES = sorted(path for path in SITE.rglob("*.html") if RUST not in path.parents and "_static" not in path.parts)
NAMES = [f"vibroimpact.{name}" for name in vi.__all__ if name not in {"plot", "KINDS", "__version__"}]
NAMES += [f"vibroimpact.plot.{name}" for name in vi.plot.__all__]


@functools.cache
def text_of(page):
    return page.read_text(encoding="utf-8")


@functools.cache
def anchors_of(page):
    return {html.unescape(name) for name in re.findall(r'\b(?:id|name)="([^"]+)"', text_of(page))}


def members(thing):
    """What a class has of its own, fields of a dataclass apart."""
    fields = {own.name for own in dataclasses.fields(thing)} if dataclasses.is_dataclass(thing) else set()
    return [name for name in vars(thing) if not name.startswith("_") and name not in fields], fields


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_a_page_with_its_fields(name):
    page = SITE / "api" / f"{name}.html"
    assert name in anchors_of(page)
    thing = functools.reduce(getattr, name.split(".")[1:], vi)
    if isinstance(thing, type):
        of_its_own, fields = members(thing)
        missing = [own for own in of_its_own if f"{name}.{own}" not in anchors_of(page)]
        missing += [own for own in fields if not re.search(rf"<strong>(?:\w+, )*{own}\b", text_of(page))]
        assert not missing


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(SITE)))
def test_links_lead_somewhere(page):
    broken = []
    for link in map(html.unescape, re.findall(r'<a\b[^>]*\bhref="([^"]+)"', text_of(page))):
        parts = urlsplit(link)
        if parts.scheme or parts.netloc:
            continue
        target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
        target = target / "index.html" if target.is_dir() else target
        if not target.is_file() or (
            parts.fragment and target.suffix == ".html" and unquote(parts.fragment) not in anchors_of(target)
        ):
            broken.append(link)
    assert not broken


@pytest.mark.parametrize(
    "page", [page for page in PAGES if "cell_input" in text_of(page)], ids=lambda page: str(page.relative_to(SITE))
)
def test_pages_that_plot_show_it(page):
    plots = len(re.findall(r'<span class="n">plot</span>', text_of(page)))
    assert len(re.findall(r"<img\b[^>]*_images/", text_of(page))) >= min(plots, 1)


def words(text):
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", "", text))).strip()


def first_sentence(text):
    """The first sentence as both languages have it: without its article, citations, and the person of its verb."""
    text = re.sub(r"\s+", " ", text.replace("`", "").replace("\u2019", "'").strip())
    text = re.sub(r" \((?:eqs?\.|theory) [^()]*(?:\([^()]*\)[^()]*)*\)", "", text)
    sentence = re.split(r"(?<=[.?])(?<!eq\.) ", text)[0].rstrip(".")
    sentence = re.sub(r"^(?:The|An?) ", "", sentence)
    return re.sub(r"^\w+?(?=s?\b)s?", lambda start: start[0].rstrip("s").capitalize(), sentence)


def in_rust():
    """First paragraphs of types and functions of the Rust documentation, by name."""
    found = {}
    for page in RUST.rglob("*.html"):
        kind, _, name = page.stem.partition(".")
        if kind in {"struct", "enum", "trait", "fn"}:
            top = re.search(r'<details class="toggle top-doc".*?<div class="docblock"><p>(.*?)</p>', text_of(page), re.DOTALL)
            if top:
                found.setdefault(name, first_sentence(words(top.group(1))))
    return found


def test_both_languages_say_the_same():
    rust = in_rust()
    both = {name: first_sentence(getattr(vi, name).__doc__) for name in vi.__all__ if name in rust}
    assert len(both) > 50
    assert {name: (said, rust[name]) for name, said in both.items() if said != rust[name]} == {}


class Silent(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def address():
    """Where the site is served, on this machine alone."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Silent, directory=SITE))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def browser():
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("no chromium here: pages are not opened")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as running:
        opened = running.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield opened.new_context()  # one for all: what pages share is fetched once
        opened.close()


WIDTHS = (1280, 390)  # [px]
PICTURES = """async () => {
    const broken = [];
    for (const picture of document.images) {
        picture.loading = 'eager';
        try { await picture.decode(); } catch { if (!picture.naturalWidth) broken.push(picture.src); }
    }
    return broken;
}"""
# Code and tables scroll in frames of their own; the page does not, and cuts no text off.
OVERHANG = """() => {
    const wide = document.documentElement.scrollWidth > document.documentElement.clientWidth;
    const cut = [...document.querySelectorAll('article :is(h1, h2, h3, p, li)')].filter(
        (text) => text.clientWidth && text.scrollWidth > text.clientWidth + 1
            && !text.closest('table, pre, .pst-scrollable-table-container'));
    return (wide ? ['the page'] : []).concat(cut.map((text) => text.textContent.slice(0, 60)));
}"""


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(SITE)))
def test_pages_in_a_browser(page, browser, address):
    tab = browser.new_page()
    wrong = []
    tab.on("console", lambda message: wrong.append(message.text) if message.type in {"error", "warning"} else None)
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.on("requestfailed", lambda request: wrong.append(f"failed: {request.url}"))
    tab.on(
        "request",
        lambda request: None if request.url.startswith((address, "data:", "blob:")) else wrong.append(f"left: {request.url}"),
    )
    tab.goto(urljoin(address, str(page.relative_to(SITE))), wait_until="load")
    wrong += [f"no picture: {source}" for source in tab.evaluate(PICTURES)]
    for width in WIDTHS:
        tab.set_viewport_size({"width": width, "height": 900})
        wrong += [f"sideways at {width}: {what}" for what in tab.evaluate(OVERHANG)]
    tab.close()
    assert not wrong

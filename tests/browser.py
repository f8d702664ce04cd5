"""Opens pages in a real browser without a window, to test what they compute, what they fetch and how they look.

The browser is that of MILLPRINT_BROWSER, or the first of BROWSERS on the PATH, driven by Playwright. Without one, the
tests that need it are skipped.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import files
from io import BytesIO
from pathlib import Path

import playwright.sync_api as playwright
import pytest
from PIL import Image

VARIABLE = "MILLPRINT_BROWSER"
# A newer axe.min.js than that of the environment.
AXE_VARIABLE = "MILLPRINT_AXE"
BROWSERS = (
    "chromium-headless-shell",
    "chrome-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
)
# A request for anything else must fail here, as it would without a network.
OPTIONS = ["--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND"]
DESKTOP, PHONE = 1280, 390
TIMEOUT_S = 120


def find_browser() -> str | None:
    """The path of a Chromium-based browser, or None."""
    names = (os.environ[VARIABLE],) if os.environ.get(VARIABLE) else BROWSERS
    return next((found for name in names if (found := shutil.which(name))), None)


def axe_script() -> str:
    """The text of axe-core, which checks accessibility: of MILLPRINT_AXE, or of the package axe-core-python."""
    given = os.environ.get(AXE_VARIABLE)
    return (Path(given) if given else Path(str(files("axe_core_python"))) / "axe.min.js").read_text(encoding="utf-8")


needs_browser = pytest.mark.skipif(
    find_browser() is None,
    reason=f"no browser: set {VARIABLE} to a Chromium-based one, or put {BROWSERS[0]} on the PATH",
)


class Browser:
    """A browser without a window. Its pages share no storage and no cache."""

    def __init__(self, browser: playwright.Browser) -> None:
        self._browser = browser

    @contextmanager
    def page(self, width: int = DESKTOP, height: int = 900) -> Iterator["Page"]:
        """A new page, empty and of that size [px]."""
        page = self._browser.new_page(viewport={"width": width, "height": height})
        page.set_default_timeout(1000 * TIMEOUT_S)
        try:
            yield Page(page)
        finally:
            page.close()


class Page:
    """An open page. `requests`: the addresses that it requested; `errors`: the errors of its scripts and requests."""

    def __init__(self, page: playwright.Page) -> None:
        self._page = page
        self.requests: list[str] = []
        self.errors: list[str] = []
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("pageerror", lambda error: self.errors.append(error.stack or error.message))
        page.on("console", lambda entry: self.errors.append(entry.text) if entry.type == "error" else None)

    def resize(self, width: int, height: int) -> None:
        """Set the size of the window [px]."""
        self._page.set_viewport_size({"width": width, "height": height})

    def open(self, file: Path) -> None:
        """Open a file and wait until it is loaded and drawn."""
        self.go(file.resolve().as_uri())

    def go(self, address: str) -> None:
        """Open an address and wait until it is drawn."""
        self._page.goto(address)
        self.draw()

    def draw(self) -> None:
        """Wait for two frames, so that what scripts have asked for is drawn."""
        self.run("await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));")

    def reduce_motion(self) -> None:
        """Be the browser of somebody who has asked for less motion, for pages that are opened from here on."""
        self._page.emulate_media(reduced_motion="reduce")

    def print(self) -> None:
        """Be as on paper."""
        self._page.emulate_media(media="print")

    def run(self, script: str):
        """Run `script`, the body of an async function; return its result. Raises playwright.Error with its error."""
        return self._page.evaluate(f"async () => {{ {script} }}")

    def press(self, key: str) -> None:
        """Press and release a key, by its name in Playwright, as a user at a keyboard does."""
        self._page.keyboard.press(key)

    def accessibility_faults(self) -> list[str]:
        """What axe finds wrong with the page, a line for each rule, with the first element that breaks it."""
        self.run(f"{axe_script()}; return 0;")
        return self.run("""
          const { violations } = await axe.run(document);
          return violations.map(({ id, help, nodes }) =>
            `${id}: ${help} (${nodes.length}): ${nodes[0].html.slice(0, 200)}`);""")

    def picture(self, path: Path) -> Image.Image:
        """A picture of the window, also written to `path`."""
        self.draw()
        return Image.open(BytesIO(self._page.screenshot(path=path))).convert("RGB")

    def outside_requests(self) -> list[str]:
        """The requested addresses outside the page and its own files."""
        return [url for url in self.requests if not url.startswith(("file:", "data:", "blob:", "about:"))]

    def measure(self) -> dict[str, float]:
        """`width` of the window, `beyond`: how much wider the page is, and `smallest`: its smallest text [px]."""
        return self.run("""
          const sizes = [...document.querySelectorAll("body *")].filter((e) => e.checkVisibility()
            && !e.closest("script, style") && [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()))
            .map((e) => { const svg = e.closest("svg"); const box = svg?.viewBox.baseVal.width;
              const scale = box ? svg.getBoundingClientRect().width / box : 1;
              return scale * parseFloat(getComputedStyle(e).fontSize); });
          return { width: innerWidth, beyond: document.documentElement.scrollWidth - innerWidth,
            smallest: Math.min(...sizes) };""")


@contextmanager
def open_browser() -> Iterator[Browser]:
    """A new browser. While it is open, asyncio runs in this thread: close it before anything else uses that."""
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=find_browser(), args=OPTIONS)
        try:
            yield Browser(browser)
        finally:
            browser.close()

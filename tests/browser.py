"""Pages in a real browser without a window: what they compute, what they fetch and how they look.

The browser is that of MILLPRINT_BROWSER, or the first of BROWSERS on the PATH; tests that need one are skipped where
there is none. It is driven by its command line alone, so that nothing has to be installed beside it.
"""

import html
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from PIL import Image

VARIABLE = "MILLPRINT_BROWSER"
BROWSERS = (
    "chromium-headless-shell",
    "chrome-headless-shell",
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
)
DESKTOP, PHONE = 1280, 390
# Time on the page's own clock, which runs as fast as the page computes.
PATIENCE_MS = 20_000


def find_browser() -> str | None:
    """The path of a browser of Chromium's kind, or None."""
    names = (os.environ[VARIABLE],) if os.environ.get(VARIABLE) else BROWSERS
    return next((found for name in names if (found := shutil.which(name))), None)


needs_browser = pytest.mark.skipif(
    find_browser() is None,
    reason=f"no browser: set {VARIABLE} to one of Chromium's kind, or put {BROWSERS[0]} on the PATH",
)


def _run(page: Path, *options: str, folder: Path) -> str:
    fixed = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={folder}/profile")
    # Should a page ask for anything, it must fail here as it would without a network.
    offline = ("--host-resolver-rules=MAP * ~NOTFOUND", "--disable-background-networking")
    command = [find_browser(), *fixed, *offline, f"--virtual-time-budget={PATIENCE_MS}", *options, page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=180, check=True)
    return done.stdout


def with_script(page: Path, script: str, folder: Path) -> Path:
    """A copy of a page that runs `script`, the body of an async function, when all is loaded.

    What it returns, or the error that anything on the page raised, is left in the document for `answer_of`.
    """
    runner = f"""<script>
(() => {{
  const failures = [];
  const leave = (said) => {{
    const place = document.createElement("pre");
    place.id = "told"; place.hidden = true; place.textContent = JSON.stringify(said);
    document.body.append(place);
  }};
  window.addEventListener("error", (event) => failures.push(event.message));
  window.addEventListener("load", async () => {{
    try {{ const value = await (async () => {{ {script} }})(); leave({{ value, failures }}); }}
    catch (error) {{ leave({{ failures: [...failures, String(error.stack)] }}); }}
  }});
}})();
</script>"""
    # First in the head, so that an error of the page's own scripts is seen.
    text = page.read_text()
    copy = folder / f"scripted_{page.name}"
    copy.write_text(text.replace("<head>", f"<head>{runner}", 1))
    assert runner in copy.read_text(), f"{page} has no <head>"
    return copy


def answer_of(page: Path, script: str, folder: Path):
    """What `script` returns on the page, as JSON; fails with the page's own error if there was one."""
    document = _run(with_script(page, script, folder), "--dump-dom", folder=folder)
    told = re.search(r'<pre id="told" hidden="">(.*?)</pre>', document, re.DOTALL)
    assert told, f"{page.name} left no answer: {document[-500:]}"
    said = json.loads(html.unescape(told.group(1)))
    assert not said["failures"], said["failures"]
    return said.get("value")


def screenshot(page: Path, width: int, height: int, path: Path, script: str = "") -> Image.Image:
    """The page as it looks in a window, after `script`, written to `path`."""
    folder = path.parent
    shown = with_script(page, script, folder) if script else page
    _run(shown, f"--screenshot={path}", f"--window-size={width},{height}", folder=folder)
    return Image.open(path).convert("RGB")


def fetched(page: Path, folder: Path, script: str = "") -> list[str]:
    """Every address that the page asked the network for; files are not among them."""
    log = folder / "network.json"
    shown = with_script(page, script, folder) if script else page
    _run(shown, "--dump-dom", f"--log-net-log={log}", folder=folder)
    asked = set(re.findall(r'"url":"([^"]+)"', log.read_text()))
    return sorted(url for url in asked if not url.startswith(("data:", "blob:")))


def overflow_of(page: Path, folder: Path, width: int, script: str = "") -> dict:
    """How much wider than the window the page is [px], and the smallest text that it shows [px]."""
    measure = """
      const sizes = [...document.querySelectorAll("body *")].filter((e) => e.checkVisibility()
        && [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()) && !e.closest("script, style"))
        .map((e) => { const svg = e.closest("svg"); const scale = svg && svg.viewBox.baseVal.width
          ? svg.getBoundingClientRect().width / svg.viewBox.baseVal.width : 1;
          return scale * parseFloat(getComputedStyle(e).fontSize); });
      return { beyond: document.documentElement.scrollWidth - window.innerWidth, width: window.innerWidth,
        smallest: Math.min(...sizes) };"""
    shown = with_script(page, script + measure, folder)
    document = _run(shown, "--dump-dom", f"--window-size={width},900", folder=folder)
    told = re.search(r'<pre id="told" hidden="">(.*?)</pre>', document, re.DOTALL)
    said = json.loads(html.unescape(told.group(1)))
    assert not said["failures"], said["failures"]
    return said["value"]

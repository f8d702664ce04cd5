"""Pages in a real browser without a window: what they compute, what they fetch and how they look.

The browser is that of MILLPRINT_BROWSER, or the first of BROWSERS on the PATH; tests that need one are skipped where
there is none. It is driven over a pair of pipes by the DevTools protocol: nothing has to be installed beside it.
"""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
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
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--hide-scrollbars",
    "--disable-background-networking",
    "--remote-debugging-pipe",
    # Should a page ask for anything, it must fail here as it would without a network.
    "--host-resolver-rules=MAP * ~NOTFOUND",
)
DESKTOP, PHONE = 1280, 390
PATIENCE_S = 120


def find_browser() -> str | None:
    """The path of a browser of Chromium's kind, or None."""
    names = (os.environ[VARIABLE],) if os.environ.get(VARIABLE) else BROWSERS
    return next((found for name in names if (found := shutil.which(name))), None)


needs_browser = pytest.mark.skipif(
    find_browser() is None,
    reason=f"no browser: set {VARIABLE} to one of Chromium's kind, or put {BROWSERS[0]} on the PATH",
)


class Page:
    """One open page. `requests`: addresses it asked for; `errors`: what went wrong in its scripts."""

    def __init__(self, commands: int, answers: int) -> None:
        self._commands, self._answers = commands, answers
        self._buffer, self._sent, self._session = b"", 0, None
        self._loaded = False
        self.requests: list[str] = []
        self.errors: list[str] = []
        target = self._send("Target.createTarget", url="about:blank")["targetId"]
        self._session = self._send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self._send(f"{domain}.enable")

    def _receive(self) -> dict:
        end = time.monotonic() + PATIENCE_S
        while b"\0" not in self._buffer:
            if not select.select([self._answers], [], [], max(0, end - time.monotonic()))[0]:
                raise TimeoutError(f"the browser said nothing for {PATIENCE_S} s")
            part = os.read(self._answers, 1 << 20)
            if not part:
                raise EOFError("the browser has ended")
            self._buffer += part
        message, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(message)

    def _note(self, message: dict) -> None:
        """Keep what an event says."""
        about = message.get("params", {})
        match message.get("method"):
            case "Page.loadEventFired":
                self._loaded = True
            case "Network.requestWillBeSent":
                self.requests.append(about["request"]["url"])
            case "Runtime.exceptionThrown":
                self.errors.append(about["exceptionDetails"].get("exception", {}).get("description", "unknown"))
            case "Log.entryAdded" if about["entry"]["level"] == "error":
                self.errors.append(about["entry"]["text"])

    def _send(self, method: str, **parameters) -> dict:
        self._sent += 1
        message = {"id": self._sent, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while (answer := self._receive()).get("id") != self._sent:
            self._note(answer)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        return answer["result"]

    def resize(self, width: int, height: int) -> None:
        """Give the window a size [px]."""
        self._send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def open(self, file: Path) -> None:
        """Open a file and wait until it is loaded."""
        self._loaded = False
        self._send("Page.navigate", url=file.resolve().as_uri())
        while not self._loaded:
            self._note(self._receive())

    def run(self, script: str):
        """What `script`, the body of an async function, returns as JSON; raises AssertionError with its error."""
        expression = f"(async () => {{ {script} }})()"
        said = self._send("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in said, said["exceptionDetails"]["exception"].get("description")
        return said["result"].get("value")

    def picture(self, path: Path) -> Image.Image:
        """The window as it looks, written to `path`."""
        # Two frames, so that what a script changed is drawn.
        self.run("await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));")
        data = base64.b64decode(self._send("Page.captureScreenshot", format="png")["data"])
        path.write_bytes(data)
        return Image.open(BytesIO(data)).convert("RGB")

    def outside_requests(self) -> list[str]:
        """Addresses that the page asked for beside itself and what it carries."""
        return [url for url in self.requests if not url.startswith(("file:", "data:", "blob:", "about:"))]

    def measure(self) -> dict[str, float]:
        """Width of the window, how much wider the page is, and its smallest text, all in px."""
        return self.run("""
          const sizes = [...document.querySelectorAll("body *")].filter((e) => e.checkVisibility()
            && !e.closest("script, style") && [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()))
            .map((e) => { const svg = e.closest("svg"); const box = svg?.viewBox.baseVal.width;
              const scale = box ? svg.getBoundingClientRect().width / box : 1;
              return scale * parseFloat(getComputedStyle(e).fontSize); });
          return { width: innerWidth, beyond: document.documentElement.scrollWidth - innerWidth,
            smallest: Math.min(...sizes) };""")


@contextmanager
def browser_page(folder: Path, width: int = DESKTOP, height: int = 900) -> Iterator[Page]:
    """An empty page in a browser of its own, which keeps its files in `folder`."""
    their_end, commands = os.pipe()
    answers, our_end = os.pipe()
    # The browser reads at 3 and writes at 4: numbers that must not be taken when the shell puts the pipes there.
    reads, writes = (fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (their_end, our_end))
    command = [find_browser(), *OPTIONS, f"--user-data-dir={folder / 'profile'}", "about:blank"]
    process = subprocess.Popen(
        ["bash", "-c", f'exec "$@" 3<&{reads} 4>&{writes}', "bash", *command],
        pass_fds=(reads, writes),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    for end in (their_end, our_end, reads, writes):
        os.close(end)
    try:
        page = Page(commands, answers)
        page.resize(width, height)
        yield page
    finally:
        process.terminate()
        process.wait(timeout=30)
        os.close(commands)
        os.close(answers)

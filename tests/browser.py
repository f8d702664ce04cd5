"""Opens pages in a real browser without a window, to test what they compute, what they fetch and how they look.

The browser is that of MILLPRINT_BROWSER, or the first of BROWSERS on the PATH. Without one, the tests that need it are
skipped. It is controlled over two pipes by the DevTools protocol, so no further package is needed.
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
from importlib.resources import files
from io import BytesIO
from pathlib import Path

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
OPTIONS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--hide-scrollbars",
    "--disable-background-networking",
    "--remote-debugging-pipe",
    # A request for anything else must fail here, as it would without a network.
    "--host-resolver-rules=MAP * ~NOTFOUND",
)
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

    def __init__(self, commands: int, answers: int) -> None:
        self._commands, self._answers = commands, answers
        self._buffer, self._sent = b"", 0
        self._pages: dict[str, Page] = {}

    def receive(self) -> dict:
        """The next message, an answer or an event."""
        end = time.monotonic() + TIMEOUT_S
        while b"\0" not in self._buffer:
            if not select.select([self._answers], [], [], max(0, end - time.monotonic()))[0]:
                raise TimeoutError(f"no message from the browser for {TIMEOUT_S} s")
            part = os.read(self._answers, 1 << 20)
            if not part:
                raise EOFError("the browser has ended")
            self._buffer += part
        message, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(message)

    def note(self, message: dict) -> None:
        """Give an event to the page that it is about, if that is open."""
        if page := self._pages.get(message.get("sessionId", "")):
            page.note(message)

    def send(self, method: str, session: str | None = None, **parameters) -> dict:
        """The result of a command; pages get the events that come before it."""
        self._sent += 1
        message = {"id": self._sent, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while (answer := self.receive()).get("id") != self._sent:
            self.note(answer)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        return answer["result"]

    @contextmanager
    def page(self, width: int = DESKTOP, height: int = 900) -> Iterator["Page"]:
        """A new page, empty and of that size [px]."""
        context = self.send("Target.createBrowserContext")["browserContextId"]
        target = self.send("Target.createTarget", url="about:blank", browserContextId=context)["targetId"]
        session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        page = self._pages[session] = Page(self, session)
        try:
            page.listen()
            page.resize(width, height)
            yield page
        finally:
            del self._pages[session]
            self.send("Target.disposeBrowserContext", browserContextId=context)


class Page:
    """An open page. `requests`: the addresses that it requested; `errors`: the errors of its scripts."""

    def __init__(self, browser: Browser, session: str) -> None:
        self._browser, self._session = browser, session
        self._loaded = False
        self.requests: list[str] = []
        self.errors: list[str] = []

    def listen(self) -> None:
        """Ask for the events that `note` records."""
        for domain in ("Page", "Runtime", "Network", "Log"):
            self._send(f"{domain}.enable")

    def note(self, message: dict) -> None:
        """Record an event of the page."""
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
        return self._browser.send(method, self._session, **parameters)

    def resize(self, width: int, height: int) -> None:
        """Set the size of the window [px]."""
        self._send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def open(self, file: Path) -> None:
        """Open a file and wait until it is loaded and drawn."""
        self.go(file.resolve().as_uri())

    def go(self, address: str) -> None:
        """Open an address, which must differ from the last in more than what follows #; wait until it is drawn."""
        self._loaded = False
        self._send("Page.navigate", url=address)
        while not self._loaded:
            self._browser.note(self._browser.receive())
        self.draw()

    def draw(self) -> None:
        """Wait for two frames, so that what scripts have asked for is drawn."""
        self.run("await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));")

    def run(self, script: str):
        """Run `script`, the body of an async function; return its result. Raises AssertionError with its error."""
        expression = f"(async () => {{ {script} }})()"
        answer = self._send("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]["exception"].get("description")
        return answer["result"].get("value")

    def press(self, key: str, code: int, shift: bool = False) -> None:
        """Press and release a key, as a user at a keyboard does; `code` is its Windows virtual-key code."""
        about = {"key": key, "code": key, "windowsVirtualKeyCode": code, "modifiers": 8 * shift}
        self._send("Input.dispatchKeyEvent", type="rawKeyDown", **about)
        self._send("Input.dispatchKeyEvent", type="keyUp", **about)

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
        data = base64.b64decode(self._send("Page.captureScreenshot", format="png")["data"])
        path.write_bytes(data)
        return Image.open(BytesIO(data)).convert("RGB")

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
def open_browser(folder: Path) -> Iterator[Browser]:
    """A new browser, which keeps its files in `folder`."""
    their_end, commands = os.pipe()
    answers, our_end = os.pipe()
    # The browser reads from descriptor 3 and writes to 4. Our ends are moved to 10 and above, so that the shell can use
    # these numbers.
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
        yield Browser(commands, answers)
    finally:
        process.terminate()
        process.wait(timeout=30)
        os.close(commands)
        os.close(answers)

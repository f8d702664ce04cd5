"""Writes `mills.html` next to the pages: the explorer of the mills that come with millprint, ready to use."""

from pathlib import Path

from sphinx.application import Sphinx

from millprint.config.included import load_mill
from millprint.explorer.content import Machine, explorer_content, mill_content
from millprint.explorer.page import explorer_page
from millprint.fingerprint.condition_search import simulated_request
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import find_ready_made, ready_made

PAGE = "mills.html"


def mills_page() -> str:
    """The page of all mills that have a fingerprint without a simulation."""
    contents = []
    for name in ready_made():
        path = find_ready_made(name)
        assert path is not None, f"{name}: its file is another one than config/fingerprints was made of"
        request = simulated_request(Fingerprint.read(path), "weighted")
        contents.append(mill_content(Machine.of_mill(load_mill(name)), [path], request))
    return explorer_page(explorer_content("the mills of millprint", contents))


def write_page(app: Sphinx, error: Exception | None) -> None:
    """Write the page into the folder of the built pages."""
    if error is None and app.builder.name == "html":
        Path(app.outdir, PAGE).write_text(mills_page())


def setup(app: Sphinx) -> dict:
    """Write the page once the others are built."""
    app.connect("build-finished", write_page)
    return {"parallel_read_safe": True}

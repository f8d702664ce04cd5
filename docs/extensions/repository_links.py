"""Links to files of the repository lead somewhere on the site too, written as a reader of the repository needs them.

`[keys](../config/keys.md)` leads to the page that `repository_pages` of conf.py names for that file. A file that is no
page is copied next to the pages and opened from there. A link to a file that does not exist is a warning. An anchor
after a word in code, written as HTML for GitHub, becomes one that links of the site may name.
"""

import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

LOGGER = logging.getLogger(__name__)
# A link, and not the same with ! before it, which is an image; its text may hold brackets.
LINK = re.compile(r"(?<!!)(\[(?:[^\[\]]|\[[^\]]*\])*\])\(([^)\s#:]+)(#[^)\s]*)?\)")

# A word in code with an anchor.
ANCHOR = re.compile(r'(`[^`]+`)<a id="([^"]+)"></a>')


def rewrite_links(app: Sphinx, text: str, source: Path) -> str:
    """`text` of the file `source`, with each link to a file outside docs/, or from there, as one that Sphinx knows."""
    pages = Path(app.srcdir).resolve()
    project = pages.parent

    def rewrite(found: re.Match) -> str:
        words, target, anchor = found[1], found[2], found[3] or ""
        path = (source.parent / target).resolve()
        if pages in (path, *path.parents):
            # A link within docs/ stays as it is; one into docs/ is written from there.
            return found[0] if pages in source.parents else f"{words}(/{path.relative_to(pages)}{anchor})"
        name = str(path.relative_to(project)) if project in path.parents else None
        page = app.config.repository_pages.get(name)
        if page and (pages / f"{page}.md").is_file():
            return f"{words}(/{page}.md{anchor})"
        if name is None or not path.is_file():
            LOGGER.warning("%s: no such file of the project: %s", source, target, type="repository_links")
            return found[0]
        return f"{words}(path:/../{name})"

    return ANCHOR.sub(r"[\1]{#\2}", LINK.sub(rewrite, text))


def on_source_read(app: Sphinx, page: str, content: list[str]) -> None:
    """Rewrite the links of a page."""
    content[0] = rewrite_links(app, content[0], Path(app.env.doc2path(page)).resolve())


def on_include_read(app: Sphinx, path: Path, page: str, content: list[str]) -> None:
    """Rewrite the links of a file that a page includes; `path` is relative to docs/."""
    content[0] = rewrite_links(app, content[0], (Path(app.srcdir) / path).resolve())


def setup(app: Sphinx) -> dict:
    """Rewrite links as pages and included files are read."""
    app.add_config_value("repository_pages", {}, "env", dict)
    app.connect("source-read", on_source_read)
    app.connect("include-read", on_include_read)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

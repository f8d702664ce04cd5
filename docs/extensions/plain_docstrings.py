"""Docstrings on the pages of docs/: plain text with `names` and indented equations, and no reStructuredText.

`names` are shown as code, indented lines as they stand, and every other sign as itself: |F|, delta_n and 2 * x mean
nothing but what they say. The doc of an attribute may end a sentence with its unit in brackets.
"""

import re
from itertools import groupby

from sphinx.application import Sphinx

CODE = re.compile(r"`([^`]+)`")
SIGNS = re.compile(r"([\\*`|_\[\]<>])")


def plain_line(line: str) -> str:
    """A line of a docstring as reStructuredText that shows it as it stands."""
    # Every second part stood between backticks.
    parts = CODE.split(line)
    return "".join(f"``{part}``" if number % 2 else SIGNS.sub(r"\\\1", part) for number, part in enumerate(parts))


def plain_docstring(lines: list[str]) -> list[str]:
    """The lines of a docstring as reStructuredText: paragraphs, lists, and literal blocks for what is indented."""
    found: list[str] = []
    after_item = False
    for indented, group in groupby(lines, key=lambda line: line.startswith(" ") if line.strip() else None):
        own = list(group)
        if indented is None:
            found += own
        elif not indented:
            for line in own:
                is_item = line.startswith("- ")
                # A list begins after an empty line, and so does the text after it.
                if is_item and found and found[-1].strip() and not after_item:
                    found.append("")
                after_item = is_item
                found.append(f"- {plain_line(line[2:])}" if is_item else plain_line(line))
        elif after_item:
            # The next lines of an item.
            found += [f"  {plain_line(line.strip())}" for line in own]
        else:
            found += ["", "::", "", *(f"    {line}" for line in own), ""]
    return found


def on_docstring(app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Rewrite a docstring in place."""
    lines[:] = plain_docstring(lines)


def setup(app: Sphinx) -> dict:
    """Rewrite docstrings as autodoc reads them."""
    app.connect("autodoc-process-docstring", on_docstring)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

"""The directive `offered-names`: what `import millprint` offers, each name with its docstring.

The list is `millprint.OFFERED`, in its order, so that the page cannot leave out a name or keep an old one.
"""

import inspect

from docutils import nodes
from docutils.parsers.rst import Directive
from docutils.statemachine import StringList
from pydantic import BaseModel
from sphinx.application import Sphinx

import millprint


def documented(name: str) -> list[str]:
    """The lines of reStructuredText that document a name.

    A class has its members too, but for a model of the configuration, whose fields are in config/keys.md, and an error.
    """
    thing = getattr(millprint, name)
    if not inspect.isclass(thing):
        return [f".. autofunction:: millprint.{name}", ""]
    without_members = issubclass(thing, (BaseModel, Exception))
    return [f".. autoclass:: millprint.{name}()", *([] if without_members else ["   :members:"]), ""]


class OfferedNames(Directive):
    """A list of everything that is offered."""

    def run(self) -> list[nodes.Node]:
        """Parse the lines of every name."""
        lines = StringList([line for name in millprint.OFFERED for line in documented(name)], "millprint.OFFERED")
        parent = nodes.section(document=self.state.document)
        self.state.nested_parse(lines, self.content_offset, parent)
        return parent.children


def setup(app: Sphinx) -> dict:
    """Register the directive."""
    app.add_directive("offered-names", OfferedNames)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

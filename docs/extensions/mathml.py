"""Equations as MathML, made by latex2mathml while the pages are built."""

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

LOGGER = logging.getLogger(__name__)


def to_mathml(node: nodes.Node, display: str) -> str:
    """The MathML of an equation; warns, which is an error of `make docs`, if latex2mathml does not know all of it."""
    try:
        mathml = convert(node.astext(), display=display)
    except Exception as error:
        LOGGER.warning("no equation: %s (%r)", node.astext(), error, location=node, type="mathml")
        return ""
    # latex2mathml writes a command that it does not know as it stands.
    if "\\" in mathml:
        LOGGER.warning("unknown command in the equation: %s", node.astext(), location=node, type="mathml")
    return mathml


def visit_inline(self, node: nodes.math) -> None:
    """Write an equation within a sentence."""
    self.body.append(to_mathml(node, "inline"))
    raise nodes.SkipNode


def visit_block(self, node: nodes.math_block) -> None:
    """Write an equation on a line of its own, with its number if it has a label."""
    # Sphinx has written the anchor of a numbered equation around it.
    self.body.append('<div class="equation">')
    self.body.append(to_mathml(node, "block"))
    if node["number"]:
        number = self.builder.config.math_eqref_format or "({number})"
        self.body.append(f'<span class="eqno">{number.format(number=node["number"])}</span>')
    self.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict:
    """Register `html_math_renderer = "mathml"`."""
    app.add_html_math_renderer("mathml", inline_renderers=(visit_inline, None), block_renderers=(visit_block, None))
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}

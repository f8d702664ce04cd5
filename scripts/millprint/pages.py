"""HTML pages from templates that lie beside the code: whole in one file, with nothing fetched from elsewhere."""

import json
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup


def render_page(template: Path, **values: Any) -> str:
    """Fill a Jinja template; values are escaped unless they are Markup. Raises UndefinedError for one left out."""
    environment = Environment(
        loader=FileSystemLoader(template.parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(**values)


def embed_files(folder: Path, *names: str) -> Markup:
    """The text of files of our own, to stand inside <style> or <script>."""
    return Markup("\n".join((folder / name).read_text().strip() for name in names))


def embed_json(content: dict) -> Markup:
    """A value as JSON that can stand inside <script>: no text of it can end the script."""
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029"))

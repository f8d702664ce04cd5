"""HTML pages and texts from templates in the folders of the library. Each page is one file and loads nothing else."""

import json
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup


def render_page(template: Path, **values: Any) -> str:
    """Fill a Jinja template. Values are escaped unless they are Markup. Raises UndefinedError for a missing value."""
    return fill_template(template, True, **values)


# Templates name those of other folders from here, such as report/tables.html.
PACKAGE = Path(__file__).parents[1]


def fill_template(template: Path, is_html: bool = False, /, **values: Any) -> str:
    """Fill a Jinja template of plain text. Raises UndefinedError for a missing value."""
    environment = Environment(
        loader=FileSystemLoader([template.parent, PACKAGE]),
        autoescape=is_html,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template.name).render(**values)


def embed_files(folder: Path, *names: str) -> Markup:
    """The text of files of this library, for use inside <style> or <script>."""
    return Markup("\n".join((folder / name).read_text().strip() for name in names))


def embed_json(content: dict) -> Markup:
    """A value as JSON for use inside <script>, escaped so that no text can end the script."""
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029"))

"""How the pages of docs/ are built: `make docs` writes them to docs/_build, readable without a network."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

project = "millprint"
author = "millprint developers"
copyright = author
version = release = version_of("millprint")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "sphinx_design",
    "mathml",
    "offered_names",
    "plain_docstrings",
    "repository_links",
]
exclude_patterns = ["_build"]

# `$...$` and `$$...$$` are equations, `::: {note}` a box, `[word]{#anchor}` an anchor, and each heading down to the
# third level has one.
myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

# Equations are MathML, which browsers draw themselves: no script of another site is needed.
html_math_renderer = "mathml"

# Files of the repository that are pages of this site too, where the page exists. Any other file is copied next to the
# pages. So one link serves readers of the repository and of the site.
repository_pages = {
    "README.md": "index",
    "CONTRIBUTING.md": "reference/contributing",
    "CHANGELOG.md": "reference/changes",
    "config/README.md": "how_to/configuration",
    "config/keys.md": "reference/keys",
    "workflow/card.md": "reference/card",
    "workflow/descriptors.md": "reference/descriptors",
    "workflow/outputs.md": "reference/outputs",
}

# Types in signatures are shown without their modules; those of other libraries have no page here.
python_use_unqualified_type_names = True
autodoc_preserve_defaults = True
autodoc_member_order = "bysource"
nitpick_ignore_regex = [("py:.*", ".*")]

html_theme = "furo"
html_title = "millprint"
html_static_path = ["static"]
# The atlas, and the explorer of the mills that come with millprint; `make reference` writes them.
html_extra_path = ["mills.html", "fingerprints.html"]
html_css_files = ["pages.css"]
html_js_files = ["pages.js"]
html_copy_source = False
html_show_copyright = False
# `$` of a terminal and `>>>` of Python are not copied.
copybutton_prompt_text = r"\$ |>>> "
copybutton_prompt_is_regexp = True

"""Builds the wheel with what a checkout has next to the library: mills, contact sets, tables, and the workflow.

The job that builds a release gives it the addresses of its repository.
"""

import os
import re
from pathlib import Path
from shutil import copytree, ignore_patterns

from setuptools import setup
from setuptools.command.build_py import build_py

INCLUDED = ("config", "workflow", "scripts", "envs", "profiles")


class BuildWithWorkflow(build_py):
    """Copies these folders next to the modules, where `millprint.config.included` finds them."""

    def run(self) -> None:
        """Build as setuptools does, and copy; an editable library reads the files of its checkout."""
        super().run()
        if self.editable_mode:
            return
        for folder in INCLUDED:
            place = Path(self.build_lib, "millprint/included", folder)
            copytree(folder, place, dirs_exist_ok=True, ignore=ignore_patterns("__pycache__"))


def repository() -> str:
    """The address of the repository that publishes, in the job that builds a release; empty elsewhere."""
    server, name = os.environ.get("GITHUB_SERVER_URL"), os.environ.get("GITHUB_REPOSITORY")
    return f"{server}/{name}" if server and name else ""


def addresses() -> dict[str, str]:
    """What the page of a release links to."""
    if not (place := repository()):
        return {}
    return {"Source": place, "Issues": f"{place}/issues", "Changelog": f"{place}/blob/main/CHANGELOG.md"}


def first_page() -> str:
    """README.md; that of a release leads into its repository from wherever it is read."""
    text = Path("README.md").read_text(encoding="utf-8")
    if not (place := repository()):
        return text
    tag = os.environ.get("GITHUB_REF_NAME", "main")

    def whole(link: re.Match) -> str:
        # Pictures and pages that a browser shows itself, and texts that the repository shows.
        kind = "raw" if link["words"].startswith("!") or link["path"].endswith(".html") else "blob"
        return f"{link['words']}{place}/{kind}/{tag}/{link['path']}"

    return re.sub(r"(?P<words>!?\[[^\]]*\]\()(?![a-z]+:|#)(?P<path>[^)\s]+)", whole, text)


setup(
    cmdclass={"build_py": BuildWithWorkflow},
    project_urls=addresses(),
    long_description=first_page(),
    long_description_content_type="text/markdown",
)

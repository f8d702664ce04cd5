"""Builds the wheel with what a checkout has next to the library: mills, contact sets, tables, and the workflow."""

import os
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


def addresses() -> dict[str, str]:
    """The addresses of the repository that publishes: of the job that builds a release, and none elsewhere."""
    server, repository = os.environ.get("GITHUB_SERVER_URL"), os.environ.get("GITHUB_REPOSITORY")
    if not (server and repository):
        return {}
    place = f"{server}/{repository}"
    return {"Source": place, "Issues": f"{place}/issues", "Changelog": f"{place}/blob/main/CHANGELOG.md"}


setup(cmdclass={"build_py": BuildWithWorkflow}, project_urls=addresses())

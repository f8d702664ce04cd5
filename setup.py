"""Builds the wheel with what a checkout has next to the library: mills, contact sets, tables, and the workflow."""

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


setup(cmdclass={"build_py": BuildWithWorkflow})

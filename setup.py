"""Builds the wheel with the included mills and contact sets, which a checkout keeps in config/ (see pyproject.toml)."""

from pathlib import Path
from shutil import copytree

from setuptools import setup
from setuptools.command.build_py import build_py

INCLUDED = ("config/mills", "config/contacts")


class BuildWithMills(build_py):
    """Copies the included files beside the modules, where `millprint.config.included` finds them."""

    def run(self) -> None:
        """Build as setuptools does, and copy; an editable library reads the files of its checkout."""
        super().run()
        if self.editable_mode:
            return
        for folder in INCLUDED:
            copytree(folder, Path(self.build_lib, "millprint/included", folder), dirs_exist_ok=True)


setup(cmdclass={"build_py": BuildWithMills})

"""The folder for what is made once and may be deleted: machine code, and what the source files compute."""

import os
from pathlib import Path

from platformdirs import user_cache_path

PACKAGE = Path(__file__).parents[1]


def cache_root() -> Path:
    """The folder of the cache: in a checkout of the project, or in the user's cache for an installed library."""
    project = PACKAGE.parents[1]
    if (project / "pyproject.toml").is_file() and os.access(project, os.W_OK):
        return project / ".numba_cache"
    return user_cache_path("millprint", appauthor=False)


CACHE_ROOT = cache_root()

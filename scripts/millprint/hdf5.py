"""HDF5 files of results, opened to be read."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from millprint.errors import ConfigError


@contextmanager
def open_hdf5(path: str | Path) -> Iterator[h5py.File]:
    """Open a file of results. Raises ConfigError, in one line, where it or a part of it cannot be read."""
    if not Path(path).is_file():
        raise ConfigError(f"{path}: no such file")
    try:
        with h5py.File(path) as file:
            yield file
    except (OSError, KeyError) as error:
        what = " ".join(str(error).split())
        raise ConfigError(
            f"{path}: truncated or damaged ({what}); delete it and run the same command again: it is made anew"
        ) from None

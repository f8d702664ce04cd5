"""HDF5 result files, written completely or not at all; reading errors are one line."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from millprint.config.errors import ConfigError
from millprint.run.files import whole_file

# h5py is imported where a file is opened: it is slow to import, and many commands open none.
if TYPE_CHECKING:
    import h5py


@contextmanager
def whole_hdf5(path: str | Path, front: Callable[[bytes], bytes] | None = None) -> Iterator[h5py.File]:
    """A file that is made in memory and written at the end, after a block of 512 bytes that `front` makes from it.

    HDF5 itself cannot close a file on a full disk: it tries again when the process ends, and crashes it.
    """
    import h5py

    with whole_file(path) as partial:
        with h5py.File(partial.name, "w", driver="core", backing_store=False) as file:
            yield file
            file.flush()
            image = file.id.get_file_image()
        partial.write_bytes((front(image) if front else b"") + image)


@contextmanager
def open_hdf5(path: str | Path) -> Iterator[h5py.File]:
    """Open a file of results. Raises ConfigError, in one line, if it or a part of it cannot be read."""
    import h5py

    if not Path(path).is_file():
        raise ConfigError(f"{path}: no such file")
    try:
        with h5py.File(path) as file:
            yield file
    except KeyError as error:
        what = " ".join(str(error).split()).strip("\"'")
        raise ConfigError(
            f"{path}: a part of it is missing ({what}), which another version or a damage may be the cause of; delete "
            "it and run the same command again"
        ) from None
    except (OSError, IndexError) as error:
        what = " ".join(str(error).split())
        raise ConfigError(f"{path}: truncated or damaged ({what}); delete it and run the same command again") from None

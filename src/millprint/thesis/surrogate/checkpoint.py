"""Tensors: their device, their files, and checkpoints from which a killed training continues exactly."""

import hashlib
import io
import json
import logging
import pickle
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import torch

from millprint.config.errors import ConfigError
from millprint.config.section import Section
from millprint.run.checksummed import checksum_header, read_checksummed
from millprint.run.files import whole_file

logger = logging.getLogger("millprint")

BUDGET = {"wall_time_max_s", "checkpoint_every_s", "threads"}


def choose_device(threads: int) -> torch.device:
    """A GPU when there is one, otherwise `threads` threads of the processor."""
    torch.set_num_threads(threads)
    return torch.device("cuda" if torch.cuda.is_available() else "cpu")


def identity(settings: Section, data: Iterable[np.ndarray]) -> str:
    """A hash of the settings of a training and of its data: only a checkpoint of the same may be resumed.

    How long to train, how often to save and on how many threads is left out: a training may go on with more.
    """
    content = settings.model_dump(mode="json", exclude={"training": BUDGET})
    total = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    for part in data:
        total.update(part.tobytes())
    return total.hexdigest()


def _as_bytes(content: dict) -> bytes:
    """The bytes that torch writes. In a file they would contain the file's name, with a process number."""
    memory = io.BytesIO()
    torch.save(content, memory)
    return memory.getvalue()


def write_checkpoint(path: str | Path, content: dict) -> None:
    """Write tensors, numbers, texts and mappings of them, below a digest of them all."""
    with whole_file(path) as partial:
        payload = _as_bytes(content)
        partial.write_bytes(checksum_header(payload) + payload)


def read_checkpoint(path: str | Path, own_identity: str, device: torch.device) -> dict | None:
    """The checkpoint at `path` if there is one of this `identity`, otherwise None, with a line in the log."""
    if not Path(path).exists():
        return None
    try:
        content = torch.load(io.BytesIO(read_checksummed(path)), map_location=device, weights_only=True)
        fits = content["identity"] == own_identity
    except (OSError, ValueError, KeyError, TypeError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        logger.warning("%s cannot be read (%s): starting again", path, " ".join(str(error).split()))
        return None
    if not fits:
        logger.info("%s belongs to other settings or data: starting again", path)
    return content if fits else None


def write_tensors(path: str | Path, content: dict) -> None:
    """Write finished weights, readable by `torch.load` with weights_only=True."""
    with whole_file(path) as partial:
        partial.write_bytes(_as_bytes(content))


def read_tensors(path: str | Path, device: torch.device | str = "cpu") -> dict:
    """Read the file of `write_tensors`. Raises ConfigError for a damaged file."""
    try:
        return torch.load(path, map_location=device, weights_only=True)
    except (OSError, ValueError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        what = str(error).split("\n", 1)[0][:100]
        raise ConfigError(f"{path}: truncated or damaged ({what}); delete it and run the same command again") from None

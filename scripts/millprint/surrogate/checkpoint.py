"""What a killed training goes on from, exactly, and files of tensors."""

import hashlib
import io
import json
import logging
import pickle
from pathlib import Path

import torch

from millprint.config.surrogate import Recipe
from millprint.errors import ConfigError
from millprint.files import whole_file
from millprint.sealed import seal, unsealed

logger = logging.getLogger("millprint")

BUDGET = {"wall_time_max_s", "checkpoint_every_s", "threads"}


def identity(recipe: Recipe, statistics: dict[str, torch.Tensor]) -> str:
    """A hash of the recipe and of the statistics of the data: only a checkpoint of the same may be resumed.

    How long to train, how often to save and on how many threads is left out: a training may go on with more.
    """
    content = recipe.model_dump(mode="json", exclude={"training": BUDGET})
    total = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    for name in sorted(statistics):
        total.update(statistics[name].cpu().numpy().tobytes())
    return total.hexdigest()


def _as_bytes(content: dict) -> bytes:
    """What torch would write; into a file it would write the file's name too, and that has a process in it."""
    held = io.BytesIO()
    torch.save(content, held)
    return held.getvalue()


def write_checkpoint(path: str | Path, content: dict) -> None:
    """Write tensors, numbers, texts and mappings of them, below a digest of them all."""
    with whole_file(path) as partial:
        payload = _as_bytes(content)
        partial.write_bytes(seal(payload) + payload)


def read_checkpoint(path: str | Path, wanted: str, device: torch.device) -> dict | None:
    """The checkpoint at `path` if there is one whose `identity` is `wanted`, otherwise None, with a line in the log."""
    if not Path(path).exists():
        return None
    try:
        content = torch.load(io.BytesIO(unsealed(path)), map_location=device, weights_only=True)
        fits = content["identity"] == wanted
    except (OSError, ValueError, KeyError, TypeError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        logger.warning("%s cannot be read (%s): starting anew", path, " ".join(str(error).split()))
        return None
    if not fits:
        logger.info("%s belongs to other settings or data: starting anew", path)
    return content if fits else None


def write_tensors(path: str | Path, content: dict) -> None:
    """Write finished weights, plain: `torch.load` with weights_only=True reads them."""
    with whole_file(path) as partial:
        partial.write_bytes(_as_bytes(content))


def read_tensors(path: str | Path, device: torch.device | str = "cpu") -> dict:
    """What `write_tensors` wrote. Raises ConfigError for a damaged file."""
    try:
        return torch.load(path, map_location=device, weights_only=True)
    except (OSError, ValueError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        what = str(error).split("\n", 1)[0][:100]
        raise ConfigError(
            f"{path}: truncated or damaged ({what}); delete it and run the same command again: it is made anew"
        ) from None

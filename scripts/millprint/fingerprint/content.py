"""The file of a fingerprint, read without what predicts from it: light enough for every start of the workflow."""

from pathlib import Path

from millprint.errors import ConfigError
from millprint.files import read_json

FORMAT = "millprint fingerprint 1"
NAMED = "one is written as fingerprint_CONTACT.json"


def read_content(path: str | Path) -> dict:
    """The content of a fingerprint's file; raises ConfigError, in one line, for a missing or another file."""
    try:
        content = read_json(path)
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such fingerprint; {NAMED}") from None
    except ValueError:
        raise ConfigError(f"{path}: not a fingerprint; {NAMED}") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ConfigError(f"{path}: format: must be {FORMAT!r}; {NAMED}")
    return content

"""Reads a card, also one that another program wrote."""

import json
from pathlib import Path

from millprint.card.card_inputs import Known
from millprint.card.card_model import FORMAT, SCHEMA_VERSION, MillingCard
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.dose.wear import read_coefficient, read_materials
from millprint.fingerprint.model import Fingerprint


def read_card(path: str | Path) -> MillingCard:
    """The card in a file.

    Raises ConfigError for a missing file, a file that is not a card, another version of the schema, and, with a line
    each, for fields that do not match the schema.
    """
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such card; `millprint card` and the target `cards` write card.json") from None
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path}: not a milling card: cannot be read as JSON ({error})") from None
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ConfigError(f"{path}: format: must be {FORMAT!r}")
    version = content.get("schema_version")
    if version != SCHEMA_VERSION or isinstance(version, bool):
        raise ConfigError(
            f"{path}: schema_version = {version!r}: must be {SCHEMA_VERSION}; write the card again, or read it with "
            "the version of millprint that wrote it"
        )
    return check_model(content, MillingCard, str(path))


def known_of(uncertainty: str | Path | None, wear: str | Path | None, materials: str | Path, contact: str) -> Known:
    """What other results tell, from files that may not be there; contact: the set that the intervals must be of."""
    why = {}
    fingerprint = coefficient = None
    if uncertainty and Path(uncertainty).is_file():
        fingerprint = Fingerprint.read(uncertainty)
        fingerprint = fingerprint if fingerprint.about["contact"] == contact else None
    if wear and Path(wear).is_file():
        coefficient = read_coefficient(wear)
    else:
        why["wear"] = "no fitted wear coefficient; the target `dose` of config/config.yaml fits one"
    return Known(fingerprint, coefficient, read_materials(materials), why)

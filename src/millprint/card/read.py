"""What a card is made from in addition to the experiment; and reading a card, also one of another program."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from millprint.card.card_model import FORMAT, SCHEMA_VERSION, MillingCard
from millprint.config.card import Experiment
from millprint.config.counting import DEFAULT_RULE, RuleName
from millprint.config.dose import DoseConfig
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.section import Fraction, Section
from millprint.dose.wear import read_coefficient, read_materials
from millprint.fingerprint.model import Fingerprint

if TYPE_CHECKING:
    from millprint.fingerprint.model import Fingerprint


# Steels differ in density by less than this fraction; other materials by more.
DENSITY_TOLERANCE = 0.03


class CardSettings(Section):
    """What a card takes from the configuration of a run, with the same defaults."""

    counting_rule: RuleName = DEFAULT_RULE
    """name of the rule that defines one collision"""
    interval: Fraction = 0.95
    """probability of the bands of a new simulation and of the mean [-]"""
    dose: DoseConfig = DoseConfig()
    """settings of spectra, heat and wear"""


@dataclass(frozen=True)
class Runs:
    """The finished simulations of a condition: summary and path of run.h5 for each seed."""

    summaries: list[dict]
    paths: list[str]


@dataclass(frozen=True)
class Known:
    """Other results that apply to the experiment, None where there are none.

    fingerprint: of the mill, with factors by contact parameters and shape; wear: result of `dose.wear.fit_wear`;
    materials: table of materials; why: reasons for what is missing, by name.
    """

    fingerprint: "Fingerprint | None" = None
    wear: Mapping | None = None
    materials: pd.DataFrame | None = None
    why: Mapping[str, str] = field(default_factory=dict)


def check_material(
    experiment: Experiment, density_kg_m3: float, materials: pd.DataFrame, place: str, path: str
) -> None:
    """Refuse, with a ConfigError in one line, a material that is not in the table, or of another density.

    density_kg_m3: of the simulated balls; place: file of the experiment; path: file of the materials.
    """
    name = experiment.balls.material
    if name is None:
        return
    if name not in materials.index:
        raise ConfigError(f"{place}: balls.material = {name!r}: not in {path}; it has {', '.join(materials.index)}")
    density = float(materials.loc[name, "density_kg_m3"])
    if abs(density / density_kg_m3 - 1) > DENSITY_TOLERANCE:
        raise ConfigError(
            f"{place}: balls.material = {name!r}: has {density:g} kg/m3, the simulated balls {density_kg_m3:g}; "
            f"give balls.density_kg_m3: {density:g}"
        )


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

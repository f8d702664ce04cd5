"""The set-ups that others measured, one record each."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.setup_models import FILES, SetupConfig, SetupFile
from millprint.config.sweep import Case, DemConfig
from millprint.validation.drums import SHORT, predict_bead_drum, predict_repose_drum
from millprint.validation.impacts import PARTIAL, predict_alumina_impact, predict_elastic_impact
from millprint.validation.measured import PLACE_COLUMNS, Inputs, check_predictions
from millprint.validation.shaken import (
    predict_leaf_spring,
    predict_shaken_box,
    predict_shaken_plate,
)
from millprint.validation.tumbling import OTHER_CONTACT, predict_tumbling


@dataclass(frozen=True)
class Kind:
    """How set-ups of a kind are predicted.

    predict: the predictions from their inputs, a table with PREDICTION_COLUMNS; variants: beginnings of the names of
    models that change one thing of ours and may explain a miss (`validation.verdicts`).
    """

    predict: Callable[[Inputs], pd.DataFrame]
    variants: tuple[str, ...] = ()


PREDICTED = {
    "tumbling": Kind(predict_tumbling, (OTHER_CONTACT,)),
    "oblique_impact": Kind(predict_alumina_impact, (PARTIAL,)),
    "elastic_impact": Kind(predict_elastic_impact, (PARTIAL,)),
    "bead_drum": Kind(predict_bead_drum, (SHORT,)),
    "repose_drum": Kind(predict_repose_drum),
    "shaken_box": Kind(predict_shaken_box),
    "leaf_spring": Kind(predict_leaf_spring),
    "shaken_plate": Kind(predict_shaken_plate),
}


def setup_named(name: str) -> SetupFile:
    """The file of a set-up. Raises ConfigError for a name that none has."""
    if name not in FILES:
        raise ConfigError(f"validation.setups: unknown set-up {name!r}; known: {', '.join(FILES)}")
    return FILES[name]


def predict(
    name: str,
    settings: SetupConfig,
    mill: MillConfig | None,
    contacts: dict[str, ContactConfig],
    dem: DemConfig,
    cases: dict[str, Case],
    runs: str | Path,
    measured: pd.DataFrame,
    folder: str | Path = "",
    other_codes: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """The predictions of a set-up, checked; `measured` are points as of `measured_points`, the others as of `Inputs`.

    A set-up gets the measured places, but not the values. Raises ConfigError as `setup_named`, and for a measured
    quantity that the set-up does not predict.
    """
    setup = setup_named(name)
    places = measured.loc[measured["setup"] == name, list(PLACE_COLUMNS)]
    inputs = Inputs(settings, mill, contacts, dem, cases, Path(runs), places, Path(folder))
    if other_codes is not None:
        inputs = replace(inputs, other_codes=other_codes)
    table = check_predictions(PREDICTED[setup.kind].predict(inputs), name)
    known = dict.fromkeys(table["quantity"])
    for id, quantity in zip(places["id"], places["quantity"], strict=True):
        if quantity not in known:
            place = f"validation.measured: column quantity, id {id} = {quantity!r}"
            raise ConfigError(f"{place}: set-up {name} predicts {', '.join(known)}")
    return table


def assumption_table(
    name: str, settings: SetupConfig, mill: MillConfig | None, contacts: dict[str, ContactConfig]
) -> list[dict[str, Any]]:
    """A row for each assumption of a set-up: setup, what, value, source."""
    setup = setup_named(name)
    rows = [(each.what, each.value, each.source) for each in setup.assumptions]
    if mill is not None:
        rows.append((f"mill {mill.name}", mill.title, mill.source))
    for contact in contacts.values():
        values = contact.model_dump(exclude={"name", "source"}, exclude_defaults=True)
        role = "predicts" if contact.name == settings.contact else "interval"
        rows += [
            (f"{key}, contact set {contact.name} ({role})", value if key == "kind" else f"{value:g}", contact.source)
            for key, value in values.items()
        ]
    return [
        {"setup": name, "what": what, "value": value, "source": " ".join(source.split())}
        for what, value, source in rows
    ]

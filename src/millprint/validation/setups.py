"""The set-ups that others measured, one record each."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.quantities import BALL_SPEEDS
from millprint.config.setup_models import SetupConfig, ShakerConfig
from millprint.config.sweep import Case, DemConfig
from millprint.validation.drums import SHORT, predict_bead_drum, predict_repose_drum
from millprint.validation.impacts import PARTIAL, predict_alumina_impact, predict_elastic_impact
from millprint.validation.measured import BALLS, PLACE_COLUMNS, Inputs, check_predictions, prediction
from millprint.validation.shaken_predictions import (
    predict_leaf_spring,
    predict_shaken_box,
    predict_shaken_plate,
)
from millprint.validation.tumbling import OTHER_CONTACT, predict_tumbling
from millprint.view.snapshots import Snapshots, open_run


def predict_ball_speeds(inputs: Inputs) -> pd.DataFrame:
    """Median of the balls' speeds in the laboratory [m/s], over all charges; the interval contains the `share`."""
    settings: ShakerConfig = inputs.settings
    speeds = []
    for path in inputs.cases:
        with open_run(inputs.runs / path / "run.h5") as file:
            for block in Snapshots(file).blocks():
                speeds.append(np.linalg.norm(block.balls["velocity_m_s"], axis=2).ravel())
    ends = (0.5 - settings.share / 2, 0.5, 0.5 + settings.share / 2)
    lower, median, upper = np.quantile(np.concatenate(speeds), ends)
    id = inputs.ids_of_single(BALL_SPEEDS)
    return pd.DataFrame([prediction(BALL_SPEEDS, "m/s", median, id=id, lower=lower, upper=upper, interval=BALLS)])


@dataclass(frozen=True)
class Assumption:
    """Something that the source does not state, or that we took from another source."""

    what: str
    value: str
    source: str


@dataclass(frozen=True)
class Setup:
    """A set-up, named after its section in the configuration.

    number: in the literature list of measured machines; title: in figures and tables; predict: its predictions from its
    inputs, a table with PREDICTION_COLUMNS; assumptions: assumptions that the files of mill and contact sets do not
    state; variants: beginnings of the names of models that change one thing of ours and may explain a miss
    (`validation.verdicts`); known: False if the source states too little, so that the prediction is an
    order of magnitude and is not judged.
    """

    name: str
    number: str
    title: str
    predict: Callable[[Inputs], pd.DataFrame]
    assumptions: tuple[Assumption, ...] = ()
    variants: tuple[str, ...] = ()
    known: bool = True


TUMBLING = (
    Assumption("power", "work of all walls on the balls: net of bearings, gears and motor", "our definition"),
    Assumption("end walls", "turn with the shell, with its friction", "assumed; photographs show closed drums"),
    Assumption(
        "ranges of contact parameters",
        "restitution 0.45 to 0.90, friction of balls 0.14 to 0.70 and of walls 0.20 to 0.70",
        "all contact sets of tumbling mills in Govender, Rajamani, Kok and Wilke 2015, Tables 1 to 6",
    ),
    Assumption(
        "range of the rolling friction", "0 to 0.02", "none in that source; twice clean steel, thesis Table 3.2"
    ),
)

SETUPS = {
    setup.name: setup
    for setup in (
        Setup(
            name="alumina_impact",
            number="3",
            title="Sphere of aluminium oxide on glass",
            predict=predict_alumina_impact,
            variants=(PARTIAL,),
            assumptions=(
                Assumption("sphere", "5 mm, 3.9 m/s", "Kharaz, Gorham and Salman 2001"),
                Assumption("plate", "soda-lime glass, 72 GPa, Poisson's ratio 0.23", "Pilkington ATS-129"),
                Assumption("interval of the restitution", "0.97 to 0.99", "one unit of the last published digit"),
                Assumption("interval of the friction", "0.087 to 0.097", "5 % of the published value"),
            ),
        ),
        Setup(
            name="elastic_impact",
            number="9",
            title="Elastic sphere on a plate",
            predict=predict_elastic_impact,
            variants=(PARTIAL,),
            assumptions=(
                Assumption("sphere", "10 um, 5 m/s along the normal; the result has no scale", "Chung and Ooi 2011"),
            ),
        ),
        Setup(
            name="bead_drum",
            number="4",
            title="Drum of glass beads",
            predict=predict_bead_drum,
            variants=(SHORT,),
            assumptions=(
                Assumption("slice", "24 mm of 360 mm, with smooth ends", "a slice of 12 mm is predicted too"),
                Assumption(
                    "frame",
                    "down the slope and along the normal of the surface that the simulation itself has",
                    "the surface is fitted over half the radius on both sides of the axis",
                ),
                Assumption(
                    "Young's modulus",
                    "0.01 GPa, not that of glass",
                    "overlaps stay below 6 % of a radius; it makes long steps possible",
                ),
                Assumption("speed", "11.6 rpm", "the post-processing of the source; its parameter file has 11.6 rad/s"),
                Assumption(
                    "interval of the contact parameters",
                    "from glass_beads to clean beads",
                    "worn beads need a step too short for this stage",
                ),
            ),
        ),
        Setup(
            name="repose_drum",
            number="7",
            title="Angle of repose in a short drum",
            predict=predict_repose_drum,
            assumptions=(
                Assumption("material", "not stated: generic friction and restitution", "contact set generic_spheres"),
                Assumption("Young's modulus", "0.01 GPa", "any that keeps overlaps small; the source has 0.0024 GPa"),
                Assumption(
                    "interval of the contact parameters",
                    "the changes of the angle that they make in slices of 30 mm",
                    "ranges for balls that nobody has measured",
                ),
            ),
        ),
        Setup(
            name="spex_shaker",
            number="8",
            title="Shaker mill of the class of SPEX 8000",
            predict=predict_ball_speeds,
            known=False,
            assumptions=(
                Assumption(
                    "balls", "12.7 and 6.35 mm, 6 % of the vial", "sizes sold with such mills; not in the source"
                ),
                Assumption("speed", "17.5 Hz", "as commonly given; not in the source"),
            ),
        ),
        Setup(
            name="slice_mill",
            number="1",
            title="Slice mill with lifters, 550 mm",
            predict=predict_tumbling,
            variants=(OTHER_CONTACT,),
            assumptions=(
                *TUMBLING,
                Assumption("filling for the formulas", "25 and 35 %", "printed with the numbers of balls"),
                Assumption("critical speed", "58.3 rpm", "printed"),
            ),
        ),
        Setup(
            name="drum_90cm",
            number="2",
            title="Drum with lifters, 900 mm",
            predict=predict_tumbling,
            variants=(OTHER_CONTACT,),
            assumptions=(*TUMBLING, Assumption("filling for the formulas", "20 %", "printed")),
        ),
        Setup(
            name="bond_mill",
            number="5",
            title="Bond mill, 305 mm",
            predict=predict_tumbling,
            variants=(OTHER_CONTACT,),
            assumptions=(
                *TUMBLING,
                Assumption("ore", "none in the mill; its friction and restitution are in the contact set", "assumed"),
                Assumption("filling for the formulas", "19 %", "20.1 kg of steel, packed to 0.60"),
            ),
        ),
        Setup(
            name="shaken_box",
            number="21",
            title="Shaken box without gravity",
            predict=predict_shaken_box,
            assumptions=(
                Assumption("free gap", "inner length less the packed thickness, which is half of it", "ours"),
                Assumption(
                    "thickness",
                    "twice the height of the centre of mass as the floor stops pushing, packed by shaking",
                    "ours",
                ),
                Assumption("Young's modulus", "0.01 GPa", "any that keeps contacts short against a period"),
            ),
        ),
        Setup(
            name="leaf_spring",
            number="22",
            title="Box on a leaf spring without gravity",
            predict=predict_leaf_spring,
            assumptions=(
                Assumption("number of balls", "37; the interval spans 33 to 41", "from memory, not in the source"),
                Assumption("frequency", "1.23 Hz, of the box without balls", "DynamO, packer.cpp, mode 19"),
                Assumption("start", "box and balls at rest, the balls all over the box", "not in the source"),
                Assumption("air and spring", "take no energy", "assumed"),
            ),
        ),
        Setup(
            name="shaken_plate",
            number="23",
            title="Plate shaken under gravity",
            predict=predict_shaken_plate,
            assumptions=(
                Assumption("layers, balls and frequency", "about four layers of 10 mm at 20 Hz", "not in the sources"),
                Assumption("lid", "so high that no ball meets it", "open boxes"),
            ),
        ),
    )
}


def setup_named(name: str) -> Setup:
    """The record of a set-up. Raises ConfigError for a name that the registry does not have."""
    if name not in SETUPS:
        raise ConfigError(f"validation.setups: unknown set-up {name!r}; known: {', '.join(SETUPS)}")
    return SETUPS[name]


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
    table = check_predictions(setup.predict(inputs), name)
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

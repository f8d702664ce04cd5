"""A card from an experiment and its finished simulations."""

import hashlib
import json
from pathlib import Path

from pydantic import BaseModel

from millprint.card.card_files import methods_paragraph, software
from millprint.card.card_model import (
    FORMAT,
    SCHEMA_VERSION,
    BallGroup,
    Balls,
    CardFingerprint,
    ContactSet,
    Jar,
    Machine,
    MillingCard,
    OverSpeed,
    Powder,
    Programme,
)
from millprint.card.parts import describe_runs, dose_part, heat_part, spectra_part, wear_part
from millprint.card.read import CardSettings, Known, Runs
from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.counting import recorded_count
from millprint.config.dose import JarSection
from millprint.config.mill import MillConfig
from millprint.config.over_speed import NOMINAL_SPEED_M_S
from millprint.fingerprint.readers import check_summary
from millprint.mill.bodies import build_bodies
from millprint.mill.wall_words import walls_in_words
from millprint.run.kernel import kernel_digest


def build_card(
    experiment: Experiment, mill: MillConfig, contact: ContactConfig, runs: Runs, settings: CardSettings, known: Known
) -> MillingCard:
    """The card. contact: the contact set as simulated, with the ball density of the experiment.

    Raises ConfigError, in one line, for a run without collisions and if the material differs from the simulated one.
    """
    for summary, path in zip(runs.summaries, runs.paths, strict=True):
        check_summary(summary, str(Path(path).with_name("summary.json")))
    first = runs.summaries[0]
    rule = recorded_count(first, settings.counting_rule)
    descriptors, missing, motion = describe_runs(runs, settings, known.fingerprint)
    balls = _balls(experiment, first)
    powder = _powder(experiment, balls)
    programme = _programme(experiment)
    not_known = dict(known.why)
    spectra, why = spectra_part(runs.summaries, runs.paths, settings)
    not_known |= {"spectra": why} if why else {}
    if powder is None or programme is None:
        lacking = "powder" if powder is None else "programme"
        not_known |= {"dose": f"no {lacking} is given"}
    dose = dose_part(descriptors, balls, powder, programme) if powder and programme else None
    jar = jar_section(experiment, settings)
    heat = heat_part(experiment, jar, powder, runs, settings)
    wear, why = wear_part(balls, powder, programme, runs, settings, known)
    not_known |= {"wear": why} if why else {}
    card = MillingCard(
        format=FORMAT,
        schema_version=SCHEMA_VERSION,
        name=experiment.name,
        title=experiment.title or mill.title,
        **{name: getattr(experiment, name) for name in ("authors", "reference", "atmosphere", "note")},
        machine=Machine(
            name=mill.name, title=mill.title, source=mill.source, motion=mill.motion.kind,
            amplitude_mm=1e3 * first["amplitude_m"] or None, speed_rpm=experiment.rpm,
        ),
        jar=Jar(
            volume_ml=mill.volume_ml, shape=mill.geometry.kind, cooling=jar.cooling,
            wall=walls_in_words(build_bodies(mill)),
            material=experiment.jar.material if experiment.jar else "",
        ),
        balls=balls,
        powder=powder,
        programme=programme,
        contact_set=_contact_set(contact),
        fingerprint=CardFingerprint(
            counting_rule=settings.counting_rule,
            collisions_by=rule["by"],
            collision_gap_turns=rule["gap_turns"],
            probability=settings.interval,
            descriptors=descriptors,
            seeds=[summary["case"]["seed"] for summary in runs.summaries],
            window_s=sum(summary["window_s"] for summary in runs.summaries),
            revolutions=sum(summary["revolutions"] for summary in runs.summaries),
            closure=max(abs(summary["closure"]) for summary in runs.summaries),
            missing=missing,
            motion=motion,
        ),
        spectra=spectra,
        dose=dose,
        heat=heat,
        wear=wear,
        not_known=not_known,
        software=software(),
        digests={
            "mill": _digest(mill),
            "contact_set": _digest(contact),
            "experiment": _digest(experiment),
            "kernels": kernel_digest(),
        },
    )  # fmt: skip
    return card.model_copy(update={"methods": methods_paragraph(card)})


def jar_section(experiment: Experiment, settings: CardSettings) -> JarSection:
    """The jar's properties for its heat balance, from the experiment, or else from the mill."""
    if experiment.jar is not None:
        return JarSection(**experiment.jar.model_dump(include=set(JarSection.model_fields)))
    return settings.dose.heat.jar_of(experiment.mill)


def _digest(section: BaseModel) -> str:
    """SHA-256 of the plain values of a section."""
    return hashlib.sha256(json.dumps(section.model_dump(mode="json"), sort_keys=True).encode()).hexdigest()


def _balls(experiment: Experiment, summary: dict) -> Balls:
    pairs = zip(summary["ball_sizes_m"], summary["ball_counts"], strict=True)
    return Balls(
        sizes=[BallGroup(diameter_mm=round(1e3 * size, 9), number=count) for size, count in pairs],
        mass_g=1e3 * summary["balls"] * summary["ball_mass_kg"],
        density_kg_m3=summary["density_kg_m3"],
        fill_ratio=summary["case"]["fill_ratio"],
        material=experiment.balls.material or "",
    )


def _powder(experiment: Experiment, balls: Balls) -> Powder | None:
    own = experiment.powder
    if own is None:
        return None
    mass = own.mass_g if own.mass_g is not None else balls.mass_g / (own.bpr or 1.0)
    return Powder(name=own.name, mass_g=mass, ball_to_powder_ratio=balls.mass_g / mass)


def _programme(experiment: Experiment) -> Programme | None:
    own = experiment.programme
    if own is None:
        return None
    return Programme(
        duration_h=own.duration_h,
        milling_h=own.milling_h,
        cycle_min=own.cycle_min if own.pause_min else None,
        pause_min=own.pause_min,
        reversal=own.reversal,
    )


def _contact_set(contact: ContactConfig) -> ContactSet:
    nominal = contact.at_speed(NOMINAL_SPEED_M_S)
    over_speed = [
        OverSpeed(coefficient=name, speeds_m_s=list(table.speeds_m_s), values=list(table.values))
        for name, table in contact.speed_tables.items()
    ]
    return ContactSet(
        **{name: value for name, value in nominal if name in ContactSet.model_fields and name != "cohesion"},
        over_speed=over_speed,
        cohesion=contact.cohesion.model_dump(exclude_none=True) if contact.cohesion else {},
    )

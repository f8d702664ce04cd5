"""A user's question to the inverse mode: targets by number or by another mill's condition, and what can be changed."""

import pandas as pd

from millprint.config.fingerprint import DESCRIPTORS, MatchConfig, TargetConfig
from millprint.errors import ConfigError
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.search import Allowed, rank_conditions


def wanted(target: TargetConfig, fingerprints: list[Fingerprint]) -> dict[str, float]:
    """The descriptors of a target by name: as given, or those that another mill's fingerprint predicts.

    Raises ConfigError if that fingerprint counts collisions by another gap than those that answer, because energies
    per collision and frequencies can be compared under one rule only.
    """
    if target.like is None:
        return target.wanted
    other = Fingerprint.read(target.like.fingerprint)
    for fingerprint in fingerprints:
        gaps = [item.about["collision_gap_s"] for item in (other, fingerprint)]
        if gaps[0] != gaps[1]:
            raise ConfigError(
                f"{target.like.fingerprint}: collisions are counted with a gap of {gaps[0]:g} s, those of "
                f"{fingerprint.about['mill']}/{fingerprint.about['contact']} with {gaps[1]:g} s; one rule for both is "
                "wanted"
            )
    like = target.like
    prediction = other.predict(like.speed_rpm / 60.0, like.ball_diameter_mm * 1e-3, like.fill_ratio)
    return {name: getattr(prediction, name).value for name in DESCRIPTORS}


def match_targets(request: MatchConfig, fingerprints: list[Fingerprint]) -> pd.DataFrame:
    """The nearest conditions for every target: `rank_conditions` under a column `target`."""
    (slowest, fastest), (emptiest, fullest) = request.speeds_rpm, request.fill_ratios
    allowed = Allowed(
        speeds_hz=(slowest / 60.0, fastest / 60.0),
        fill_ratios=(emptiest, fullest),
        ball_diameters_m=tuple(diameter * 1e-3 for diameter in request.ball_diameters_mm),
        densities_kg_m3=tuple(request.densities_kg_m3),
    )
    tables = []
    for target in request.targets:
        descriptors = wanted(target, fingerprints)
        table = rank_conditions(descriptors, fingerprints, allowed, request.weights.model_dump(), request.ranked)
        table.insert(0, "target", target.name)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)

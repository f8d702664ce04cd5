"""Inverse mode: the speeds that keep a target's descriptors, and the user's conditions ranked by how near they come."""

import pandas as pd

from millprint.config.fingerprint import InverseConfig, TargetConfig
from millprint.files import write_table
from millprint.fingerprint.inverse import DESCRIPTORS, CurvePoint, invert_speed
from millprint.fingerprint.master import MasterCurves
from millprint.fingerprint.published import published_point, read_published
from millprint.fingerprint.search import Allowed, curve_point, rank_conditions
from millprint.job import job


def wanted(target: TargetConfig) -> dict[str, float]:
    """The descriptors of a target by name."""
    return {name: getattr(target, name) for name in DESCRIPTORS}


def solve_speeds(curves: MasterCurves, points: dict[str, CurvePoint], inverse: InverseConfig) -> pd.DataFrame:
    """Speeds at the fixed fill ratio and ball size, for every target and set of curves."""
    about, fill = curves.about, inverse.fixed_fill_ratio
    machine = (about["density_kg_m3"], about["amplitude_m"], inverse.fixed_ball_diameter_mm * 1e-3, about["volume_m3"])
    tables = []
    for target in inverse.targets:
        for source, point in points.items():
            table = invert_speed(wanted(target), point, fill, *machine)
            table.insert(0, "curves", source)
            table.insert(0, "target", target.name)
            tables.append(table)
    return pd.concat(tables, ignore_index=True)


def rank_targets(curves: dict[str, MasterCurves], inverse: InverseConfig) -> pd.DataFrame:
    """The nearest conditions for every target."""
    allowed = Allowed(
        speeds_hz=tuple(speed / 60.0 for speed in inverse.speeds_rpm),
        fill_ratios=tuple(inverse.fill_ratios),
        ball_diameters_m=tuple(diameter * 1e-3 for diameter in inverse.ball_diameters_mm),
    )
    chosen = [curves[contact] for contact in inverse.contacts]
    weights = inverse.weights.model_dump()
    tables = []
    for target in inverse.targets:
        table = rank_conditions(wanted(target), chosen, allowed, weights, inverse.ranked)
        table.insert(0, "target", target.name)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def main(smooth: dict[str, tuple[str, str]], published_path: str, output, inverse: InverseConfig) -> None:
    """Solve and rank from our curves, and solve from the published ones where the thesis prints them."""
    curves = {contact: MasterCurves.read(*paths) for contact, paths in smooth.items()}
    own = curves[inverse.contact]
    printed = published_point(read_published(published_path), inverse.contact, inverse.fixed_fill_ratio)
    points = {"ours": curve_point(own, inverse.fixed_fill_ratio)} | ({"published": printed} if printed else {})
    write_table(solve_speeds(own, points, inverse), output.inverse)
    write_table(rank_targets(curves, inverse), output.ranked)


if "snakemake" in globals():
    with job(snakemake.log[0], "invert master curves"):
        files = zip(snakemake.input.smooth, snakemake.input.about, strict=True)
        main(
            dict(zip(snakemake.params.contacts, files, strict=True)),
            snakemake.input.published,
            snakemake.output,
            InverseConfig(**snakemake.params.settings["inverse"]),
        )

"""Inverse mode: the speeds that keep a target's descriptors, and the user's conditions ranked by how near they come."""

import pandas as pd

from millprint.config.fingerprint import InverseConfig
from millprint.files import write_table
from millprint.fingerprint.inverse import CurvePoint, invert_speed
from millprint.fingerprint.match import match_targets, wanted
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.published import published_point, read_published
from millprint.job import job


def solve_speeds(own: Fingerprint, points: dict[str, CurvePoint], inverse: InverseConfig) -> pd.DataFrame:
    """Speeds at the fixed fill ratio and ball size by the scaling alone, for every target and set of curves."""
    about, fill = own.about, inverse.fixed_fill_ratio
    machine = (about["density_kg_m3"], about["amplitude_m"], inverse.fixed_ball_diameter_mm * 1e-3, about["volume_m3"])
    tables = []
    for target in inverse.targets:
        for source, point in points.items():
            table = invert_speed(wanted(target, [own]), point, fill, *machine)
            table.insert(0, "curves", source)
            table.insert(0, "target", target.name)
            tables.append(table)
    return pd.concat(tables, ignore_index=True)


def main(fingerprints: dict[str, str], published_path: str, output, inverse: InverseConfig) -> None:
    """Solve and rank from our curves, and solve from the published ones where the thesis prints them."""
    read = {contact: Fingerprint.read(path) for contact, path in fingerprints.items()}
    own, fill = read[inverse.contact], inverse.fixed_fill_ratio
    printed = published_point(read_published(published_path), inverse.contact, fill)
    scaled = own.at(fill)
    points = {"ours": CurvePoint(scaled["Pn"].value, scaled["Pt"].value, scaled["f"].value)}
    points |= {"published": printed} if printed else {}
    write_table(solve_speeds(own, points, inverse), output.inverse)
    write_table(match_targets(inverse, [read[contact] for contact in inverse.contacts]), output.ranked)


if "snakemake" in globals():
    with job(snakemake.log[0], "invert master curves"):
        main(
            dict(zip(snakemake.params.contacts, snakemake.input.fingerprints, strict=True)),
            snakemake.input.published,
            snakemake.output,
            InverseConfig(**snakemake.params.settings),
        )

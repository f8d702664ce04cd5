"""Inverse mode: the speeds that give the target descriptors, and possible conditions ranked by their distance.

params: names of `contacts`, and `settings`. input: `fingerprints` and `published` curves. output: `inverse` (speeds)
and `ranked` (conditions).
"""

import pandas as pd

from millprint.config.fingerprint import DESCRIPTOR_SETS, InverseConfig
from millprint.fingerprint.condition import WEIGHTED_BASIC
from millprint.fingerprint.condition_search import match_targets, target_descriptors
from millprint.fingerprint.inverse import invert_speed
from millprint.fingerprint.model import KNOWN, Fingerprint
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.curves.regimes import published_point, read_published


def solve_speeds(own: Fingerprint, points: dict[str, dict[str, float]], inverse: InverseConfig) -> pd.DataFrame:
    """Speeds at the fixed fill ratio and ball size from the scaling laws only, for every target and set of curves.

    Curves that know nothing of weighted descriptors, as those of the thesis, answer no target of them.
    """
    condition = own.condition(
        speed_hz=1.0,  # is what is sought
        ball_diameter_m=inverse.fixed_ball_diameter_mm * 1e-3,
        fill_ratio=inverse.fixed_fill_ratio,
    )
    tables = []
    for target in inverse.targets:
        for source, point in points.items():
            wanted = target_descriptors(target, [own], inverse.descriptors)
            if not wanted.keys().isdisjoint(DESCRIPTOR_SETS["weighted"]) and not point.keys() >= set(WEIGHTED_BASIC):
                continue
            table = invert_speed(wanted, point, condition, own.about["volume_m3"])
            table.insert(0, "curves", source)
            table.insert(0, "target", target.name)
            tables.append(table)
    return pd.concat(tables, ignore_index=True)


def main(fingerprints: dict[str, str], published_paths: list[str], output, inverse: InverseConfig) -> None:
    """Solve and rank with our curves, and solve with the published curves for the contact sets that have them."""
    read = {contact: Fingerprint.read(path) for contact, path in fingerprints.items()}
    own, fill = read[inverse.contact], inverse.fixed_fill_ratio
    printed = published_point(read_published(*published_paths), inverse.contact, fill)
    scaled = own.at(fill)
    points = {"ours": {name: scaled[name].value for name in KNOWN}}
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

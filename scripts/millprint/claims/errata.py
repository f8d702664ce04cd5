"""Printed statements that a computation contradicts, each with the calculation that shows it."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path

import pandas as pd

from millprint.claims.chapter6 import BALL_THRESHOLD_M, SNAP_BACK_M, VARIANT
from millprint.claims.compare import ERRATUM
from millprint.claims.evidence import Evidence, rows
from millprint.claims.tabulate import chapter_of
from millprint.files import read_json, read_table
from millprint.surrogate.tables import covered_share

TRAINING_RUNS = "dem/emax/calibrated/d10_f0.10_n300_s*/summary.json"
# Energies are printed in whole microjoules, rounded or truncated; a departure that counts exceeds what that does.
ROUNDING_UJ, DEPARTURE_PERCENT = 1.0, 1.0


@dataclass(frozen=True)
class Erratum:
    """One printed statement and what contradicts it.

    chapter, locus: where it is printed; printed, computed: what stands there and what follows; calculation: the
    numbers that lead to it; source: the table of the run, or of the data, that they are in.
    """

    chapter: str
    locus: str
    printed: str
    computed: str
    calculation: str
    source: str


COLUMNS = [field.name for field in fields(Erratum)]


def errata_of_claims(claims: pd.DataFrame) -> list[Erratum]:
    """The claims with the verdict `erratum`, in the order of the table."""
    return [
        Erratum(
            chapter_of(claim.id),
            claim.locus,
            f"{claim.quantity}: {claim.published} {claim.unit}".removesuffix(" -"),
            f"{claim.reproduced} {claim.unit}".removesuffix(" -"),
            claim.explanation,
            f"report/claims.tsv, {claim.id}",
        )
        for claim in claims[claims["verdict"] == ERRATUM].itertuples()
    ]


def _design(evidence: Evidence, data: Path) -> list[Erratum]:
    """Runs that depart from the generator of the fraction, and what that does to the design."""
    audit = evidence.table("doe/audit.tsv")
    departs = rows(audit, departs="yes")
    if departs.empty:
        return []
    levels = rows(departs, check="runs at each level")
    shared = rows(departs, check="shared degrees of freedom")
    effects = [f"{row.subject} is run {row.found} times at its levels, not {row.wanted}" for row in levels.itertuples()]
    effects += [f"{row.subject} share {row.found} degrees of freedom" for row in shared.itertuples()]
    return [
        Erratum(
            "chapter 2",
            "Table 2.3",
            f"{row.subject}: {row.found}, in a design with the {row.check}",
            row.wanted,
            f"{row.note}. So the design is not orthogonal: {'; '.join(effects)}.",
            "doe/audit.tsv",
        )
        for row in departs[departs["check"].str.startswith("generator")].itertuples()
    ]


def _literature(evidence: Evidence, data: Path) -> list[Erratum]:
    """Entries of Tables 2.1 and 2.2 that contradict others of the same study."""
    found = rows(evidence.table("doe/literature_checks.tsv"), agrees="no")
    return [
        Erratum(
            "chapter 2",
            "Table 2.2",
            f"reference {row.reference}, {row.check}: {row.reported:g}",
            f"{row.follows:.3g}",
            f"from the study's other entries{'' if pd.isna(row.note) else '; ' + row.note}",
            "doe/literature_checks.tsv",
        )
        for row in found.itertuples()
    ]


def _constant_descriptors(evidence: Evidence, data: Path) -> list[Erratum]:
    """Sec. 3.3.4: at the speed that keeps the energies with smaller balls, the frequency of collisions is not kept."""
    table = rows(evidence.table("fingerprint/inverse.tsv"), target="thesis_reference", kept="normal energy")
    found = rows(table, fill_ratio=0.10, ball_diameter_mm=5.0, curves="published")
    if found.empty:
        return []
    row = found.iloc[0]
    kept = [row[f"{name}_energy_J_residual_percent"] for name in ("normal", "tangential")]
    frequency, off = row["frequency_per_ball_hz"], row["frequency_per_ball_hz_residual_percent"]
    return [
        Erratum(
            "chapter 3",
            "Sec. 3.3.4",
            f"all three descriptors are the same with 5 mm balls at {row['speed_rpm']:.0f} rpm",
            f"collisions of a ball rise by {off:.0f} % to {frequency:.0f} 1/s",
            f"energies go with omega^2 d^3 and are kept (normal {kept[0]:+.1f} %, tangential {kept[1]:+.1f} %), the "
            f"specific frequency goes with omega (Eq. 3.29): {frequency / (1 + off / 100):.0f} 1/s times "
            f"{1 + off / 100:.2f}",
            "fingerprint/inverse.tsv",
        )
    ]


def _normal_energy(evidence: Evidence, data: Path) -> list[Erratum]:
    """Table 5.1: at one fill ratio the energies go with the square of the speed (Eq. 3.28), to the printed digit."""
    runs = read_table(data / "screening.tsv", numeric=["speed_rpm", "normal_energy_uJ", "tangential_energy_uJ"])
    found = []
    for name in ("normal", "tangential"):
        levels = runs.groupby("speed_rpm")[f"{name}_energy_uJ"].first()
        for speed in levels.index:
            others = levels.drop(speed)
            # Each printed number stands for a range, and so do the numbers that follow from it.
            low = float(((others - ROUNDING_UJ) * (speed / others.index) ** 2).max())
            high = float(((others + ROUNDING_UJ) * (speed / others.index) ** 2).min())
            off = 100 * (levels[speed] / (0.5 * (low + high)) - 1)
            if low > high or abs(off) < DEPARTURE_PERCENT:
                continue
            given = " and ".join(f"{value:g} at {other:g}" for other, value in others.items())
            found.append(
                Erratum(
                    "chapter 5",
                    "Table 5.1",
                    f"{name} energy of a collision at {speed:g} rpm: {levels[speed]:g} microjoules",
                    f"{low:.1f} to {high:.1f} microjoules",
                    f"the energies of one fill ratio go with omega^2 (Eq. 3.28); {given} rpm agree with each other to "
                    f"the printed digit, and the entry is {off:+.1f} % off what follows from them",
                    "config/data/screening.tsv",
                )
            )
    return found


def _contact_radius(evidence: Evidence, data: Path) -> list[Erratum]:
    """Table 6.3: a connectivity radius below the distance of two balls in contact."""
    summaries = [read_json(path) for path in sorted(evidence.results.glob(TRAINING_RUNS))]
    if not summaries:
        return []
    nearest = min(s["ball_diameter_m"] * (1 - s["max_overlap_fraction"] / 2) for s in summaries)
    deepest = max(s["max_overlap_fraction"] for s in summaries)
    return [
        Erratum(
            "chapter 6",
            "Table 6.3, Sec. 6.2.4",
            f"balls are joined where their centres are within r_c = {BALL_THRESHOLD_M:g} m",
            f"centres never come nearer than {nearest:.5f} m",
            f"ball diameter {summaries[0]['ball_diameter_m']:g} m less the deepest overlap of {len(summaries)} run(s), "
            f"{100 * deepest:.2f} % of a radius: {nearest / BALL_THRESHOLD_M:.1f} times r_c, so that no ball-ball edge "
            "ever exists; as a gap between surfaces r_c works",
            TRAINING_RUNS,
        )
    ]


def _snap_back(evidence: Evidence, data: Path) -> list[Erratum]:
    """Sec. 6.2.4: the side of the snap-back threshold on which overlaps are deep."""
    path = evidence.results / "surrogate/wall_contacts.tsv"
    if not path.is_file():
        return []
    table = read_table(path, numeric=["low_m", "high_m", "contacts"])
    deeper = 100 * covered_share(table, SNAP_BACK_M)
    return [
        Erratum(
            "chapter 6",
            "Sec. 6.2.4",
            f"deeper overlaps have phi < phi_sb = {SNAP_BACK_M:g} m",
            "deeper overlaps have phi > phi_sb",
            "phi is negative inside and -(radius - overlap) at a contact, so it rises with the overlap. As printed, "
            f"{100 - deeper:.2f} % of the {int(table['contacts'].sum())} wall contacts of the training snapshots would "
            "be deep overlaps, and every ball off the wall as well",
            "surrogate/wall_contacts.tsv",
        )
    ]


def _pearson(evidence: Evidence, data: Path) -> list[Erratum]:
    """Sec. 6.3.2: a correlation of cumulative curves, which two unrelated simulations have as well."""
    table = rows(evidence.table("surrogate/metrics.tsv"), variant=VARIANT)
    empty, told = (rows(table, measure=name) for name in ("cumulative_pearson_r", "increments_5ms_r"))
    if empty.empty or told.empty:
        return []
    tests = ", ".join(f"{row.test} {row.dem_reference:.4f}" for row in empty.itertuples())
    increments = ", ".join(f"{row.test} {row.dem_reference:.2f}" for row in told.itertuples())
    return [
        Erratum(
            "chapter 6",
            "Sec. 6.3.2",
            "a Pearson r of 0.9998 of the cumulative dissipation shows that its evolution is captured",
            f"two simulations that share nothing but the mill reach {empty['dem_reference'].max():.4f}",
            f"r of another seed's cumulative curve with the truth: {tests}; two rising lines always correlate. Of "
            f"increments over 5 ms r is {increments}",
            "surrogate/metrics.tsv",
        )
    ]


FINDERS: tuple[Callable[[Evidence, Path], list[Erratum]], ...] = (
    _design,
    _literature,
    _constant_descriptors,
    _normal_energy,
    _contact_radius,
    _snap_back,
    _pearson,
)


def collect_errata(results: Path, data: Path, claims: pd.DataFrame) -> pd.DataFrame:
    """Every erratum by chapter: those among the claims, then what no claim states. Columns: those of Erratum.

    results: the folder of the run; data: that of the measured tables; claims: what `tabulate_claims` returns. A
    contradiction whose tables the run did not write is left out.
    """
    found = errata_of_claims(claims)
    evidence = Evidence(Path(results))
    for finder in FINDERS:
        found += finder(evidence, Path(data))
    table = pd.DataFrame([vars(erratum) for erratum in found], columns=COLUMNS)
    return table.sort_values("chapter", kind="stable", ignore_index=True)

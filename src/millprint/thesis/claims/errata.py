"""Contradictions inside the thesis: two printed places that cannot both hold, with the calculation that shows it."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pandas as pd

from millprint.config.workflow import PartitionConfig
from millprint.estimate.judge import DIFFERS
from millprint.run.tables import Number, read_measured
from millprint.thesis.claims.chapter2 import PRIOR_REFERENCE
from millprint.thesis.claims.chapter3 import CONTACT, implied_difference, misfit_of_the_revolutions
from millprint.thesis.claims.evidence import ERRATUM, Evidence, Finding, change_percent, datum, in_words
from millprint.thesis.claims.tabulate import chapter_of
from millprint.thesis.surrogate.measures import covered_share

# The printed value, the other place with what it prints, the computed value, and the calculation.
Row = tuple[str, str, str, str]
ERRATA_COLUMNS = ["chapter", "locus", "printed", "against", "computed", "calculation", "source"]
ERRATA: list[tuple[str, str, str, Callable[[Evidence], Iterator[Row]]]] = []

CONTESTED = "doe/contested.tsv"
AUDIT, LITERATURE = "doe/audit.tsv", "doe/literature_checks.tsv"
REPORTED = "config/data/literature.tsv"
SCREENING, PRINTED = "config/data/screening.tsv", "config/data/claims.tsv"
TRAINING_RUNS, WALL_CONTACTS = "dem/emax/calibrated/d10_f0.10_n300_s*/summary.json", "surrogate/wall_contacts.tsv"
# Energies are printed in whole microjoules, rounded or truncated; only a larger departure counts.
ROUNDING_UJ, DEPARTURE_PERCENT = 1.0, 1.0
# Differences between ball sizes that are further apart are not the same [percentage points].
SIZES_PP = 5.0
# Table 6.3.
BALL_THRESHOLD_M, SNAP_BACK_M = 0.0015, -0.0049


def erratum(chapter: str, locus: str, source: str) -> Callable:
    """Register a function that yields what contradicts a place of the thesis; source: the file with the numbers."""

    def register(find: Callable[[Evidence], Iterator[Row]]) -> Callable[[Evidence], Iterator[Row]]:
        ERRATA.append((chapter, locus, source, find))
        return find

    return register


def errata_of_claims(claims: pd.DataFrame, findings: Mapping[str, Finding]) -> list[tuple[str, ...]]:
    """The claims with the verdict `erratum`, in the order of the table, as rows of ERRATA_COLUMNS."""
    found: list[tuple[str, ...]] = []
    for claim in claims[claims["reason"].str.startswith(ERRATUM)].itertuples():
        contradiction = findings[claim.id].contradiction
        assert contradiction is not None, "the verdict is of claims that have one"
        printed, computed = (
            f"{value} {claim.unit}".removesuffix(" -") for value in (claim.published, claim.reproduced)
        )
        about = f"{claim.quantity}: {printed}", contradiction.place, computed, contradiction.check
        found.append((chapter_of(claim.id), claim.locus, *about, f"report/claims.tsv, {claim.id}"))
    return found


@erratum("chapter 2", "Table 2.3", AUDIT)
def departing_run(evidence: Evidence) -> Iterator[Row]:
    """Runs that depart from the generator of the fraction, and what that does to the design."""
    departs = evidence.table(AUDIT, "departs == 'yes'")
    if departs.empty:
        return
    levels = departs[departs["check"] == "runs at each level"]
    shared = departs[departs["check"] == "shared degrees of freedom"]
    apart = evidence.table(CONTESTED, "degrees_of_freedom_if_rival_first > degrees_of_freedom_if_designed")
    effects = [
        in_words(levels, "{subject} is run {found} times at its levels, not {wanted}", "; "),
        in_words(shared, "{subject} share {found} degrees of freedom", "; "),
        in_words(
            apart,
            "{term} after {rival} has {degrees_of_freedom_if_rival_first} degrees of freedom, and would have "
            "{degrees_of_freedom_if_designed} without this departure",
            "; ",
        ),
    ]
    for row in departs[departs["check"].str.startswith("generator")].itertuples():
        yield (
            f"{row.subject}: {row.found}",
            f"Sec. 2.2.5, the {row.check}",
            row.wanted,
            f"{row.note}. So the design is not orthogonal: {'; '.join(filter(None, effects))}.",
        )


@erratum("chapter 2", "Table 2.2", LITERATURE)
def contradicting_studies(evidence: Evidence) -> Iterator[Row]:
    """Entries of Tables 2.1 and 2.2 that contradict others of the same study."""
    for row in evidence.table(LITERATURE, f"verdict == '{DIFFERS}'").itertuples():
        yield (
            f"reference {row.reference}, {row.check}: {row.reported:g}",
            "other entries of the same study",
            f"{row.follows:.3g}",
            "as printed" if pd.isna(row.note) else row.note,
        )


@erratum("chapter 3", "Table 3.5", PRINTED)
def contact_set_of_the_revolutions(evidence: Evidence) -> Iterator[Row]:
    """The means that the table implies differ between the sizes as the text says for the other contact set."""
    if not {"3.size.steel.t", "3.size.calibrated.n"} <= set(evidence.printed.index):
        return
    steel, calibrated = (float(evidence.printed[name]) for name in ("3.size.steel.t", "3.size.calibrated.n"))
    normal, tangential = (implied_difference(evidence.printed, letter) for letter in ("n", "t"))
    if abs(tangential - steel) > SIZES_PP or abs(normal - calibrated) < SIZES_PP:
        return
    yield (
        "standard deviations and variations of 10 and 5 mm balls; the contact set is not named",
        f"Sec. 3.3.1: with calibrated contacts the normal means differ by {calibrated:g} % and the tangential ones do "
        f"not, with clean steel these differ by {steel:g} %",
        f"normal {normal:+.0f} %, tangential {tangential:+.0f} %",
        "means are standard deviations over variations, 10 over 5 mm, over four speeds: what the text says for clean "
        "steel. If the table is of calibrated contacts (it does not say), table and text cannot both hold"
        + _nearer_set(evidence),
    )


def _nearer_set(evidence: Evidence) -> str:
    """How far our means are from those of Table 3.5 with either contact set, in words; empty without both."""
    found = {contact: misfit_of_the_revolutions(evidence, contact) for contact in (CONTACT, "steel")}
    if None in found.values():
        return ""
    told = " and ".join(f"{value:.0f} % with the contact set {name}" for name, value in found.items())
    return f". Our own means are off those of the table by {told} (root mean square)"


@erratum("chapter 4", "Table 4.3", REPORTED)
def time_of_the_prior_art(evidence: Evidence) -> Iterator[Row]:
    """The milling time of the study that is compared with is another one in chapter 2."""
    prior, told = PartitionConfig.prior, "4.prior.time"
    reported_h = datum(evidence, REPORTED, "reference", PRIOR_REFERENCE, "time_h")
    if told not in evidence.printed.index or reported_h == prior.time_h:
        return
    change = float(evidence.printed[told])
    this_h = prior.time_h * (1 + change / 100)
    yield (
        f"milling time of Chen et al., 2017: {prior.time_h:g} h, so that ours is {change:g} %",
        f"Table 2.2, reference {PRIOR_REFERENCE} of chapter 2: {reported_h:g} h",
        f"{change_percent(reported_h, this_h):.0f} %",
        f"{this_h:.1f} h against {reported_h:g} h, if both are the same study, as its authors, year, yield, speed and "
        "ball-to-powder ratio say",
    )


@erratum("chapter 5", "Table 5.1", SCREENING)
def energies_of_the_screening(evidence: Evidence) -> Iterator[Row]:
    """At one fill ratio the energies go with the square of the speed (Eq. 3.28), to the printed digit."""
    columns = ["speed_rpm", "normal_energy_uJ", "tangential_energy_uJ"]
    runs = read_measured(evidence.data / "screening.tsv", list(map(Number, columns)))
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
            yield (
                f"{name} energy of a collision at {speed:g} rpm: {levels[speed]:g} microjoules",
                "the other speeds of Table 5.1, by Eq. 3.28",
                f"{low:.1f} to {high:.1f} microjoules",
                f"the energies of one fill ratio go with omega^2 (Eq. 3.28); {given} rpm agree with each other to the "
                f"printed digit, and the entry is {off:+.1f} % off what follows from them",
            )


@erratum("chapter 6", "Table 6.3, Sec. 6.2.4", TRAINING_RUNS)
def connectivity_radius(evidence: Evidence) -> Iterator[Row]:
    """A connectivity radius below the distance of two balls in contact."""
    runs = evidence.table(TRAINING_RUNS)
    if runs.empty:
        return
    diameters, overlaps = runs["ball_diameter_m"], runs["max_overlap_fraction"]
    nearest = (diameters * (1 - overlaps / 2)).min()
    yield (
        f"balls are joined where their centres are within r_c = {BALL_THRESHOLD_M:g} m",
        f"Table 6.1, balls of {1e3 * diameters[0]:g} mm",
        f"centres never come nearer than {nearest:.5f} m",
        f"ball diameter {diameters[0]:g} m less the deepest overlap of {len(runs)} run(s), "
        f"{100 * overlaps.max():.2f} % of a radius: {nearest / BALL_THRESHOLD_M:.1f} times r_c, so that no ball-ball "
        "edge ever exists; as a gap between surfaces r_c works",
    )


@erratum("chapter 6", "Sec. 6.2.4", WALL_CONTACTS)
def side_of_the_snap_back(evidence: Evidence) -> Iterator[Row]:
    """The side of the snap-back threshold on which overlaps are deep."""
    table = evidence.table(WALL_CONTACTS)
    if table.empty:
        return
    shallow = 100 - 100 * covered_share(table, SNAP_BACK_M)
    yield (
        f"deeper overlaps have phi < phi_sb = {SNAP_BACK_M:g} m",
        "Sec. 6.2.4, phi is negative inside",
        "deeper overlaps have phi > phi_sb",
        f"phi is negative inside and -(radius - overlap) at a contact, so it rises with the overlap. As printed, "
        f"{shallow:.2f} % of the {int(table['contacts'].sum())} wall contacts of the training snapshots would be deep "
        "overlaps, and every ball off the wall as well",
    )


def collect_errata(
    results: str | Path, data: str | Path, claims: pd.DataFrame, findings: Mapping[str, Finding]
) -> pd.DataFrame:
    """Every erratum by chapter: those among the claims, then what no claim states. Columns: ERRATA_COLUMNS.

    results: the folder of the run; data: that of the measured tables; claims, findings: what
    `tabulate_claims` and `collect_findings` return. A contradiction whose tables the run did not write is left out.
    """
    found = errata_of_claims(claims, findings)
    evidence = Evidence(Path(results), Path(data), claims.set_index("id")["published"])
    for chapter, locus, source, find in ERRATA:
        found += [(chapter, locus, *contradiction, source) for contradiction in find(evidence)]
    return pd.DataFrame(found, columns=ERRATA_COLUMNS).sort_values("chapter", kind="stable", ignore_index=True)

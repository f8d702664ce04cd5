"""The claims on one page: verdicts by chapter, and every erratum with its calculation."""

import pandas as pd

from millprint.claims.compare import DEVIATES, ERRATUM, NOT_RUN, REPRODUCED, VERDICTS
from millprint.figures.claims import VERDICT_COLOURS
from millprint.pages import embed_files, render_page
from millprint.report.tables import FOLDER, Section

MEANINGS = {
    REPRODUCED: "within the tolerance of the claim",
    ERRATUM: "the computation shows that the printed value cannot be right",
    DEVIATES: "outside the tolerance; the table says by how much and what is known of why",
    NOT_RUN: "this configuration leaves out what the claim needs",
}
WORST = 15
DEVIATION_COLUMNS = ["id", "locus", "quantity", "published", "unit", "reproduced", "deviation", "explanation"]


def _bars(counts: pd.DataFrame) -> list[dict]:
    """A bar for each chapter, with the fraction of each verdict."""
    bars = []
    for row in counts.to_dict("records"):
        parts = [
            {"name": name, "count": row[name], "colour": VERDICT_COLOURS[name], "share": row[name] / row["claims"]}
            for name in VERDICTS
            if row[name]
        ]
        said = ", ".join(f"{part['count']} {part['name']}" for part in parts)
        bars.append({"chapter": row["chapter"], "claims": row["claims"], "parts": parts, "said": said})
    return bars


def largest_deviations(claims: pd.DataFrame, count: int = WORST) -> pd.DataFrame:
    """The claims that deviate, words first, then numbers by the size of their deviation [%], largest first."""
    found = claims[claims["verdict"] == DEVIATES]
    size = pd.to_numeric(found["deviation"]).abs()
    return found.loc[size.sort_values(ascending=False, na_position="first").index, DEVIATION_COLUMNS].head(count)


def _with_source(errata: pd.DataFrame) -> pd.DataFrame:
    """The errata with the table that the numbers are in at the end of the calculation."""
    told = [f"{row.calculation.rstrip('.')} ({row.source})." for row in errata.itertuples()]
    return errata.drop(columns="source").assign(calculation=told)


def summary_page(name: str, claims: pd.DataFrame, counts: pd.DataFrame, errata: pd.DataFrame) -> str:
    """The page of the run `name`; claims, counts and errata as tabulate_claims, count_verdicts, collect_errata give."""
    deviating = int(counts[DEVIATES].sum())
    shown = min(deviating, WORST)
    sections = [
        Section(
            "Errata",
            _with_source(errata),
            f"{len(errata)} printed statements that a computation of this run contradicts, with the calculation and "
            "the table that its numbers are in.",
            cards=True,
        ),
        Section(
            "Largest deviations",
            largest_deviations(claims),
            f"{shown} of {deviating} claims that deviate, statements first; deviation in per cent of the printed "
            "value. The table of all claims has the rest.",
            cards=True,
        ),
    ]
    return render_page(
        FOLDER / "summary.html",
        title="Which numbers of the thesis hold",
        introduction=f"Run {name}: the {len(claims)} numbers and statements of the thesis, computed anew from its "
        "measured data and its methods, and held against what is printed.",
        verdicts=[
            {"name": key, "meaning": MEANINGS[key], "colour": VERDICT_COLOURS[key], "count": int(counts[key].sum())}
            for key in VERDICTS
        ],
        bars=_bars(counts),
        sections=[section for section in sections if len(section.frame)],
        style=embed_files(FOLDER, "page.css"),
        script=embed_files(FOLDER, "tables.js"),
    )

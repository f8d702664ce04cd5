"""The page of a run: its runtimes, claims and conclusions."""

import re
from pathlib import Path

import pandas as pd
from markupsafe import Markup

from millprint.estimate.judge import AGREES, DIFFERS, OPEN
from millprint.report.table_pages import FOLDER, Section, section_id, tables_page
from millprint.run.files import read_table
from millprint.run.html_pages import embed_files, render_page
from millprint.run.outputs import listed_tables
from millprint.thesis.claims.conclusions import HOLDINGS, HOLDS, deviating_everywhere, in_prose
from millprint.thesis.claims.evidence import ERRATUM, NATURES, Finding
from millprint.thesis.claims.tabulate import INTERVAL_PARTS, JAR_COLUMNS, count_natures, count_verdicts

RUNTIME_COLUMNS = ["stage", "job", "wall_s", "processor_s", "memory_MB"]
# The line that millprint.run.job writes at the end of a job.
DONE = re.compile(r": done in ([\d.]+) s$", re.MULTILINE)

# The templates of these pages.
OWN = Path(__file__).parent


def _row(folder: Path, path: Path, **times: float) -> dict:
    inside = path.relative_to(folder).with_suffix("")
    return {"stage": inside.parts[0], "job": "/".join(inside.parts[1:]) or inside.name, **times}


def _benchmarks(folder: Path) -> list[dict]:
    found = []
    for path in sorted(folder.rglob("*.tsv")):
        table = read_table(path, numeric=["s", "cpu_time", "max_rss"])
        row = table.iloc[-1]
        found.append(_row(folder, path, wall_s=row["s"], processor_s=row["cpu_time"], memory_MB=row["max_rss"]))
    return found


def _logs(folder: Path) -> list[dict]:
    found = []
    for path in sorted(folder.rglob("*.log")):
        times = DONE.findall(path.read_text(errors="replace"))
        if times:
            found.append(_row(folder, path, wall_s=float(times[-1])))
    return found


def tabulate_runtimes(benchmarks: Path, logs: Path) -> pd.DataFrame:
    """A row for every job that has ended: stage, job, wall_s and, of those with a benchmark, processor_s, memory_MB.

    benchmarks: the folder of Snakemake's benchmark files; logs: that of the jobs' own logs, laid out alike.
    """
    rows = _benchmarks(Path(benchmarks))
    known = {(row["stage"], row["job"]) for row in rows}
    rows += [row for row in _logs(Path(logs)) if (row["stage"], row["job"]) not in known]
    table = pd.DataFrame(rows, columns=RUNTIME_COLUMNS)
    return table.sort_values(["stage", "job"], ignore_index=True)


def sum_stages(runtimes: pd.DataFrame) -> pd.DataFrame:
    """Jobs, wall time and processor time [min] of every stage, and the longest job."""
    groups = runtimes.groupby("stage", sort=False)
    longest = runtimes.loc[groups["wall_s"].idxmax()].set_index("stage")
    return pd.DataFrame(
        {
            "jobs": groups.size(),
            "wall_min": groups["wall_s"].sum() / 60,
            "processor_min": groups["processor_s"].sum(min_count=1) / 60,
            "longest_job": longest["job"],
            "longest_s": longest["wall_s"],
        }
    ).reset_index()


# Colour of a verdict, and what it means.
SHOWN_VERDICTS = {
    AGREES: ("#009E73", "the value is within the tolerance of the claim"),
    DIFFERS: ("#D55E00", "outside the tolerance; the table says by how much and what is known of why"),
    OPEN: ("#BBBBBB", "not run: this configuration leaves out what the claim needs"),
}
LARGEST_COUNT = 15
DEVIATION_COLUMNS = ["id", "locus", "quantity", "published", "unit", "reproduced", "deviation", "explanation"]
# Pages of the tables, by the path of a table under the results folder.
PAGES = {
    table.path: f"tables_{chapter}.html#{section_id(table.title)}"
    for chapter, tables in listed_tables().items()
    for table in tables
}


def _bars(counts: pd.DataFrame) -> list[dict]:
    """A bar for each chapter, with the fraction of each verdict."""
    bars = []
    for row in counts.to_dict("records"):
        parts = [
            {"name": name, "count": row[name], "colour": colour, "share": row[name] / row["claims"]}
            for name, (colour, _) in SHOWN_VERDICTS.items()
            if row[name]
        ]
        said = ", ".join(f"{part['count']} {part['name']}" for part in parts)
        bars.append({"chapter": row["chapter"], "claims": row["claims"], "parts": parts, "said": said})
    return bars


def largest_deviations(claims: pd.DataFrame, count: int = LARGEST_COUNT) -> pd.DataFrame:
    """The claims whose value differs, without errata: words, then numbers by their deviation [%], largest first."""
    found = claims[(claims["verdict"] == DIFFERS) & ~claims["reason"].str.startswith(ERRATUM)]
    size = pd.to_numeric(found["deviation"]).abs()
    return found.loc[size.sort_values(ascending=False, na_position="first").index, DEVIATION_COLUMNS].head(count)


def link_to(path: str, results: Path) -> Markup:
    """A file of the results as a link from report/: to where a page shows it, else to itself; text if it is absent."""
    if not (results / path).is_file():
        return Markup.escape(path)
    return Markup('<a href="{}">{}</a>').format(PAGES.get(path, f"../{path}"), path)


def _with_source(explanation: str, tolerance: str, finding: Finding, results: Path) -> Markup:
    """The explanation of a claim, then a fold with the tolerance of its verdict and its sources."""
    sources = Markup("; ").join(link_to(source.path, results) + source.details for source in finding.sources)
    fold = Markup("<details><summary>source</summary>tolerance: {}; from {}</details>")
    return Markup.escape(explanation) + fold.format(tolerance, sources or "no file")


def claims_page(name: str, claims: pd.DataFrame, findings: dict[str, Finding], results: Path) -> str:
    """The page of every claim; claims and findings as tabulate_claims and collect_findings give, of the run `name`."""
    explanations = [
        _with_source(claim.explanation, claim.tolerance, findings[claim.id], results) for claim in claims.itertuples()
    ]
    # Of type object, as pandas would make plain text of it.
    shown = claims.assign(explanation=pd.Series(explanations, dtype=object, index=claims.index))
    # In one cell with the value: the page is no wider than a screen.
    origin = (claims["repeats"] + " of ").where(claims["repeats"] != "", "") + claims["interval_from"]
    interval = " (" + claims["lower"] + " to " + claims["upper"] + ", " + origin + ")"
    shown["reproduced"] += interval.where(claims["interval_from"] != "", "")
    jars = "; other jars " + claims["jars_lower"] + " to " + claims["jars_upper"] + ", " + claims["jars_meeting"]
    shown["reproduced"] += jars.where(claims["jars_meeting"] != "", "")
    shown["nature"] = claims["nature"].str.replace("_", " ")
    shown = shown.drop(columns=["basis", "tolerance", "source", *INTERVAL_PARTS, *JAR_COLUMNS])
    introduction = f"What the run {name} computed for each claim, and its verdicts. {count_natures(claims)}."
    sections = [Section("Every claim", shown, cards=True)]
    return tables_page("Claims of the thesis", introduction, sections, template=OWN / "claims.html")


def what_falls(claims: pd.DataFrame, conclusions: pd.DataFrame, stored: pd.DataFrame, run: str) -> list[str]:
    """The conclusions with claims that stand on no machine, a sentence each.

    claims as tabulate_claims, conclusions as judge_conclusions, stored as read_stored.
    """
    names = deviating_everywhere(claims, stored, run)
    sentences = []
    for row in conclusions.itertuples():
        own = [name for name in row.against.split(", ") if name in names]
        if own:
            some = f"Of its {row.claims} claims, these are reproduced nowhere"
            how = some if len(own) < row.claims else "Nothing of it is reproduced anywhere"
            told = "; ".join(in_prose(name, claims) for name in own)
            sentences.append(f"{_capital(row.chapter)}: {row.conclusion} {how}: {told}.")
    return sentences


def front_text(conclusions: pd.DataFrame, falls: list[str], first: dict[str, str]) -> str:
    """What the first page of the report says for each chapter, as reStructuredText.

    conclusions as judge_conclusions, falls as what_falls; first: the first sentence of a chapter that has one of its
    own.
    """
    lines = ["**Which conclusions of the thesis hold**", ""]
    for chapter, own in conclusions.groupby("chapter", sort=False):
        groups = {words: own[own[HOLDS] == word] for word, words in HOLDINGS.items() if (own[HOLDS] == word).any()}
        told = ", ".join(f"{words}: {len(group)}" for words, group in groups.items())
        begin = f": {_plain(first[str(chapter)])}" if chapter in first else ","
        lines += [f"- **{_capital(str(chapter))}**{begin} {len(own)} conclusions; {told}.", ""]
        for words, group in groups.items():
            told = " ".join(f"{row.conclusion.rstrip('.')} ({row.reason})." for row in group.itertuples())
            lines += [f"  - *{words.capitalize()}*: {_plain(told)}", ""]
    lines += ["**What stands on no machine**", "", *(f"- {_plain(sentence)}\n" for sentence in falls)]
    return "\n".join(lines if falls else lines[:-2]) + "\n"


def _capital(words: str) -> str:
    return words[0].upper() + words[1:]


def _plain(text: str) -> str:
    """Text in which no sign has a meaning in reStructuredText."""
    return re.sub(r"([\\*`|_])", r"\\\1", text)


def summary_page(
    name: str, claims: pd.DataFrame, conclusions: pd.DataFrame, errata: pd.DataFrame, results: Path, told: list[str]
) -> str:
    """The page of the run `name`; tables as tabulate_claims, judge_conclusions and collect_errata give.

    told: sentences below the conclusions: what stands on no machine, as what_falls gives, and other machines.
    """
    counts = count_verdicts(claims)
    natures = count_verdicts(claims, "nature")
    natures["nature"] = natures["nature"].map(NATURES)
    largest = largest_deviations(claims, len(claims))
    linked = [
        Markup("{} ({}).").format(row.calculation.rstrip("."), link_to(row.source, results))
        for row in errata.itertuples()
    ]
    errata = errata.drop(columns="source").assign(calculation=pd.Series(linked, dtype=object, index=errata.index))
    shown = {
        "natures": Section("What the claims are", natures),
        "errata": Section("Errata", errata, cards=True),
        "largest": Section("Largest deviations", largest.head(LARGEST_COUNT), cards=True),
    }
    return render_page(
        OWN / "summary.html",
        title="Which conclusions of the thesis stand",
        introduction=f"Run {name}: the conclusions of the thesis and the {len(claims)} numbers and statements that "
        "they rest on, computed again from its measured data and its methods, and compared with what is printed.",
        first=Section("What stands", conclusions, cards=True),
        told=told,
        counted=count_natures(claims),
        deviating=len(largest),
        verdicts=[
            {"name": key, "meaning": meaning, "colour": colour, "count": int(counts[key].sum())}
            for key, (colour, meaning) in SHOWN_VERDICTS.items()
        ],
        bars=_bars(counts),
        sections={name: section for name, section in shown.items() if len(section.frame)},
        style=embed_files(FOLDER, "page.css"),
        script=embed_files(FOLDER, "tables.js"),
    )

"""Tables of runs that pages print: stored with processor, commit and date, and told as Markdown."""

import platform
import textwrap
from collections.abc import Callable, Iterable
from pathlib import Path

import pandas as pd
from llvmlite import binding

from millprint.config.setup_models import FILES
from millprint.estimate.judge import AGREES, DIFFERS, NOT_RUN
from millprint.fingerprint.coverage import NEW
from millprint.run.files import read_table, write_table
from millprint.run.machine import commit
from millprint.run.numbers import prefix_of
from millprint.thesis.claims.conclusions import MACHINE
from millprint.thesis.surrogate.measures import against_baselines, told_against
from millprint.thesis.yields.features import LEFT_OUT, NESTED
from millprint.thesis.yields.regressors import AVERAGED, SURFACE, TITLES
from millprint.validation.measured import read_measurements
from millprint.validation.setups import setup_named
from millprint.validation.verdicts import EVERY, tabulate_coverage

MEASURED = "config/data/measured.tsv"
MADE, TIMINGS, PHYSICS = "config/fingerprints/made.tsv", "benchmarks/timings.tsv", "benchmarks/physics.tsv"
BASELINES, VALIDATION, YIELDS, STEPS, JAR, BANDS = (
    f"docs/why/{name}.tsv"
    for name in (
        "surrogate_baselines",
        "validation_verdicts",
        "yield_scores",
        "convergence",
        "jar_fit",
        "band_coverage",
    )
)
TIMES, FIRST_HOUR = "docs/how_to/run_times.tsv", "docs/first_hour.tsv"
R2, CRPS, MINUS, BY_CHANCE = "r2", "crps_pp", "r2 minus that of ", "p of shuffled yields"
LEVELS = (0.5, 0.8, 0.95)


# The widest vector instructions of a processor, which decide in which order sums are taken; widest first.
INSTRUCTIONS = {"avx512f": "AVX-512", "avx2": "AVX2", "avx": "AVX", "sve": "SVE", "neon": "NEON"}


def this_machine(date: str, results: str | Path) -> dict[str, str]:
    """The processor of this machine, its vector instructions, the commit of the tree of a run, and a date, by MACHINE.

    results: the folder of the run.
    """
    features = binding.get_host_cpu_features()
    widest = next((title for name, title in INSTRUCTIONS.items() if features.get(name)), platform.machine())
    # The first characters of 40, and whether files had changed.
    code = commit(results)
    return dict(zip(MACHINE, (binding.get_host_cpu_name(), widest, code[:8] + code[40:], date), strict=True))


def of_baselines(results: Path) -> pd.DataFrame:
    """What the networks and their baselines were off by."""
    return read_table(results / "surrogate/baselines.tsv")


def of_validation(results: Path) -> pd.DataFrame:
    """The verdicts on the measured numbers that this run predicted."""
    table = read_table(results / "validation/verdicts.tsv")
    return table[table["reason"] != NOT_RUN]


def of_yields(results: Path) -> pd.DataFrame:
    """A row for each number of the yield models by both whole schemes: scores, differences, and what intervals hold."""
    scores, distributions, differences, coverage, shuffles = (
        read_table(results / f"yield/{name}.tsv")
        for name in ("scores_by_scheme", "scores", "differences", "coverage", "permutation_test")
    )
    against = MINUS + differences["against"]
    # Each of many models is compared with one.
    differences = differences.drop(columns="p").rename(columns={"difference": "value", "p_holm": "p"})
    chance = {"model": AVERAGED, "strategy": "primary", "scheme": LEFT_OUT, "measure": BY_CHANCE}
    parts = [
        scores[scores["metric"] == R2].rename(columns={"metric": "measure"}),
        distributions[distributions["score"] == CRPS].rename(columns={"score": "measure"}),
        differences[differences["metric"] == R2].assign(measure=against),
        coverage.assign(measure="held " + coverage["nominal"].astype(str)).rename(columns={"covered": "value"}),
        shuffles.assign(**chance).rename(columns={"p": "value", "permutations": "repeats"}),
    ]
    numbers = ["value", "error", "p", "width_pp", "repeats", "lowest", "median", "highest"]
    table = pd.concat(parts, ignore_index=True)[["model", "strategy", "scheme", "measure", *numbers]]
    return table[table["scheme"].isin([LEFT_OUT, NESTED])].reset_index(drop=True)


def of_convergence(results: Path) -> pd.DataFrame:
    """What time step and Young's modulus change in the thesis's mill."""
    changes = [
        f"{name}_deviation_{part}"
        for name in ("normal_power", "tangential_power", "wall_power")
        for part in ("percent", "se_percent")
    ]
    about = ["mill", "contact", "ball_diameter_mm", "fill_ratio", "speed_rpm", "seeds"]
    about += ["time_step_s", "rayleigh_fraction", "young_modulus_gpa", "closure_worst"]
    parts = {name: read_table(results / f"convergence/{name}.tsv") for name in ("timestep", "modulus")}
    return pd.concat([part[[*about, *changes]].assign(changed=name) for name, part in parts.items()], ignore_index=True)


def of_jar(results: Path) -> pd.DataFrame:
    """What the jar was fitted to and what was held back over a whole run, and the misfits of jars that fit as well."""
    table, jars = (read_table(results / f"fingerprint/{name}.tsv") for name in ("fit", "equal_jars"))
    columns = ["record", "parameter_value", "name", "quantity", "fill_ratio", "ball_diameter_mm", "speed_rpm", "role"]
    jars["name"], again = jars["jar"].astype(str) + " " + jars["counting_rule"], jars["again_misfit"].notna()
    roles = {"fitted": "again_misfit", "held back": "again_held_back_misfit"}
    parts = [
        jars[again].rename(columns={name: "parameter_value"}).assign(record="equal jar", role=role)
        for role, name in roles.items()
    ]
    own = table[table["record"].isin(["misfit", "value"])]
    return pd.concat([own, *parts], ignore_index=True)[[*columns, "published", "ours", "error_percent"]]


def of_times(results: Path) -> pd.DataFrame:
    """Processor time of the rules of a run, the longest first."""
    jobs = read_table(results / "report/runtimes.tsv").dropna(subset="processor_s").groupby("stage")["processor_s"]
    times = pd.DataFrame({"jobs": jobs.size(), "processor_min": jobs.sum() / 60}).rename_axis("rule").reset_index()
    return times.sort_values("processor_min", ascending=False)


def of_bands(results: Path) -> pd.DataFrame:
    """How often the bands of mills held new simulations."""
    found = [read_table(path).assign(mill=path.parent.name) for path in sorted(results.glob("mills/*/coverage.tsv"))]
    table = pd.concat(found, ignore_index=True)
    return table[table["left_out"] == NEW]


def of_first_hour(results: Path) -> pd.DataFrame:
    """The numbers of the planetary mill's page, with SI prefixes as the page has them."""
    table = read_table(results / "mills/planetary/fingerprint.tsv").dropna(subset="value")
    numbers = pd.to_numeric(table["value"], errors="coerce")
    table, numbers = table[numbers.notna()], numbers.dropna()
    factors, units = zip(*map(prefix_of, numbers, table["unit"].fillna("")), strict=True)
    ends = {name: pd.to_numeric(table[name]) * factors for name in ("lower", "upper")}
    return table.assign(value=numbers * factors, **ends, unit=units)


# By stored table: the file of a run that it is made of, what it has of the folder of the run, and the column whose
# values in a run take the place of earlier rows.
STORED: dict[str, tuple[str, Callable[[Path], pd.DataFrame], str]] = {
    BASELINES: (
        "surrogate/baselines.tsv",
        lambda results: read_table(results / "surrogate/baselines.tsv"),
        "processor",
    ),
    VALIDATION: ("validation/verdicts.tsv", of_validation, "setup"),
    YIELDS: ("yield/scores.tsv", of_yields, "processor"),
    STEPS: ("convergence/timestep.tsv", of_convergence, "changed"),
    JAR: ("fingerprint/fit.tsv", of_jar, "record"),
    TIMES: ("report/runtimes.tsv", of_times, "processor"),
    FIRST_HOUR: ("mills/planetary/fingerprint.tsv", of_first_hour, "section"),
    BANDS: ("mills/planetary/coverage.tsv", of_bands, "mill"),
    TIMINGS: ("dem.tsv", lambda results: read_table(results / "dem.tsv").drop(columns="wall"), "processor"),
    PHYSICS: ("physics.tsv", lambda results: read_table(results / "physics.tsv"), "processor"),
}
# Only of the run of docs/first_hour.md.
OF_FIRST_HOUR = (FIRST_HOUR, BANDS)


def store_tables(results: Path, machine: dict[str, str]) -> list[str]:
    """Put the tables that the run in the folder `results` has in the place of the stored ones; returns which."""
    done = []
    for path, (needed, made, replaced) in STORED.items():
        if (results / needed).exists() and (results.name == "first_hour" or path not in OF_FIRST_HOUR):
            own = made(results).assign(**machine)
            earlier = read_table(path) if Path(path).exists() else own.iloc[:0]
            earlier = earlier[~earlier[replaced].isin(own[replaced])]
            write_table(pd.concat([earlier, own], ignore_index=True), path)
            done.append(path)
    return done


def newest(root: Path, path: str) -> pd.DataFrame:
    """The rows of a stored table of the processor that ran last."""
    table = read_table(root / path).sort_values("date", kind="stable")
    return table[table["processor"] == table["processor"].iloc[-1]]


def places(table: pd.DataFrame) -> str:
    """Where and when the rows of a stored table were made, in words."""
    rows = table[MACHINE].astype(str).drop_duplicates().itertuples(index=False)
    return "; ".join(f"{row.processor}, {row.instructions}, commit {row.commit}, {row.date}" for row in rows)


def in_markdown(head: list[str], rows: Iterable[Iterable[object]]) -> str:
    """A table as Markdown."""
    lines, bar = [head, ["---"] * len(head), *rows], "\\|"
    return "\n".join(f"| {' | '.join(str(cell).replace('|', bar) for cell in line)} |" for line in lines)


def told(*parts: str) -> str:
    """Paragraphs, filled to the width of a page."""
    return "\n\n".join(part if part.startswith("|") else textwrap.fill(part, 120) for part in parts)


def of_verdicts(root: Path) -> str:
    """What is met of each quantity of each set-up, and how often intervals hold."""
    table = read_table(root / VALIDATION)
    rows = []
    for (setup, quantity, kind), own in table.groupby(["setup", "quantity", "class"], sort=False):
        if own["predicted"].isna().all():
            continue
        differs = own["verdict"] == DIFFERS
        explained = int(own.loc[differs, "explanation"].str.startswith("met by").sum())
        ratio = own["ratio"].dropna()
        spread = "" if ratio.empty else _span(ratio.min(), ratio.max())
        counts = len(own), int((own["verdict"] == AGREES).sum()), int(differs.sum()), explained
        rows.append((setup_named(str(setup)).title, quantity, kind, *counts, spread))
    head = ["set-up", "quantity", "compared with", "numbers", "agree", "differ", "explained", "ours over theirs"]
    held = [
        [
            EVERY if row.setup == EVERY else setup_named(row.setup).title,
            row.interval,
            row.held,
            row.numbers,
            f"{row.share:.2f}, {row.lower:.2f} to {row.upper:.2f}",
            row.overlapping,
        ]
        for row in tabulate_coverage(table).itertuples()
    ]
    held_head = ["set-up", "interval by", "held", "of", "share, 95 % interval", "reached by the measured interval"]
    words = "`explained`: by another contact law or contact set, of those that differ."
    measured = set(read_measurements(root / MEASURED, FILES)["setup"]) - set(table["setup"])
    lacking = "; ".join(setup_named(name).title for name in FILES if name in measured)
    missing = f" Not run since then: {lacking}." if lacking else ""
    return told(f"Of runs on {places(table)}. {words}{missing}", in_markdown(head, rows), in_markdown(held_head, held))


def _span(lower: float, upper: float) -> str:
    """Two numbers, or one where they are printed alike."""
    ends = [f"{end:.2f}" for end in (lower, upper)]
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


# Rows and columns of the tables of docs/why/surrogate.md, by the names in BASELINES.
TESTS = {"trained": "of the training", "motion1": "unseen: motion 1", "motion2": "unseen: motion 2",
         "post": "unseen: jar with a post"}  # fmt: skip
MODELS = {
    "thesis": "networks", "no_network": "no network", "scaled_power": "scaled power", "scaled_motion": "scaled motion",
    "long_step": "DEM, step of 8e-6 s", "other_seed": "another seed of the DEM",
}  # fmt: skip


def longest_rollouts(root: Path) -> pd.DataFrame:
    """What the networks and their baselines were off by in the newest run, over the longest roll-outs."""
    own = newest(root, BASELINES)
    return own[own["length_s"] == own["length_s"].max()]


def of_networks(root: Path) -> str:
    """Whether a network beats what needs none."""
    return told(told_against(against_baselines(longest_rollouts(root), "thesis")))


def of_rollouts(root: Path) -> str:
    """The longest roll-outs of networks and baselines in three tables."""
    own = longest_rollouts(root)
    printed = own.groupby("test")["thesis_percent"].first()

    def table(column: str, last: dict[str, str] | None = None) -> str:
        text = (
            own[column].map("{:.3g}".format).mask(own[column].isna(), "none").mask(own["ran_away"] == "yes", "ran away")
        )
        cells = text.groupby([own["test"], own["model"]]).agg(", ".join)
        lines = [
            [words, *(cells[test, model] for model in MODELS), *([last[test]] if last else [])]
            for test, words in TESTS.items()
        ]
        return in_markdown(["motion", *MODELS.values(), *(["printed in the thesis"] if last else [])], lines)

    stated = {test: "not stated" if pd.isna(printed[test]) else f"{printed[test]:g}" for test in TESTS}
    return told(
        f"A whole run on {places(own)}, each test over {own['length_s'].iloc[0]:g} s. Error of the dissipated energy "
        "in per cent, a number for each training:",
        table("dissipation_error_percent", stated),
        "A small error of a sum can be two errors that cancel. Mean square speed of the balls over the DEM's:",
        table("mean_square_speed_ratio"),
        "Pearson's r between the energies dissipated in each 5 ms and the DEM's (`none`: the power is constant):",
        table("increments_5ms_r"),
    )


def of_models(root: Path) -> str:
    """Scores of every yield model by both schemes, what its intervals hold, and which differences are beyond chance."""
    table = newest(root, YIELDS)
    found = table.set_index(["model", "strategy", "scheme", "measure"])
    models = list(dict.fromkeys(table[["model", "strategy"]].itertuples(index=False, name=None)))
    models.sort(key=lambda model: -float(found.at[(*model, LEFT_OUT, R2), "value"]))

    def score(model: tuple[str, str], scheme: str, measure: str, digits: int, error: bool = False) -> str:
        row = found.loc[(*model, scheme, measure)]
        ends = [f"{row[name]:.{digits}f}" for name in ("lowest", "median", "highest")]
        own = f"{row['value']:.{digits}f}" + (f" ± {row['error']:.{digits}f}" if error else "")
        return own + ("" if ends[0] == ends[2] else f" ({', '.join(ends)})")

    rows, held = [], []
    for model in models:
        name = named(*model)
        rows.append((name, score(model, LEFT_OUT, R2, 2, True), score(model, NESTED, R2, 2), *(
            score(model, scheme, CRPS, 1) for scheme in (LEFT_OUT, NESTED))))  # fmt: skip
        own = [[found.loc[(*model, scheme, f"held {level}")] for level in LEVELS] for scheme in (LEFT_OUT, NESTED)]
        held.append((name, *(", ".join(f"{100 * row['value']:.0f}" for row in each) for each in own),
                     ", ".join(f"{row['width_pp']:.0f}" for row in own[1])))  # fmt: skip
    pairs = [
        (name, scheme, words)
        for name in (AVERAGED, SURFACE)
        for scheme, words in ((LEFT_OUT, "leave-one-out"), (NESTED, "5-fold"))
    ]
    apart = [(named(*model), *(minus(found, model, name, scheme) for name, scheme, _ in pairs)) for model in models]
    orders = found.xs(R2, level="measure").groupby("scheme")["repeats"].max()
    chance = table[table["measure"] == BY_CHANCE].iloc[0]
    return told(
        f"Of a whole run on {places(table)}: leave-one-out in {orders[LEFT_OUT]:.0f} orders of the rows, and "
        f"{orders[NESTED]:.0f} shuffles of the 5 folds, with (lowest, median, highest) over them where they differ. "
        "After ± is a jackknife error over the runs. CRPS is in points of yield.",
        in_markdown(["model", "R2, leave-one-out", "R2, 5-fold", "CRPS, leave-one-out", "CRPS, 5-fold"], rows),
        "Runs that each model's own intervals of 50, 80 and 95 % hold, in per cent:",
        in_markdown(["model", "leave-one-out", "5-fold", "their mean widths, 5-fold (points)"], held),
        f"R2 minus that of the {TITLES[AVERAGED]} and of the {TITLES[SURFACE]}, with errors of paired tests; a * where "
        "p < 0.05 after Holm's correction for the models of a column:",
        in_markdown(["model", *(f"{TITLES[name]}, {words}" for name, _, words in pairs)], apart),
        f"Of {chance['repeats']:.0f} shuffles of the yields, the best reaches an R2 of {chance['highest']:.2f} (p = "
        f"{chance['value']:.2g} for the measured order, by leave-one-out in closed form).",
    )  # fmt: skip


def minus(found: pd.DataFrame, model: tuple[str, str], reference: str, scheme: str) -> str:
    """R2 of a model minus that of a reference, with a star where a paired test tells them apart at 5 %, corrected."""
    place = (*model, scheme, f"{MINUS}{reference} primary")
    if place not in found.index:
        return ""
    row = found.loc[place]
    return f"{row['value']:+.2f} ± {row['error']:.2f}" + (" *" if row["p"] < 0.05 else "")


def named(model: str, strategy: str) -> str:
    """A yield model in words."""
    return TITLES[model] + (", two steps" if strategy == "two_step" else "")


def of_speed(root: Path) -> str:
    """How many times as long as ours a step of LAMMPS took, on each processor that was timed."""
    table = read_table(root / TIMINGS)
    own = table[table["code"] == "LAMMPS"].round({"ratio_to_us": 1})
    words = []
    for _, rows in own.groupby("processor", sort=False):
        times, balls = (", ".join(map(str, rows[name])) for name in ("ratio_to_us", "balls"))
        words.append(f"{times} times as long with {balls} balls on {places(rows)}")
    return told(f"LAMMPS took {'; '.join(words)}.")


def of_timings(root: Path) -> str:
    """Processor time of a step of a ball in both codes."""
    table = read_table(root / TIMINGS)
    jar = table["case"].str.partition("_")[0] + table["code"].map({"LAMMPS": " LAMMPS"}).fillna("")
    times = table["processor_ns"].map("{:.1f}".format)
    cells = times.groupby([table["processor"], table["balls"], jar], sort=False).first().unstack()
    ratios = table[table["code"] == "LAMMPS"].set_index(["processor", "balls"])
    rows = [
        (processor, balls, *own, f"{row['ratio_to_us']:.1f} ± {row['ratio_95']:.1f}".removesuffix(" ± nan"))
        for ((processor, balls), own), row in zip(
            ((place, cells.loc[place, ["emax", "cylinder", "cylinder LAMMPS"]]) for place in ratios.index),
            ratios.to_dict("records"),
            strict=True,
        )
    ]
    head = ["processor", "balls", "millprint, Emax", "millprint, cylinder", "LAMMPS, cylinder", "ratio"]
    return told(f"{places(table)}; LAMMPS of {table['lammps'].iloc[-1]}.", in_markdown(head, rows))


def of_engines(root: Path) -> str:
    """Means of the same motion by both codes, by contact law."""
    words = {"wall_power_W": "power of the walls (W)", "kinetic_translation_J": "energy of translation (J)",
             "kinetic_spin_J": "energy of spin (J)", "ball_contacts": "contacts of a ball with others"}  # fmt: skip
    table = newest(root, PHYSICS)
    rows = [
        (row.law, words[row.quantity], f"{row.millprint:.4g} ± {row.millprint_95:.2g}",
         f"{row.lammps:.4g} ± {row.lammps_95:.2g}", f"{row.difference_pct:+.1f} ± {row.difference_pct_95:.1f}")
        for row in table[table["quantity"].isin(words)].itertuples()
    ]  # fmt: skip
    differs = " ".join(
        f"`{law}`: both differ {said}." for law, said in table.groupby("law", sort=False)["differs"].first().items()
    )
    return told(
        f"{places(table)}, {table['runs'].iloc[0]} starts of each code, half-widths of 95 %:",
        in_markdown(["law", "mean of", "millprint", "LAMMPS", "difference (%)"], rows),
        differs,
    )


def of_steps(root: Path) -> str:
    """What the time step changes in the thesis's mill."""
    return _changes(root, "timestep", ["step over $t_R$"], lambda row: [f"{row.rayleigh_fraction:.3f}"])


def of_modulus(root: Path) -> str:
    """What Young's modulus changes in the thesis's mill."""
    return _changes(root, "modulus", ["modulus (GPa)"], lambda row: [f"{row.young_modulus_gpa:g}"])


def _changes(root: Path, changed: str, head: list[str], cells: Callable) -> str:
    table = read_table(root / STEPS)
    own = table[table["changed"] == changed]
    first = own.groupby("ball_diameter_mm").cumcount() == 0
    names = {"$P_n$": "normal_power", "$P_t$": "tangential_power", "$P$": "wall_power"}
    rows = []
    for is_first, row in zip(first, own.itertuples(), strict=True):
        changes = (
            "0"
            if is_first
            else f"{getattr(row, f'{name}_deviation_percent'):+.1f} ± "
            f"{getattr(row, f'{name}_deviation_se_percent'):.1f}"
            for name in names.values()
        )
        rows.append([f"{row.ball_diameter_mm:g}", f"{row.fill_ratio:g}", f"{row.speed_rpm:g}", *cells(row),
                     f"{100 * row.closure_worst:.2g}", *changes])  # fmt: skip
    head = ["balls (mm)", "fill ratio", "rpm", *head, "closure (%)", *(f"change of {name} (%)" for name in names)]
    return told(
        f"Of a whole run on {places(own)}: {own['seeds'].iloc[0]} starts in each row, changes against the first row "
        "with standard errors; closure is the largest error of the energy balance over the work of the walls.",
        in_markdown(head, rows),
    )


def of_fitted(root: Path) -> str:
    """What the jar was fitted to, and what a whole run with it has."""
    table = newest(root, JAR)
    values = table[(table["record"] == "value") & ((table["role"] == "fitted") | (table["name"] == "Pn_f0.06"))]
    words = {"Pn": "normal power", "Pt": "tangential power", "f": "collision frequency"}
    words |= {name: f"{name} dissipation in a turn (J)" for name in ("normal", "tangential")}
    rows = [
        (words[row.quantity], f"{row.fill_ratio:g}", row.role, f"{row.published:.3g}", f"{row.ours:.3g}",
         f"{row.error_percent:+.0f}")
        for row in values.itertuples()
    ]  # fmt: skip
    again = table[table["record"] == "equal jar"]
    spans = again.groupby([again["name"].str.partition(" ")[0], "role"])["parameter_value"].agg(["min", "max"])
    jars = spans.apply(lambda row: _span(row["min"], row["max"]), axis=1).unstack()
    misfits = table[table["record"] == "misfit"].set_index("role")["parameter_value"]
    return told(
        f"In a whole run on {places(table)}, whose windows are longer than those of the search, and with all speeds "
        "and ball sizes in the powers:",
        in_markdown(["quantity", "fill ratio", "role", "printed", "ours", "error (%)"], rows),
        "The root mean square of ln(ours / printed) is "
        f"{misfits['fitted']:.2f} over the fitted values and {misfits['held back']:.2f} over all that were held back. "
        "Jars that fit equally well, simulated for a part of that, by the counting rules with which they do:",
        in_markdown(["jar", "fitted values", "held back"], ((jar, *ends) for jar, *ends in jars.itertuples())),
    )


def of_stages(root: Path) -> str:
    """Processor time of a whole run by its longest stages."""
    table = newest(root, TIMES)
    rows = [(f"`{row.rule}`", row.jobs, f"{row.processor_min:.1f}") for row in table.head(8).itertuples()]
    total = f"{table['processor_min'].sum():.0f}"
    rows.append(("all", table["jobs"].sum(), total))
    return told(
        f"A whole run, `make thesis`, on {places(table)}: {total} minutes of a processor by its jobs' benchmarks.",
        in_markdown(["rule", "jobs", "processor min"], rows),
    )


def of_new(root: Path) -> str:
    """How often bands of the mills of the first hour held new simulations."""
    table = newest(root, BANDS)
    words = {"Pw": "power of the walls", "Pn": "$P_n$", "Pt": "$P_t$", "En_star": "$E^*_n$", "Et_star": "$E^*_t$"}
    rows = [
        (row.mill, words[row.quantity], row.held, row.conditions, f"{row.half_width_percent:.2g}",
         f"{row.error_percent:.2g}")
        for row in table[table["quantity"].isin(words)].itertuples()
    ]  # fmt: skip
    head = ["mill", "quantity", "held", "of", "half of the band (%)", "rms error (%)"]
    return told(f"{places(table)}:", in_markdown(head, rows))


def of_widths(root: Path) -> str:
    """How wide the bands of the included mills are at most."""
    table = read_table(root / MADE)
    rows = [
        (row.mill, f"{row.wall_half_percent:.2g}", f"{row.part_half_percent:.2g}", row.version)
        for row in table.itertuples()
    ]
    return in_markdown(["mill", "power of the walls (%)", "its parts (%)", "of version"], rows)


# By name of a block.
BLOCKS: dict[str, Callable[[Path], str]] = {
    "speed": of_speed,
    "timings": of_timings,
    "engines": of_engines,
    "validation": of_verdicts,
    "networks": of_networks,
    "surrogate": of_rollouts,
    "yields": of_models,
    "steps": of_steps,
    "modulus": of_modulus,
    "fitted": of_fitted,
    "stages": of_stages,
    "bands": of_new,
    "widths": of_widths,
}

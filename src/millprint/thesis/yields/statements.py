"""Sentences about the yield models, each computed from the tables that it speaks of."""

import pandas as pd

from millprint.thesis.yields.evaluation import CRPS, LOG_SCORE
from millprint.thesis.yields.library_trials import DECLARED, DIFFERENCE, EARLIER
from millprint.thesis.yields.metrics import LEFT_OUT, NESTED
from millprint.thesis.yields.regressors import AVERAGED, PRIMARY, TITLES, TWO_STEP
from millprint.thesis.yields.retrospective import ALL_TARGETS, CHANCE, IMPROVEMENT, LEARNING, RULE

BOTH = {LEFT_OUT: "leave-one-out", NESTED: "repeated k-fold"}
# The two-step process with the start of the largest marginal likelihood, and with the thesis's search for a start.
STARTS, SEARCHED = "gpr_starts", "gpr"
PAIR = (AVERAGED, PRIMARY), (STARTS, TWO_STEP)


def _title(model: str, strategy: str) -> str:
    return TITLES[model] + (", two-step" if strategy == TWO_STEP else "")


def _one(table: pd.DataFrame, **where: str) -> pd.Series:
    """The only row with these values."""
    for column, value in where.items():
        table = table[table[column] == value]
    (row,) = (each for _, each in table.iterrows())
    return row


def _over_repeats(row: pd.Series, digits: int = 3) -> str:
    """The spread of a score over its repeats, in words; nothing for a score without repeats."""
    if not row["repeats"] > 1:
        return ""
    low, middle, high = (f"{row[name]:.{digits}f}" for name in ("lowest", "median", "highest"))
    return f" ({low} to {high} over {row['repeats']:g} repeats, median {middle})"


def _both_schemes(scores: pd.DataFrame) -> str:
    parts = []
    for model, strategy in PAIR:
        rows = {name: _one(scores, model=model, strategy=strategy, scheme=name, metric="r2") for name in BOTH}
        values = (
            f"{row['value']:.3f} +- {row['error']:.3f} by {BOTH[name]}{_over_repeats(row)}"
            for name, row in rows.items()
        )
        parts.append(f"{_title(model, strategy)}: R2 {' and '.join(values)}")
    return f"{'; '.join(parts)}. Errors are jackknife errors over the runs."


def _told_apart(differences: pd.DataFrame) -> str:
    rows = [_one(differences, model=STARTS, strategy=TWO_STEP, scheme=name, metric="r2") for name in BOTH]
    apart = [row["told_apart"] == "yes" for row in rows]
    values = "; ".join(
        f"{BOTH[row['scheme']]}: {row['difference']:+.3f} +- {row['error']:.3f}{_over_repeats(row)}, p = {row['p']:.2g}"
        for row in rows
    )
    verdict = {
        (True, True): "can be told apart by both schemes",
        (False, False): "cannot be told apart",
        (True, False): f"can be told apart by {BOTH[LEFT_OUT]}, but not by {BOTH[NESTED]}",
        (False, True): f"can be told apart by {BOTH[NESTED]}, but not by {BOTH[LEFT_OUT]}",
    }[apart[0], apart[1]]
    two, averaged = _title(STARTS, TWO_STEP), _title(AVERAGED, PRIMARY)
    return f"The {two} and the {averaged} {verdict} (R2 of the first minus that of the second: {values})."


def _starts(scores: pd.DataFrame, differences: pd.DataFrame) -> str:
    """How much of the score of the thesis's process is lost by its search for a start."""
    parts = []
    for scheme, title in BOTH.items():
        searched, several = (
            _one(scores, model=name, strategy=TWO_STEP, scheme=scheme, metric="r2") for name in (SEARCHED, STARTS)
        )
        against = _one(differences, model=SEARCHED, strategy=TWO_STEP, scheme=scheme, metric="r2")
        apart = "can" if against["told_apart"] == "yes" else "cannot"
        parts.append(
            f"{title}: R2 {searched['value']:.3f}{_over_repeats(searched)} with the searched start, "
            f"{several['value']:.3f}{_over_repeats(several)} with that of the largest marginal likelihood; with the "
            f"searched one it {apart} be told apart from the {_title(AVERAGED, PRIMARY)} ({against['difference']:+.3f} "
            f"+- {against['error']:.3f}{_over_repeats(against)}, p = {against['p']:.2g})"
        )
    return (
        "The marginal likelihood of the thesis's process has several maxima, and a search by cross-validation in a "
        f"fold chooses among them by few rows. {'; '.join(parts)}."
    )


def _others(differences: pd.DataFrame) -> str:
    parts = []
    for scheme, title in BOTH.items():
        rows = differences[(differences["scheme"] == scheme) & (differences["metric"] == "r2")]
        models = [_title(*pair) + (", one step" if pair[1] == PRIMARY else "") for pair in _names(rows, "yes")]
        parts.append(f"{title}: {', '.join(models) or 'none'}")
    return f"After Holm, these differ from the {_title(AVERAGED, PRIMARY)} in R2: {'; '.join(parts)}."


def _names(rows: pd.DataFrame, told_apart: str) -> list[tuple[str, str]]:
    kept = rows[rows["told_apart"] == told_apart]
    return list(zip(kept["model"], kept["strategy"], strict=True))


def _distributions(scores: pd.DataFrame, coverage: pd.DataFrame) -> str:
    parts = []
    for model, strategy in PAIR:
        rows = {name: _one(scores, model=model, strategy=strategy, scheme=name, score=CRPS) for name in BOTH}
        logs = {name: _one(scores, model=model, strategy=strategy, scheme=name, score=LOG_SCORE) for name in BOTH}
        own = coverage[(coverage["model"] == model) & (coverage["strategy"] == strategy)]
        held = own[(own["scheme"] == LEFT_OUT) & (own["method"] == rows[LEFT_OUT]["distribution"])]
        shares = ", ".join(
            f"{100 * row['covered']:.0f} % ({row['width_pp']:.0f} points wide) for a nominal {100 * row['nominal']:g} %"
            for _, row in held.iterrows()
        )
        values = " and ".join(
            f"{row['value']:.2f} +- {row['error']:.2f} points by {BOTH[name]}{_over_repeats(row, 2)} (climatology "
            f"worse by {100 * row['skill'] / (1 - row['skill']):.0f} %; log score {logs[name]['value']:.2f}"
            f"{_over_repeats(logs[name], 2)}, {logs[name]['skill']:.2f} below climatology)"
            for name, row in rows.items()
        )
        parts.append(f"{_title(model, strategy)}: CRPS {values}; its intervals hold {shares} of the left-out runs")
    return f"{'. '.join(parts)}."


def _chance(test: pd.DataFrame) -> str:
    row = test.iloc[0]
    return (
        f"Chance does not explain the {_title(AVERAGED, PRIMARY)}'s score: "
        if row["p"] < 0.05
        else f"Chance may explain the {_title(AVERAGED, PRIMARY)}'s score: "
    ) + (
        f"p = {row['p']:.3g} from {row['permutations']:g} shuffles of the yields ({row['measure']}: "
        f"{row['measured']:.3f} measured, at most {row['highest']:.3f} and in the median {row['median']:.3f} shuffled)."
    )


def _choice(libraries: pd.DataFrame) -> str:
    parts = []
    for scheme, title in BOTH.items():
        row = _one(libraries, library=f"random halves of the {EARLIER}", scheme=scheme, metric="r2")
        parts.append(f"{row['lowest']:.3f} to {row['highest']:.3f} by {title}")
    return (
        "Some 130 kernels were tried by leave-one-out before the earlier library was fixed. "
        f"{row['repeats']:g} random halves of it reach R2 from {', and from '.join(parts)}: the error of that choice."
    )


def _priors(libraries: pd.DataFrame) -> str:
    parts = []
    for scheme, title in BOTH.items():
        old, new = (_one(libraries, library=name, scheme=scheme, metric="r2") for name in (EARLIER, DECLARED))
        change = _one(libraries, library=DIFFERENCE, scheme=scheme, metric="r2")
        parts.append(
            f"{title}: R2 {new['value']:.3f}{_over_repeats(new)} with the declared and {old['value']:.3f}"
            f"{_over_repeats(old)} with the earlier library (difference {change['value']:+.3f} +- {change['error']:.3f}"
            f"{_over_repeats(change)}, p = {change['p']:.2g})"
        )
    return f"{'; '.join(parts)}. The declared library was written down before any score of it was computed."


def _next_experiments(summary: pd.DataFrame, learning: pd.DataFrame) -> str:
    """What the retrospective test says about the best run, over targets, and about what the chosen runs teach."""
    runs = {name: _one(summary, target=ALL_TARGETS, strategy=name) for name in (RULE, IMPROVEMENT, CHANCE)}
    last = learning[learning["runs"] == learning["runs"].max()]
    taught = {name: _one(last, strategy=name) for name in (LEARNING, IMPROVEMENT, RULE, CHANCE)}
    against = "; ".join(
        f"{title} {-taught[name]['less_than_chance_pp']:+.1f} points ({-taught[name]['less_upper']:+.1f} to "
        f"{-taught[name]['less_lower']:+.1f}), which {taught[name]['conclusion']}"
        for name, title in ((LEARNING, "chosen for learning"), (IMPROVEMENT, "for the yield"), (RULE, "by the rule"))
    )
    return (
        f"To the best run: the rule of most balls and longest time takes {runs[RULE]['mean_runs']:.1f} runs, expected "
        f"improvement {runs[IMPROVEMENT]['mean_runs']:.1f}, random choice {runs[CHANCE]['mean_runs']:.1f}; the rule "
        f"{runs[RULE]['conclusion']}. Error of runs that could not be chosen, with {last['runs'].iloc[0]:g} "
        f"runs known: {taught[CHANCE]['error_pp']:.1f} points after random choice. Against it: {against}."
    )


def state(tables: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Columns: about, statement.

    tables: scores_by_scheme, differences, scores, coverage, libraries, permutation_test, search and learning.
    """
    sentences = {
        "both schemes": _both_schemes(tables["scores_by_scheme"]),
        "two best models": _told_apart(tables["differences"]),
        "starts": _starts(tables["scores_by_scheme"], tables["differences"]),
        "other models": _others(tables["differences"]),
        "distributions": _distributions(tables["scores"], tables["coverage"]),
        "chance": _chance(tables["permutation_test"]),
        "what was looked at": _choice(tables["libraries"]),
        "prior": _priors(tables["libraries"]),
        "next experiments": _next_experiments(tables["search"], tables["learning"]),
    }
    return pd.DataFrame({"about": list(sentences), "statement": list(sentences.values())})

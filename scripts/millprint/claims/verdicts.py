"""The words of verdicts on claims. A module of its own, which imports nothing: the check before a run needs them."""

REPRODUCED, DEVIATES, ERRATUM, NOT_RUN = "reproduced", "deviates", "erratum", "not run"
UNDECIDED = "undecided: the interval crosses the tolerance"
VERDICTS = (REPRODUCED, ERRATUM, UNDECIDED, DEVIATES, NOT_RUN)


def in_short(verdict: str) -> str:
    """The first word or words of a verdict, for a legend or the head of a column."""
    return verdict.partition(":")[0]

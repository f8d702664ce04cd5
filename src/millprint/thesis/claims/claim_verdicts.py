"""The words of verdicts on claims. A module of its own, which imports nothing: the check before a run needs them."""

# By the value itself.
REPRODUCED, DEVIATES, ERRATUM, NOT_RUN = "reproduced", "deviates", "erratum", "not run"
VERDICTS = (REPRODUCED, ERRATUM, DEVIATES, NOT_RUN)

# By the interval, of claims that have one; these two besides REPRODUCED and DEVIATES.
UNDECIDED, TOO_WIDE, TOO_FEW = "undecided", "wider than the tolerance", "too few repeats"
INTERVAL_VERDICTS = (REPRODUCED, DEVIATES, UNDECIDED, TOO_WIDE, TOO_FEW)
# Another run may fall on either side of the tolerance.
OPEN_VERDICTS = (UNDECIDED, TOO_WIDE, TOO_FEW)

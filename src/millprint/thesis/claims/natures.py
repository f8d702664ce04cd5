"""The nature of a claim, which is how its value is obtained, and its basis: whether the thesis states it."""

# Values of the column `nature` of claims.tsv, ordered by how much a match proves, least first.
NATURES = {
    "read": "read from a table of the thesis and printed back",
    "arithmetic": "arithmetic on printed numbers",
    "put_in": "put in and read back",
    "fitted": "fitted to the printed value",
    "simulated": "simulated",
    "trained": "trained",
    "timed": "a run time",
}
# The same on every machine, because they do not depend on chance.
CERTAIN = ("read", "arithmetic")
TIMED = "timed"

# Values of the column `basis`.
STATED, DERIVED = "stated", "derived"
BASES = {
    STATED: "printed in the thesis, as a number or as a statement",
    DERIVED: "not printed: follows from two printed numbers (a mean from its standard deviation and variation)",
}

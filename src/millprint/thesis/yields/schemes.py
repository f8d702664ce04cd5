"""Names of the ways to split the rows; in a module without the splits, since claims and sentences read only tables."""

LEFT_OUT, NESTED, RANDOM = "leave_one_out", "nested_cv", "random_split"
# The locked split at the budget of the other schemes, to be compared with them.
LOCKED_AGAIN = "locked_reduced_budget"

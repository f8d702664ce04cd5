"""What the Pareto plot shows: each term's F, the F that is significant, and the F behind a printed p-value."""

import pandas as pd
from scipy.stats import f as f_distribution


def pareto_table(
    anova: pd.DataFrame, corrected: pd.DataFrame, printed_p: dict[str, float], significance: float = 0.05
) -> pd.DataFrame:
    """Terms of an ANOVA table by falling F (thesis Fig. 2.3).

    `printed_p` maps sources to published p-values; F_published is the F that gives them with these degrees of freedom.
    F_type_two is that of the corrected table.
    """
    residual = anova.loc[anova["term"] == "Residual", "degrees_of_freedom"].iloc[0]
    terms = anova[anova["F"].notna()]
    freedom = terms["degrees_of_freedom"]
    second = corrected[corrected["sums"] == "II"].set_index("term")["F"]
    table = terms[["source", "term", "degrees_of_freedom", "F", "p_value"]].assign(
        critical_F=f_distribution.isf(significance, freedom, residual),
        F_type_two=terms["term"].map(second),
        F_published=f_distribution.isf(terms["source"].map(printed_p).astype(float), freedom, residual),
    )
    return table.sort_values("F", ascending=False, ignore_index=True)

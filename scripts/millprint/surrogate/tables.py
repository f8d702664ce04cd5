"""Tables of the stage: a row a measure, with the figures of the thesis and the aims beside ours."""

import pandas as pd

# What the thesis prints for its surrogate: Sec. 6.3 and 6.4, and appendix A for the variants named there.
THESIS = {
    ("trained", "position_mse_plateau_m2"): 2e-4,
    ("trained", "dissipation_error_percent"): 2.78,
    ("motion1", "dissipation_error_percent"): 23.84,
    ("motion2", "dissipation_error_percent"): 46.62,
    ("post", "dissipation_error_original_percent"): 5.97,
    ("motion1", "cumulative_pearson_r"): 0.9998,
    ("motion2", "cumulative_pearson_r"): 0.9998,
    ("post", "balls_left"): 0,
}
# Appendix A: error of the cumulative dissipation [%] of the ablations that it gives a number for.
APPENDIX = {"baseline": 2.78, "phi_shallow": 15.45, "phi_deep": 4.18, "no_global_loss": 514.35}
AIMS = {
    ("trained", "dissipation_error_percent"): 2.0,
    ("motion1", "dissipation_error_percent"): 5.0,
    ("motion2", "dissipation_error_percent"): 5.0,
    ("post", "dissipation_error_percent"): 7.0,
}


def tabulate(
    values: dict[str, float], reference: dict[str, float], test: str, variant: str, ablation: bool = False
) -> pd.DataFrame:
    """Rows of metrics.tsv, with the thesis's figure and our aim where there is one.

    An ablation is held against appendix A, any other variant against the results of chapter 6.
    """
    rows = []
    for measure, value in values.items():
        if ablation:
            thesis = APPENDIX.get(variant) if (test, measure) == ("trained", "dissipation_error_percent") else None
        else:
            thesis = THESIS.get((test, measure))
        rows.append(
            {
                "variant": variant,
                "test": test,
                "measure": measure,
                "value": value,
                "dem_reference": reference.get(measure),
                "thesis": thesis,
                "aim": None if ablation else AIMS.get((test, measure)),
            }
        )
    return pd.DataFrame(rows)


def join_tables(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """One table of several; a column that some of them lack is empty there."""
    columns = dict.fromkeys(column for table in tables for column in table.columns)
    records = [record for table in tables for record in table.to_dict("records")]
    return pd.DataFrame(records, columns=list(columns))

"""The tables of a run that the report shows, by chapter."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Listed:
    """A table: its path in the results folder, its title, and a note for its readers."""

    path: str
    title: str
    note: str = ""


TABLES = {
    "2": (
        Listed(
            "doe/anova_printed.tsv",
            "Analysis of variance as in Table 2.5",
            "Type I sums of squares of the yield as a fraction. Columns as_designed take the level of speed that the "
            "fraction wants in every run; truncated are the digits as the thesis prints them.",
        ),
        Listed(
            "doe/anova_corrected.tsv",
            "Analysis of variance, corrected",
            "Sums that do not depend on the order of the terms, with sizes of the effects and their intervals.",
        ),
        Listed("doe/audit.tsv", "The design as it was run", "Every check of the 27 runs against the fraction 3^(4-1)."),
        Listed("doe/contested.tsv", "Which effects share their sums of squares"),
        Listed("doe/residuals.tsv", "Runs, fitted yields and residuals"),
        Listed("doe/wear.tsv", "Wear of the balls (Table 2.6)"),
        Listed("doe/literature_checks.tsv", "Do the entries of Table 2.2 agree with each other?"),
    ),
    "3": (
        Listed(
            "fingerprint/descriptors.tsv",
            "Descriptors of every simulated condition",
            "A row a condition, means over its seeds. Pn, Pt and f are the scaled powers and frequency of Eqs 3.28 "
            "and 3.29; columns that end in se are standard errors, in sd deviations between seeds.",
        ),
        Listed(
            "fingerprint/table_3_5.tsv",
            "Dissipation in one revolution (Table 3.5)",
            "Deviations in per cent of the printed values; printed means are standard deviation over coefficient of "
            "variation.",
        ),
        Listed("fingerprint/zones.tsv", "Operational zones", "Fill ratios at which the curves turn, with intervals."),
        Listed("fingerprint/exponents.tsv", "Exponents of the scaling laws"),
        Listed("fingerprint/collapse.tsv", "Spread before and after the normalisation"),
        Listed("fingerprint/inverse.tsv", "Speeds that keep a target (Sec. 3.3.4)"),
        Listed("fingerprint/inverse_ranked.tsv", "Conditions that come nearest to a target"),
        Listed("calibration/drop_test.tsv", "Virtual drop tests (Eq. 3.19)"),
        Listed("convergence/timestep.tsv", "What the time step changes"),
        Listed("convergence/modulus.tsv", "What Young's modulus changes (Fig. 3.4)"),
    ),
    "4": (
        Listed(
            "partition/table_4_2.tsv",
            "Conditions and yields (Table 4.2)",
            "From the published master curves, and from ours, with the interval of the power.",
        ),
        Listed("partition/table_4_3.tsv", "Against earlier work (Table 4.3)"),
        Listed("partition/table_4_4.tsv", "Yield and mass for a watt (Table 4.4)"),
        Listed("partition/table_4_5.tsv", "Energy leverage (Table 4.5)"),
        Listed("partition/slopes.tsv", "Slopes of the yield over the fill ratio"),
        Listed("partition/design.tsv", "The same for other fill ratios"),
    ),
    "5": (
        Listed(
            "yield/locked.tsv",
            "Every model on the locked split (Table 5.6)",
            "Six test rows: differences between models are within chance, as the next table shows.",
        ),
        Listed("yield/honest.tsv", "The same under other schemes, with intervals"),
        Listed("yield/coverage.tsv", "How often predictive intervals hold a run that was left out"),
        Listed("yield/predictions.tsv", "Predictions"),
        Listed("yield/out_of_domain.tsv", "Outside the trained domain (Table 5.8)"),
        Listed("yield/regimes_summary.tsv", "Errors at fill ratios that were not trained"),
        Listed(
            "yield/next_experiments.tsv", "The next experiments", "What to run for a higher yield, or a better model."
        ),
        Listed("yield/choices.tsv", "What the choices that the thesis leaves open change"),
        Listed("yield/tried.tsv", "Everything that was tried, by leave-one-out"),
    ),
    "6": (
        Listed(
            "surrogate/metrics.tsv",
            "Measures of every roll-out",
            "dem_reference is the same measure of a simulation with another seed, which no surrogate has to beat.",
        ),
        Listed("surrogate/runtime.tsv", "Runtimes of surrogate and simulation"),
    ),
}

"""The sources of the claims' values: the rule that writes each file, and the function that computes its content."""

from dataclasses import dataclass
from fnmatch import fnmatch

# By path from the results folder: the rule that writes the file, and the function that computes its content. Where one
# column has a function of its own, its name follows the path. Functions are named, not imported: claims read files, and
# what computed these would bring most of the library.
ORIGINS: dict[str, tuple[str, str]] = {
    "doe/fraction.json": ("tabulate_experiments", "millprint.thesis.doe.factorial_designs.describe"),
    "doe/audit.tsv": ("tabulate_experiments", "millprint.thesis.doe.audit.audit_table"),
    "doe/anova_printed.tsv": ("analyse_variance", "millprint.thesis.doe.variance.printed_table"),
    "doe/interactions.tsv": ("analyse_variance", "millprint.thesis.doe.trends.interaction_table"),
    "doe/residuals.tsv": ("analyse_variance", "millprint.thesis.doe.residuals.residual_table"),
    "doe/pareto.tsv": ("analyse_variance", "millprint.thesis.doe.variance.pareto_table"),
    "doe/half_life.tsv": ("tabulate_experiments", "millprint.thesis.doe.wet_lab.half_life_table"),
    "doe/wear.tsv": ("tabulate_experiments", "millprint.thesis.doe.wet_lab.wear_table"),
    "calibration/drop_test.tsv": ("calibrate_restitution", "millprint.thesis.calibration.drop.simulate_drops"),
    "calibration/*/friction_fit.tsv": ("fit_friction", "millprint.thesis.calibration.experiment.fit_experiment"),
    "convergence/modulus.tsv": ("tabulate_convergence", "millprint.dem.convergence.convergence_table"),
    "dem/*/summary.json": ("run_dem_case", "millprint.dem.summary.summarise"),
    "fingerprint/descriptors.tsv": ("tabulate_descriptors", "millprint.fingerprint.descriptors.tabulate_descriptors"),
    "fingerprint/cycles.tsv": ("tabulate_descriptors", "millprint.fingerprint.cycles.tabulate_cycles"),
    "fingerprint/means_*.tsv": ("fit_master_curves", "millprint.fingerprint.master_curves.average_curves"),
    "fingerprint/collapse.tsv": ("fit_master_curves", "millprint.thesis.curves.collapse.tabulate_collapse"),
    "fingerprint/inverse.tsv": ("invert_master_curves", "millprint.fingerprint.inverse.invert_speed"),
    "partition/table_4_2.tsv yield_percent": ("partition_dissipation", "millprint.thesis.curves.regimes.read_regimes"),
    "partition/table_4_2.tsv": ("partition_dissipation", "millprint.thesis.curves.regimes.design_cases"),
    "partition/table_4_3.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.compare_with_prior"),
    "partition/table_4_4.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.specific_yields"),
    "partition/table_4_5.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.energy_leverage"),
    "partition/slopes.tsv": ("partition_dissipation", "millprint.thesis.curves.energy.fit_slopes"),
    "yield/scores_by_scheme.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.score_table"),
    "yield/out_of_domain.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.predictions"),
    "yield/time_variance.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.time_variance"),
    "yield/shap_ranking.tsv": ("evaluate_yield_models", "millprint.thesis.yields.evaluation.rank_features"),
    "surrogate/*/metrics.tsv": ("evaluate_surrogate", "millprint.thesis.surrogate.rollout_evaluation.evaluate"),
    "surrogate/runtime.tsv dem_seconds_for_15_s": (
        "time_surrogates",
        "millprint.thesis.surrogate.timing.simulation_seconds",
    ),
    "surrogate/runtime.tsv": ("time_surrogates", "millprint.thesis.surrogate.timing.time_rollouts"),
    "surrogate/wall_contacts.tsv": (
        "build_surrogate_dataset",
        "millprint.thesis.surrogate.measure_tables.wall_contact_table",
    ),
    "surrogate/ablations.tsv": ("tabulate_ablations", "millprint.thesis.surrogate.ablations.ablation_table"),
}


@dataclass(frozen=True)
class Source:
    """Where a value comes from.

    path: of the file, from the results folder, or of a file of the project; columns: names, separated by commas;
    rows: a condition on the columns, as `pandas.DataFrame.query` takes it, empty for every row; rule: what writes the
    file; for a simulation run_dem_case, also where a job of another rule run_dem_... holds several, and for the errors
    of a network evaluate_surrogate; function: what computes
    its content.
    """

    path: str
    columns: str
    rows: str
    rule: str
    function: str

    def __str__(self) -> str:
        return f"{self.path}{self.details}"

    @property
    def details(self) -> str:
        """All but the path, in words."""
        rows = f" [{self.rows}]" if self.rows else ""
        return f"{rows} {self.columns} (rule {self.rule}, {self.function})"


def source_in(path: str, columns: str, rows: str = "") -> Source:
    """A source in a file of the results. Raises KeyError for a file that ORIGINS does not have."""
    for pattern, (rule, function) in ORIGINS.items():
        if fnmatch(path, pattern) or pattern == f"{path} {columns}":
            return Source(path, columns, rows, rule, function)
    raise KeyError(f"{path}: no file of claims.sources.ORIGINS")

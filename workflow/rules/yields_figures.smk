"""Figures of the yield models, what their tables say in sentences, and the list of all files of chapter 5."""

YIELD_FIGURES = f"{YIELDS}/figures"


rule plot_yields:
    input:
        predictions=rules.evaluate_yield_models.output.predictions,
        shap=rules.evaluate_yield_models.output.shap,
        honest=rules.evaluate_yield_models.output.honest,
        coverage=rules.evaluate_yield_models.output.coverage,
        retrospective=rules.search_retrospectively.output.retrospective,
        proposals=rules.predict_yields.output.proposals,
        regimes=rules.leave_groups_out.output.regimes_summary,
        scores=rules.evaluate_yield_models.output.scores,
        pit=rules.evaluate_yield_models.output.pit,
        permutations=PERMUTED["permutations"],
        sources=rules.leave_groups_out.output.sources,
        sources_predictions=rules.leave_groups_out.output.sources_predictions,
        claims=CONFIG.data.claims,
        differences=rules.evaluate_yield_models.output.differences,
        libraries=rules.try_alternatives.output.libraries,
        permutation_test=PERMUTED["permutation_test"],
        search=rules.search_retrospectively.output.summary,
        learning=rules.search_retrospectively.output.learning,
    output:
        statements=f"{YIELDS}/statements.tsv",
        predictions_svg=report(
            f"{YIELD_FIGURES}/predictions.svg",
            caption="../report/yield_predictions.rst",
            category="Chapter 5",
            labels={"figure": "5.2", "shows": "predictions for the six test rows"},
        ),
        predictions_png=f"{YIELD_FIGURES}/predictions.png",
        intervals_svg=report(
            f"{YIELD_FIGURES}/intervals.svg",
            caption="../report/yield_intervals.rst",
            category="Chapter 5",
            labels={"figure": "5.3", "shows": "predictive intervals of the two-step GPR"},
        ),
        intervals_png=f"{YIELD_FIGURES}/intervals.png",
        shap_svg=report(
            f"{YIELD_FIGURES}/shap.svg",
            caption="../report/yield_shap.rst",
            category="Chapter 5",
            labels={"figure": "5.4", "shows": "SHAP values of the two-step tree models"},
        ),
        shap_png=f"{YIELD_FIGURES}/shap.png",
        evaluation_svg=report(
            f"{YIELD_FIGURES}/evaluation.svg",
            caption="../report/yield_evaluation.rst",
            category="Chapter 5",
            labels={"figure": "Table 5.6", "shows": "locked split against honest schemes"},
        ),
        evaluation_png=f"{YIELD_FIGURES}/evaluation.png",
        coverage_svg=report(
            f"{YIELD_FIGURES}/coverage.svg",
            caption="../report/yield_coverage.rst",
            category="Chapter 5",
            labels={"figure": "coverage", "shows": "predictive intervals of left-out runs"},
        ),
        coverage_png=f"{YIELD_FIGURES}/coverage.png",
        retrospective_svg=report(
            f"{YIELD_FIGURES}/retrospective.svg",
            caption="../report/yield_retrospective.rst",
            category="Chapter 5",
            labels={"figure": "retrospective", "shows": "runs to the best run"},
        ),
        retrospective_png=f"{YIELD_FIGURES}/retrospective.png",
        proposals_svg=report(
            f"{YIELD_FIGURES}/proposals.svg",
            caption="../report/yield_proposals.rst",
            category="Chapter 5",
            labels={"figure": "next experiments", "shows": "what to run next"},
        ),
        proposals_png=f"{YIELD_FIGURES}/proposals.png",
        regimes_svg=report(
            f"{YIELD_FIGURES}/regimes.svg",
            caption="../report/yield_regimes.rst",
            category="Chapter 5",
            labels={"figure": "regimes", "shows": "error at unseen fill ratios"},
        ),
        regimes_png=f"{YIELD_FIGURES}/regimes.png",
        scores_svg=report(
            f"{YIELD_FIGURES}/scores.svg",
            caption="../report/yield_scores.rst",
            category="Chapter 5",
            labels={"figure": "proper scores", "shows": "CRPS and logarithmic score"},
        ),
        scores_png=f"{YIELD_FIGURES}/scores.png",
        pit_svg=report(
            f"{YIELD_FIGURES}/pit.svg",
            caption="../report/yield_pit.rst",
            category="Chapter 5",
            labels={"figure": "calibration", "shows": "PIT histograms"},
        ),
        pit_png=f"{YIELD_FIGURES}/pit.png",
        permutations_svg=report(
            f"{YIELD_FIGURES}/permutations.svg",
            caption="../report/yield_permutations.rst",
            category="Chapter 5",
            labels={"figure": "chance", "shows": "scores on shuffled yields"},
        ),
        permutations_png=f"{YIELD_FIGURES}/permutations.png",
        sources_svg=report(
            f"{YIELD_FIGURES}/sources.svg",
            caption="../report/yield_sources.rst",
            category="Chapter 5",
            labels={"figure": "sources", "shows": "what transfers to the runs of others"},
        ),
        sources_png=f"{YIELD_FIGURES}/sources.png",
    log:
        f"{LOGS}/yields/plot_yields.log",
    localrule: True
    message:
        "Drawing the figures of chapter 5, and writing what its tables say"
    script:
        "../../scripts/plot_yields.py"


YIELD_OUTPUTS = [
    *rules.evaluate_yield_models.output,
    rules.try_alternatives.output.libraries,
    *PERMUTED.values(),
    *rules.leave_groups_out.output,
    *rules.predict_yields.output,
    *rules.search_retrospectively.output,
    *rules.plot_yields.output,
]

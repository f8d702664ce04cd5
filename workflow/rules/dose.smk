"""What the powder has been through: wear of the balls, from the sliding work of the simulations."""

from millprint.fingerprint.cases import described_cases, is_as_built

WEAR = CONFIG.dose.wear
WEAR_CONTACT = CONFIG.partition.contact
# Balls of one size in the mill as built: the weighings are of such balls.
WEAR_CASES = [
    path
    for path, case in described_cases(CONFIG, CASES).items()
    if (case.mill, case.contact) == (CONFIG.mill, WEAR_CONTACT) and case.mixture is None and is_as_built(case)
]
WEAR_SUMMARIES = [f"{RESULTS}/dem/{path}/summary.json" for path in WEAR_CASES]
# Contact parameters widen the intervals where the whole run has their analysis.
WEAR_IS_ANALYSED = CONFIG.mill in CONFIG.uncertainty.mills and CONFIG.mills.contact_set == WEAR_CONTACT


rule fit_wear:
    input:
        **({"factors": f"{RESULTS}/uncertainty/{CONFIG.mill}/contact.json"} if WEAR_IS_ANALYSED else {}),
        summaries=lambda wildcards: sliding_summaries(),
        runs=lambda wildcards: records_of(sliding_summaries()),
        weighings=CONFIG.data.wear,
        materials=WEAR.materials,
    output:
        runs=f"{DOSE}/sliding.tsv",
        conditions=f"{DOSE}/sliding_conditions.tsv",
        fit=f"{DOSE}/wear_fit.tsv",
        coefficient=f"{DOSE}/wear_coefficient.json",
        wear=f"{DOSE}/wear.tsv",
        svg=report(
            f"{DOSE}/wear.svg",
            caption="../report/wear.rst",
            category="Chapter 2",
            labels={"figure": "Table 2.6", "shows": "wear by Archard's law"},
        ),
        png=f"{DOSE}/wear.png",
    log:
        f"{LOGS}/dose/fit_wear.log",
    benchmark:
        f"{BENCHMARKS}/fit_wear/fit_wear.tsv"
    params:
        settings=WEAR.model_dump(mode="json"),
        machine={
            "mill": CONFIG.mill,
            "contact": WEAR_CONTACT,
            "counting_rule": CONFIG.fingerprint.counting_rule,
        },
    message:
        "Measuring the sliding work, fitting the wear coefficient to half of {input.weighings}, and predicting the rest"
    script:
        "../../scripts/fit_wear.py"


rule predict_mill_wear:
    input:
        summaries=lambda wildcards: [path for name in BOX for path in heated_summaries(name)],
        runs=lambda wildcards: [path for name in BOX for path in heated_runs(name)],
        coefficient=rules.fit_wear.output.coefficient,
        materials=WEAR.materials,
    output:
        table=f"{RESULTS}/mills/wear.tsv",
        svg=report(
            f"{RESULTS}/mills/wear.svg",
            caption="../report/mill_wear.rst",
            category="Mills",
            labels={"mill": "all", "figure": "wear of the balls"},
        ),
        png=f"{RESULTS}/mills/wear.png",
    log:
        f"{LOGS}/mills/wear.log",
    localrule: True
    params:
        settings=WEAR.model_dump(mode="json"),
    message:
        "Predicting the wear of the balls in {BOX}"
    script:
        "../../scripts/predict_mill_wear.py"


# A target of its own: the coefficient of wear comes from the simulations of the thesis, which `mills` does not start.
rule mill_wear:
    input:
        rules.predict_mill_wear.output,
    localrule: True
    message:
        "The wear of the balls in the mills of the box is complete"


DOSE_OUTPUTS = [
    *rules.tabulate_spectra.output,
    # Figures of the spectra and the doses of the measured yields are made with chapters 3 and 4.
    *(
        path
        for made in (rules.plot_fingerprint, rules.partition_dissipation)
        for path in made.output
        if path.startswith(f"{DOSE}/")
    ),
    *rules.fit_wear.output,
]

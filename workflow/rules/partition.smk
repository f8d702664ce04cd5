"""Chapter 4: shear against compression; energy spectra of the sweeps, and wear of the balls."""

PARTITION = f"{RESULTS}/partition"
PARTITION_FIGURES = f"{PARTITION}/figures"


rule partition_dissipation:
    input:
        regimes=CONFIG.data.regimes,
        screening=CONFIG.data.screening,
        fingerprint=f"{RESULTS}/fingerprint/fingerprint_{CONFIG.partition.contact}.json",
    output:
        table_4_2=f"{PARTITION}/table_4_2.tsv",
        table_4_3=f"{PARTITION}/table_4_3.tsv",
        table_4_4=f"{PARTITION}/table_4_4.tsv",
        table_4_5=f"{PARTITION}/table_4_5.tsv",
        slopes=f"{PARTITION}/slopes.tsv",
        design=f"{PARTITION}/design.tsv",
        yield_figure=figures(f"{PARTITION_FIGURES}/yield"),
        specific_figure=figures(f"{PARTITION_FIGURES}/specific_yield"),
        mass_figure=figures(f"{PARTITION_FIGURES}/mass_per_watt"),
        doses=f"{DOSE}/dose.tsv",
        kinetics=f"{DOSE}/kinetics.tsv",
        curves=f"{DOSE}/kinetics_curves.tsv",
        verdict=f"{DOSE}/dose_verdict.txt",
        dose_figure=figures(f"{DOSE}/dose"),
    log:
        f"{LOGS}/partition/partition_dissipation.log",
    localrule: True
    params:
        settings=settings("partition"),
        density_kg_m3=CONTACTS[CONFIG.partition.contact].density_kg_m3,
    message:
        "Calculating and drawing the cases of constant speed and constant power, their yields, energy costs and doses"
    script:
        "../../scripts/partition_dissipation.py"


rule tabulate_spectra:
    input:
        summaries=[path for contact in CONFIG.contacts for path in swept_summaries(contact)],
        runs=[path for contact in CONFIG.contacts for path in records_of(swept_summaries(contact))],
    output:
        spectra=expand(f"{DOSE}/spectra_{{contact}}.tsv", contact=CONFIG.contacts),
        summary=expand(f"{DOSE}/spectra_summary_{{contact}}.tsv", contact=CONFIG.contacts),
    log:
        f"{LOGS}/dose/tabulate_spectra.log",
    benchmark:
        f"{BENCHMARKS}/tabulate_spectra/tabulate_spectra.tsv"
    params:
        runs={contact: records_of(swept_summaries(contact)) for contact in CONFIG.contacts},
        rules=rules_named(*spectra_rules(CONFIG.fingerprint.counting_rule)),
    message:
        "Tabulating the energy spectra of {CONFIG.contacts}"
    script:
        "../../scripts/tabulate_simulations.py"


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
        summaries=WEAR_SUMMARIES,
        runs=records_of(WEAR_SUMMARIES),
        weighings=CONFIG.data.wear,
        materials=WEAR.materials,
    output:
        runs=f"{DOSE}/sliding.tsv",
        conditions=f"{DOSE}/sliding_conditions.tsv",
        fit=f"{DOSE}/wear_fit.tsv",
        coefficient=f"{DOSE}/wear_coefficient.json",
        wear=f"{DOSE}/wear.tsv",
        figure=figures(f"{DOSE}/wear"),
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


# No part of `mills`, which does not start the simulations of the thesis that the coefficient of wear comes from.
rule mill_wear:
    """The wear of the balls in the mills of the box."""
    input:
        summaries=lambda wildcards: [path for name in BOX for path in heated_summaries(name)],
        runs=lambda wildcards: [path for name in BOX for path in records_of(heated_summaries(name))],
        coefficient=rules.fit_wear.output.coefficient,
        materials=WEAR.materials,
    output:
        table=f"{RESULTS}/mills/wear.tsv",
        figure=figures(f"{RESULTS}/mills/wear"),
    log:
        f"{LOGS}/mills/wear.log",
    localrule: True
    params:
        settings=WEAR.model_dump(mode="json"),
    message:
        "Predicting the wear of the balls in {BOX}"
    script:
        "../../scripts/fit_wear.py"


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

"""Dose: energy and hits that a gram of powder has seen, and the kinetics of the measured yields."""


rule tabulate_dose:
    input:
        screening=CONFIG.data.screening,
        regimes=CONFIG.data.regimes,
        table_4_2=f"{RESULTS}/partition/table_4_2.tsv",
    output:
        doses=f"{DOSE}/dose.tsv",
        kinetics=f"{DOSE}/kinetics.tsv",
        curves=f"{DOSE}/kinetics_curves.tsv",
        verdict=f"{DOSE}/dose_verdict.txt",
        svg=report(
            f"{DOSE}/dose.svg",
            caption="../report/dose.rst",
            category="Chapter 4",
            labels={"figure": "dose", "shows": "yield against time and dose"},
        ),
        png=f"{DOSE}/dose.png",
    log:
        f"{LOGS}/dose/tabulate_dose.log",
    localrule: True
    params:
        ball_diameter_m=CONFIG.partition.ball_diameter_mm * 1e-3,
        density_kg_m3=CONTACTS[CONFIG.partition.contact].density_kg_m3,
        library=library("tabulate_dose.py"),
    message:
        "Calculating the dose of every run, fitting kinetics to the yields, and drawing both"
    script:
        "../../scripts/tabulate_dose.py"


YIELD_DOSE_OUTPUTS = [*rules.tabulate_dose.output]

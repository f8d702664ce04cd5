"""Shear against compression: the five cases of thesis chapter 4, and the dose and kinetics of the measured yields."""

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
        yield_svg=report(
            f"{PARTITION_FIGURES}/yield.svg",
            caption="../report/partition_yield.rst",
            category="Chapter 4",
            labels={"figure": "4.3", "shows": "yield against fill ratio"},
        ),
        yield_png=f"{PARTITION_FIGURES}/yield.png",
        specific_svg=report(
            f"{PARTITION_FIGURES}/specific_yield.svg",
            caption="../report/partition_specific_yield.rst",
            category="Chapter 4",
            labels={"figure": "4.4", "shows": "specific yield against fill ratio"},
        ),
        specific_png=f"{PARTITION_FIGURES}/specific_yield.png",
        mass_svg=report(
            f"{PARTITION_FIGURES}/mass_per_watt.svg",
            caption="../report/partition_mass.rst",
            category="Chapter 4",
            labels={"figure": "4.5", "shows": "converted mass per watt against fill ratio"},
        ),
        mass_png=f"{PARTITION_FIGURES}/mass_per_watt.png",
        doses=f"{DOSE}/dose.tsv",
        kinetics=f"{DOSE}/kinetics.tsv",
        curves=f"{DOSE}/kinetics_curves.tsv",
        verdict=f"{DOSE}/dose_verdict.txt",
        dose_svg=report(
            f"{DOSE}/dose.svg",
            caption="../report/dose.rst",
            category="Chapter 4",
            labels={"figure": "dose", "shows": "yield against time and dose"},
        ),
        dose_png=f"{DOSE}/dose.png",
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


PARTITION_OUTPUTS = [*rules.partition_dissipation.output]

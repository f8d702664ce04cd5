"""Dose of any mill: counting rules of spectra, and temperatures."""

DOSE = f"{RESULTS}/dose"
HEAT = f"{RESULTS}/dose/heat/{{mill}}"
# Part of a whole run.
HEATED_MILLS = list(dict.fromkeys([CONFIG.mill, *CONFIG.dose.heat.mills]))


rule balance_heat:
    input:
        summaries=lambda wildcards: heated_summaries(wildcards.mill),
        runs=lambda wildcards: records_of(heated_summaries(wildcards.mill)),
    output:
        sources=f"{HEAT}/sources.tsv",
        parameters=f"{HEAT}/parameters.tsv",
        temperatures=f"{HEAT}/temperatures.tsv",
        limits=f"{HEAT}/limits.tsv",
        flash=f"{HEAT}/flash.tsv",
        figure=figures(f"{HEAT}/temperatures"),
    log:
        f"{LOGS}/dose/{{mill}}_heat.log",
    benchmark:
        f"{BENCHMARKS}/balance_heat/{{mill}}.tsv"
    params:
        settings=settings("dose.heat"),
        title=lambda wildcards: mill_named(wildcards.mill).title,
        speed_unit=lambda wildcards: mill_named(wildcards.mill).speed_unit,
    message:
        "Calculating temperatures in mill {wildcards.mill}"
    script:
        "../../scripts/balance_heat.py"


HEAT_OUTPUTS = expand([*rules.balance_heat.output], mill=HEATED_MILLS)


rule heat:
    """Temperatures of balls, powder and jar over a milling programme, and the pauses that keep a limit."""
    input:
        HEAT_OUTPUTS,


# The spectra of the mill are written by the jobs of its fingerprint.
rule dose:
    """Energy spectra; for the thesis also dose, kinetics and wear."""
    input:
        lambda wildcards: DOSE_OUTPUTS if CHAPTERS else [path for path in FINGERPRINTED if path.startswith(f"{DOSE}/")],

"""How warm balls, powder and jar of a mill get, over a milling programme: results/dose/heat."""

HEAT = f"{RESULTS}/dose/heat/{{mill}}"
HEATED_TOGETHER = [name for name in dict.fromkeys(CONFIG.dose.heat.mills) if name != CONFIG.mill]
# Part of a whole run.
HEATED_MILLS = [CONFIG.mill, *HEATED_TOGETHER]


rule balance_heat:
    input:
        summaries=lambda wildcards: heated_summaries(wildcards.mill),
        runs=lambda wildcards: heated_runs(wildcards.mill),
        measured=lambda wildcards: measured_heat([wildcards.mill]),
    output:
        sources=f"{HEAT}/sources.tsv",
        parameters=f"{HEAT}/parameters.tsv",
        temperatures=f"{HEAT}/temperatures.tsv",
        limits=f"{HEAT}/limits.tsv",
        comparison=f"{HEAT}/comparison.tsv",
        flash=f"{HEAT}/flash.tsv",
        svg=report(
            f"{HEAT}/temperatures.svg",
            caption="../report/heat.rst",
            category="Mills",
            labels={"mill": "{mill}", "figure": "temperatures"},
        ),
        png=f"{HEAT}/temperatures.png",
    log:
        f"{LOGS}/dose/{{mill}}_heat.log",
    benchmark:
        f"{BENCHMARKS}/balance_heat/{{mill}}.tsv"
    wildcard_constraints:
        mill=none_of(HEATED_TOGETHER),
    params:
        settings=CONFIG.dose.heat.model_dump(mode="json"),
        titles=lambda wildcards: {wildcards.mill: mill_named(wildcards.mill).title},
    message:
        "Calculating temperatures in mill {wildcards.mill}"
    script:
        "../../scripts/balance_heat.py"


# One job for the mills in section `dose.heat`. The mill of the run has a job of its own, which does not wait for theirs.
if HEATED_TOGETHER:

    use rule balance_heat as balance_heats with:
        input:
            summaries=lambda wildcards: [path for name in HEATED_TOGETHER for path in heated_summaries(name)],
            runs=lambda wildcards: [path for name in HEATED_TOGETHER for path in heated_runs(name)],
            measured=measured_heat(HEATED_TOGETHER),
        output:
            sources=expand(f"{HEAT}/sources.tsv", mill=HEATED_TOGETHER),
            parameters=expand(f"{HEAT}/parameters.tsv", mill=HEATED_TOGETHER),
            temperatures=expand(f"{HEAT}/temperatures.tsv", mill=HEATED_TOGETHER),
            limits=expand(f"{HEAT}/limits.tsv", mill=HEATED_TOGETHER),
            comparison=expand(f"{HEAT}/comparison.tsv", mill=HEATED_TOGETHER),
            flash=expand(f"{HEAT}/flash.tsv", mill=HEATED_TOGETHER),
            svg=[
                report(
                    f"{HEAT}/temperatures.svg".format(mill=name),
                    caption="../report/heat.rst",
                    category="Mills",
                    labels={"mill": name, "figure": "temperatures"},
                )
                for name in HEATED_TOGETHER
            ],
            png=expand(f"{HEAT}/temperatures.png", mill=HEATED_TOGETHER),
        log:
            f"{LOGS}/dose/heat.log",
        benchmark:
            f"{BENCHMARKS}/balance_heat/{'_'.join(HEATED_TOGETHER)}.tsv"
        params:
            settings=CONFIG.dose.heat.model_dump(mode="json"),
            titles={name: mill_named(name).title for name in HEATED_TOGETHER},
        message:
            "Calculating temperatures in {HEATED_TOGETHER}"


HEAT_OUTPUTS = expand([*rules.balance_heat.output], mill=HEATED_MILLS)


rule heat:
    input:
        HEAT_OUTPUTS,
    localrule: True
    message:
        "The heat balances are complete"

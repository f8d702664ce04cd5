"""Descriptors against the time step, which justify the default step, and against Young's modulus (Fig. 3.4)."""

CONVERGENCE = f"{RESULTS}/convergence"
STEP_STUDY = summaries_of([sweep for sweep in CONFIG.sweeps if sweep.compares_steps])
# A sweep with a single step is not tabulated. No other stage needs its cases, so they are requested here.
ONE_STEP = [path for path in summaries_over("time_steps_s") if path not in STEP_STUDY]


rule compare_time_steps:
    input:
        summaries=STEP_STUDY,
    output:
        table=f"{CONVERGENCE}/timestep.tsv",
        choice=f"{CONVERGENCE}/timestep.json",
        svg=report(
            f"{CONVERGENCE}/timestep.svg",
            caption="../report/timestep.rst",
            category="Chapter 3",
            labels={"figure": "Sec. 3.2.3", "shows": "energy balance and descriptors against the time step"},
        ),
        png=f"{CONVERGENCE}/timestep.png",
    log:
        f"{LOGS}/convergence/compare_time_steps.log",
    localrule: True
    params:
        counting_rule=CONFIG.fingerprint.counting_rule,
        further_rules=CONFIG.convergence.counting_rules,
        settings=CONFIG.convergence.model_dump(mode="json", exclude={"study"}),
        configured_s=CONFIG.dem.time_step_s,
        library=library("compare_time_steps.py"),
    message:
        "Searching the largest time step that leaves every descriptor unchanged"
    script:
        "../../scripts/compare_time_steps.py"


rule compare_moduli:
    input:
        summaries=summaries_over("young_moduli_gpa"),
    output:
        table=f"{CONVERGENCE}/modulus.tsv",
        svg=report(
            f"{CONVERGENCE}/modulus.svg",
            caption="../report/modulus.rst",
            category="Chapter 3",
            labels={"figure": "3.4", "shows": "power and run time against Young's modulus"},
        ),
        png=f"{CONVERGENCE}/modulus.png",
    log:
        f"{LOGS}/convergence/compare_moduli.log",
    localrule: True
    params:
        counting_rule=CONFIG.fingerprint.counting_rule,
        further_rules=CONFIG.convergence.counting_rules,
        library=library("compare_moduli.py"),
    message:
        "Tabulating and drawing descriptors, power and run time against Young's modulus (Fig. 3.4)"
    script:
        "../../scripts/compare_moduli.py"


# A configuration without such a sweep has nothing to tabulate.
CONVERGENCE_OUTPUTS = [*ONE_STEP]
if STEP_STUDY:
    CONVERGENCE_OUTPUTS += [*rules.compare_time_steps.output]
if summaries_over("young_moduli_gpa"):
    CONVERGENCE_OUTPUTS += [*rules.compare_moduli.output]

"""Descriptors against the time step, which justify the default step, and against Young's modulus (Fig. 3.4)."""

CONVERGENCE = f"{RESULTS}/convergence"
STEP_STUDY = summaries_of([sweep for sweep in CONFIG.sweeps if sweep.compares_steps])
# A sweep with a single step is not tabulated. No other stage needs its cases, so they are requested here.
ONE_STEP = [path for path in summaries_over("time_steps_s") if path not in STEP_STUDY]


rule tabulate_timestep:
    input:
        summaries=STEP_STUDY,
    output:
        table=f"{CONVERGENCE}/timestep.tsv",
    log:
        f"{LOGS}/convergence/tabulate_timestep.log",
    localrule: True
    params:
        varied="time_step_s",
        counting_rule=CONFIG.fingerprint.counting_rule,
        further_rules=CONFIG.convergence.counting_rules,
        library=library("tabulate_convergence.py"),
    message:
        "Tabulating descriptors against the time step"
    script:
        "../../scripts/tabulate_convergence.py"


rule choose_time_step:
    input:
        table=rules.tabulate_timestep.output.table,
    output:
        choice=f"{CONVERGENCE}/timestep.json",
    log:
        f"{LOGS}/convergence/choose_time_step.log",
    localrule: True
    params:
        settings=CONFIG.convergence.model_dump(mode="json", exclude={"study"}),
        configured_s=CONFIG.dem.time_step_s,
        library=library("choose_time_step.py"),
    message:
        "Searching the largest time step that leaves every descriptor unchanged"
    script:
        "../../scripts/choose_time_step.py"


rule plot_timestep:
    input:
        table=rules.tabulate_timestep.output.table,
        choice=rules.choose_time_step.output.choice,
    output:
        svg=report(
            f"{CONVERGENCE}/timestep.svg",
            caption="../report/timestep.rst",
            category="Chapter 3",
            labels={"figure": "Sec. 3.2.3", "shows": "energy balance and descriptors against the time step"},
        ),
        png=f"{CONVERGENCE}/timestep.png",
    log:
        f"{LOGS}/convergence/plot_timestep.log",
    localrule: True
    params:
        library=library("plot_timestep.py"),
    message:
        "Drawing energy balance and descriptors against the time step"
    script:
        "../../scripts/plot_timestep.py"


rule tabulate_modulus:
    input:
        summaries=summaries_over("young_moduli_gpa"),
    output:
        table=f"{CONVERGENCE}/modulus.tsv",
    log:
        f"{LOGS}/convergence/tabulate_modulus.log",
    localrule: True
    params:
        varied="young_modulus_gpa",
        counting_rule=CONFIG.fingerprint.counting_rule,
        further_rules=CONFIG.convergence.counting_rules,
        library=library("tabulate_convergence.py"),
    message:
        "Tabulating descriptors, power and run time against Young's modulus (Fig. 3.4)"
    script:
        "../../scripts/tabulate_convergence.py"


rule plot_modulus:
    input:
        table=rules.tabulate_modulus.output.table,
    output:
        svg=report(
            f"{CONVERGENCE}/modulus.svg",
            caption="../report/modulus.rst",
            category="Chapter 3",
            labels={"figure": "3.4", "shows": "power and run time against Young's modulus"},
        ),
        png=f"{CONVERGENCE}/modulus.png",
    log:
        f"{LOGS}/convergence/plot_modulus.log",
    localrule: True
    params:
        library=library("plot_modulus.py"),
    message:
        "Drawing power and run time against Young's modulus"
    script:
        "../../scripts/plot_modulus.py"


# A configuration without such a sweep has nothing to tabulate.
CONVERGENCE_OUTPUTS = [*ONE_STEP]
if STEP_STUDY:
    CONVERGENCE_OUTPUTS += [
        *rules.tabulate_timestep.output,
        *rules.choose_time_step.output,
        *rules.plot_timestep.output,
    ]
if summaries_over("young_moduli_gpa"):
    CONVERGENCE_OUTPUTS += [*rules.tabulate_modulus.output, *rules.plot_modulus.output]

"""Descriptors against the time step, which justify the default step, and against Young's modulus (Fig. 3.4)."""

from millprint.dem.timestep import longest_step
from millprint.fingerprint.cases import described_cases

CONVERGENCE = f"{RESULTS}/convergence"
STEP_STUDY = summaries_of([sweep for sweep in CONFIG.sweeps if sweep.compares_steps])
# A sweep with a single step is not tabulated. No other stage needs its cases, so they are requested here.
ONE_STEP = [path for path in summaries_over("time_steps_s") if path not in STEP_STUDY]
MODULUS_STUDY = summaries_over("young_moduli_gpa")


rule tabulate_convergence:
    input:
        of_step=STEP_STUDY,
        of_modulus=MODULUS_STUDY,
    output:
        # A configuration without one of the sweeps has nothing to tabulate of it.
        **(
            {
                "step_table": f"{CONVERGENCE}/timestep.tsv",
                "choice": f"{CONVERGENCE}/timestep.json",
                "step_svg": report(
                    f"{CONVERGENCE}/timestep.svg",
                    caption="../report/timestep.rst",
                    category="Chapter 3",
                    labels={"figure": "Sec. 3.2.3", "shows": "energy balance and descriptors against the time step"},
                ),
                "step_png": f"{CONVERGENCE}/timestep.png",
            }
            if STEP_STUDY
            else {}
        ),
        **(
            {
                "modulus_table": f"{CONVERGENCE}/modulus.tsv",
                "modulus_svg": report(
                    f"{CONVERGENCE}/modulus.svg",
                    caption="../report/modulus.rst",
                    category="Chapter 3",
                    labels={"figure": "3.4", "shows": "power and run time against Young's modulus"},
                ),
                "modulus_png": f"{CONVERGENCE}/modulus.png",
            }
            if MODULUS_STUDY
            else {}
        ),
    log:
        f"{LOGS}/convergence/tabulate_convergence.log",
    localrule: True
    params:
        counting_rule=CONFIG.fingerprint.counting_rule,
        further_rules=CONFIG.convergence.counting_rules,
        settings=CONFIG.convergence.model_dump(mode="json", exclude={"study"}),
        taken_s={
            ball: longest_step(ball, described_cases(CONFIG, CASES).values(), CONTACTS, CONFIG.dem)
            for sweep in CONFIG.sweeps
            if sweep.compares_steps
            for ball in sweep.ball_diameters_mm
        },
    message:
        "Tabulating and drawing descriptors against time step and Young's modulus (Fig. 3.4)"
    script:
        "../../scripts/tabulate_convergence.py"


CONVERGENCE_OUTPUTS = [*ONE_STEP, *rules.tabulate_convergence.output]

"""Chapter 3: time step and Young's modulus (Fig. 3.4), and virtual calibration (Sec. 3.2.2)."""

from millprint.config.calibration import SwingConfig
from millprint.dem.resources import longest_step

CONVERGENCE = f"{RESULTS}/convergence"
STEP_STUDY = files_of(rows_of("SWEEP", *(sweep.name for sweep in CONFIG.sweeps if sweep.compares_steps)))
# A sweep with a single step is not tabulated. No other stage needs its cases, so they are requested here.
ONE_STEP = [path for path in summaries_over("time_steps_s") if path not in STEP_STUDY]
MODULUS_STUDY = summaries_over("young_moduli_gpa")


rule tabulate_convergence:
    input:
        of_step=STEP_STUDY,
        of_modulus=MODULUS_STUDY,
    output:
        # A configuration without one of the sweeps has no table of it.
        **(
            {
                "step_table": f"{CONVERGENCE}/timestep.tsv",
                "choice": f"{CONVERGENCE}/timestep.json",
                "step_figure": figures(f"{CONVERGENCE}/timestep"),
            }
            if STEP_STUDY
            else {}
        ),
        **(
            {
                "modulus_table": f"{CONVERGENCE}/modulus.tsv",
                "modulus_figure": figures(f"{CONVERGENCE}/modulus"),
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
        rules=rules_named(CONFIG.fingerprint.counting_rule, *CONFIG.convergence.counting_rules),
        settings=CONFIG.convergence.model_dump(mode="json", exclude={"study"}),
        taken_s={
            ball: longest_step(ball / 1e3, described_cases(CONFIG, CASES).values(), CONTACTS, CONFIG.dem)
            for sweep in CONFIG.sweeps
            if sweep.compares_steps
            for ball in sweep.ball_diameters_mm
        },
    message:
        "Tabulating and drawing descriptors against time step and Young's modulus (Fig. 3.4)"
    script:
        "../../scripts/study_settings.py"


CONVERGENCE_OUTPUTS = [*ONE_STEP, *rules.tabulate_convergence.output]


CALIBRATION = f"{RESULTS}/calibration"
# What the figure of a fit shows.
FRICTION_TABLES = ("track", "fit", "profile", "paths")
EXPERIMENTS = {test.name: test for test in CONFIG.calibration.oscillation.experiments}


wildcard_constraints:
    experiment="|".join(EXPERIMENTS),


rule fit_friction:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        track=lambda wildcards: [path for path in [EXPERIMENTS[wildcards.experiment].track] if path],
        sources=lambda wildcards: [
            file
            for name in EXPERIMENTS[wildcards.experiment].mills(CONFIG.mill).values()
            for file in shape_files(name)
        ],
    output:
        track=f"{CALIBRATION}/{{experiment}}/track.tsv",
        fit=f"{CALIBRATION}/{{experiment}}/friction_fit.tsv",
        profile=f"{CALIBRATION}/{{experiment}}/profile.tsv",
        paths=f"{CALIBRATION}/{{experiment}}/paths.tsv",
    log:
        f"{LOGS}/calibration/fit_friction_{{experiment}}.log",
    benchmark:
        f"{BENCHMARKS}/fit_friction/{{experiment}}.tsv"
    params:
        experiment=lambda wildcards: EXPERIMENTS[wildcards.experiment].model_dump(mode="json"),
        identity=lambda wildcards: [
            *(mill_identity(MILLS[name]) for name in EXPERIMENTS[wildcards.experiment].mills(CONFIG.mill).values()),
            contact_identity(CONTACTS[EXPERIMENTS[wildcards.experiment].contact]),
        ],
        mills=lambda wildcards, output: {
            key: dumped(MILLS[name]) for key, name in EXPERIMENTS[wildcards.experiment].mills(CONFIG.mill).items()
        },
        contact=lambda wildcards, output: CONTACTS[EXPERIMENTS[wildcards.experiment].contact].model_dump(mode="json"),
        rayleigh_fraction_max=CONFIG.dem.rayleigh_fraction_max,
        settings=CONFIG.calibration.oscillation.part(SwingConfig),
        interval=CONFIG.calibration.interval,
    message:
        "Fitting the friction pair of experiment {wildcards.experiment}"
    script:
        "../../scripts/fit_friction.py"


# The figures of the friction fits too: drawn here, a change of a figure repeats no fit.
rule calibrate_restitution:
    input:
        **{name: expand(rules.fit_friction.output[name], experiment=EXPERIMENTS) for name in FRICTION_TABLES},
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
        measured=[path for path in [CONFIG.calibration.drop_test.measured] if path],
    output:
        **({"over_speed": f"{CALIBRATION}/restitution_over_speed.tsv"} if CONFIG.calibration.drop_test.measured else {}),
        drops=f"{CALIBRATION}/drop_test.tsv",
        restitution=f"{CALIBRATION}/restitution.tsv",
        drops_figure=figures(f"{CALIBRATION}/drop_test"),
        friction_figures=figures(*(f"{CALIBRATION}/{name}/friction_fit" for name in EXPERIMENTS)),
    log:
        f"{LOGS}/calibration/calibrate_restitution.log",
    benchmark:
        f"{BENCHMARKS}/calibrate_restitution/calibrate_restitution.tsv"
    params:
        contacts=[CONTACTS[name].model_dump(mode="json") for name in CONFIG.contacts],
        time_step_s=CONFIG.dem.time_step_s,
        rayleigh_fraction_max=CONFIG.dem.rayleigh_fraction_max,
        settings=settings("calibration.drop_test"),
        interval=CONFIG.calibration.interval,
    message:
        "Simulating the drop test, fitting the restitution, and drawing the calibration"
    script:
        "../../scripts/calibrate_restitution.py"


CALIBRATION_OUTPUTS = [
    *rules.calibrate_restitution.output,
    *expand(rules.fit_friction.output, experiment=EXPERIMENTS),
]


rule calibration:
    """The drop test and the friction of chapter 3."""
    input:
        CALIBRATION_OUTPUTS,

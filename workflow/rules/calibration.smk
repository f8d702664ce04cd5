"""Virtual calibration: the drop test and the oscillating ball (thesis Sec. 3.2.2)."""

from millprint.config.calibration import SwingConfig

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
            for file in MILLS[name].source_files
        ],
    output:
        track=f"{CALIBRATION}/{{experiment}}/track.tsv",
        fit=f"{CALIBRATION}/{{experiment}}/friction_fit.tsv",
        profile=f"{CALIBRATION}/{{experiment}}/profile.tsv",
        paths=f"{CALIBRATION}/{{experiment}}/paths.tsv",
        swings=f"{CALIBRATION}/{{experiment}}/swings.tsv",
    log:
        f"{LOGS}/calibration/fit_friction_{{experiment}}.log",
    benchmark:
        f"{BENCHMARKS}/fit_friction/{{experiment}}.tsv"
    params:
        experiment=lambda wildcards: EXPERIMENTS[wildcards.experiment].model_dump(mode="json"),
        mills=lambda wildcards: {
            key: dumped(MILLS[name]) for key, name in EXPERIMENTS[wildcards.experiment].mills(CONFIG.mill).items()
        },
        contact=lambda wildcards: CONTACTS[EXPERIMENTS[wildcards.experiment].contact].model_dump(mode="json"),
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
        drops=f"{CALIBRATION}/drop_test.tsv",
        restitution=f"{CALIBRATION}/restitution.tsv",
        drops_svg=report(
            f"{CALIBRATION}/drop_test.svg",
            caption="../report/drop_test.rst",
            category="Chapter 3",
            labels={"figure": "Sec. 3.2.2", "shows": "restitution from the drop test"},
        ),
        drops_png=f"{CALIBRATION}/drop_test.png",
        friction_svgs=[
            report(
                f"{CALIBRATION}/{name}/friction_fit.svg",
                caption="../report/friction_fit.rst",
                category="Chapter 3",
                labels={"figure": "3.3", "shows": f"friction pair of the oscillating ball, {name}"},
            )
            for name in EXPERIMENTS
        ],
        friction_pngs=[f"{CALIBRATION}/{name}/friction_fit.png" for name in EXPERIMENTS],
    log:
        f"{LOGS}/calibration/calibrate_restitution.log",
    benchmark:
        f"{BENCHMARKS}/calibrate_restitution/calibrate_restitution.tsv"
    params:
        contacts=[CONTACTS[name].model_dump(mode="json") for name in CONFIG.contacts],
        time_step_s=CONFIG.dem.time_step_s,
        rayleigh_fraction_max=CONFIG.dem.rayleigh_fraction_max,
        settings=CONFIG.calibration.drop_test.model_dump(mode="json"),
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
    input:
        CALIBRATION_OUTPUTS,
    localrule: True
    message:
        "The calibration is complete"

"""Chapter 6 and appendix A: the graph-network surrogate, its roll-outs, and the ablations."""

import math


include: "surrogate_common.smk"


SURROGATE_TESTS = list(CONFIG.surrogate.tests)
MOVING_TESTS = [name for name, test in CONFIG.surrogate.tests.items() if not test.driven]
SURROGATE_TABLES = ["metrics", "errors", "dissipation", "distributions"]

# Everything of chapter 6, for the chapter's target, `all` and the table of claims.
SURROGATE_OUTPUTS = [
    *(f"{SURROGATE}/{name}" for name in ("wall_contacts.tsv", "metrics.tsv", "runtime.tsv", "controls.tsv")),
    *(
        f"{SURROGATE}/{name}.{kind}"
        for name in ("signed_distance", "wall_contacts", "recursion")
        for kind in ("svg", "png")
    ),
    *expand(
        f"{SURROGATE}/{{variant}}/{{name}}.{{kind}}",
        variant=CONFIG.surrogate.variants,
        name=("loss", "error_growth", "dissipation", "distributions"),
        kind=("svg", "png"),
    ),
    *expand(
        f"{SURROGATE}/{{variant}}/{{test}}/{{name}}",
        variant=CONFIG.surrogate.variants,
        test=MOVING_TESTS,
        name=("motion.svg", "motion.png", "motion.gif"),
    ),
]


wildcard_constraints:
    variant="|".join([*CONFIG.surrogate.variants, *CONFIG.surrogate.ablations]),
    test="|".join(SURROGATE_TESTS),


rule build_surrogate_dataset:
    input:
        runs=[simulated(case) for case in CONFIG.surrogate.snapshots.cases],
    output:
        dataset=f"{SURROGATE}/dataset.h5",
        wall_contacts=f"{SURROGATE}/wall_contacts.tsv",
    log:
        f"{LOGS}/surrogate/build_surrogate_dataset.log",
    benchmark:
        f"{BENCHMARKS}/build_surrogate_dataset/build_surrogate_dataset.tsv"
    conda:
        "../../envs/millprint.yaml"
    params:
        settings=CONFIG.surrogate.snapshots.model_dump(mode="json"),
        library=library("build_surrogate_dataset.py"),
    message:
        "Features, targets and contacts of every snapshot to train on"
    script:
        "../../scripts/build_surrogate_dataset.py"


rule trace_surrogate_contacts:
    input:
        kernels=ancient(f"{RESULTS}/dem/kernels.json"),
    output:
        dataset=f"{SURROGATE}/contacts.h5",
    log:
        f"{LOGS}/surrogate/trace_surrogate_contacts.log",
    benchmark:
        f"{BENCHMARKS}/trace_surrogate_contacts/trace_surrogate_contacts.tsv"
    conda:
        "../../envs/millprint.yaml"
    params:
        **contact_settings(),
        library=library("trace_surrogate_contacts.py"),
    message:
        "Simulations whose contacts are followed coarse step by coarse step"
    script:
        "../../scripts/trace_surrogate_contacts.py"


rule train_contact_surrogate:
    input:
        dataset=rules.trace_surrogate_contacts.output.dataset,
    output:
        weights=f"{SURROGATE}/{{variant}}/weights.pt",
        history=f"{SURROGATE}/{{variant}}/loss.tsv",
    log:
        f"{LOGS}/surrogate/{{variant}}/train_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/train_contact_surrogate/{{variant}}.tsv"
    wildcard_constraints:
        variant=any_of(CONFIG.surrogate.of_kind("contact")),
    conda:
        "../../envs/millprint.yaml"
    threads: CONFIG.surrogate.contact.training.threads
    params:
        **contact_settings(),
        library=library("train_contact_surrogate.py"),
    message:
        "Train the ensemble of the surrogate {wildcards.variant}"
    script:
        "../../scripts/train_contact_surrogate.py"


rule train_surrogate:
    input:
        dataset=rules.build_surrogate_dataset.output.dataset,
    output:
        weights=f"{SURROGATE}/{{variant}}/weights.pt",
        history=f"{SURROGATE}/{{variant}}/loss.tsv",
    log:
        f"{LOGS}/surrogate/{{variant}}/train_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/train_surrogate/{{variant}}.tsv"
    wildcard_constraints:
        variant=any_of(CONFIG.surrogate.of_kind("graph")),
    # The longest chain of the thesis begins here.
    priority: 1
    retries: RETRIES
    conda:
        "../../envs/millprint.yaml"
    threads: lambda wildcards: CONFIG.surrogate.variant(wildcards.variant).training.threads
    resources:
        # Twice its own limit [min], and some to start.
        runtime=lambda wildcards: 20
        + math.ceil(CONFIG.surrogate.variant(wildcards.variant).training.wall_time_max_s / 30),
    params:
        settings=lambda wildcards: CONFIG.surrogate.variant(wildcards.variant).recipe().model_dump(mode="json"),
        library=library("train_surrogate.py"),
    message:
        "Train the surrogate {wildcards.variant}"
    script:
        "../../scripts/train_surrogate.py"


rule roll_out_surrogate:
    input:
        weights=variant_weights,
        run=lambda wildcards: simulated(CONFIG.surrogate.tests[wildcards.test].case),
    output:
        rollout=f"{SURROGATE}/{{variant}}/{{test}}/rollout.h5",
    log:
        f"{LOGS}/surrogate/{{variant}}/{{test}}/roll_out_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/roll_out_surrogate/{{variant}}/{{test}}.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        edges=variant_settings("edges"),
        settings=rollout_settings,
        test=test_settings,
        library=library("roll_out_surrogate.py"),
    message:
        "Roll out the surrogate {wildcards.variant}: {wildcards.test}"
    script:
        "../../scripts/roll_out_surrogate.py"


rule evaluate_surrogate:
    input:
        unpack(compared_runs),
        rollouts=lambda wildcards: expand(
            rules.roll_out_surrogate.output.rollout,
            variant=wildcards.variant,
            test=tests_of(wildcards.variant),
        ),
    output:
        **{name: f"{SURROGATE}/{{variant}}/{name}.tsv" for name in SURROGATE_TABLES},
    log:
        f"{LOGS}/surrogate/{{variant}}/evaluate_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/evaluate_surrogate/{{variant}}.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        tests=lambda wildcards: tests_of(wildcards.variant),
        library=library("evaluate_surrogate.py"),
    message:
        "Measure the surrogate {wildcards.variant} against the simulation"
    script:
        "../../scripts/evaluate_surrogate.py"


rule evaluate_single_steps:
    input:
        weights=variant_weights,
        runs=lambda wildcards: [
            simulated(CONFIG.surrogate.tests[name].case) for name in moving_tests_of(wildcards.variant)
        ],
    output:
        steps=f"{SURROGATE}/{{variant}}/single_steps.tsv",
    log:
        f"{LOGS}/surrogate/{{variant}}/evaluate_single_steps.log",
    benchmark:
        f"{BENCHMARKS}/evaluate_single_steps/{{variant}}.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        edges=variant_settings("edges"),
        starts_s=lambda wildcards: {
            name: CONFIG.surrogate.tests[name].starts_s[0] for name in moving_tests_of(wildcards.variant)
        },
        library=library("evaluate_single_steps.py"),
    message:
        "Single steps of the surrogate {wildcards.variant}"
    script:
        "../../scripts/evaluate_single_steps.py"


rule check_measures:
    input:
        unpack(trained_runs),
    output:
        controls=f"{SURROGATE}/controls.tsv",
    log:
        f"{LOGS}/surrogate/check_measures.log",
    benchmark:
        f"{BENCHMARKS}/check_measures/check_measures.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        start_s=CONFIG.surrogate.tests[CONFIG.surrogate.trained_test].starts_s[0],
        interval_s=CONFIG.surrogate.rollout.frame_interval_s,
        test=CONFIG.surrogate.trained_test,
        library=library("check_measures.py"),
    message:
        "What the measures make of roll-outs that are known to be right or wrong"
    script:
        "../../scripts/check_measures.py"


rule time_surrogates:
    input:
        weights=[f"{SURROGATE}/{variant}/weights.pt" for variant in CONFIG.surrogate.variants],
        trained=simulated(CONFIG.surrogate.snapshots.cases[0]),
        runs=[simulated(case) for case in CONFIG.surrogate.timing.cases],
    output:
        runtime=f"{SURROGATE}/runtime.tsv",
    log:
        f"{LOGS}/surrogate/time_surrogates.log",
    benchmark:
        f"{BENCHMARKS}/time_surrogates/time_surrogates.tsv"
    conda:
        "../../envs/millprint.yaml"
    # It uses one thread, and takes every core so that nothing runs beside what is timed.
    threads: workflow.cores
    params:
        variants={
            variant: {
                section: getattr(CONFIG.surrogate.variant(variant), section).model_dump(mode="json")
                for section in ("edges", "rollout")
            }
            for variant in CONFIG.surrogate.variants
        },
        timing=CONFIG.surrogate.timing.model_dump(mode="json"),
        library=library("time_surrogates.py"),
    message:
        "Time the surrogates beside our simulation"
    script:
        "../../scripts/time_surrogates.py"


rule collect_surrogate:
    input:
        metrics=[path for variant in CONFIG.surrogate.variants for path in measured(variant)],
    output:
        metrics=f"{SURROGATE}/metrics.tsv",
    log:
        f"{LOGS}/surrogate/collect_surrogate.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        library=library("collect_surrogate.py"),
    message:
        "Measures of every surrogate"
    script:
        "../../scripts/collect_surrogate.py"


rule plot_surrogate_data:
    input:
        run=simulated(CONFIG.surrogate.snapshots.cases[0]),
        wall_contacts=rules.build_surrogate_dataset.output.wall_contacts,
    output:
        slices_svg=report(
            f"{SURROGATE}/signed_distance.svg",
            caption="../report/surrogate_signed_distance.rst",
            category="Chapter 6",
            labels={"figure": "signed distance (Fig. 6.3)"},
        ),
        slices_png=f"{SURROGATE}/signed_distance.png",
        contacts_svg=report(
            f"{SURROGATE}/wall_contacts.svg",
            caption="../report/surrogate_wall_contacts.rst",
            category="Chapter 6",
            labels={"figure": "wall contacts (Fig. 6.4)"},
        ),
        contacts_png=f"{SURROGATE}/wall_contacts.png",
        loop_svg=report(
            f"{SURROGATE}/recursion.svg",
            caption="../report/surrogate_recursion.rst",
            category="Chapter 6",
            labels={"figure": "recursive stage (Fig. 6.5)"},
        ),
        loop_png=f"{SURROGATE}/recursion.png",
    log:
        f"{LOGS}/surrogate/plot_surrogate_data.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        settings={
            section: getattr(CONFIG.surrogate, section).model_dump(mode="json")
            for section in ("graph", "edges", "network", "training", "rollout")
        },
        library=library("plot_surrogate_data.py"),
    message:
        "Draw the signed distance of the jar, its wall contacts and the recursion"
    script:
        "../../scripts/plot_surrogate_data.py"


rule plot_surrogate:
    input:
        **rules.evaluate_surrogate.output,
        history=f"{SURROGATE}/{{variant}}/loss.tsv",
    output:
        loss_svg=report(
            f"{SURROGATE}/{{variant}}/loss.svg",
            caption="../report/surrogate_loss.rst",
            category="Chapter 6",
            labels={"figure": "loss of {variant} (Fig. 6.6)"},
        ),
        loss_png=f"{SURROGATE}/{{variant}}/loss.png",
        errors_svg=report(
            f"{SURROGATE}/{{variant}}/error_growth.svg",
            caption="../report/surrogate_error_growth.rst",
            category="Chapter 6",
            labels={"figure": "position error of {variant} (Figs 6.7, 6.11)"},
        ),
        errors_png=f"{SURROGATE}/{{variant}}/error_growth.png",
        dissipation_svg=report(
            f"{SURROGATE}/{{variant}}/dissipation.svg",
            caption="../report/surrogate_dissipation.rst",
            category="Chapter 6",
            labels={"figure": "dissipation of {variant} (Figs 6.8, 6.14, 6.15, 6.17)"},
        ),
        dissipation_png=f"{SURROGATE}/{{variant}}/dissipation.png",
        distributions_svg=report(
            f"{SURROGATE}/{{variant}}/distributions.svg",
            caption="../report/surrogate_distributions.rst",
            category="Chapter 6",
            labels={"figure": "distributions of {variant}"},
        ),
        distributions_png=f"{SURROGATE}/{{variant}}/distributions.png",
    log:
        f"{LOGS}/surrogate/{{variant}}/plot_surrogate.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        tests=MOVING_TESTS,
        library=library("plot_surrogate.py"),
    message:
        "Draw loss and roll-outs of the surrogate {wildcards.variant}"
    script:
        "../../scripts/plot_surrogate.py"


rule compare_motion:
    input:
        rollouts=expand(f"{SURROGATE}/{{{{variant}}}}/{{test}}/rollout.h5", test=MOVING_TESTS),
        runs=[simulated(CONFIG.surrogate.tests[test].runs()["dem"]) for test in MOVING_TESTS],
    output:
        stills=[
            report(
                f"{SURROGATE}/{{variant}}/{test}/motion.svg",
                caption="../report/surrogate_motion.rst",
                category="Chapter 6",
                labels={"figure": f"balls of {{variant}}, {test} (Figs 6.9, 6.12, 6.13, 6.18)"},
            )
            for test in MOVING_TESTS
        ],
        pngs=[f"{SURROGATE}/{{variant}}/{test}/motion.png" for test in MOVING_TESTS],
        gifs=[f"{SURROGATE}/{{variant}}/{test}/motion.gif" for test in MOVING_TESTS],
        # Snakemake's report shows a PNG, also one that moves, but hands a GIF out as a download only. One is enough
        # for a report that is sent by mail.
        movie=report(
            f"{SURROGATE}/{{variant}}/{CONFIG.surrogate.trained_test}/motion_animated.png",
            caption="../report/surrogate_motion.rst",
            category="Chapter 6",
            labels={"figure": "animation of {variant} (Fig. 6.9)"},
        ),
    log:
        f"{LOGS}/surrogate/{{variant}}/compare_motion.log",
    benchmark:
        f"{BENCHMARKS}/compare_motion/{{variant}}.tsv"
    conda:
        "../../envs/millprint.yaml"
    threads: 1
    params:
        tests=MOVING_TESTS,
        trained=CONFIG.surrogate.trained_test,
        settings=CONFIG.surrogate.movie.model_dump(mode="json"),
        library=library("compare_motion.py"),
    message:
        "Draw balls of the surrogate {wildcards.variant} beside those of the simulation"
    script:
        "../../scripts/compare_motion.py"


rule tabulate_ablations:
    input:
        metrics=[path for variant in CONFIG.surrogate.ablations for path in measured(variant)],
        histories=[
            f"{SURROGATE}/{CONFIG.surrogate.weights_of(variant)}/loss.tsv" for variant in CONFIG.surrogate.ablations
        ],
    output:
        ablations=f"{SURROGATE}/ablations.tsv",
    log:
        f"{LOGS}/surrogate/tabulate_ablations.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        changes={variant: changes(variant) for variant in CONFIG.surrogate.ablations},
        length_s={
            variant: CONFIG.surrogate.rollout_of(variant, CONFIG.surrogate.trained_test).length_s
            for variant in CONFIG.surrogate.ablations
        },
        library=library("tabulate_ablations.py"),
    message:
        "Every ablation beside what the thesis says of it"
    script:
        "../../scripts/tabulate_ablations.py"


rule plot_ablations:
    input:
        ablations=rules.tabulate_ablations.output.ablations,
    output:
        svg=report(
            f"{SURROGATE}/ablations.svg",
            caption="../report/surrogate_ablations.rst",
            category="Appendix A",
            labels={"figure": "ablations (Figs A.1 to A.8)"},
        ),
        png=f"{SURROGATE}/ablations.png",
    log:
        f"{LOGS}/surrogate/plot_ablations.log",
    localrule: True
    conda:
        "../../envs/millprint.yaml"
    params:
        library=library("plot_ablations.py"),
    message:
        "Draw the ablations of appendix A"
    script:
        "../../scripts/plot_ablations.py"


# Appendix A. Not part of `all`: nine more trainings, as long as that of the variant `thesis`.
rule ablations:
    input:
        rules.tabulate_ablations.output,
        rules.plot_ablations.output,
    localrule: True

"""Chapter 6 and appendix A: surrogates of the simulation."""

SURROGATE = f"{RESULTS}/surrogate"
SURROGATE_TESTS = list(CONFIG.surrogate.tests)
# By variant, the names of all of its trainings.
TRAININGS = {variant: CONFIG.surrogate.trainings_of(variant) for variant in CONFIG.surrogate.variants}
ROLLOUT = f"{SURROGATE}/{{variant}}/{{test}}/rollout.h5"
# The names of the variants, the ablations and their further trainings.
SURROGATES = [*CONFIG.surrogate.every, *CONFIG.surrogate.trained_again]
MOVING_TESTS = [name for name, test in CONFIG.surrogate.tests.items() if not test.driven]
# Every training of an ablation.
ABLATED = [name for name in SURROGATES if CONFIG.surrogate.training_of(name)[0] in CONFIG.surrogate.ablations]


wildcard_constraints:
    variant="|".join(SURROGATES),
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
    priority: 1
    params:
        settings=settings("surrogate.snapshots"),
    message:
        "Calculating features, targets and contacts of every training snapshot"
    script:
        "../../scripts/build_surrogate_dataset.py"


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
    priority: 1
    threads: lambda wildcards: CONFIG.surrogate.variant(wildcards.variant).training.threads
    resources:
        # Twice its own limit, and 20 min to start.
        runtime=lambda wildcards: (
            20 + math.ceil(CONFIG.surrogate.variant(wildcards.variant).training.wall_time_max_s / 30)
        ),
    params:
        recipe=lambda wildcards: CONFIG.surrogate.variant(wildcards.variant).recipe().model_dump(mode="json"),
    message:
        "Training the surrogate {wildcards.variant}"
    script:
        "../../scripts/train_surrogate.py"


SURROGATE_TABLES = ["metrics", "errors", "dissipation", "distributions", "single_steps"]


rule roll_out_surrogate:
    input:
        weights=lambda wildcards: weights_for(wildcards.variant),
        runs=lambda wildcards: [simulated(CONFIG.surrogate.tests[test].case) for test in tests_of(wildcards.variant)],
    output:
        rollouts=expand(ROLLOUT, test=SURROGATE_TESTS, allow_missing=True),
    log:
        f"{LOGS}/surrogate/{{variant}}/roll_out_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/roll_out_surrogate/{{variant}}.tsv"
    wildcard_constraints:
        variant=none_of(ABLATED),
    priority: 1
    params:
        edges=lambda wildcards: edges_of(wildcards.variant),
        tests=lambda wildcards: {test: rollout_in(wildcards.variant, test) for test in tests_of(wildcards.variant)},
    message:
        "Rolling out the surrogate {wildcards.variant} in every test"
    script:
        "../../scripts/roll_out_surrogate.py"


# An ablation has other files: a roll-out in one test.
use rule roll_out_surrogate as roll_out_ablation with:
    output:
        rollouts=[ROLLOUT.replace("{test}", CONFIG.surrogate.trained_test)],
    wildcard_constraints:
        variant=any_of(ABLATED),
    message:
        "Rolling out the surrogate {wildcards.variant} in the test on the training motion"


rule evaluate_surrogate:
    input:
        unpack(lambda wildcards: compared_runs(tests_of(wildcards.variant))),
        rollouts=lambda wildcards: expand(ROLLOUT, variant=wildcards.variant, test=tests_of(wildcards.variant)),
        claims=CONFIG.data.claims,
        weights=lambda wildcards: weights_for(wildcards.variant),
        stepped=lambda wildcards: [
            simulated(CONFIG.surrogate.tests[test].case) for test in starts_in(tests_of(wildcards.variant))
        ],
    output:
        **{name: f"{SURROGATE}/{{variant}}/{name}.tsv" for name in SURROGATE_TABLES},
    log:
        f"{LOGS}/surrogate/{{variant}}/evaluate_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/evaluate_surrogate/{{variant}}.tsv"
    priority: 1
    params:
        edges=lambda wildcards: edges_of(wildcards.variant),
        tests=lambda wildcards: tests_of(wildcards.variant),
        starts_s=lambda wildcards: starts_in(tests_of(wildcards.variant)),
    message:
        "Comparing the surrogate {wildcards.variant} with the simulation, over roll-outs and single steps"
    script:
        "../../scripts/evaluate_surrogate.py"


rule check_measures:
    input:
        **compared_runs(MOVING_TESTS),
        trained=[simulated(case) for case in CONFIG.surrogate.snapshots.cases],
    output:
        controls=f"{SURROGATE}/controls.tsv",
    log:
        f"{LOGS}/surrogate/check_measures.log",
    benchmark:
        f"{BENCHMARKS}/check_measures/check_measures.tsv"
    params:
        starts_s=starts_in(SURROGATE_TESTS),
        # As long as the roll-outs of the first variant.
        lengths_s={test: CONFIG.surrogate.rollout_of(list(TRAININGS)[0], test).length_s for test in MOVING_TESTS},
        interval_s=CONFIG.surrogate.rollout.frame_interval_s,
        train_until_s=CONFIG.surrogate.snapshots.train_until_s,
    message:
        "Checking the measures with roll-outs that are known to be right or wrong, and with those in which nothing is learned"
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
    priority: 1
    # The job uses one thread. With a request for more than any machine has, Snakemake reserves all cores for it, so that
    # no other job disturbs the timing.
    threads: 1024
    params:
        variants={
            name: {
                "edges": CONFIG.surrogate.variant(name).edges.model_dump(mode="json"),
                "snap_back_m": CONFIG.surrogate.variant(name).rollout.snap_back_m,
            }
            for name in CONFIG.surrogate.variants
        },
        timing=settings("surrogate.timing"),
    message:
        "Timing the surrogates and the simulation"
    script:
        "../../scripts/roll_out_surrogate.py"


VARIANT_FIGURES = ("loss", "error_growth", "dissipation", "distributions")


rule plot_surrogates:
    input:
        **{
            name: expand(rules.evaluate_surrogate.output[name], variant=CONFIG.surrogate.variants)
            for name in ("errors", "distributions")
        },
        run=simulated(CONFIG.surrogate.snapshots.cases[0]),
        wall_contacts=rules.build_surrogate_dataset.output.wall_contacts,
        histories=expand(f"{SURROGATE}/{{variant}}/loss.tsv", variant=CONFIG.surrogate.variants),
        controls=rules.check_measures.output.controls,
        # Of every training of a variant.
        measured=[path for variant in CONFIG.surrogate.variants for path in measured_trainings(variant)],
        dissipation=[
            path
            for variant in CONFIG.surrogate.variants
            for path in expand(rules.evaluate_surrogate.output.dissipation, variant=TRAININGS[variant])
        ],
    output:
        metrics=f"{SURROGATE}/metrics.tsv",
        trainings=f"{SURROGATE}/trainings.tsv",
        baselines=f"{SURROGATE}/baselines.tsv",
        against=f"{SURROGATE}/against_baselines.tsv",
        slices_figure=figures(f"{SURROGATE}/signed_distance"),
        slices_tsv=f"{SURROGATE}/signed_distance.tsv",
        contacts_figure=figures(f"{SURROGATE}/wall_contacts"),
        loop_figure=figures(f"{SURROGATE}/recursion"),
        variant_figures=figures(
            *(f"{SURROGATE}/{variant}/{name}" for variant in CONFIG.surrogate.variants for name in VARIANT_FIGURES)
        ),
    log:
        f"{LOGS}/surrogate/plot_surrogates.log",
    priority: 1
    localrule: True
    params:
        window=CONFIG.surrogate.graph.window,
        edges=settings("surrogate.edges"),
        snap_back_m=CONFIG.surrogate.rollout.snap_back_m,
        tests=MOVING_TESTS,
        trained_test=CONFIG.surrogate.trained_test,
        trainings=TRAININGS,
    message:
        "Collecting the measures of every surrogate, and drawing their input, losses and roll-outs"
    script:
        "../../scripts/plot_surrogates.py"


# Variants and the tests with moving balls, in the order of the animations.
MOVED = [(variant, test) for variant in CONFIG.surrogate.variants for test in MOVING_TESTS]


rule compare_motion:
    input:
        rollouts=[ROLLOUT.format(variant=variant, test=test) for variant, test in MOVED],
        runs=[simulated(CONFIG.surrogate.tests[test].runs()["dem"]) for _, test in MOVED],
    output:
        stills=[shown(f"{SURROGATE}/{variant}/{test}/motion.svg") for variant, test in MOVED],
        pngs=[f"{SURROGATE}/{variant}/{test}/motion.png" for variant, test in MOVED],
        tsvs=[f"{SURROGATE}/{variant}/{test}/motion.tsv" for variant, test in MOVED],
        gifs=[f"{SURROGATE}/{variant}/{test}/motion.gif" for variant, test in MOVED],
        # Snakemake's report shows a PNG, even an animated one, but offers a GIF only as a download. One animation of each
        # variant keeps the report small enough for mail.
        movies=[
            shown(f"{SURROGATE}/{variant}/{CONFIG.surrogate.trained_test}/motion_animated.png")
            for variant in CONFIG.surrogate.variants
        ],
    log:
        f"{LOGS}/surrogate/compare_motion.log",
    benchmark:
        f"{BENCHMARKS}/compare_motion/compare_motion.tsv"
    priority: 1
    params:
        moved=MOVED,
        trained=CONFIG.surrogate.trained_test,
    message:
        "Drawing the balls of the surrogates next to those of the simulation"
    script:
        "../../scripts/compare_motion.py"


SURROGATE_OUTPUTS = [
    rules.build_surrogate_dataset.output.wall_contacts,
    rules.check_measures.output.controls,
    rules.time_surrogates.output.runtime,
    *rules.plot_surrogates.output,
    *rules.compare_motion.output,
]


rule ablations:
    """Appendix A: the ablations of the surrogate."""
    input:
        measured=[path for variant in CONFIG.surrogate.ablations for path in measured_trainings(variant)],
        histories=[
            f"{SURROGATE}/{CONFIG.surrogate.weights_of(variant)}/loss.tsv" for variant in CONFIG.surrogate.ablations
        ],
        claims=CONFIG.data.claims,
    output:
        ablations=f"{SURROGATE}/ablations.tsv",
        figure=figures(f"{SURROGATE}/ablations"),
    log:
        f"{LOGS}/surrogate/ablations.log",
    localrule: True
    params:
        trainings={variant: CONFIG.surrogate.trainings_of(variant) for variant in CONFIG.surrogate.ablations},
        changes={variant: changes(variant) for variant in CONFIG.surrogate.ablations},
        length_s={
            variant: CONFIG.surrogate.rollout_of(variant, CONFIG.surrogate.trained_test).length_s
            for variant in CONFIG.surrogate.ablations
        },
    message:
        "Tabulating every ablation next to the statement of the thesis, and drawing them"
    script:
        "../../scripts/plot_surrogates.py"

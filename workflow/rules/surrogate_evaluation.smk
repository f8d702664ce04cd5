"""Surrogates against the simulation: roll-outs, single steps, measures and timings."""

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
        variant=none_of([*ABLATED, *QUICK_TRAININGS]),
    priority: 1
    params:
        variants=lambda wildcards: {wildcards.variant: rolled_out(wildcards.variant)},
    message:
        "Rolling out the surrogate {wildcards.variant} in every test"
    script:
        "../../scripts/roll_out_surrogate.py"


use rule roll_out_surrogate as roll_out_ablation with:
    output:
        rollouts=[ROLLOUT.replace("{test}", CONFIG.surrogate.trained_test)],
    wildcard_constraints:
        variant=any_of(ABLATED),
    message:
        "Rolling out the surrogate {wildcards.variant} in the test on the training motion"


if QUICK_TRAININGS:

    use rule roll_out_surrogate as roll_out_quick_surrogates with:
        input:
            weights=list(dict.fromkeys(map(weights_for, QUICK_TRAININGS))),
            runs=[simulated(test.case) for test in CONFIG.surrogate.tests.values()],
        output:
            rollouts=[ROLLOUT.format(variant=each, test=test) for each in QUICK_TRAININGS for test in SURROGATE_TESTS],
        log:
            f"{LOGS}/surrogate/roll_out_surrogates.log",
        benchmark:
            f"{BENCHMARKS}/roll_out_surrogate/quick.tsv"
        params:
            variants={each: rolled_out(each) for each in QUICK_TRAININGS},
        message:
            "Rolling out {QUICK_TRAININGS} in every test"


rule evaluate_surrogate:
    input:
        unpack(lambda wildcards: compared_runs(tests_of(wildcards.variant))),
        rollouts=lambda wildcards: expand(ROLLOUT, variant=wildcards.variant, test=tests_of(wildcards.variant)),
        claims=CONFIG.data.claims,
        weights=lambda wildcards: [weights_for(wildcards.variant)],
        stepped=lambda wildcards: stepped_in(tests_of(wildcards.variant)),
    output:
        **{name: [f"{SURROGATE}/{{variant}}/{name}.tsv"] for name in SURROGATE_TABLES},
    log:
        f"{LOGS}/surrogate/{{variant}}/evaluate_surrogate.log",
    benchmark:
        f"{BENCHMARKS}/evaluate_surrogate/{{variant}}.tsv"
    wildcard_constraints:
        variant=any_of([name for name in SURROGATES if name not in QUICK_TRAININGS]),
    priority: 1
    params:
        variants=lambda wildcards: {wildcards.variant: edges_of(wildcards.variant)},
        tests=lambda wildcards: tests_of(wildcards.variant),
        starts_s=lambda wildcards: starts_in(tests_of(wildcards.variant)),
    message:
        "Comparing the surrogate {wildcards.variant} with the simulation, over roll-outs and single steps"
    script:
        "../../scripts/evaluate_surrogate.py"


if QUICK_TRAININGS:

    use rule evaluate_surrogate as evaluate_quick_surrogates with:
        input:
            **compared_runs(SURROGATE_TESTS),
            rollouts=expand(ROLLOUT, variant=QUICK_TRAININGS, test=SURROGATE_TESTS),
            claims=CONFIG.data.claims,
            weights=list(map(weights_for, QUICK_TRAININGS)),
            stepped=stepped_in(SURROGATE_TESTS),
        output:
            **{
                name: expand(f"{SURROGATE}/{{variant}}/{name}.tsv", variant=QUICK_TRAININGS)
                for name in SURROGATE_TABLES
            },
        log:
            f"{LOGS}/surrogate/evaluate_surrogates.log",
        benchmark:
            f"{BENCHMARKS}/evaluate_surrogate/quick.tsv"
        params:
            variants={each: edges_of(each) for each in QUICK_TRAININGS},
            tests=SURROGATE_TESTS,
            starts_s=starts_in(SURROGATE_TESTS),
        message:
            "Comparing {QUICK_TRAININGS} with the simulation"


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
        timing=CONFIG.surrogate.timing.model_dump(mode="json"),
    message:
        "Timing the surrogates and the simulation"
    script:
        "../../scripts/time_surrogates.py"

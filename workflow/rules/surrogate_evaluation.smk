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
        stepped=lambda wildcards: stepped_in(tests_of(wildcards.variant)),
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
        timing=CONFIG.surrogate.timing.model_dump(mode="json"),
    message:
        "Timing the surrogates and the simulation"
    script:
        "../../scripts/time_surrogates.py"

"""How far the averaged model can be trusted: its library, chance, and what all tables say, in sentences."""

from millprint.config.yields import HeldOutConfig


rule compare_libraries:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        libraries=f"{YIELDS}/libraries.tsv",
        members=f"{YIELDS}/library_members.tsv",
    log:
        f"{LOGS}/yields/compare_libraries.log",
    benchmark:
        f"{BENCHMARKS}/compare_libraries/compare_libraries.tsv"
    params:
        training=yield_settings("training"),
        honest=CONFIG.yields.honest.part(HeldOutConfig),
        averaging=yield_settings("averaging"),
        trial=yield_settings("library_trial"),
        library=library("compare_libraries.py"),
    message:
        "Scoring the declared library, the one before it and random halves of both"
    script:
        "../../scripts/compare_libraries.py"


rule permute_yields:
    input:
        rules.split_screening.output.train,
        rules.split_screening.output.test,
    output:
        permutations=f"{YIELDS}/permutations.tsv",
        test=f"{YIELDS}/permutation_test.tsv",
    log:
        f"{LOGS}/yields/permute_yields.log",
    benchmark:
        f"{BENCHMARKS}/permute_yields/permute_yields.tsv"
    params:
        averaging=yield_settings("averaging"),
        trial=yield_settings("library_trial"),
        library=library("permute_yields.py"),
    message:
        "Scoring the averaged model on shuffled yields"
    script:
        "../../scripts/permute_yields.py"


rule state_yields:
    input:
        honest=rules.evaluate_yield_models.output.honest,
        differences=rules.evaluate_yield_models.output.differences,
        scores=rules.evaluate_yield_models.output.scores,
        coverage=rules.evaluate_yield_models.output.coverage,
        libraries=rules.compare_libraries.output.libraries,
        permutation_test=rules.permute_yields.output.test,
    output:
        statements=f"{YIELDS}/statements.tsv",
    log:
        f"{LOGS}/yields/state_yields.log",
    localrule: True
    params:
        library=library("state_yields.py"),
    message:
        "Writing what the tables of the yield models say"
    script:
        "../../scripts/state_yields.py"

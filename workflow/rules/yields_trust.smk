"""How far the averaged model can be trusted: its library, and chance."""

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

"""How far the averaged model can be trusted: other libraries, and chance."""

from millprint.config.yields import HeldOutConfig

PERMUTED = {
    "permutations": f"{YIELDS}/permutations.tsv",
    "permutation_test": f"{YIELDS}/permutation_test.tsv",
}


rule try_alternatives:
    input:
        train=rules.split_screening.output.train,
        test=rules.split_screening.output.test,
    output:
        libraries=f"{YIELDS}/libraries.tsv",
    log:
        f"{LOGS}/yields/try_alternatives.log",
    benchmark:
        f"{BENCHMARKS}/try_alternatives/try_alternatives.tsv"
    params:
        training=yield_settings("training"),
        honest=CONFIG.yields.honest.part(HeldOutConfig),
        averaging=yield_settings("averaging"),
        trial=yield_settings("library_trial"),
    message:
        "Scoring the averaged model with the library declared, the one before it and random halves of both"
    script:
        "../../scripts/try_alternatives.py"


use rule try_alternatives as permute_yields with:
    output:
        **PERMUTED,
    log:
        f"{LOGS}/yields/permute_yields.log",
    benchmark:
        f"{BENCHMARKS}/permute_yields/permute_yields.tsv"
    params:
        averaging=yield_settings("averaging"),
        trial=yield_settings("library_trial"),
    message:
        "Scoring the averaged model on shuffled yields"

"""The fit of the jar, whose shape the thesis does not give: fitted values, values held back, and the search."""

from millprint.config.fit import TrialConfig
from millprint.thesis.fit import fitted_mill

FIT = f"{RESULTS}/fingerprint"
FIT_MILL = fitted_mill(CONFIG, MILLS)
FIT_OUTPUTS = []

if FIT_MILL:
    SIMULATED_JAR = {
        "mill": dumped(FIT_MILL),
        "contact": CONTACTS[CONFIG.fit.contact].model_dump(mode="json"),
        "dem": settings("dem"),
    }

    rule fit_jar:
        input:
            kernels=ancient(f"{RESULTS}/dem/kernels.json"),
            published=PUBLISHED,
        output:
            search=f"{FIT}/fit_search.tsv",
            geometry=f"{FIT}/fit_geometry.yaml",
        log:
            f"{LOGS}/fingerprint/fit_jar.log",
        benchmark:
            f"{BENCHMARKS}/fit_jar/fit_jar.tsv"
        params:
            **SIMULATED_JAR,
            settings=settings("fit"),
        message:
            "Searching the jar that agrees best with the published values chosen for the fit"
        script:
            "../../scripts/fit_jar.py"

    rule measure_fit_sensitivity:
        input:
            kernels=ancient(f"{RESULTS}/dem/kernels.json"),
            published=PUBLISHED,
        output:
            sensitivity=f"{FIT}/fit_sensitivity.tsv",
        log:
            f"{LOGS}/fingerprint/measure_fit_sensitivity.log",
        benchmark:
            f"{BENCHMARKS}/measure_fit_sensitivity/measure_fit_sensitivity.tsv"
        params:
            **SIMULATED_JAR,
            settings=CONFIG.fit.part(TrialConfig),
        message:
            "Measuring the effect of one step of each parameter of the jar"
        script:
            "../../scripts/measure_fit_sensitivity.py"

    rule tabulate_fit:
        input:
            descriptors=rules.tabulate_descriptors.output.descriptors,
            cycles=rules.tabulate_descriptors.output.cycles,
            published=PUBLISHED,
            sensitivity=rules.measure_fit_sensitivity.output.sensitivity,
        output:
            fit=f"{FIT}/fit.tsv",
        log:
            f"{LOGS}/fingerprint/tabulate_fit.log",
        localrule: True
        params:
            mill=SIMULATED_JAR["mill"],
            contact=CONFIG.fit.contact,
            fitted=CONFIG.fit.fitted,
            counting_rule=CONFIG.fingerprint.counting_rule,
        message:
            "Tabulating the fitted values and those held back"
        script:
            "../../scripts/tabulate_fit.py"

    rule measure_shape:
        input:
            search=rules.fit_jar.output.search,
            published=PUBLISHED,
        output:
            shape=f"{RESULTS}/uncertainty/{FIT_MILL.name}/shape.json",
        log:
            f"{LOGS}/uncertainty/{FIT_MILL.name}_shape.log",
        localrule: True
        params:
            mill=SIMULATED_JAR["mill"],
            settings=CONFIG.fit.part(TrialConfig),
            about={"counting_rule": CONFIG.fingerprint.counting_rule, "probability": CONFIG.fingerprint.interval},
        message:
            "Calculating what the fit leaves open of the shape of the jar"
        script:
            "../../scripts/measure_shape.py"

    rule fit:
        input:
            rules.fit_jar.output,
        localrule: True
        message:
            "The fit of the jar is complete"

    FIT_OUTPUTS += [
        *rules.measure_fit_sensitivity.output,
        *rules.tabulate_fit.output,
        # The search takes longer than the rest of the stage.
        *(rules.fit_jar.output if CONFIG.fit.in_all else []),
    ]

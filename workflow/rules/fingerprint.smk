"""Chapter 3: master curves with descriptors and inverse mode, fit of the jar, intervals of the curves."""

from millprint.thesis.fit import fitted_mill, numbers_of

FINGERPRINT = f"{RESULTS}/fingerprint"
FINGERPRINT_FIGURES = f"{FINGERPRINT}/figures"
DESCRIBED_CASES = described_cases(CONFIG, CASES)
# Values that the thesis prints; those that are claims are in the second table.
PUBLISHED = [CONFIG.data.published, CONFIG.data.claims]
OWN_FINGERPRINTS = [f"{FINGERPRINT}/fingerprint_{contact}.json" for contact in CONFIG.contacts]
# Those whose conditions are targets of the inverse mode.
LIKE_FINGERPRINTS = [target.like.fingerprint for target in CONFIG.fingerprint.inverse.targets if target.like]


wildcard_constraints:
    contact="|".join(CONTACTS),


rule fit_master_curves:
    input:
        summaries=[f"{RESULTS}/dem/{path}/summary.json" for path in DESCRIBED_CASES],
        runs=[f"{RESULTS}/dem/{path}/run.h5" for path in DESCRIBED_CASES],
        published=PUBLISHED,
        # A target may be a condition of the curves that are fitted here.
        others=[path for path in LIKE_FINGERPRINTS if path not in OWN_FINGERPRINTS],
    output:
        descriptors=f"{FINGERPRINT}/descriptors.tsv",
        counting_rules=f"{FINGERPRINT}/counting_rules.tsv",
        cycles=f"{FINGERPRINT}/cycles.tsv",
        densities=f"{FINGERPRINT}/cycle_densities.tsv",
        table_3_5=f"{FINGERPRINT}/table_3_5.tsv",
        means=expand(f"{FINGERPRINT}/means_{{contact}}.tsv", contact=CONFIG.contacts),
        curves=expand(f"{FINGERPRINT}/curves_{{contact}}.tsv", contact=CONFIG.contacts),
        fingerprint=OWN_FINGERPRINTS,
        coverage=expand(f"{FINGERPRINT}/coverage_{{contact}}.tsv", contact=CONFIG.contacts),
        collapse=f"{FINGERPRINT}/collapse.tsv",
        universal=f"{FINGERPRINT}/universal.tsv",
        exponents=f"{FINGERPRINT}/exponents.tsv",
        zones=f"{FINGERPRINT}/zones.tsv",
        inverse=f"{FINGERPRINT}/inverse.tsv",
        ranked=f"{FINGERPRINT}/inverse_ranked.tsv",
    log:
        f"{LOGS}/fingerprint/fit_master_curves.log",
    benchmark:
        f"{BENCHMARKS}/fit_master_curves/fit_master_curves.tsv"
    params:
        mill=CONFIG.mill,
        contacts=CONFIG.contacts,
        volume_m3=MILLS[CONFIG.mill].volume_ml * 1e-6,
        counting_rule=CONFIG.fingerprint.counting_rule,
        rules=rules_named(),
        cycle_fill_ratio=CONFIG.fingerprint.cycle_fill_ratio,
        interval=CONFIG.fingerprint.interval,
        smooth_points=CONFIG.fingerprint.smooth_points,
        inverse=settings("fingerprint.inverse"),
    message:
        "Tabulating every condition, fitting the master curves of {CONFIG.contacts}, and searching target descriptors"
    script:
        "../../scripts/fit_master_curves.py"


rule plot_fingerprint:
    input:
        descriptors=rules.fit_master_curves.output.descriptors,
        cycles=rules.fit_master_curves.output.cycles,
        densities=rules.fit_master_curves.output.densities,
        means=rules.fit_master_curves.output.means,
        curves=rules.fit_master_curves.output.curves,
        zones=rules.fit_master_curves.output.zones,
        universal=rules.fit_master_curves.output.universal,
        exponents=rules.fit_master_curves.output.exponents,
        published=PUBLISHED,
        runs=[path for contact in CONFIG.contacts for path in mapped_runs(contact).values()],
        spectra=expand(f"{DOSE}/spectra_{{contact}}.tsv", contact=CONFIG.contacts),
    output:
        densities_figure=figures(f"{FINGERPRINT_FIGURES}/cycle_densities"),
        means_figure=figures(f"{FINGERPRINT_FIGURES}/cycle_means"),
        energies=figures(*(f"{FINGERPRINT_FIGURES}/energies_{contact}" for contact in CONFIG.contacts)),
        curves=figures(*(f"{FINGERPRINT_FIGURES}/master_curves_{contact}" for contact in CONFIG.contacts)),
        universal_figure=figures(f"{FINGERPRINT_FIGURES}/universal_curves"),
        exponents_figure=figures(f"{FINGERPRINT_FIGURES}/exponents"),
        maps=figures(*(f"{FINGERPRINT_FIGURES}/maps_{contact}" for contact in CONFIG.contacts)),
        maps_tsvs=expand(f"{FINGERPRINT_FIGURES}/maps_{{contact}}.tsv", contact=CONFIG.contacts),
        spectra=figures(*(f"{DOSE}/spectra_{contact}" for contact in CONFIG.contacts)),
    log:
        f"{LOGS}/fingerprint/plot_fingerprint.log",
    localrule: True
    params:
        mill=CONFIG.mill,
        contacts=CONFIG.contacts,
        cycle_fill_ratio=CONFIG.fingerprint.cycle_fill_ratio,
        maps=[mapped_runs(contact) for contact in CONFIG.contacts],
        titles=[f"{MILLS[CONFIG.mill].title}, contact set {contact}" for contact in CONFIG.contacts],
        counting_rule=CONFIG.fingerprint.counting_rule,
        conditions=settings("fingerprint.maps"),
    message:
        "Drawing the figures of chapter 3: revolutions, master curves, their scaling, maps, and energy spectra"
    script:
        "../../scripts/plot_fingerprint.py"


FINGERPRINT_OUTPUTS = [*rules.fit_master_curves.output, *rules.plot_fingerprint.output]


FIT_MILL = fitted_mill(CONFIG, MILLS)
FIT_OUTPUTS = []
# The jars that fit as well, and their simulations, for the claims of chapter 3.
EQUAL_JARS = {}

if FIT_MILL:
    FIT_CONTACT, FIT_SEARCH = CONTACTS[CONFIG.fit.search.contact], settings("fit.search")

    rule fit:
        """The shape of a jar by a fit to published powers."""
        input:
            kernels=ancient(f"{RESULTS}/dem/kernels.json"),
            published=PUBLISHED,
        output:
            search=f"{FINGERPRINT}/fit_search.tsv",
            geometry=f"{FINGERPRINT}/fit_geometry.yaml",
            equal_jars=f"{FINGERPRINT}/fit_equal_jars.tsv",
        log:
            f"{LOGS}/fingerprint/fit.log",
        benchmark:
            f"{BENCHMARKS}/fit/fit.tsv"
        params:
            identity=identity_inside([FIT_MILL], [FIT_CONTACT], CONFIG.fit.search.counting_rules),
            mill=lambda wildcards, output: dumped(FIT_MILL),
            contact=lambda wildcards, output: FIT_CONTACT.model_dump(mode="json"),
            dem=lambda wildcards, output: settings("dem"),
            settings=FIT_SEARCH,
        message:
            "Searching the jar that agrees best with the published values chosen for the fit"
        script:
            "../../scripts/fit_jar.py"

    use rule fit as measure_fit_sensitivity with:
        output:
            sensitivity=f"{FINGERPRINT}/fit_sensitivity.tsv",
        log:
            f"{LOGS}/fingerprint/measure_fit_sensitivity.log",
        benchmark:
            f"{BENCHMARKS}/measure_fit_sensitivity/measure_fit_sensitivity.tsv"
        message:
            "Measuring the effect of one step of each parameter of the jar"

    if CONFIG.fit.equal_jars:

        use rule fit as simulate_equal_jar with:
            input:
                kernels=ancient(f"{RESULTS}/dem/kernels.json"),
                equal_jars=CONFIG.fit.equal_jars,
            output:
                summaries=f"{FINGERPRINT}/equal_jars/{{jar}}.json",
            log:
                f"{LOGS}/fingerprint/simulate_equal_jar_{{jar}}.log",
            benchmark:
                f"{BENCHMARKS}/simulate_equal_jar/{{jar}}.tsv"
            wildcard_constraints:
                jar=r"\d+",
            message:
                "Simulating jar {wildcards.jar} of those that fit equally well, at the conditions of chapter 3"

        EQUAL_JARS = {
            "equal_jars": CONFIG.fit.equal_jars,
            "of_jars": expand(
                rules.simulate_equal_jar.output.summaries,
                jar=numbers_of(CONFIG.fit.equal_jars, CONFIG.fit.search.equal_jars),
            ),
        }

    rule tabulate_fit:
        input:
            **EQUAL_JARS,
            descriptors=rules.fit_master_curves.output.descriptors,
            cycles=rules.fit_master_curves.output.cycles,
            published=PUBLISHED,
            sensitivity=rules.measure_fit_sensitivity.output.sensitivity,
        output:
            **({"equal": f"{FINGERPRINT}/equal_jars.tsv"} if CONFIG.fit.equal_jars else {}),
            fit=f"{FINGERPRINT}/fit.tsv",
        log:
            f"{LOGS}/fingerprint/tabulate_fit.log",
        localrule: True
        params:
            mill=dumped(FIT_MILL),
            settings=FIT_SEARCH,
            counting_rule=CONFIG.fingerprint.counting_rule,
        message:
            "Tabulating the fitted and the held-back values"
        script:
            "../../scripts/tabulate_fit.py"

    use rule tabulate_fit as measure_shape with:
        input:
            search=rules.fit.output.search,
            published=PUBLISHED,
        output:
            shape=f"{RESULTS}/uncertainty/{FIT_MILL.name}/shape.json",
        log:
            f"{LOGS}/uncertainty/{FIT_MILL.name}_shape.log",
        params:
            probability=CONFIG.fingerprint.interval,
        message:
            "Calculating what the fit leaves open of the shape of the jar"

    FIT_OUTPUTS += [
        *rules.measure_fit_sensitivity.output,
        *rules.tabulate_fit.output,
        # The search takes longer than the rest of the stage.
        *(rules.fit.output if "fit" in CONFIG.also else []),
    ]


# The fingerprint of chapter 3 is from more simulations than the mill's own sweep; the factors hold for both.
rule add_uncertainty_to_chapters:
    input:
        # No decision depends on the figures or on the tables next to them.
        chapters=[
            *(path for path in FINGERPRINT_OUTPUTS if path.endswith((".tsv", ".json")) and "/figures/" not in path),
            f"{RESULTS}/partition/table_4_2.tsv",
        ],
        fingerprint=f"{FINGERPRINT}/fingerprint_{CONFIG.mills.contact_set}.json",
        contact=rules.measure_uncertainty.output.contact.format(mill=CONFIG.mill),
        shape=shape_of(CONFIG.mill),
        claims=CONFIG.data.claims,
    output:
        fingerprint=f"{UNCERTAINTY}/fingerprint_{{contact}}.json".format(
            mill=CONFIG.mill, contact=CONFIG.mills.contact_set
        ),
        thesis=f"{UNCERTAINTY}/thesis.tsv".format(mill=CONFIG.mill),
    log:
        f"{LOGS}/uncertainty/add_to_chapters.log",
    localrule: True
    params:
        results=lambda wildcards, output: str(Path(output.thesis).parents[2]),
        cycle_fill_ratio=CONFIG.fingerprint.cycle_fill_ratio,
    message:
        "Adding the intervals by contact parameters to the curves of chapter 3 and to printed values"
    script:
        "../../scripts/draw_claims.py"


UNCERTAINTY_THESIS_OUTPUTS = (
    [*rules.add_uncertainty_to_chapters.output] if CONFIG.mill in CONFIG.uncertainty.mills else []
)

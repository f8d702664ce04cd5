"""Any mill: picture, fingerprint from its own sweep, collapse of the box, match, large mill, explorer, convergence."""

SCALE_UP = f"{RESULTS}/scale_up"
STUDY = f"{RESULTS}/convergence/{{mill}}"


# For a mill without a sweep. The conditions follow from its walls; calculating them needs libraries, so it is a job.
checkpoint derive_sweep:
    input:
        sources=lambda wildcards: shape_files(wildcards.mill),
    output:
        sweep=f"{MILL}/sweep.json",
    log:
        f"{LOGS}/mills/{{mill}}_sweep.log",
    localrule: True
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
    message:
        "Deriving speeds, balls and fill ratios that suit mill {wildcards.mill}"
    script:
        "../../scripts/derive_sweep.py"


rule draw_mill:
    input:
        sources=lambda wildcards: shape_files(wildcards.mill),
    output:
        geometry_figure=figures(f"{MILL}/geometry"),
        motion_figure=figures(f"{MILL}/motion"),
        geometry_tsv=f"{MILL}/geometry.tsv",
        motion_tsv=f"{MILL}/motion.tsv",
    log:
        f"{LOGS}/mills/{{mill}}_draw.log",
    localrule: True
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
    message:
        "Drawing mill {wildcards.mill} and its motion"
    script:
        "../../scripts/draw_mill.py"


rule describe_mill:
    input:
        sources=lambda wildcards: shape_files(wildcards.mill),
        summaries=lambda wildcards: files_of(rows_of("MILL", wildcards.mill)),
        runs=lambda wildcards: files_of(rows_of("MILL", wildcards.mill), "run.h5"),
    output:
        descriptors=f"{MILL}/descriptors.tsv",
        curves=f"{MILL}/curves.tsv",
        fingerprint=f"{MILL}/fingerprint.json",
        collapse=f"{MILL}/collapse.tsv",
        zones=f"{MILL}/zones.tsv",
        sheet=f"{MILL}/fingerprint.tsv",
        spectra=f"{DOSE}/{{mill}}/spectra.tsv",
        spectra_summary=f"{DOSE}/{{mill}}/spectra_summary.tsv",
    log:
        f"{LOGS}/mills/{{mill}}_describe.log",
    benchmark:
        f"{BENCHMARKS}/describe_mill/{{mill}}.tsv"
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
        counting_rule=CONFIG.mills.rule,
        interval=CONFIG.fingerprint.interval,
        smooth_points=CONFIG.fingerprint.smooth_points,
        spectra_rules=spectra_rules(CONFIG.mills.rule),
        rules=rules_named(*spectra_rules(CONFIG.mills.rule)),
    message:
        "Calculating fingerprint and energy spectra of mill {wildcards.mill}"
    script:
        "../../scripts/describe_mill.py"


rule measure_coverage:
    input:
        summaries=lambda wildcards: files_of(rows_of("NEW", wildcards.mill)),
        runs=lambda wildcards: files_of(rows_of("NEW", wildcards.mill), "run.h5"),
        fingerprint=rules.describe_mill.output.fingerprint,
    output:
        coverage=f"{MILL}/coverage.tsv",
        held_out=f"{MILL}/held_out.tsv",
    log:
        f"{LOGS}/mills/{{mill}}_coverage.log",
    benchmark:
        f"{BENCHMARKS}/measure_coverage/{{mill}}.tsv"
    params:
        rules=rules_named(CONFIG.mills.rule),
    message:
        "Counting how often the bands of mill {wildcards.mill} hold new simulations"
    script:
        "../../scripts/measure_coverage.py"


rule draw_fingerprint:
    input:
        sources=lambda wildcards: shape_files(wildcards.mill),
        sheet=rules.describe_mill.output.sheet,
        descriptors=rules.describe_mill.output.descriptors,
        curves=rules.describe_mill.output.curves,
        spectra=rules.describe_mill.output.spectra,
        spectra_summary=rules.describe_mill.output.spectra_summary,
        limits=rules.balance_heat.output.limits,
    output:
        figure=figures(f"{MILL}/fingerprint"),
        pdf=f"{MILL}/fingerprint.pdf",
        spectra_figure=figures(f"{DOSE}/{{mill}}/spectra"),
        rules_figure=figures(f"{DOSE}/{{mill}}/spectra_rules"),
    log:
        f"{LOGS}/mills/{{mill}}_fingerprint.log",
    localrule: True
    params:
        mill=lambda wildcards: dumped(mill_named(wildcards.mill)),
        contact=CONTACTS[CONFIG.mills.contact_set].model_dump(mode="json"),
        rules=spectra_rules(CONFIG.mills.rule),
    message:
        "Drawing the fingerprint of mill {wildcards.mill} on one page, and its energy spectra"
    script:
        "../../scripts/draw_fingerprint.py"


rule collect_mills:
    input:
        collapse=[f"{RESULTS}/mills/{name}/collapse.tsv" for name in BOX],
        coverage=[f"{RESULTS}/mills/{name}/coverage.tsv" for name in BOX],
    output:
        table=f"{RESULTS}/mills/collapse.tsv",
        figure=figures(f"{RESULTS}/mills/collapse"),
        coverage=f"{RESULTS}/mills/coverage.tsv",
    log:
        f"{LOGS}/mills/collect.log",
    localrule: True
    params:
        mills=BOX,
    message:
        "Comparing how well the curves of {BOX} collapse, and counting how often their bands hold new simulations"
    script:
        "../../scripts/compare_mills.py"


rule coverage:
    """How many new simulations the bands of the mills of the box hold."""
    input:
        rules.collect_mills.output.coverage,


MILL_PICTURES = expand([*rules.draw_mill.output], mill=BOX)
# A smoke test runs one case of each mill, and draws all mills.
BOX_OUTPUTS = (
    [*MILL_PICTURES, *(files_of(rows_of("MILL", name))[0] for name in BOX if MILLS[name].sweep)]
    if CONFIG.mills.first_case_only
    else [
        *MILL_PICTURES,
        *expand([*rules.draw_fingerprint.output, *rules.balance_heat.output], mill=BOX),
        *rules.collect_mills.output,
        f"{RESULTS}/mills/explorer.html",
    ]
)
FINGERPRINTED = [
    output.format(mill=CONFIG.mill)
    for made in (rules.draw_mill, rules.describe_mill, rules.measure_coverage, rules.draw_fingerprint)
    for output in made.output
]


# A run of one mill in a folder of its own ends with its record. In results/ the record is that of the whole run.
RECORD = [] if CHAPTERS or RESULTS == "results" else [f"{RESULTS}/ro-crate-metadata.json"]


rule fingerprint:
    """The fingerprint of the run's mill: its curves, its page, its spectra, and how often its bands hold."""
    input:
        FINGERPRINTED,
        RECORD,


rule mills:
    """The fingerprints of the mills of mills.box, compared."""
    input:
        BOX_OUTPUTS,


if CONFIG.mills.match is not None:

    rule match:
        """The settings of mills.match.mill that come nearest to a condition of another mill."""
        input:
            mill=predicting(CONFIG.mills.match.mill),
            like=predicting(CONFIG.mills.match.like.mill),
        output:
            match=f"{RESULTS}/mills/match.tsv",
        log:
            f"{LOGS}/mills/match.log",
        localrule: True
        params:
            settings=settings("mills.match"),
            descriptors=CONFIG.fingerprint.descriptors,
        message:
            "Matching {CONFIG.mills.match.mill} to {CONFIG.mills.match.like.mill}"
        script:
            "../../scripts/compare_mills.py"


if CONFIG.mills.scale_up is not None:

    rule scale_up:
        """A large mill, similar to mills.scale_up.mill, and what it costs to simulate."""
        input:
            fingerprint=described(CONFIG.mills.scale_up.mill),
            summary=files_of(rows_of("SCALE_UP", CONFIG.mills.scale_up.mill)),
        output:
            sheet=f"{SCALE_UP}/sheet.tsv",
            run=f"{SCALE_UP}/run.tsv",
            figure=figures(f"{SCALE_UP}/sheet"),
        log:
            f"{LOGS}/mills/scale_up.log",
        localrule: True
        params:
            settings=settings("mills.scale_up"),
            rayleigh_fraction=CONFIG.mills.rayleigh_fraction,
            mill=dumped(MILLS[CONFIG.mills.scale_up.mill]),
            contact=CONTACTS[CONFIG.mills.contact_set].model_dump(mode="json"),
        message:
            "Planning the large mill and its costs"
        script:
            "../../scripts/plan_scale_up.py"


EXPLORED_WITH = {
    "name": CONFIG.name,
    "rule": CONFIG.mills.rule,
    "descriptors": CONFIG.fingerprint.descriptors,
    "heat": settings("dose.heat"),
}
# What a page takes from each mill, by the names of `millprint.explorer.content`.
OF_MILL = {
    "spectra": rules.describe_mill.output.spectra,
    "summary": rules.describe_mill.output.spectra_summary,
    "temperatures": rules.balance_heat.output.temperatures,
    "limits": rules.balance_heat.output.limits,
}


rule explore_mill:
    input:
        unpack(lambda wildcards: explored([wildcards.mill])),
        sources=lambda wildcards: shape_files(wildcards.mill),
    output:
        html=shown(f"{MILL}/explorer.html"),
    log:
        f"{LOGS}/mills/{{mill}}_explorer.log",
    localrule: True
    params:
        mills=lambda wildcards: [dumped(mill_named(wildcards.mill))],
        about=EXPLORED_WITH,
    message:
        "Building the explorer of mill {wildcards.mill}, a page that needs no server"
    script:
        "../../scripts/build_explorer.py"


use rule explore_mill as explore_mills with:
    input:
        **explored(BOX),
        sources=[path for name in BOX for path in shape_files(name)],
    output:
        html=shown(f"{RESULTS}/mills/explorer.html"),
    log:
        f"{LOGS}/mills/explorer.log",
    params:
        mills=[dumped(mill_named(name)) for name in BOX],
        about=EXPLORED_WITH,
    message:
        "Building the explorer of {BOX}, a page that needs no server"


rule explorer:
    """A page with sliders for the run's mill."""
    input:
        rules.explore_mill.output.html.format(mill=CONFIG.mill),
        RECORD,


rule study_settings:
    input:
        summaries=lambda wildcards: files_of(rows_of("STUDY", wildcards.mill)),
        runs=lambda wildcards: files_of(rows_of("STUDY", wildcards.mill), "run.h5"),
    output:
        table=f"{STUDY}/study.tsv",
        window=f"{STUDY}/window.tsv",
        verdict=f"{STUDY}/verdict.json",
        line=f"{STUDY}/verdict.txt",
        figure=figures(f"{STUDY}/study"),
    log:
        f"{LOGS}/convergence/{{mill}}_study.log",
    localrule: True
    params:
        folder=lambda wildcards, output: str(Path(output.table).parents[2] / "dem"),
        variants=lambda wildcards: study_plan(wildcards.mill),
        sweep_seeds=lambda wildcards: len(TABLE.swept(wildcards.mill).sweep.seeds),
        counting_rule=CONFIG.mills.rule,
        rules=rules_named(CONFIG.mills.rule),
        study=settings("convergence.study"),
    message:
        "Comparing time step, stiffness, facets, window and seeds of mill {wildcards.mill}"
    script:
        "../../scripts/study_settings.py"


rule convergence:
    """Whether time step, stiffness, window and number of seeds are good enough."""
    input:
        lambda wildcards: CONVERGENCE_OUTPUTS if CHAPTERS else [],
        expand(rules.study_settings.output, mill=CONFIG.mill),

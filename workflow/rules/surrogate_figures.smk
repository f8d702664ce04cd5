"""Figures and animations of the surrogates, and the list of all files of chapter 6."""


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
    params:
        window=CONFIG.surrogate.graph.window,
        edges=CONFIG.surrogate.edges.model_dump(mode="json"),
        snap_back_m=CONFIG.surrogate.rollout.snap_back_m,
        library=library("plot_surrogate_data.py"),
    message:
        "Drawing the signed distance of the jar, its wall contacts and the recursion"
    script:
        "../../scripts/plot_surrogate_data.py"


rule plot_surrogate:
    input:
        **rules.evaluate_surrogate.output,
        history=f"{SURROGATE}/{{variant}}/loss.tsv",
        spread=f"{SURROGATE}/metrics.tsv",
        trainings=lambda wildcards: expand(
            rules.evaluate_surrogate.output.dissipation,
            variant=CONFIG.surrogate.trainings_of(wildcards.variant),
        ),
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
    params:
        tests=MOVING_TESTS,
        library=library("plot_surrogate.py"),
    message:
        "Drawing loss and roll-outs of the surrogate {wildcards.variant}"
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
        # Snakemake's report shows a PNG, even an animated one, but offers a GIF only as a download. One animation keeps
        # the report small enough for mail.
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
    params:
        tests=MOVING_TESTS,
        trained=CONFIG.surrogate.trained_test,
        settings=CONFIG.surrogate.movie.model_dump(mode="json"),
        library=library("compare_motion.py"),
    message:
        "Drawing the balls of the surrogate {wildcards.variant} next to those of the simulation"
    script:
        "../../scripts/compare_motion.py"


SURROGATE_OUTPUTS = [
    rules.build_surrogate_dataset.output.wall_contacts,
    rules.check_measures.output.controls,
    rules.time_surrogates.output.runtime,
    *rules.collect_surrogate.output,
    *rules.plot_surrogate_data.output,
    *expand([*rules.plot_surrogate.output, *rules.compare_motion.output], variant=CONFIG.surrogate.variants),
]

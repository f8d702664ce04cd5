"""Measures, figures and animations of all surrogates, and the list of all files of chapter 6."""

# The figures of a variant: name, caption, and what it shows.
VARIANT_FIGURES = {
    "loss": ("surrogate_loss", "loss of {variant} (Fig. 6.6)"),
    "error_growth": ("surrogate_error_growth", "position error of {variant} (Figs 6.7, 6.11)"),
    "dissipation": ("surrogate_dissipation", "dissipation of {variant} (Figs 6.8, 6.14, 6.15, 6.17)"),
    "distributions": ("surrogate_distributions", "distributions of {variant}"),
}


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
        slices_svg=report(
            f"{SURROGATE}/signed_distance.svg",
            caption="../report/surrogate_signed_distance.rst",
            category="Chapter 6",
            labels={"figure": "signed distance (Fig. 6.3)"},
        ),
        slices_png=f"{SURROGATE}/signed_distance.png",
        slices_tsv=f"{SURROGATE}/signed_distance.tsv",
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
        svgs=[
            report(
                f"{SURROGATE}/{variant}/{name}.svg",
                caption=f"../report/{caption}.rst",
                category="Chapter 6",
                labels={"figure": title.format(variant=variant)},
            )
            for variant in CONFIG.surrogate.variants
            for name, (caption, title) in VARIANT_FIGURES.items()
        ],
        pngs=[f"{SURROGATE}/{variant}/{name}.png" for variant in CONFIG.surrogate.variants for name in VARIANT_FIGURES],
    log:
        f"{LOGS}/surrogate/plot_surrogates.log",
    priority: 1
    localrule: True
    params:
        window=CONFIG.surrogate.graph.window,
        edges=CONFIG.surrogate.edges.model_dump(mode="json"),
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
        stills=[
            report(
                f"{SURROGATE}/{variant}/{test}/motion.svg",
                caption="../report/surrogate_motion.rst",
                category="Chapter 6",
                labels={"figure": f"balls of {variant}, {test} (Figs 6.9, 6.12, 6.13, 6.18)"},
            )
            for variant, test in MOVED
        ],
        pngs=[f"{SURROGATE}/{variant}/{test}/motion.png" for variant, test in MOVED],
        tsvs=[f"{SURROGATE}/{variant}/{test}/motion.tsv" for variant, test in MOVED],
        gifs=[f"{SURROGATE}/{variant}/{test}/motion.gif" for variant, test in MOVED],
        # Snakemake's report shows a PNG, even an animated one, but offers a GIF only as a download. One animation of each
        # variant keeps the report small enough for mail.
        movies=[
            report(
                f"{SURROGATE}/{variant}/{CONFIG.surrogate.trained_test}/motion_animated.png",
                caption="../report/surrogate_motion.rst",
                category="Chapter 6",
                labels={"figure": f"animation of {variant} (Fig. 6.9)"},
            )
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
        settings=CONFIG.surrogate.movie.model_dump(mode="json"),
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

"""Joins the measures of all surrogates; draws their input (distance and contacts of the wall), losses and roll-outs.

Or tabulates the ablations of appendix A next to the statements of the thesis, and draws them.

Settings: surrogate.graph.window, surrogate.edges, surrogate.rollout.snap_back_m, surrogate.tests; trainings of every
variant. Of surrogate.ablations: what each changes, its trainings, and the length of its roll-out.
Inputs: `run`, `wall_contacts`, `controls`; `errors`, `distributions`, `histories`, `measured` and `dissipation` of
the variants. Of ablations `measured`, `histories`, and `claims`.
Outputs: `metrics`, `trainings`, `baselines`, `against`, the figures, and the points of one as `slices_tsv`; or
`ablations`.
"""

import numpy as np
import pandas as pd

from millprint.config.surrogate import EdgeConfig
from millprint.figures.style import in_pairs, save
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.run.tables import read_printed
from millprint.thesis.figures.chapter6_figures import (
    plot_ablations,
    plot_dissipation,
    plot_distance_slices,
    plot_distributions,
    plot_error_growth,
    plot_loss,
    plot_recursion,
    plot_wall_contacts,
)
from millprint.thesis.surrogate.measures import (
    DISSIPATION,
    ablation_table,
    against_baselines,
    baseline_rows,
    baseline_table,
    covered_share,
    join_tables,
    scatter_in_words,
    tabulate_trainings,
    with_motion,
    with_spread,
)
from millprint.thesis.surrogate.rollout import read_attributes, read_scene


def read_measures(paths: list[str]) -> pd.DataFrame:
    """The measures of several trainings, joined."""
    return join_tables([read_table(path, text=["variant", "test", "measure"]) for path in paths])


def collect(given, made, trainings: dict[str, list[str]], trained_test: str) -> None:
    """Write the measures of each variant and of the baselines, those of each training, and both side by side.

    trained_test: the test on the motion of the training; all others are on motions that no training has seen.
    """
    found = read_measures(list(given.measured))
    controls = read_table(given.controls, text=["rollout", "test", "measure"])
    repeated = tabulate_trainings(found, trainings)
    metrics = join_tables([with_spread(found, trainings), baseline_rows(controls)])
    write_table(with_motion(metrics, trained_test), made.metrics)
    write_table(with_motion(repeated, trained_test), made.trainings)
    errors = found[found["measure"] == DISSIPATION].drop_duplicates("test").set_index("test")
    baselines = baseline_table(repeated, controls, errors["thesis"].to_dict(), trained_test)
    write_table(baselines, made.baselines)
    write_table(against_baselines(baselines, next(iter(trainings))), made.against)


def draw_data(run: str, wall_contacts: str, made, own) -> None:
    """Draw the signed distance of the jar, where balls touch its wall, and the recursion of a roll-out."""
    scene = read_scene(run)
    table = read_table(wall_contacts)
    height = scene.bounds_m[:, 2]
    # One section through the middle of the jar, one at the height of the centre of a ball on the floor.
    slices = [
        scene.section("y", float(np.mean(scene.bounds_m[:, 1]))),
        scene.section("z", float(height[0] + scene.ball_radius_m)),
    ]
    save(plot_distance_slices(slices), *made.slices_figure, tsv=made.slices_tsv)
    edges = EdgeConfig(**own.edges)
    covered = covered_share(table, edges.wall_threshold_m)
    save(plot_wall_contacts(table, edges.wall_threshold_m, covered), *made.contacts_figure)
    step_s = read_attributes(run)["case"]["snapshot_interval_s"]
    save(plot_recursion(own.window, edges, own.snap_back_m, step_s), *made.loop_figure)


def compare_ablations(inputs, output, changes: dict, length_s: dict, trainings: dict[str, list[str]]) -> str:
    """Write and draw a row for each ablation, with the interval over its trainings or those of the baseline.

    Returns the sentence on this interval.
    """
    losses = {name: read_table(path) for name, path in zip(changes, inputs.histories, strict=True)}
    printed = read_printed(inputs.claims)
    table = ablation_table(read_measures(list(inputs.measured)), losses, changes, length_s, printed, trainings)
    write_table(table, output.ablations)
    written = read_table(output.ablations, text=["variant", "says"])
    save(plot_ablations(written, scatter_in_words(written)), *output.figure)
    return scatter_in_words(table) or "the baseline was trained once, so nothing tells chance apart"


def draw_variants(inputs, output, trainings: dict[str, list[str]], tests: list[str]) -> None:
    """Draw loss, growth of errors, dissipation and distributions of every variant, for each test with moving balls."""

    def of_tests(path: str) -> pd.DataFrame:
        table = read_table(path, text=["test"])
        return table[table["test"].isin(tests)]

    spread = read_table(output.metrics, text=["variant", "test"])
    paths, dissipation = in_pairs(output.variant_figures), iter(inputs.dissipation)
    tables = zip(inputs.histories, inputs.errors, inputs.distributions, strict=True)
    for (variant, own), (losses, errors, distributions) in zip(trainings.items(), tables, strict=True):
        measured, (first, *others) = spread[spread["variant"] == variant], [of_tests(next(dissipation)) for _ in own]
        figures = (
            plot_loss(read_table(losses)),
            plot_error_growth(of_tests(errors)),
            plot_dissipation(first, measured, others),
            plot_distributions(of_tests(distributions), measured),
        )
        for figure in figures:
            save(figure, *next(paths))


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "draw the surrogates") as log:
        if made.get("ablations"):
            log.info("%s", compare_ablations(given, made, own.changes, own.length_s, own.trainings))
        else:
            collect(given, made, own.trainings, own.trained_test)
            draw_data(given.run, given.wall_contacts, made, own)
            draw_variants(given, made, own.trainings, own.tests)

"""Keys that earlier versions had, for a clear refusal of a configuration that still has one."""

from typing import Any

from pydantic import BaseModel

from millprint.config.fit import JarSearch

# By the path of a key without the numbers of its lists: its value today, or what to do. A key that is a constant of its
# section today is not here.
REMOVED = {
    "convergence.closure_max": "fixed at 0.001",
    "convergence.confidence": "fixed at 0.95",
    "convergence.study.confidence": "fixed at 0.95",
    "convergence.study.facet_factors": "fixed at [0.5, 2]",
    "convergence.study.modulus_factors": "fixed at [0.3, 3]",
    "convergence.study.step_factors": "fixed at [0.5, 2]",
    "dem.collision_rows_max": "fixed at 3000000",
    "dem.occupancy_cell_m": "fixed at 0.002",
    "dem.occupancy_interval_s": "fixed at 0.0005",
    "dem.skin_share": "fixed at 1.5",
    "doe.half_life": "fixed at pH 11 and 298 K",
    "doe.powder": "the table of it is gone",
    "dose.heat.measured": "the comparison with a measured bound is gone",
    "dose.heat.times": "fixed at 61",
    "dose.spectra.bins_per_decade": "fixed at 5",
    "dose.spectra.highest_J": "fixed at 10",
    "dose.spectra.lowest_J": "fixed at 1e-12",
    "dose.wear.fill_tolerance": "fixed at 0.05",
    "dose.wear.probability": "fixed at 0.95",
    "fit.shape": "fixed, in millprint.thesis.fit.jar_search",
    "mills.collapse_max": "fixed at 0.2",
    "mills.explored": "`millprint explore` makes a page of any mill",
    "mills.match.like_bulk_filling": "give like_fill_ratio",
    "mills.match.like_mass_g": "give like_fill_ratio",
    "mills.match.like_number": "give like_fill_ratio",
    "mills.scale_up.run_settle_s": "fixed at 0.1",
    "mills.scale_up.run_turns": "fixed at 1",
    "surrogate.movie": "fixed, in scripts/compare_motion.py",
    "sweeps.threads": "that of all simulations is dem.threads",
    "uncertainty.closure_max": "fixed at 0.02",
    "view.frames_per_second": "fixed at 25",
    "view.paraview_every": "fixed at 1; `millprint export` has --every",
    "yields.library_trial.earlier": "the comparison of libraries is gone",
    "yields.library_trial.sub_libraries": "the comparison of libraries is gone",
    "yields.retrospective.chosen_runs": "the table of what chosen runs teach is gone",
    "yields.retrospective.held_out_runs": "the table of what chosen runs teach is gone",
    "dose.heat.surroundings.moving_air.at_rest": "fixed at still_air",
    "dose.heat.surroundings.still_air.at_rest": "fixed at still_air",
    "dose.heat.surroundings.water.at_rest": "fixed at water",
    **{f"fit.{key}": "fixed, in millprint.config.fit" for key in JarSearch.model_fields},
    **dict.fromkeys(
        (
            f"validation.{setup}"
            for setup in (
                "alumina_impact",
                "bead_drum",
                "bond_mill",
                "drum_90cm",
                "elastic_impact",
                "repose_drum",
                "slice_mill",
                "spex_shaker",
            )
        ),
        "fixed, in millprint.config.setup_models",
    ),
}


def what_became_of(key: str, section: type[BaseModel] | None) -> str:
    """What a key of this section that earlier versions had is today; empty for one that they had not."""
    own = key.rpartition(".")[2]
    if key in REMOVED or section is None or own not in section.__class_vars__:
        return REMOVED.get(key, "")
    value = getattr(section, own)
    plain = type(value) in (int, float, str, list, tuple)
    return f"fixed at {_in_yaml(value)}" if plain else f"fixed, in {section.__module__}"


def _in_yaml(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_in_yaml, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)

"""The recursive stage in words, with the settings of a variant (thesis Sec. 6.2.2, steps 0 to 9)."""

from millprint.config.surrogate import EdgeConfig


def steps_in_words(window: int, edges: EdgeConfig, snap_back_m: float | None, step_s: float) -> tuple[str, list[str]]:
    """What the recursion starts from, and its steps."""
    reach = "gap of surfaces" if edges.ball_threshold_reading == "surface_gap" else "distance of centres"
    back = (
        "balls stay where they are" if snap_back_m is None else f"balls with φ ≥ {1e3 * snap_back_m:g} mm back to there"
    )
    return f"window of {window} snapshots from DEM", [
        "graph of the newest snapshot,\nfeatures of the whole window",
        "network: acceleration of each ball,\ndissipation of the step",
        f"Euler step of {step_s:g} s\n(Eqs 6.31, 6.32)",
        "place of the jar from its motion,\nsigned distance φ of every ball",
        f"edges: wall where φ ≥ {1e3 * edges.wall_threshold_m:g} mm,\n"
        f"balls where the {reach} ≤ {1e3 * edges.ball_threshold_m:g} mm",
        f"snap-back: {back}",
        "newest snapshot in, oldest out",
    ]

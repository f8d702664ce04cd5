"""Plane sections through the signed distance of a vessel (thesis Fig. 6.3)."""

import numpy as np

from millprint.surrogate.scene import Scene

AXES = "xyz"


def section(scene: Scene, normal: str, at_m: float, points: int = 161) -> dict:
    """Signed distance on the plane `normal` = at_m of the body frame, not a number outside the vessel.

    Returns `title`, `axes` (two names), `first_m` (a,), `second_m` (b,) and `distance_m` (b, a).
    """
    across = [axis for axis in range(3) if axis != AXES.index(normal)]
    low, high = scene.bounds_m
    lines = [np.linspace(low[axis], high[axis], points) for axis in across]
    grid = np.full((points, points, 3), at_m)
    grid[..., across[0]], grid[..., across[1]] = np.meshgrid(*lines)
    distance, _ = scene.signed_distance(grid, np.zeros(3))
    axes = tuple(AXES[axis] for axis in across)
    return {
        "title": f"{axes[0]}{axes[1]} plane, {normal} = {1e3 * at_m:.3g} mm",
        "axes": axes,
        "first_m": lines[0],
        "second_m": lines[1],
        "distance_m": np.where(distance < 0, distance, np.nan),
    }

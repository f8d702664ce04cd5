"""What the walls of a mill are, in words: exact surfaces, and what stays as it is drawn."""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from millprint.config.motion_kinds import MotionSection
from millprint.mill.bodies import Body
from millprint.mill.borders import borders_of
from millprint.mill.vessel import Vessel
from millprint.run.numbers import counted, plain

# Flat facets look round where more than this number follow each other with turns of less than 20 degrees [rad].
FEW_FACETS = 8
ROUND_TURN = np.radians(20)
LEAST_TURN = 1e-3
# A vessel turns about its own axis within this share of its radius, and within this angle [rad].
OFF_AXIS, SLANT = 0.02, np.radians(1)


def _discs(vessel: Vessel) -> np.ndarray:
    """Which facets (f,) are flat walls that end at circles only."""
    found, is_line = vessel.facet_curves < 0, np.ones(len(vessel.edge_arrays.turn), dtype=bool)
    is_line[list(borders_of(vessel).arcs)] = False
    found[vessel.edge_arrays.facets[is_line]] = False
    return found


def _counted(vessels: Iterable[Vessel]) -> str:
    """The walls of some bodies together: "2 cylinders, 1 torus, 2 discs; 12 flat walls"."""
    surfaces, discs, flat, drawn = [], 0, 0, 0
    for vessel in vessels:
        surfaces += [
            curve.kind
            for number, curve in enumerate(vessel.curves)
            if not any(curve.is_part_of(other) for other in vessel.curves[:number])
        ]
        discs += int(_discs(vessel).sum())
        flat += int((vessel.facet_curves < 0).sum())
        drawn += int((round_facets(vessel) > 0).sum())
    counts = [(surfaces.count(kind), kind) for kind in ("cylinder", "cone", "sphere", "torus")]
    exact = ", ".join(counted(number, word) for number, word in [*counts, (discs, "disc")] if number)
    rest = [(flat - discs - drawn, "flat wall"), (drawn, "flat facet")]
    told = ", ".join(counted(number, word) for number, word in rest if number) + " of round walls" * (drawn > 0)
    return "; ".join(filter(None, (exact, told)))


def walls_in_words(bodies: Sequence[Body]) -> str:
    """The walls of a mill: "1 cylinder, 2 discs", and those of its inserts after "; inserts: "."""
    vessel, *inserts = (body.vessel for body in bodies)
    return _counted([vessel]) + (f"; inserts: {_counted(inserts)}" if inserts else "")


def round_facets(vessel: Vessel) -> np.ndarray:
    """For each facet (f,) how many make a wall with it that looks round and is flat, 0 where it is part of none."""
    flat = vessel.facet_curves < 0
    turns, pairs = np.abs(vessel.edge_arrays.turn), vessel.edge_arrays.facets
    joined = pairs[(turns > LEAST_TURN) & (turns < ROUND_TURN) & flat[pairs].all(axis=1)]
    count = len(flat)
    _, part = connected_components(coo_array((np.ones(len(joined)), joined.T), (count, count)), directed=False)
    size = np.bincount(part)[part]
    return np.where(size > FEW_FACETS, size, 0)


def round_triangles(vessel: Vessel) -> np.ndarray:
    """Which of the triangles (t,) of a vessel are part of a wall that looks round and is flat."""
    corners, loops = vessel.outlines.corners.counts, vessel.outlines.facets.counts
    return np.repeat(round_facets(vessel) > 0, corners + 2 * loops - 4)


def drawn_in_words(vessel: Vessel) -> str | None:
    """What depends on how finely a round wall is drawn that is not an exact surface, and why it is not; or None."""
    facets = round_facets(vessel).max()
    if not facets:
        return None
    why = vessel.report[-1] if vessel.report else "it is near no cylinder, cone, sphere or torus"
    more_decimals = "with more decimals, or " if vessel.report else ""
    return (
        f"a wall that looks round stays {facets} flat facets ({why}): where balls roll, collision frequency and E*n "
        "need 192 facets a turn, the normal power more, and E*t is too small with any number "
        f"(docs/why/jar_and_motion.md); export it {more_decimals}as 192 facets a turn"
    )


def off_axis_in_words(body: Body, law: MotionSection) -> str | None:
    """How far the line about which a vessel turns is off the axis of its largest round wall, and what to write; or None
    for one that turns about its own axis, or not steadily.

    law: the motion by its keys. Of a sphere any line through its middle is an axis.
    """
    vessel, motion = body.vessel, body.motion
    whole = [number for number, curve in enumerate(vessel.curves) if curve.hollow and curve.part is None]
    if not motion.rate or not whole:
        return None
    curve = vessel.curves[max(whole, key=lambda number: vessel.areas[vessel.facet_curves == number].sum())]
    is_sphere, radius = curve.kind == "sphere", (curve.major or 0.0) + (curve.minor or 0.0)
    away = curve.origin - motion.pivot
    away = away - (away @ motion.axis) * motion.axis
    off, slant = float(np.linalg.norm(away)), float(np.arccos(min(1.0, abs(curve.axis @ motion.axis))))
    found, advice, is_free = [], [], hasattr(law, "pivot_mm")
    if slant > SLANT and not is_sphere:
        found.append(f"{plain(np.degrees(slant))} degrees")
        axis = ", ".join(plain(part) for part in np.round(curve.axis, 4) + 0.0)
        advice.append(f"write axis: [{axis}]" if is_free else f"turn the drawing until [{axis}] in it is [0, 0, 1]")
    if off > OFF_AXIS * radius:
        found.append(f"{plain(1e3 * off)} mm")
        wanted = motion.pivot + away if is_free else -away
        to = ", ".join(plain(part) for part in np.round(1e3 * wanted, 3) + 0.0)
        advice.append(f"write pivot_mm: [{to}]" if is_free else f"move the drawing by [{to}] mm")
    if not found:
        return None
    return (
        f"the axis of the vessel's largest round wall, a {curve.kind} of {plain(1e3 * radius)} mm radius, is "
        f"{' and '.join(found)} apart from the line about which the vessel turns; if it turns about that axis, "
        f"{' and '.join(advice)}"
    )

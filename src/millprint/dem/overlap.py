"""Why a run stopped at an overlap: what the ball met, where by the exact distance, how fast, and what to change."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from millprint.config.contact_set import CONTACT_LAWS
from millprint.dem.laws.registry import law_of
from millprint.dem.layout import COUNTER, HISTORY, LANE, LANES, LAW
from millprint.mill.borders import borders_of
from millprint.mill.creases import nearest_on_circle
from millprint.mill.distance import signed_distance
from millprint.mill.drawn_creases import crease_feet
from millprint.mill.kernel_columns import span_of, width_of
from millprint.mill.vessel import Vessel
from millprint.mill.walls import SURFACE

if TYPE_CHECKING:
    from millprint.dem.simulation import Simulation

# A feature is where the nearest point of the wall lies within this fraction of the body's size.
ON_FEATURE = 1e-6
# A step over this share of an elastic impact's duration does not resolve it: at the largest step that is usually
# allowed, 0.2 of the Rayleigh time, it is 0.04.
UNRESOLVED = 0.1


class Meeting(NamedTuple):
    """A contact that overlaps too much.

    overlap and its bound [m]; speed at which its partners met [m/s]; stiffness: coefficient of normal
    stiffness of the law; mass: reduced [kg]; begun [s]; others: further open contacts of the ball.
    """

    overlap: float
    bound: float
    speed: float
    stiffness: float
    mass: float
    begun: float
    others: int


def overlap_in_words(stopped: "Simulation") -> str:
    """The message of a run that stopped at an overlap; it advises what to change only where that is the cause."""
    ball, partner = int(stopped.counters[COUNTER.ball]), int(stopped.counters[COUNTER.partner])
    meeting = _meeting(stopped, ball, partner)
    radius = stopped.balls.radius[stopped.balls.species[ball]]
    share = radius * stopped.dem.overlap_max / meeting.bound
    other, place, clear_m = _pair(stopped, ball, partner) if partner >= 0 else _wall(stopped, ball)
    moving = float(np.linalg.norm(stopped.balls.velocity_now[ball]))
    of = "its radius" if share == 1 else "the smaller radius"
    return (
        f"ball {ball} overlaps {other} by {_percent(meeting.overlap, meeting.bound, stopped)} of {of}, more than "
        f"{100 * stopped.dem.overlap_max:g} %, at {stopped.time_s:.6f} s: {place}; they "
        f"met at {meeting.speed:.3g} m/s, and the ball has {moving:.3g} m/s now. {_cause(stopped, meeting, clear_m)}"
    )


def _percent(overlap: float, bound: float, stopped: "Simulation") -> str:
    return f"{100 * stopped.dem.overlap_max * overlap / bound:.3g} %"


def _meeting(stopped: "Simulation", ball: int, partner: int) -> Meeting:
    """The contact of a ball and its partner with the largest overlap; one that has just closed is still there."""
    first, second, is_open, histories = _contacts(stopped)
    own = np.flatnonzero((first == ball) & (second == partner))
    chosen = int(own[np.argmax(histories[own, HISTORY.peak_overlap])])
    balls, species = stopped.balls, stopped.balls.species[ball]
    law, mass = stopped.laws.wall[SURFACE.rough, species], float(balls.mass[species])
    if partner >= 0:
        other = stopped.balls.species[partner]
        law, mass = stopped.laws.pair[species, other], mass * balls.mass[other] / (mass + balls.mass[other])
    further = is_open & ((first == ball) | (second == ball))
    further[chosen] = False
    return Meeting(
        overlap=float(histories[chosen, HISTORY.peak_overlap]),
        bound=float(law[LAW.largest_overlap]),
        # Less than zero where a contact begins while its partners part.
        speed=max(0.0, float(histories[chosen, HISTORY.approach_speed])),
        stiffness=float(law[LAW.normal_stiffness]),
        mass=float(mass),
        begun=float(histories[chosen, HISTORY.start]),
        others=int(further.sum()),
    )


def _contacts(stopped: "Simulation") -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Both partners of every contact (c,), whether it is open, and its history (c, width): HistoryColumns.

    Where the lists were about to be made again, the contacts have been set aside.
    """
    contacts, aside, used = stopped.contacts, *(int(stopped.counters[at]) for at in (COUNTER.aside, COUNTER.used))
    if aside >= 0:
        partners = contacts.kept_ball[:aside], contacts.kept_partner[:aside]
        return *partners, np.ones(aside, dtype=bool), contacts.kept_history[:aside]
    lanes = contacts.lanes.reshape(-1, width_of(LANE), LANES).transpose(0, 2, 1).reshape(-1, width_of(LANE))[:used]
    partners = contacts.ball[:used], contacts.partner[:used]
    return *partners, contacts.slot[:used] >= 0, lanes[:, span_of(LANE.history)]


def _pair(stopped: "Simulation", ball: int, partner: int) -> tuple[str, str, float]:
    """The other ball, the distance of both in words, and 0: the contact of two balls is certain."""
    balls = stopped.balls
    apart = float(np.linalg.norm(balls.position[ball] - balls.position[partner]))
    reach = balls.radius[balls.species[ball]] + balls.radius[balls.species[partner]]
    return f"ball {partner}", f"their centres are {1e3 * apart:.4g} mm apart, and touch at {1e3 * reach:.4g} mm", 0.0


def _wall(stopped: "Simulation", ball: int) -> tuple[str, str, float]:
    """The body whose surface is nearest, the place in words, and how far the ball is from touching it [m].

    Distances are the exact ones of `mill.distance`, less than zero for a ball in the wall.
    """
    radius = float(stopped.balls.radius[stopped.balls.species[ball]])
    found = []
    for body in stopped.bodies:
        at = body.to_body(stopped.balls.position[ball][None], stopped.time_s)[0]
        distance, gradient = signed_distance(body.vessel)(at)
        found.append((-float(distance), body, at - distance * gradient))
    height, body, nearest = min(found, key=lambda each: each[0])
    clear = height - radius
    where = f"clear of it by {1e3 * clear:.3g} mm" if clear > 0 else f"in it by {-1e3 * clear:.3g} mm"
    place = ", ".join(f"{1e3 * value:.4g}" for value in nearest)
    words = (
        f"by the exact distance, its centre is {1e3 * height:.4g} mm from the nearest point of the wall, on "
        f"{feature_at(body.vessel, nearest)} at ({place}) mm of the {body.name}'s frame, so that it is {where}"
    )
    return f"the wall of {body.name}", words, clear


def feature_at(vessel: Vessel, point: np.ndarray) -> str:
    """What a point (3,) [m] of a surface belongs to: a round wall, a corner, a convex edge, a seam, or a facet."""
    near = ON_FEATURE * vessel.size
    for curve in vessel.curves:
        distance, _, past = curve.touch(point[None])
        if abs(distance[0]) < near and past[0] <= 0:
            return "a round wall"
    if np.linalg.norm(vessel.vertices - point, axis=1).min() < near:
        return "a corner"
    for rim in borders_of(vessel).rims:
        if np.linalg.norm(nearest_on_circle(rim.row, point[None])[0] - point) < near:
            return "a convex rim" if rim.turn > 0 else "a seam"
    creases = borders_of(vessel).creases.values()
    feet = [crease_feet(crease.rows[None], 0, point[None])[0] for crease in creases]
    for crease, foot in zip(creases, feet, strict=True):
        if np.linalg.norm(foot - point) < near:
            return "a convex crease" if crease.turn > 0 else "a seam"
    for edge in vessel.edges:
        along = edge.end - edge.start
        share = np.clip((point - edge.start) @ along / (along @ along), 0, 1)
        if np.linalg.norm(point - edge.start - share * along) < near:
            return "a convex edge" if edge.turn > 0 else "a seam"
    return "a facet"


def _cause(stopped: "Simulation", meeting: Meeting, clear_m: float) -> str:
    """What caused the overlap, and what to change."""
    causes = []
    law, reached, duration = law_of(stopped.contact), 0.0, np.inf
    if meeting.speed > 0:
        reached, duration = law.impact(meeting.mass, meeting.stiffness, meeting.speed)
    impact = f"an elastic impact at that speed reaches {_percent(reached, meeting.bound, stopped)}"
    if reached >= meeting.bound:
        key, (words, unit) = list(CONTACT_LAWS[stopped.contact.kind].told.items())[-1]
        own = stopped.contact.value_of(key)
        needed = own * (reached / meeting.bound) ** law.overlap_power
        causes.append(
            f"the speed is too high for this {words}: {impact}; it needs {needed:.3g} "
            f"{unit} in place of {own:g}, or a slower mill"
        )
    step = stopped.clock.step
    if step > UNRESOLVED * duration:
        causes.append(
            f"the step is too large: an elastic impact at that speed lasts {duration:.2g} s, "
            f"{duration / step:.2g} steps"
        )
    if causes:
        return "; and ".join(causes)
    # The ball has moved a step since the contact was last checked.
    moved = 2 * step * float(np.abs(stopped.balls.velocity_now).max())
    innocent = f"Neither speed nor step is the cause ({impact})"
    if clear_m > moved:
        return (
            f"{innocent}: the ball is clear of the surface, so that this is a fault of millprint's wall; please report "
            "it with the files of the mill"
        )
    if meeting.begun <= (1.5 - stopped.settle_steps) * step:
        return f"{innocent}: the ball overlaps from the start on; look at the starting positions"
    others = f"{meeting.others} further contacts" if meeting.others else "no other contact"
    return f"{innocent}: the ball is pressed there, with {others}; look at the surface, and at bodies that close a gap"

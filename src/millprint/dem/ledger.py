"""The energy ledger: work of walls and gravity against stored and dissipated energy, and why a balance is open."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd

from millprint.config.errors import SimulationError
from millprint.dem.collisions import by_surface
from millprint.dem.laws.registry import law_of
from millprint.dem.layout import LAW
from millprint.dem.recording import SAMPLE_NAMES
from millprint.mill.walls import SURFACE

if TYPE_CHECKING:
    from millprint.dem.simulation import Simulation


def ledger_series(samples: np.ndarray) -> pd.DataFrame:
    """The ledger as a time series of energies [J], with works counted from the first sample.

    samples: (m, width) rows of layout.SampleColumns, at least one. Returns m rows with those columns and with
    sliding_J, kinetic_J, elastic_J, gravity_work_J and imbalance_J.

    sliding_J is the tangential work that is neither damping nor held by the tangential springs. It includes what a
    spring gives up when its stiffness falls with the overlap, so that nothing of the tangential work is lost.
    """
    series = pd.DataFrame(samples, columns=SAMPLE_NAMES)
    works = ["wall_work_J", "normal_damping_J", "tangential_damping_J", "tangential_work_J", "rolling_J"]
    series[works] -= series[works].iloc[0]
    stored = series["elastic_tangential_J"] - series["elastic_tangential_J"].iloc[0]
    series["sliding_J"] = series["tangential_work_J"] - series["tangential_damping_J"] - stored
    series["kinetic_J"] = series["kinetic_translation_J"] + series["kinetic_spin_J"]
    series["elastic_J"] = series["elastic_normal_J"] + series["elastic_tangential_J"]
    series["gravity_work_J"] = series["potential_J"].iloc[0] - series["potential_J"]
    series["imbalance_J"] = (
        series["wall_work_J"]
        + series["gravity_work_J"]
        - (series["kinetic_J"] - series["kinetic_J"].iloc[0])
        - (series["elastic_J"] - series["elastic_J"].iloc[0])
        - series[["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]].sum(axis=1)
    )
    return series


# Dissipated energies of the ledger.
DISSIPATED = ("normal_damping", "tangential_damping", "sliding", "rolling")


def ledger_summary(series: pd.DataFrame) -> dict[str, float]:
    """Work of walls and gravity, dissipated and stored energies over the series [J], and imbalance: what is left."""
    last, change = series.iloc[-1], series.iloc[-1] - series.iloc[0]
    totals = {name: float(last[f"{name}_J"]) for name in ("wall_work", "gravity_work", *DISSIPATED, "imbalance")}
    return totals | {f"{name}_change": float(change[f"{name}_J"]) for name in ("kinetic", "elastic")}


def work_scale(series: pd.DataFrame) -> float:
    """What an error of the energy balance is a fraction of [J]: the wall work.

    If the walls do next to no work (a mill at rest, or one that only lifts and lowers its balls), a tenth of the energy
    dissipated, or of what gravity takes and gives.
    """
    last = series.iloc[-1]
    to_and_fro = series["potential_J"].diff().abs().sum()
    dissipated = last[["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]].sum()
    return float(max(abs(last["wall_work_J"]), 0.1 * dissipated, 0.1 * to_and_fro))


def closure(series: pd.DataFrame) -> float:
    """Error of the energy balance over the series, as a fraction of `work_scale` [-]."""
    scale = work_scale(series)
    return float(abs(series["imbalance_J"].iloc[-1]) / scale) if scale > 0 else 0.0


class OpenBalanceError(SimulationError):
    """An energy balance that does not close, and why.

    found, its error, is over `largest`, fractions of the wall work [-]; step_factor: what the step is multiplied by so
    that it may close, 0 where a shorter one does not help.
    """

    def __init__(self, found: float, largest: float, cause: str = "", step_factor: float = 0.0) -> None:
        balance = (
            f"the energy balance is open by {100 * found:.3g} % of the wall work (closure_max {100 * largest:g} %)"
        )
        super().__init__(f"{balance}: {cause}" if cause else balance)
        self.step_factor = step_factor


def check_closure(series: pd.DataFrame, largest: float) -> float:
    """The closure; raises OpenBalanceError, without a cause, where it exceeds `largest`."""
    error = closure(series)
    if not error <= largest:
        raise OpenBalanceError(error, largest)
    return error


# Leapfrog dissipates more in a hit than the hit takes, by HIT_ERROR (step / duration)^2 of its normal damping; the step
# is the cause of an error up to STEP_SHARE times the sum of that. Both are measured: docs/why/contact.md.
HIT_ERROR, STEP_SHARE = 4.0, 4
# A contact that lasts as long as LASTING impacts to its overlap is pressed, and balls are jammed where the other
# pressed contacts of a ball have together more than its force over ALIKE.
LASTING, ALIKE = 10, 3
# A shorter step aims at this part of the error that is allowed; pressed contacts are resolved by this part of a step.
AIM, JAM_STEP = 0.7, 0.5


class Hits(NamedTuple):
    """Contacts (c,) as elastic impacts.

    mass: reduced [kg]; taken: duration at the speed of approach [s]; reached: duration of an impact that reaches the
    largest overlap [s]; excess: elastic energy at that overlap, less what the approach brought [J].
    """

    mass: np.ndarray
    taken: np.ndarray
    reached: np.ndarray
    excess: np.ndarray


def check_balance(run: "Simulation", series: pd.DataFrame, table: pd.DataFrame) -> float:
    """The closure of the ledger `series`; raises OpenBalanceError, with the cause, where it exceeds the case's bound.

    table: rows as `collision_table` gives them.

    With a step h, an impact of duration t that dissipates E_n dissipates 4 E_n (h / t)^2 more than it takes, so that

        closure = 4 sum of E_n (h / t)^2 / work of the walls

    is what the step makes. A larger error has another cause.
    """
    found, largest = closure(series), run.case.closure_max or run.dem.closure_max
    if found <= largest:
        return found
    contacts = by_surface(table)
    hits = _as_impacts(run, contacts)
    made = HIT_ERROR * float((contacts["normal_J"] * (run.step / hits.taken) ** 2).sum()) / work_scale(series)
    explained = f"hits explain {100 * made:.2g} % at this step"
    if found <= STEP_SHARE * made:
        factor = (AIM * largest / found) ** 0.5
        raise OpenBalanceError(found, largest, f"the step is too large, {explained}; make {_key(run, factor)}", factor)
    cause, factor = _jam_or_jump(run, series, contacts, hits)
    raise OpenBalanceError(found, largest, f"{explained}{cause}", factor)


def _jam_or_jump(run: "Simulation", series: pd.DataFrame, contacts: pd.DataFrame, hits: Hits) -> tuple[str, float]:
    """A cause that is not in the hits, and the factor on the step that may help, as of OpenBalanceError.

    Where the imbalance grows most, the contact whose overlap holds the most energy that its approach did not bring is
    pressed by another one of the same ball, or has jumped.
    """
    parts = np.abs(np.diff(series["imbalance_J"]))
    worst = int(parts.argmax())
    begin, end = series["time_s"].iloc[worst : worst + 2]
    told = f"{parts[worst] / parts.sum():.0%} of the error from {begin:.6g} to {end:.6g} s"
    there = (contacts["start_s"] < end) & (contacts["start_s"] + contacts["duration_s"] > begin)
    first = int(np.where(there, hits.excess, -np.inf).argmax()) if there.any() else None
    if first is not None and (others := _pressed_with(first, contacts[there], hits)):
        where = ", ".join(_partners(run, contacts.loc[each]) for each in [first, *others[:2]])
        return (
            f", and balls are jammed: {where} were pressed for {contacts['duration_s'][first]:.2g} s, with up to "
            f"{contacts['peak_force_N'][first]:.3g} N; {told}. Give the balls more room there, or take other balls; "
            "half the step may resolve a jam that passes"
        ), JAM_STEP
    if first is not None and hits.excess[first] > 0:
        met = contacts["approach_speed_m_s"][first]
        as_after = np.hypot(met, (2 * hits.excess[first] / hits.mass[first]) ** 0.5)
        pair = _partners(run, contacts.loc[first])
        told += f", where {pair} met at {met:.2g} m/s and overlapped as after {as_after:.2g} m/s"
    return (
        f", so that a shorter one does not help. Contacts make or lose energy: {told}. Look at the surfaces there; if "
        "they are sound, this is a fault of millprint's wall: please report it with the files of the mill"
    ), 0.0


def _key(run: "Simulation", factor: float) -> str:
    """The key of the case's step, with the value that it needs."""
    if run.case.rayleigh_fraction and not run.case.time_step_s:
        return f"rayleigh_fraction {factor * run.case.rayleigh_fraction:.2g}"
    return f"time_step_s {factor * run.step:.2g}"


def _as_impacts(run: "Simulation", contacts: pd.DataFrame) -> Hits:
    """Contacts as `by_surface` gives them as elastic impacts of the law."""
    law, species = law_of(run.contact), run.balls.species
    second, own = contacts["second"].to_numpy(), species[contacts["first"]]
    is_wall, other = second < 0, species[np.maximum(second, 0)]
    mass, partner = run.balls.mass[own], run.balls.mass[other]
    mass = np.where(is_wall, mass, mass * partner / (mass + partner))
    walls, pairs = (array[..., LAW.normal_stiffness] for array in (run.laws.wall[SURFACE.rough], run.laws.pair))
    stiffness = np.where(is_wall, walls[own], pairs[own, other])
    impact = np.vectorize(law.impact, otypes=[float, float])
    # A contact that begins while its partners part has no impact: it takes for ever.
    speed = np.maximum(contacts["approach_speed_m_s"].to_numpy(), 1e-12)
    # U = m v^2 / 2 goes with a power of the overlap.
    needed = (contacts["peak_overlap_m"].to_numpy() / impact(mass, stiffness, 1.0)[0]) ** (law.overlap_power / 2)
    return Hits(
        mass=mass,
        taken=impact(mass, stiffness, speed)[1],
        reached=impact(mass, stiffness, np.maximum(needed, 1e-12))[1],
        excess=mass / 2 * (needed**2 - speed**2),
    )


def _pressed_with(first: int, contacts: pd.DataFrame, hits: Hits) -> list[int]:
    """The further contacts that press a ball of the contact `first`, the strongest first; none if not a jam."""
    lasting = contacts[contacts["duration_s"] > LASTING * hits.reached[contacts.index]]
    if first not in lasting.index:
        return []
    own = contacts.loc[first]
    balls = [ball for ball in own[["first", "second"]].astype(int) if ball >= 0]
    touching = lasting["first"].isin(balls) | lasting["second"].isin(balls)
    others = lasting[touching].drop(first).sort_values("peak_force_N", ascending=False)
    return others.index.to_list() if others["peak_force_N"].sum() > own["peak_force_N"] / ALIKE else []


def _partners(run: "Simulation", contact: pd.Series) -> str:
    """Both partners of a contact in words."""
    second = int(contact["second"])
    if second >= 0:
        return f"balls {contact['first']:.0f} and {second}"
    body = run.walls.body[np.flatnonzero(run.walls.patch == -1 - second)[0]] if len(run.bodies) > 1 else 0
    return f"ball {contact['first']:.0f} and {run.bodies[body].name}"

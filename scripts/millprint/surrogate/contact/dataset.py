"""The training set of the contact surrogate: samples of contacts, states to roll out from, and their truth."""

from dataclasses import dataclass, fields
from pathlib import Path

import h5py
import numpy as np
from tqdm import tqdm

from millprint.config.contact import ContactConfig
from millprint.config.contact_surrogate import CoarseConfig, TraceConfig, ValidationConfig
from millprint.config.mill import MillConfig
from millprint.config.section import Section
from millprint.config.sweep import Case, DemConfig
from millprint.dem.layout import TOTAL
from millprint.hdf5 import open_hdf5, whole_hdf5
from millprint.surrogate.contact.coarse import SavedState, coarse_step
from millprint.surrogate.contact.tracer import Tracer

CHANNELS = [TOTAL.normal_damping_J, TOTAL.tangential_work_J]


class TracedModels(Section):
    """Settings of the traced simulations: mills and contact sets by name, and those of the DEM."""

    mills: dict[str, MillConfig]
    contacts: dict[str, ContactConfig]
    dem: DemConfig


@dataclass(frozen=True)
class Samples:
    """Contacts of many states: rows (n, SAMPLE_COLUMNS) in single precision, and the number in each (states,)."""

    rows: np.ndarray
    sizes: np.ndarray

    @classmethod
    def joined(cls, parts: list[tuple[np.ndarray, np.ndarray]]) -> "Samples":
        """Of several (rows, sizes), one after the other."""
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


@dataclass(frozen=True)
class Truth:
    """The result of the DEM from a state: works (2,) normal and tangential [J] after length_s, positions (n, 3) [m]."""

    begin: SavedState
    works_J: np.ndarray
    position_m: np.ndarray


def open_tracer(trace: TraceConfig, models: TracedModels, coarse: CoarseConfig, interval_s: float) -> Tracer:
    """The simulation of a trace, at the start of its motion; a whole number of coarse steps makes `interval_s` [s].

    Raises KeyError for a mill or a contact set that `models` lacks.
    """
    mill, contact, dem = models.mills[trace.mill], models.contacts[trace.contact], models.dem
    step = coarse_step(contact, trace.ball_diameter_mm / 2e3, coarse.rayleigh_multiple, interval_s)
    case = Case(
        mill=trace.mill, contact=trace.contact, ball_diameter_mm=trace.ball_diameter_mm, fill_ratio=trace.fill_ratio,
        speed_rpm=trace.speed_rpm, seed=trace.seed, settle_s=dem.settle_s, discard_s=trace.from_s,
        window_s=trace.until_s - trace.from_s,
    )  # fmt: skip
    return Tracer(case, mill, contact, dem, step, coarse.substeps)


def follow(tracer: Tracer, trace: TraceConfig, bar: tqdm | None = None) -> Samples:
    """Samples of the contacts of a trace."""
    tracer.to_time(trace.from_s)
    parts = []
    # A second at a time, for the progress.
    for until_s in np.linspace(trace.from_s, trace.until_s, 11)[1:]:
        parts.append(tracer.sample(trace.every, until_s))
        if bar is not None:
            bar.update()
    return Samples.joined(parts)


def truths(tracer: Tracer, settings: ValidationConfig) -> list[Truth]:
    """States from the present time on, each where the one before ends, and where the DEM takes them."""
    found = []
    for _ in range(settings.starts):
        begin, before, time_s = tracer.saved(), tracer.works(), tracer.coarse_number * tracer.coarse.step
        tracer.to_time(time_s + settings.position_s)
        position = tracer.balls.position.copy()
        tracer.to_time(time_s + settings.length_s)
        found.append(Truth(begin, (tracer.works() - before)[CHANNELS], position))
    return found


def write_dataset(parts: list[Samples], true_states: list[Truth], path: str | Path) -> None:
    """Write samples as groups `samples/0`, ... and truths as groups `truths/0`, ... of an HDF5 file."""
    options = {"compression": "gzip", "compression_opts": 2, "shuffle": True}
    with whole_hdf5(path) as file:
        for number, part in enumerate(parts):
            group = file.create_group(f"samples/{number}")
            group.create_dataset("rows", data=part.rows, **options)
            group["sizes"] = part.sizes
        for number, truth in enumerate(true_states):
            group = file.create_group(f"truths/{number}")
            group["works_J"], group["position_m"] = truth.works_J, truth.position_m
            group.attrs["step"] = truth.begin.step
            for field in fields(SavedState):
                if field.name != "step":
                    group[f"begin/{field.name}"] = getattr(truth.begin, field.name)


def read_dataset(path: str | Path) -> tuple[list[Samples], list[Truth]]:
    """Read a file of `write_dataset`."""
    with open_hdf5(path) as file:
        parts = [Samples(group["rows"][:], group["sizes"][:]) for group in _groups(file, "samples")]
        true_states = []
        for group in _groups(file, "truths"):
            arrays = {
                field.name: group[f"begin/{field.name}"][:] for field in fields(SavedState) if field.name != "step"
            }
            begin = SavedState(**arrays, step=int(group.attrs["step"]))
            true_states.append(Truth(begin, group["works_J"][:], group["position_m"][:]))
    return parts, true_states


def _groups(file: h5py.File, name: str) -> list[h5py.Group]:
    return [file[f"{name}/{number}"] for number in range(len(file[name]))]

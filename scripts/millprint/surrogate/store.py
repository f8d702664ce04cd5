"""Roll-outs on disk."""

from pathlib import Path

from millprint.hdf5 import open_hdf5, whole_hdf5
from millprint.surrogate.rollout import RollOut

UNITS = {
    "time_s": "s",
    "position_m": "m",
    "velocity_m_s": "m/s",
    "dissipated_J": "J",
    "crossed_s": "s",
    "start_s": "s",
}


def write_rollout(rollout: RollOut, path: str | Path, case: str) -> None:
    """Write a data set for each array of RollOut, with its unit, and the case that it starts from."""
    with whole_hdf5(path) as file:
        file.attrs["case"] = case
        for kind, number in rollout.edges.items():
            file.attrs[f"mean_{kind}_edges"] = number
        for name, unit in UNITS.items():
            file[name] = getattr(rollout, name)
            file[name].attrs["units"] = unit


def read_rollout(path: str | Path) -> RollOut:
    """Read what `write_rollout` wrote."""
    with open_hdf5(path) as file:
        edges = {kind: float(file.attrs[f"mean_{kind}_edges"]) for kind in ("wall", "pair")}
        return RollOut(**{name: file[name][:] for name in UNITS}, edges=edges)

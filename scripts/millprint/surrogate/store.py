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
# What not every surrogate knows.
OPTIONAL = {"spin_rad_s": "rad/s", "normal_J": "J", "tangential_J": "J", "collisions": "1", "member_dissipated_J": "J",
            "doubt": "1"}  # fmt: skip


def write_rollout(rollout: RollOut, path: str | Path, case: str) -> None:
    """Write a data set for each array of RollOut, with its unit, and the case that it starts from."""
    with whole_hdf5(path) as file:
        file.attrs["case"] = case
        for kind, number in rollout.edges.items():
            file.attrs[f"mean_{kind}_edges"] = number
        for name, unit in (UNITS | OPTIONAL).items():
            if getattr(rollout, name) is not None:
                file[name] = getattr(rollout, name)
                file[name].attrs["units"] = unit


def read_rollout(path: str | Path) -> RollOut:
    """Read what `write_rollout` wrote."""
    with open_hdf5(path) as file:
        edges = {
            kind: float(file.attrs[key]) for kind in ("wall", "pair") if (key := f"mean_{kind}_edges") in file.attrs
        }
        present = [*UNITS, *(name for name in OPTIONAL if name in file)]
        return RollOut(**{name: file[name][:] for name in present}, edges=edges)

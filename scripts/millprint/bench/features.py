"""What other tools have and we have: theirs from a table with sources, ours from registries and from tests that exist.

Nothing of our own column is typed: a feature is there because a registry lists it or because a test shows it. A test
that is renamed or removed makes the page wrong, which the check of `make reference` finds.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from millprint.config.motion import MOTIONS
from millprint.errors import ConfigError
from millprint.files import read_table
from millprint.mill.shapes import SHAPES

TOOLS = ("LAMMPS", "LIGGGHTS", "YADE", "EDEM")
COLUMNS = ("tool", "feature", "has", "source")
UNKNOWN = "not known to us"


@dataclass(frozen=True)
class Feature:
    """A row of the comparison.

    title: as readers know it; tests: `file::function` below tests/, each of which shows that we have it, none if we do
    not; found: what registries say of it, in place of `yes`.
    """

    title: str
    tests: tuple[str, ...] = ()
    found: Callable[[], str] | None = None

    def ours(self, root: Path) -> str:
        """What we have. Raises ConfigError for a test that is not there."""
        for test in self.tests:
            check_test(root, test)
        return self.found() if self.found else "yes" if self.tests else "no"


def check_test(root: Path, test: str) -> None:
    """Raise ConfigError if tests/ has no such test; test: `file::function`."""
    file, _, function = test.partition("::")
    path = root / "tests" / file
    if not path.is_file() or not re.search(rf"^def {re.escape(function)}\(", path.read_text(), re.MULTILINE):
        raise ConfigError(f"tests/{test}: no such test, so that nothing shows the feature")


def licence(root: Path) -> str:
    """Our licence, of the file LICENSE."""
    return (root / "LICENSE").read_text().splitlines()[0].removesuffix(" License")


def _walls() -> str:
    shapes = ", ".join(kind.replace("_", " ") for kind in SHAPES if kind != "stl")
    return f"triangles from STL, PLY or OBJ, and {shapes}; {len(MOTIONS)} kinds of motion"


FEATURES = {
    "moving_walls": Feature(
        "walls that move as the mill does",
        ("physics/test_bodies.py::test_a_binary_stl_gives_the_same_powers_within_the_spread_of_seeds",
         "physics/test_walls.py::test_wall_velocity_is_the_rate_of_change_of_position"),
        _walls,
    ),
    "split_energies": Feature(
        "normal and tangential energy of each collision, walls included",
        ("physics/test_balance.py::test_collisions_sum_to_the_ledger",),
    ),
    "collision_list": Feature(
        "list of all collisions",
        ("unit/test_dem_collisions.py::test_summary_and_run_agree",
         "unit/test_dem_collisions.py::test_contacts_of_a_pair_within_the_gap_are_one_collision"),
    ),
    "balance": Feature(
        "a run fails if its energy balance does not close",
        ("physics/test_balance.py::test_an_open_balance_is_refused",),
    ),
    "restart": Feature(
        "a stopped run goes on bit for bit",
        ("physics/test_restart.py::test_a_stopped_run_goes_on_bit_for_bit",),
    ),
    "fingerprint": Feature(
        "curves over speed, fill and balls that predict a condition with an interval",
        ("unit/test_fingerprint_model.py::test_the_band_holds_the_stated_fraction_of_left_out_conditions",),
    ),
    "contact_uncertainty": Feature(
        "intervals by contact parameters that are not known",
        ("unit/test_uncertainty.py::test_design_emulator_and_indices_give_those_of_ishigamis_function",),
    ),
    "scripting": Feature("use from Python", ("unit/test_api.py::test_every_name_is_there_and_explains_itself",)),
    "parallel": Feature(
        "parallel",
        ("physics/test_threads.py::test_threads_change_a_run_only_by_rounding",),
        lambda: "threads; conditions beside each other, also on a cluster",
    ),
    "other_shapes": Feature("bodies other than spheres"),
    "cohesion": Feature("cohesion"),
    "fluid_coupling": Feature("coupling with a fluid"),
}  # fmt: skip
LICENCE = "licence"


def read_tools(path: str | Path) -> pd.DataFrame:
    """The features of other tools, with a source each. Raises ConfigError for an unknown name, or one twice."""
    table = read_table(path, numeric=[], text=list(COLUMNS))
    for row, tool, feature in zip(range(1, len(table) + 1), table["tool"], table["feature"], strict=True):
        if tool not in TOOLS:
            raise ConfigError(f"{path}: column tool, row {row} = {tool}: must be one of {', '.join(TOOLS)}")
        if feature not in (LICENCE, *FEATURES):
            known = ", ".join((LICENCE, *FEATURES))
            raise ConfigError(f"{path}: column feature, row {row} = {feature}: must be one of {known}")
    twice = table[table.duplicated(["tool", "feature"])]
    if len(twice):
        raise ConfigError(f"{path}: {twice.iloc[0]['tool']}, {twice.iloc[0]['feature']}: stands there twice")
    return table


def feature_rows(tools: pd.DataFrame, root: Path) -> list[list[str]]:
    """Title, ours, and that of each of TOOLS, for the licence and every feature, as text."""
    theirs = {(row.tool, row.feature): str(row.has) for row in tools.itertuples()}
    rows = [("licence", LICENCE, licence(root))]
    rows += [(feature.title, name, feature.ours(root)) for name, feature in FEATURES.items()]
    return [[title, ours, *(theirs.get((tool, name), UNKNOWN) for tool in TOOLS)] for title, name, ours in rows]

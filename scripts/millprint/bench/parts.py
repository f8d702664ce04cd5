"""What the parts of a step cost, from the processor's clock (millprint.dem.profile)."""

import numpy as np
import pandas as pd

from millprint.bench.cases import Setup, count_steps, start_from
from millprint.dem.profile import PARTS, make_profile

# Columns of results/bench/parts.tsv.
PART_COLUMNS = ("case", "balls", "part", "share", "ns_per_ball_step")
# Time of the mill's motion that compiles the loop with the clock [s].
SHORT_S = 1e-5


def parts_of(setup: Setup, start: np.ndarray, driven_s: float) -> pd.DataFrame:
    """Share of each part of the step loop in a run from `start` (n, 3) [m], a row each, in PART_COLUMNS.

    ns_per_ball_step is the share of the processor time of this run: reading the clock makes it slower than others.
    """
    for seconds in (SHORT_S, driven_s):
        simulation = start_from(setup, start, seconds)
        simulation.profile = profile = make_profile()
        simulation.run(f"{setup.name}: parts of a step")
    ticks = profile[: len(PARTS)]
    share = ticks / ticks.sum()
    ns = simulation.processor_s / count_steps(simulation) / setup.balls * 1e9
    rows = {"case": setup.name, "balls": setup.balls, "part": PARTS, "share": share, "ns_per_ball_step": share * ns}
    return pd.DataFrame(rows)[list(PART_COLUMNS)]


def parts_text(parts: pd.DataFrame) -> str:
    """The shares of all cases in per cent, a row for each part."""
    shares = 100 * parts.pivot(index="part", columns="case", values="share").loc[list(PARTS)]
    return f"share of a step [%]\n{shares.to_string(float_format='{:.1f}'.format)}"

"""A made-up atlas: random power laws and random smooth parts, for tests of what reads one."""

import numpy as np
import pandas as pd

from millprint.atlas.atlas_model import FITTED, MARKS, PREDICTED, KindModel, Surface, Width
from millprint.atlas.kind_groups import Kind
from millprint.atlas.kinds import KINDS
from millprint.atlas.page.atlas_page import OF_ERRORS

CENTRES = 30


def made_model(kind: Kind, seed: int = 1) -> KindModel:
    """Numbers near their scales, which change with every input."""
    draw = np.random.default_rng(seed)
    width = len(kind.groups) + len(kind.derived)
    # The last input is whether balls hit something, which only the power depends on.
    centres = np.column_stack([draw.random((CENTRES, width)), draw.random(CENTRES) > 0.5])

    def surface(level: float, slope: float = 0.3, width: int = width) -> Surface:
        rows = np.sort(draw.choice(CENTRES, CENTRES - 4, replace=False))
        return Surface(
            linear=np.array([level, *draw.normal(0, slope, width)]), lengths=draw.uniform(0.4, 4.0, width),
            weights=draw.normal(0, 0.3, len(rows)), rows=rows, noise=np.full(len(rows), 0.01), amplitude=0.2,
        )  # fmt: skip

    levels = {"normal_energy": -1.0, "tangential_energy": -3.0, "tangential_frequency": 3.0, "rolling_ratio": -2.0}
    surfaces = {name: surface(levels.get(name, 0.0)) for name in FITTED if name != "power"}
    surfaces["power"] = surface(-1.0, width=width + 1)
    widths = {name: Width(np.array([-2.0, *draw.normal(0, 0.1, width)]), 1.6, 0.6) for name in PREDICTED}
    about = {"simulations": CENTRES, "without_hits": 0, "version": "made up", "processor_s": 1}
    return KindModel(kind, centres, surfaces, widths, surface(3.0, 0.2), about)


def made_atlas() -> dict[str, KindModel]:
    """One of each kind."""
    return {name: made_model(kind, seed) for seed, (name, kind) in enumerate(KINDS.items())}


def made_errors() -> pd.DataFrame:
    """The table of its errors on held-out mills."""
    rows = {OF_ERRORS["median"]: 0.1, OF_ERRORS["held"]: 0.9}
    own = [{"kind": name, "model": model, "mills": 100, **dict.fromkeys(MARKS, value)}
           for name in KINDS for model, value in rows.items()]  # fmt: skip
    return pd.DataFrame(own)

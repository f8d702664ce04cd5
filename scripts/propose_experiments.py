"""Proposes the next experiments within the region that the user can reach."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.mill import MillConfig
from millprint.config.proposals import ProposalConfig
from millprint.doe.runs import YIELD
from millprint.files import read_table, write_table
from millprint.fingerprint.regimes import read_regimes
from millprint.job import job
from millprint.predict.averaging import average, fit_library
from millprint.predict.proposals import propose
from millprint.predict.regimes import Machine, regime_rows
from millprint.predict.region import CURVES, Mill, check_region, region_conditions
from millprint.predict.tables import read_rows


def main(
    parts: list[str],
    regimes: str,
    curves: str | None,
    proposals: str,
    machine: Machine,
    volume: float,
    settings: ProposalConfig,
    averaging: AveragingConfig,
) -> None:
    """Write the proposals; `curves` is a table of master curves, or None for those of `regimes`."""
    cases = read_regimes(regimes)
    known = [read_rows(path) for path in parts]
    if settings.regimes:
        known.append(regime_rows(cases, machine))
    rows = pd.concat(known, ignore_index=True)
    table = cases if curves is None else read_table(curves, numeric=["fill_ratio", *CURVES])
    check_region(settings.region, table, "config")
    mill = Mill(machine.density, machine.amplitude, volume)
    with threadpool_limits(1):
        model = average(fit_library(rows, rows[YIELD].to_numpy(float), averaging), averaging)
        conditions = region_conditions(settings.region, table, mill)
        write_table(propose(model, rows, conditions, settings), proposals)


if "snakemake" in globals():
    with job(snakemake.log[0], "propose experiments"):
        main(
            [snakemake.input.train, snakemake.input.test],
            snakemake.input.regimes,
            snakemake.input.get("curves"),
            snakemake.output.proposals,
            Machine.of_mill(MillConfig(**snakemake.params.mill), **snakemake.params.machine),
            snakemake.params.volume_m3,
            ProposalConfig(**snakemake.params.settings),
            AveragingConfig(**snakemake.params.averaging),
        )

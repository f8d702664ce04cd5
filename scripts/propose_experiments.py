"""Proposes the next experiments within the configured region."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.mill import MillConfig
from millprint.config.proposals import ProposalConfig
from millprint.doe.runs import YIELD
from millprint.files import read_table, write_table
from millprint.fingerprint.condition import BASIC, Condition
from millprint.fingerprint.regimes import read_regimes
from millprint.job import job
from millprint.predict.averaging import fit_averaged
from millprint.predict.proposals import propose
from millprint.predict.regimes import reference_of_mill, regime_rows
from millprint.predict.region import Mill, check_region, region_conditions
from millprint.predict.tables import read_rows


def main(
    parts: list[str],
    cases: pd.DataFrame,
    curves: str | None,
    proposals: str,
    reference: Condition[float],
    volume: float,
    settings: ProposalConfig,
    averaging: AveragingConfig,
) -> None:
    """Write the proposals; `curves` is the path of a table of master curves, or None for the curves of `cases`."""
    known = [read_rows(path) for path in parts]
    if settings.regimes:
        known.append(regime_rows(cases, reference))
    rows = pd.concat(known, ignore_index=True)
    table = cases if curves is None else read_table(curves, numeric=["fill_ratio", *BASIC])
    check_region(settings.region, table, "config")
    mill = Mill(reference.density_kg_m3, reference.amplitude_m, volume)
    with threadpool_limits(1):
        model = fit_averaged(rows, rows[YIELD].to_numpy(float), averaging)
        conditions = region_conditions(settings.region, table, mill)
        write_table(propose(model, rows, conditions, settings), proposals)


if "snakemake" in globals():
    with job(snakemake.log[0], "propose experiments"):
        cases = read_regimes(snakemake.input.regimes)
        main(
            [snakemake.input.train, snakemake.input.test],
            cases,
            snakemake.input.get("curves"),
            snakemake.output.proposals,
            reference_of_mill(cases, MillConfig(**snakemake.params.mill), **snakemake.params.machine),
            snakemake.params.volume_m3,
            ProposalConfig(**snakemake.params.settings),
            AveragingConfig(**snakemake.params.averaging),
        )

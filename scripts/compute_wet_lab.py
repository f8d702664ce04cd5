"""Calculates half-lives, ball wear and the iron from it, and powder masses and gas volumes of the screening runs."""

from millprint.config.design import Factor
from millprint.config.doe import ChemistryConfig, GasConfig, HalfLifeConfig, PowderConfig
from millprint.doe.runs import read_runs
from millprint.doe.wet_lab import half_life_table, powder_table, read_wear, wear_table
from millprint.files import write_table
from millprint.job import job


def main(
    screening: str,
    weighings: str,
    output,
    factors: list[Factor],
    solution: HalfLifeConfig,
    jar: PowderConfig,
    chemistry: ChemistryConfig,
    gas: GasConfig,
) -> None:
    """Write the three tables."""
    runs = read_runs(screening, factors, positive=["bpr", "molar_ratio"])
    write_table(half_life_table(solution), output.half_life)
    write_table(wear_table(read_wear(weighings)), output.wear)
    write_table(powder_table(runs, jar, chemistry, gas), output.powder)


if "snakemake" in globals():
    with job(snakemake.log[0], "compute wet lab"):
        main(
            snakemake.input.screening,
            snakemake.input.weighings,
            snakemake.output,
            [Factor(**factor) for factor in snakemake.params.factors],
            HalfLifeConfig(**snakemake.params.half_life),
            PowderConfig(**snakemake.params.powder),
            ChemistryConfig(**snakemake.params.chemistry),
            GasConfig(**snakemake.params.gas),
        )

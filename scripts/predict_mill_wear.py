"""Wear of the balls and iron in the powder in the mills of the box, by the coefficient of the thesis's weighings.

Settings: dose.wear.
Inputs: `summaries`, their `runs`, `coefficient`, `materials`.
Outputs: `table`, and the figure.
"""

from millprint.config.dose import WearConfig
from millprint.dose.wear import mean_conditions, predict_wear, read_coefficient, read_materials, tabulate_sliding
from millprint.figures.style import save
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.figures.chapter2_figures import plot_mill_wear


def main(runs: list[tuple[str, str]], coefficient: str, materials: str, output, settings: WearConfig) -> None:
    """Write the wear at every condition of the mills and the figure. runs: pairs of run.h5 and summary.json."""
    result = read_coefficient(coefficient)
    conditions = mean_conditions(tabulate_sliding(runs))
    # Factors by contact parameters are those of single mills; the note says that they are not in the interval.
    known = read_materials(materials, settings.material)
    wear = predict_wear(conditions, known, settings.charges, result, None)
    write_table(wear, output.table)
    save(plot_mill_wear(wear, settings.material), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "wear in the mills of the box"):
        main(
            list(zip(snakemake.input.runs, snakemake.input.summaries, strict=True)),
            snakemake.input.coefficient,
            snakemake.input.materials,
            snakemake.output,
            WearConfig(**snakemake.params.settings),
        )

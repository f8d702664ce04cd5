"""Measures the sliding work; fits the wear coefficient to half of the weighings, compares it with the others, and
predicts the wear elsewhere. Or predicts the wear in the mills of the box by that coefficient.

Settings: dose.wear; mill, contact set and counting rule of the weighings.
Inputs: `summaries`, their `runs`, `materials`; `weighings`, and `factors` if there are any; or `coefficient`.
Outputs: `runs`, `conditions`, `fit`, `coefficient`, `wear`, or the `table` of the mills; and the figure.
"""

from millprint.config.dose import WearConfig
from millprint.dose.wear import (
    CONDITION,
    mean_conditions,
    predict_wear,
    read_coefficient,
    read_materials,
    tabulate_sliding,
)
from millprint.figures.style import save
from millprint.fingerprint.bands import read_factors
from millprint.run.files import read_json, read_table, write_json, write_table
from millprint.run.job import job
from millprint.thesis.doe.wet_lab import fit_wear, read_wear, said_of_wear, wear_table
from millprint.thesis.figures.chapter2_figures import plot_mill_wear, plot_wear


def main(inputs, output, settings: WearConfig, machine: dict[str, str], log) -> None:
    """Write the weighings with their predictions, the coefficient, and the wear at every condition.

    machine: mill and contact set of the weighings, and the counting rule of the factors by contact parameters.
    """
    conditions = read_table(output.conditions, text=CONDITION[:2])
    own = conditions[(conditions["mill"] == machine["mill"]) & (conditions["contact"] == machine["contact"])]
    materials = read_materials(inputs.materials, settings.material)
    weighings = wear_table(read_wear(inputs.weighings))
    table, result = fit_wear(weighings, own, materials.loc[settings.material])
    log.info("wear: %s", said_of_wear(result))
    factors = read_factors(inputs.factors, "contact", machine) if inputs.get("factors") else None
    write_table(table, output.fit)
    write_json({**result, "said": said_of_wear(result)}, output.coefficient)
    wear = predict_wear(conditions, materials, settings.charges, result, factors)
    write_table(wear, output.wear)


if "snakemake" in globals():
    given, made, settings = snakemake.input, snakemake.output, WearConfig(**snakemake.params.settings)
    with job(snakemake.log[0], "wear of the balls") as log:
        sliding = tabulate_sliding(list(zip(given.runs, given.summaries, strict=True)))
        conditions = mean_conditions(sliding)
        if made.get("table"):
            # Factors by contact parameters are those of single mills; the note says that they are not in the interval.
            known = read_materials(given.materials, settings.material)
            wear = predict_wear(conditions, known, settings.charges, read_coefficient(given.coefficient), None)
            write_table(wear, made.table)
            save(plot_mill_wear(wear, settings.material), *made.figure)
        else:
            write_table(sliding, made.runs)
            write_table(conditions, made.conditions)
            log.info("sliding work of %d simulations: %s", len(given.runs), made.runs)
            main(given, made, settings, snakemake.params.machine, log)
            weighings, predicted = read_table(made.fit), read_table(made.wear)
            figure = plot_wear(weighings, predicted, settings.material, read_json(made.coefficient)["said"])
            save(figure, *made.figure)

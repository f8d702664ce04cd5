"""Predicts yields of new conditions, and proposes the next experiments within the configured region.

Settings: yields.prediction, yields.training, yields.evaluation.conformal_folds, yields.interval_level,
yields.proposals, doe.chemistry; the volume of the mill.
Inputs: `model`, `conditions`, `proposing`, `mill`, and `experiments` if there are any.
Outputs: `predicted`, `proposals`, `left_out`, `reasons`.
"""

from threadpoolctl import threadpool_limits

from millprint.config.doe import ChemistryConfig
from millprint.config.yields import PredictionConfig, ProposalConfig, TrainingConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.yields.experiments import RUNNING, Mill, experiment_rows, read_experiments, region_conditions
from millprint.thesis.yields.new_conditions import MillCurves, write_predictions
from millprint.thesis.yields.proposals import count_reasons, propose, split_region
from millprint.thesis.yields.stored_models import load_averaged, training_rows


def propose_experiments(
    given, made, volume: float, settings: ProposalConfig, limits: PredictionConfig, reaction: ChemistryConfig
) -> str:
    """Write the proposals, and what may not be proposed with its reasons; return a line for the log.

    volume: of the jar of the mill [m3]; limits: those of predictions.
    """
    with threadpool_limits(1):
        process, known = load_averaged(given.proposing), training_rows(given.proposing)
        own = MillCurves.read(given.mill)
        machine = Mill(own.density, own.amplitude, volume)
        conditions = region_conditions(settings.region, own.curves, machine)
        allowed, left_out = split_region(process, known, conditions, settings, limits, reaction, machine, own)
        running, taken = conditions.iloc[:0], []
        if settings.experiments:
            told = read_experiments(settings.experiments, own.curves)
            running, taken = experiment_rows(told, RUNNING, own.curves, machine), told["case"].tolist()
        table = propose(process, known, allowed, settings, running, limits.curve_tolerance, taken)
    write_table(table, made.proposals)
    write_table(left_out, made.left_out)
    write_table(count_reasons(left_out, len(conditions)), made.reasons)
    free = settings.replicates + settings.centre_points + 2 * settings.runs - len(table)
    return f"{len(allowed)} of {len(conditions)} conditions may be proposed; {free} slots of the batch are left empty"


if "snakemake" in globals():
    given, made, asked = snakemake.input, snakemake.output, snakemake.params
    limits = PredictionConfig(**asked.settings)
    with job(snakemake.log[0], "predict yields") as logger:
        own = (limits, TrainingConfig(**asked.training), asked.conformal_folds, asked.interval_level)
        write_predictions(given.model, given.conditions, made.predicted, *own, extrapolate=False, mill=given.mill)
        logger.info("predicted: %s", given.conditions)
        settings, reaction = ProposalConfig(**asked.proposals), ChemistryConfig(**asked.chemistry)
        logger.info(propose_experiments(given, made, asked.volume_m3, settings, limits, reaction))

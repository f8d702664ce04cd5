"""Calculates the training set of the surrogate from the snapshots of simulations.

Settings: surrogate.snapshots.
Inputs: `runs`: run.h5 of each simulation.
Outputs: `dataset` and `wall_contacts`.
"""

import numpy as np

from millprint.config.surrogate import SnapshotConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.surrogate.dataset import TrainingRun, featurise, wall_contact_distances, write_dataset
from millprint.thesis.surrogate.measures import wall_contact_table
from millprint.thesis.surrogate.rollout import read_scene, read_trajectory

if "snakemake" in globals():
    given, made, settings = snakemake.input, snakemake.output, SnapshotConfig(**snakemake.params.settings)
    with job(snakemake.log[0], "build the surrogate's training set") as log:
        parts: list[TrainingRun] = []
        distances: list[np.ndarray] = []
        for case, path in zip(settings.cases, given.runs, strict=True):
            trajectory, scene = read_trajectory(path, until_s=settings.validation_until_s), read_scene(path)
            snapshots, count = featurise(trajectory, scene), len(trajectory.time_s)
            train_end = trajectory.index(settings.train_until_s)
            parts.append(TrainingRun(case, snapshots, train_end, count - 1))
            distances.append(wall_contact_distances(snapshots, train_end))
            log.info("%s: %d snapshots of %d balls, %d to train on", path, count, trajectory.balls, train_end)
        write_dataset(parts, made.dataset)
        write_table(wall_contact_table(np.concatenate(distances)), made.wall_contacts)

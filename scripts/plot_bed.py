"""Figure: the flowing bed of a measured drum, each ball coloured by its speed.

params: `radius_m` and `diameter_m`. input: `run` (run.h5). output: `svg`, `png`, `tsv`.
"""

from pathlib import Path

from millprint.figures.style import save
from millprint.figures.validation_figures import plot_bed
from millprint.run.job import job
from millprint.validation.drums import slab_of_bed
from millprint.validation.setups import setup_named

if "snakemake" in globals():
    name, given = snakemake.wildcards.setup, snakemake.params
    with job(snakemake.log[0], f"plot the bed of set-up {name}"):
        balls = slab_of_bed(Path(snakemake.input.run), given.diameter_m)
        figure = plot_bed(balls, given.radius_m, given.diameter_m, setup_named(name).title)
        save(figure, snakemake.output.svg, snakemake.output.png, tsv=snakemake.output.tsv)

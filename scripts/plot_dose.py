"""Draws yields against time, doses and hits, with the best kinetics over each."""

from millprint.figures.spectra import plot_doses
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "plot doses"):
        doses, curves = (read_table(snakemake.input[name]) for name in ("doses", "curves"))
        save(plot_doses(doses, curves), snakemake.output.svg, snakemake.output.png)

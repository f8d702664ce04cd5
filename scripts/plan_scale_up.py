"""A large mill by geometric similarity: how to run it, what stays the same, and the cost of simulating it.

Settings: mills.scale_up, mills.rayleigh_fraction; the small mill, the contact set.
Inputs: `fingerprint`, and `summary` of a simulated large mill.
Outputs: `sheet`, `run`, and the figure.
"""

from millprint.cases.of_mill import enlarged
from millprint.config.contact_set import ContactConfig
from millprint.config.counting import recorded_count
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import ScaleUpConfig
from millprint.dem.laws.registry import step_scale
from millprint.figures.mill_sheet_figure import plot_scale_up
from millprint.figures.style import save
from millprint.fingerprint.mill_collapse import compare_run, tabulate_scale_up
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import read_json, write_table
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "plan the large mill") as logger:
        settings, fraction = ScaleUpConfig(**snakemake.params.settings), snakemake.params.rayleigh_fraction
        fingerprint, run = Fingerprint.read(snakemake.input.fingerprint), read_json(snakemake.input.summary)
        _, factor = enlarged(MillConfig(**snakemake.params.mill), settings.volume_l, "large")
        contact = ContactConfig(**snakemake.params.contact)
        # The smallest ball has the shortest step.
        smallest = min((run["case"].get("mixture") or {}).get("sizes_mm", [1e3 * run["case"]["ball_diameter_m"]]))
        step = fraction * step_scale(contact, smallest / 2e3)
        sheet = tabulate_scale_up(fingerprint, factor, settings, step, run["ns_per_ball_step"])
        write_table(sheet, snakemake.output.sheet)
        compared = compare_run(sheet, run, recorded_count(run, fingerprint.about["counting_rule"]))
        write_table(compared, snakemake.output.run)
        save(plot_scale_up(sheet), *snakemake.output.figure)
        logger.info("simulated large mill: %d balls, %.3g s of processor time", run["balls"], run["processor_s"])

"""Simulates a tumbling mill at every speed, number of balls, seed and contact set of its section.

Settings: the settings of the set-up, dem; its mill and contact sets.
Inputs: `measured`.
Outputs: `runs` and `charge`.
"""

from pathlib import Path

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setup_models import read_settings
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.validation.measured import measured_points, read_measurements
from millprint.thesis.validation.setups import SETUPS
from millprint.thesis.validation.tumbling_runs import design, measured_speeds, run_all

if "snakemake" in globals():
    name, given = snakemake.wildcards.setup, snakemake.params
    with job(snakemake.log[0], f"simulate {name}"):
        settings = read_settings(name, given.settings)
        contacts = {contact["name"]: ContactConfig(**contact) for contact in given.contacts}
        points = measured_points(read_measurements(snakemake.input.measured, SETUPS))
        places = measured_speeds(settings, points[points["setup"] == name])
        done = Path(snakemake.output.runs).with_name("runs.partial")
        runs, charge = run_all(
            design(settings, contacts, places),
            settings,
            MillConfig(**given.mill),
            contacts[settings.contact],
            DemConfig(**given.dem),
            done,
        )
        write_table(runs, snakemake.output.runs)
        write_table(charge, snakemake.output.charge)
        done.unlink(missing_ok=True)

"""The predictions of one measured set-up; or first the simulations of a tumbling mill that they need.

A tumbling mill is simulated at every speed, number of balls, seed and contact set of its section.

Settings: the settings of the set-up, dem; its mill and contact sets.
Inputs: `measured`; `other_codes`, and the `runs` and `tables` of its simulations.
Outputs: `predictions`; or `runs` and `charge`.
"""

from pathlib import Path

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setup_models import SETTINGS, read_settings, setup_cases
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.validation.measured import KEPT, measured_points, read_measurements, read_other_codes
from millprint.validation.setups import predict
from millprint.validation.tumbling_runs import design, measured_speeds, run_all

if "snakemake" in globals():
    name, given, made = snakemake.wildcards.setup, snakemake.params, snakemake.output
    with job(snakemake.log[0], f"predict set-up {name}"):
        settings, dem = read_settings(name, given.settings), DemConfig(**given.dem)
        mill = MillConfig(**given.mill) if given.mill else None
        contacts = {contact["name"]: ContactConfig(**contact) for contact in given.contacts}
        points = measured_points(read_measurements(snakemake.input.measured, SETTINGS))
        if made.get("charge"):
            done = Path(made.runs).with_name(KEPT)
            wanted = design(settings, contacts, measured_speeds(settings, points[points["setup"] == name]))
            runs, charge = run_all(wanted, settings, mill, contacts[settings.contact], dem, done)
            write_table(runs, made.runs)
            write_table(charge, made.charge)
            done.unlink(missing_ok=True)
        else:
            others, cases = read_other_codes(snakemake.input.other_codes), setup_cases(settings, dem)
            own = (name, settings, mill, contacts, dem, cases)
            write_table(predict(*own, given.runs, points, given.folder, others), made.predictions)
            (Path(given.folder) / KEPT).unlink(missing_ok=True)

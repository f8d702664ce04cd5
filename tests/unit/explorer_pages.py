"""Explorers of two made-up mills with energy spectra and temperatures, for the tests of the page."""

from pathlib import Path

import numpy as np

from millprint.config.dose import HeatConfig
from millprint.dose.heat_balance import HeatSource, heat_tables
from millprint.dose.spectra import tabulate_spectra
from millprint.explorer.content import Heat, Machine, Spectra, explorer_content, explorer_page, mill_content
from millprint.fingerprint.condition_search import simulated_request
from millprint.fingerprint.descriptors import condition_of, tabulate_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import write_table
from tests.unit.synthetic_mill import FILLS, VOLUME, summaries, summary
from tests.unit.test_dose_spectra import contacts, write

RULE = "lifetimes"
HEAT = HeatConfig(samples=16)
# Of one turn a second, in units of gravity.
ACCELERATION = {"emax": 0.0684, "planetary": 0.4346}
# Simulated conditions of the spectra and of the heat balance: fill ratio and speed [rpm].
CONDITIONS = ((0.06, 600.0), (0.06, 1200.0), (0.12, 600.0), (0.12, 1200.0))


def spectra_of(folder: Path) -> Spectra:
    """Tables of spectra of contacts with energies at random, the harder the faster the mill."""
    generator, runs = np.random.default_rng(5), []
    for number, (fill, speed) in enumerate(CONDITIONS):
        kinds = [contacts(400, 1.0, 1.0), contacts(200, 1.0, 1.0, wall=True)]
        for table in kinds:
            scale = 1e-4 * (speed / 600) ** 2
            table["normal_J"] = scale * generator.lognormal(0.0, 2.0, len(table))
            table["sliding_J"] = scale * generator.lognormal(0.5, 1.5, len(table))
            table["damping_J"] = 0.0
        path, summary = write(folder / f"{number}.h5", *kinds, fill=fill)
        summary["case"]["speed_hz"] = speed / 60
        runs.append((path, summary | {"contact": "calibrated"}))
    table, summary = tabulate_spectra(runs, [RULE])
    write_table(table, folder / "spectra.tsv")
    write_table(summary, folder / "spectra_summary.tsv")
    return Spectra([(folder / "spectra.tsv", folder / "spectra_summary.tsv")], RULE)


def heat_of(folder: Path, mill: str, runs: list[dict]) -> Heat:
    """Tables of temperatures of a jar that dissipates more at a higher speed, of runs with these summaries."""
    sources = [
        HeatSource(
            condition=f"{about['charge'] or 'd10'}_f{about['fill_ratio']:.2f}_n{about['speed_rpm']:g}",
            about=about | {"seeds": 1},
            power_W=np.full((2, 3), 5.0 * (about["speed_rpm"] / 600) ** 3),
            balls_kg=0.1, balls_m2=0.008, inside_m2=0.013, inside_m3=125e-6,
        )
        for about in map(condition_of, runs)
    ]  # fmt: skip
    tables = heat_tables(HEAT, mill, sources, times=7)
    write_table(tables.temperatures, folder / f"{mill}_temperatures.tsv")
    write_table(tables.limits, folder / f"{mill}_limits.tsv")
    return Heat(folder / f"{mill}_temperatures.tsv", folder / f"{mill}_limits.tsv", HEAT)


def two_mills(folder: Path) -> dict:
    """A page of two mills, the first with spectra, both with temperatures; its content and the fingerprints."""
    found, mills = {}, []
    for name, factor in (("emax", 1.0), ("planetary", 2.0)):
        runs = summaries(fills=FILLS[::2])
        path = folder / f"{name}.json"
        Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), factor * VOLUME, 0.95).write(path)
        own = Fingerprint.read(path)
        found[name] = own
        machine = Machine(name, f"Mill {name}", "the jar moves", ACCELERATION[name])
        spectra = spectra_of(folder) if name == "emax" else None
        heat = heat_of(folder, name, [summary(fill, speed_rpm=speed) for fill, speed in CONDITIONS])
        mills.append(mill_content(machine, [path], simulated_request(own, "weighted"), None, spectra, heat))
    content = explorer_content("a_run", mills)
    page = folder / "explorer.html"
    page.write_text(explorer_page(content))
    return {"page": page, "content": content, "fingerprints": found, "folder": folder}

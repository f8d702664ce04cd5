"""Figures 3.5 to 3.12 and 3.14: single revolutions, master curves of each contact set, their scaling, and maps.

Also the energy spectra of the conditions of the maps: collisions a second, power, and its share above an energy.

Settings: mill, contacts, fingerprint.cycle_fill_ratio, fingerprint.counting_rule, fingerprint.maps.
Inputs: `descriptors`, `cycles`, `densities`, `means`, `curves`, `zones`, `universal`, `exponents`, `spectra`,
`published`, and the `runs` of the maps.
Outputs: each figure as SVG and PNG, `energies`, `curves` and `spectra` of each contact set and `maps` of each run in
pairs of both, and the points of the maps as `maps_tsvs`.
"""

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import shown
from millprint.figures.dose_figures import plot_spectra
from millprint.figures.style import in_pairs, save
from millprint.fingerprint.descriptors import as_built
from millprint.run.files import read_table
from millprint.run.job import job
from millprint.thesis.figures.chapter3_and_4_figures import (
    plot_cycle_densities,
    plot_cycle_means,
    plot_energies,
    plot_exponents,
    plot_maps,
    plot_master_curves,
    plot_universal_curves,
)
from millprint.thesis.regimes import published_curves, published_cycles, read_occupancy, read_published
from millprint.thesis.scaling import conditions_of, universal_descriptors


def of_mill(table: pd.DataFrame, own) -> pd.DataFrame:
    """The rows of the mill of the chapters with their contact sets."""
    return table[(table["mill"] == own.mill) & table["contact"].isin(own.contacts)]


def draw_cycles(inputs, output, own) -> None:
    """Draw the mill's revolutions at the fill ratio of Table 3.5."""
    tables = of_mill(as_built(read_table(inputs.cycles)), own), published_cycles(read_published(*inputs.published))
    shown = (table[np.isclose(table["fill_ratio"], own.cycle_fill_ratio)] for table in tables)
    save(plot_cycle_densities(of_mill(read_table(inputs.densities), own)), *output.densities_figure)
    save(plot_cycle_means(*shown), *output.means_figure)


def draw_master_curves(inputs, output, own) -> None:
    """Draw the conditions, means and smooth curves with their zones, and the values that the thesis prints."""
    table, zones = read_table(inputs.descriptors), read_table(inputs.zones)
    files = zip(inputs.means, inputs.curves, in_pairs(output.energies), in_pairs(output.curves), strict=True)
    for contact, (means, curves, energies, drawn) in zip(own.contacts, files, strict=True):
        descriptors = as_built(conditions_of(table, own.mill, contact))
        figure = plot_master_curves(
            descriptors,
            read_table(means),
            read_table(curves),
            published_curves(read_published(*inputs.published), contact),
            zones[zones["contact"] == contact],
        )
        save(plot_energies(descriptors), *energies)
        save(figure, *drawn)


def draw_scaling(inputs, output, own) -> None:
    """Draw the conditions of the mill after the universal scaling, and its exponents with the run's counting rule."""
    descriptors = of_mill(as_built(read_table(inputs.descriptors)), own)
    universal = plot_universal_curves(universal_descriptors(descriptors), read_table(inputs.universal))
    save(universal, *output.universal_figure)
    exponents = read_table(inputs.exponents)
    shown = exponents["contact"].isin(own.contacts) & (exponents["counting_rule"] == own.counting_rule)
    save(plot_exponents(exponents[shown].dropna(subset="exponent")), *output.exponents_figure)


def draw_maps(runs: dict[float, str], paths: tuple[str, str], tsv: str) -> None:
    """Draw one row of maps for each run, by its fill ratio."""
    if not runs:
        raise ConfigError("fingerprint.maps: no simulation of the sweeps has this ball diameter, speed and fill ratio")
    save(plot_maps([read_occupancy(path, f"fill {fill:g}") for fill, path in runs.items()]), *paths, tsv=tsv)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot the fingerprint"):
        given, made, own = snakemake.input, snakemake.output, snakemake.params
        for draw in (draw_cycles, draw_master_curves, draw_scaling):
            draw(given, made, own)
        for runs, *paths in zip(own.maps, in_pairs(made.maps), made.maps_tsvs, strict=True):
            draw_maps(runs, *paths)
        for path, title, figure in zip(given.spectra, own.titles, in_pairs(made.spectra), strict=True):
            chosen = shown(read_spectra(path), own.counting_rule, **own.conditions)
            save(plot_spectra(chosen, title), *figure)

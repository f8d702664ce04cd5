"""Figures 3.5 to 3.12 and 3.14: single revolutions, master curves of each contact set, their scaling, and maps.

Also the energy spectra of the conditions of the maps: collisions a second, power, and its share above an energy.

Settings: mill, contacts, fingerprint.cycle_fill_ratio, fingerprint.counting_rule, fingerprint.maps.
Inputs: `descriptors`, `cycles`, `densities`, `means`, `curves`, `zones`, `universal`, `exponents`, `spectra`,
`published`, and the `runs` of the maps.
Outputs: each figure as SVG and PNG, `energies`, `curves` and `spectra` of each contact set and `maps` of each run in
pairs of both, and the points of the maps as `maps_tsvs`.
"""

from millprint.config.errors import ConfigError
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import shown
from millprint.figures.dose_figures import plot_spectra
from millprint.figures.style import in_pairs, save
from millprint.fingerprint.descriptors import NOTHING, as_built
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


def draw_cycles(inputs, output, mill: str, contacts: list[str], fill_ratio: float) -> None:
    """Draw one mill's revolutions at the fill ratio of Table 3.5."""
    densities, cycles = read_table(inputs.densities), read_table(inputs.cycles)
    shown = (
        (cycles["mill"] == mill)
        & (cycles["varied"] == NOTHING)
        & cycles["contact"].isin(contacts)
        & cycles["fill_ratio"].sub(fill_ratio).abs().lt(1e-9)
    )
    published = published_cycles(read_published(*inputs.published))
    published = published[published["fill_ratio"].sub(fill_ratio).abs().lt(1e-9)]
    kept = densities[(densities["mill"] == mill) & densities["contact"].isin(contacts)]
    save(plot_cycle_densities(kept), *output.densities_figure)
    save(plot_cycle_means(cycles[shown], published), *output.means_figure)


def draw_master_curves(inputs, output, mill: str, contacts: list[str]) -> None:
    """Draw the conditions, means and smooth curves with their zones, and the values that the thesis prints."""
    table, zones = read_table(inputs.descriptors), read_table(inputs.zones)
    files = zip(inputs.means, inputs.curves, in_pairs(output.energies), in_pairs(output.curves), strict=True)
    for contact, (means, curves, energies, drawn) in zip(contacts, files, strict=True):
        descriptors = as_built(conditions_of(table, mill, contact))
        figure = plot_master_curves(
            descriptors,
            read_table(means),
            read_table(curves),
            published_curves(read_published(*inputs.published), contact),
            zones[zones["contact"] == contact],
        )
        save(plot_energies(descriptors), *energies)
        save(figure, *drawn)


def draw_scaling(inputs, output, mill: str, contacts: list[str]) -> None:
    """Draw the conditions of one mill after the universal scaling, and its exponents with the run's counting rule."""
    descriptors = as_built(read_table(inputs.descriptors))
    descriptors = descriptors[(descriptors["mill"] == mill) & descriptors["contact"].isin(contacts)]
    universal = plot_universal_curves(universal_descriptors(descriptors), read_table(inputs.universal))
    save(universal, *output.universal_figure)
    exponents = read_table(inputs.exponents)
    own = exponents["contact"].isin(contacts) & (exponents["counting_rule"] == descriptors["counting_rule"].iloc[0])
    save(plot_exponents(exponents[own].dropna(subset="exponent")), *output.exponents_figure)


def draw_maps(runs: dict[float, str], paths: tuple[str, str], tsv: str) -> None:
    """Draw one row of maps for each run, by its fill ratio."""
    if not runs:
        raise ConfigError("fingerprint.maps: no simulation of the sweeps has this ball diameter, speed and fill ratio")
    save(plot_maps([read_occupancy(path, f"fill {fill:g}") for fill, path in runs.items()]), *paths, tsv=tsv)


def draw_spectra(spectra_path: str, title: str, paths: tuple[str, str], rule: str, chosen: dict) -> None:
    """Draw the spectra of the chosen conditions, by one counting rule."""
    save(plot_spectra(shown(read_spectra(spectra_path), rule, **chosen), title), *paths)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot the fingerprint"):
        files, own = (snakemake.input, snakemake.output), snakemake.params
        draw_cycles(*files, own.mill, own.contacts, own.cycle_fill_ratio)
        draw_master_curves(*files, own.mill, own.contacts)
        draw_scaling(*files, own.mill, own.contacts)
        made = snakemake.output
        for runs, *paths in zip(own.maps, in_pairs(made.maps), made.maps_tsvs, strict=True):
            draw_maps(runs, *paths)
        spectra = zip(snakemake.input.spectra, own.titles, in_pairs(made.spectra), strict=True)
        for spectra_path, *about in spectra:
            draw_spectra(spectra_path, *about, own.counting_rule, own.conditions)

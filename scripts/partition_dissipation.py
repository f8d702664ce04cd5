"""Shear against compression: Tables 4.2 to 4.5 and the two regression lines, from published and from our curves."""

import pandas as pd

from millprint.config.partition import PartitionConfig
from millprint.files import write_table
from millprint.fingerprint.energy import Chemistry, compare_with_prior, energy_leverage, specific_yields
from millprint.fingerprint.master import MasterCurves
from millprint.fingerprint.regimes import design_cases, power_as_run, read_regimes, with_curves
from millprint.fingerprint.slopes import fit_slopes
from millprint.job import job


def best_run(runs: pd.DataFrame, cases: pd.DataFrame) -> dict[str, float]:
    """The run of the highest yield, with its speed [Hz]."""
    index = runs["yield_percent"].idxmax()
    return runs.loc[index, ["yield_percent", "time_h", "bpr"]].to_dict() | {"speed_hz": cases.loc[index, "speed_hz"]}


def main(regimes_path: str, smooth_path: str, about_path: str, output, settings: PartitionConfig) -> None:
    """Design the cases and judge the measured yields, twice: with the published curves, and with ours."""
    measured, curves = read_regimes(regimes_path), MasterCurves.read(smooth_path, about_path)
    machine = (
        settings.reference_speed_rpm / 60.0,
        curves.about["density_kg_m3"],
        curves.about["amplitude_m"],
        settings.ball_diameter_mm * 1e-3,
    )
    chemistry = Chemistry(
        borate_molar_mass=settings.borate_molar_mass_g_mol * 1e-3,
        borohydride_molar_mass=settings.borohydride_molar_mass_g_mol * 1e-3,
        enthalpy=settings.enthalpy_kJ_mol * 1e3,
        gibbs=settings.gibbs_kJ_mol * 1e3,
        lower_heating_value=settings.lower_heating_value_kJ_mol * 1e3,
    )
    published = design_cases(measured, *machine)
    ours = design_cases(with_curves(measured, curves), *machine).drop(columns="power_as_printed_W")
    # The yields were measured at the speeds of the published design, so our curves give the power at those.
    ours["power_as_run_W"] = power_as_run(ours, published["speed_hz"], *machine[1:])
    printed = measured.assign(power_W=published["power_as_printed_W"])
    as_run = measured.assign(power_W=ours["power_as_run_W"])
    money = (settings.plug_efficiency, settings.electricity_price_EUR_kWh)
    write_table(published.assign(yield_percent=measured["yield_percent"]), output.table_4_2)
    write_table(ours.assign(yield_percent=measured["yield_percent"]), output.table_4_2_ours)
    prior = settings.prior.model_dump(exclude={"source"})
    write_table(compare_with_prior(best_run(measured, published), prior), output.table_4_3)
    write_table(specific_yields(printed), output.table_4_4)
    write_table(specific_yields(as_run), output.table_4_4_ours)
    write_table(energy_leverage(printed, chemistry, *money), output.table_4_5)
    write_table(energy_leverage(as_run, chemistry, *money), output.table_4_5_ours)
    write_table(fit_slopes(measured, settings.interval), output.slopes)


if "snakemake" in globals():
    with job(snakemake.log[0], "partition dissipation"):
        main(
            snakemake.input.regimes,
            snakemake.input.smooth,
            snakemake.input.about,
            snakemake.output,
            PartitionConfig(**snakemake.params.settings),
        )

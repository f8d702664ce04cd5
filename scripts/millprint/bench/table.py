"""The tables of the benchmark as text, and the codes that they name."""

import pandas as pd

OURS, LAMMPS = "millprint", "LAMMPS"
NAMES = {"steps_per_s": "steps/s", "ns_per_ball_step": "ns a ball-step", "ratio_to_us": "ratio to us"}


def timing_text(table: pd.DataFrame, spread: pd.DataFrame) -> str:
    """The timings, with the range of the repetitions and the processor time of a ball-step."""
    shown = table.merge(spread, on=["case", "code"])
    shown["range"] = [f"{low:.1f} to {high:.1f}" for low, high in zip(shown.least_ns, shown.largest_ns, strict=True)]
    shown = shown.drop(columns=["least_ns", "largest_ns"]).rename(columns=NAMES)
    shown["processor ns"] = shown.pop("processor_ns").map("{:.1f}".format)
    formats = {"steps/s": "{:,.0f}".format, "ns a ball-step": "{:.1f}".format, "ratio to us": "{:.1f}".format}
    return shown.to_string(index=False, formatters=formats)


def across_text(over_jar: dict[str, float], jar: str, large: tuple[str, str, float]) -> str:
    """The comparison between different jars, which has no column in the table."""
    ratios = ", ".join(f"{case} {ratio:.1f}" for case, ratio in over_jar.items())
    return (
        f"LAMMPS in the cylinder over millprint in the {jar} jar, which LAMMPS cannot express: {ratios}\n"
        f"a ball-step of {large[0]} over one of {large[1]}: {large[2]:.2f}"
    )


def physics_text(table: pd.DataFrame) -> str:
    """The means of both codes for each law, with the remaining differences between the laws."""
    parts = []
    for (law, differs), rows in table.groupby(["law", "differs"], sort=False):
        shown = pd.DataFrame(
            {
                "quantity": rows["quantity"],
                "millprint": [f"{v:.4g} +- {e:.2g}" for v, e in zip(rows.millprint, rows.millprint_se, strict=True)],
                "LAMMPS": [f"{v:.4g} +- {e:.2g}" for v, e in zip(rows.lammps, rows.lammps_se, strict=True)],
                "difference %": rows["difference_pct"].map("{:+.1f}".format),
                "standard errors": rows["standard_errors"].map("{:+.1f}".format),
            }
        )
        parts.append(f"law {law}: differs {differs}\n{shown.to_string(index=False)}")
    return "\n\n".join(parts)

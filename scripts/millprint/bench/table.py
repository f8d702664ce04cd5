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
    """The means of both codes for each law with their 95 % intervals, and the remaining differences of the laws."""

    def shown(rows: pd.DataFrame, name: str, form: str) -> list[str]:
        pairs = zip(rows[name], rows[f"{name}_95"], strict=True)
        return [f"{value:{form}}" + ("" if pd.isna(half) else f" +- {half:.2g}") for value, half in pairs]

    parts = []
    for (law, differs), rows in table.groupby(["law", "differs"], sort=False):
        columns = {
            "quantity": rows["quantity"],
            "millprint": shown(rows, "millprint", ".4g"),
            "LAMMPS": shown(rows, "lammps", ".4g"),
            "difference %": shown(rows, "difference_pct", "+.1f"),
        }
        runs = rows["runs"].iloc[0]
        what = "95 % intervals" if rows["difference_pct_95"].notna().all() else "too few for an interval"
        parts.append(
            f"law {law}: differs {differs}; {runs} runs, {what}\n{pd.DataFrame(columns).to_string(index=False)}"
        )
    return "\n\n".join(parts)

"""Which simulations of the sweeps the fingerprint is made of. The Snakefile asks: nothing heavy is imported here."""

from millprint.config.sweep import Case
from millprint.config.workflow import WorkflowConfig


def is_as_built(case: Case) -> bool:
    """Whether a case runs the mill and the balls as they are described."""
    return case.amplitude_mm is None and case.density_kg_m3 is None


def has_chapters(config: WorkflowConfig, cases: dict[str, Case]) -> bool:
    """Whether the configuration has the chapters' sections, and its sweeps simulate the mill that they are about."""
    simulated = any(case.mill == config.mill for case in described_cases(config, cases).values())
    return config.has_chapter_sections and simulated


def described_cases(config: WorkflowConfig, cases: dict[str, Case]) -> dict[str, Case]:
    """The cases that descriptors are made of: snapshots, a changed modulus or step serve other questions.

    Amplitude and density are varied for the fingerprint of the run's own mill: such a case of another mill is left out.
    """
    return {
        path: case
        for path, case in cases.items()
        if case.speed_rpm > 0
        and case.snapshot_interval_s is None
        and case.young_modulus_gpa is None
        and case.time_step_s is None
        and (is_as_built(case) or case.mill == config.mill)
    }


def mapped_cases(config: WorkflowConfig, cases: dict[str, Case], contact: str) -> dict[float, str]:
    """Fill ratio to path of the cases that the heat maps of a contact set show: the first seed of each, if any."""
    maps = config.fingerprint.maps
    chosen: dict[float, str] = {}
    if maps is None:
        return chosen
    for path, case in described_cases(config, cases).items():
        if not is_as_built(case):
            continue
        place = (case.mill, case.contact, case.ball_diameter_mm, case.speed_rpm)
        if (
            place == (config.mill, contact, maps.ball_diameter_mm, maps.speed_rpm)
            and case.fill_ratio in maps.fill_ratios
        ):
            chosen.setdefault(case.fill_ratio, path)
    return dict(sorted(chosen.items()))

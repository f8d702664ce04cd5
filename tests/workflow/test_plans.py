"""What Snakemake plans for other configurations."""

import pytest
import yaml
from snakemake.utils import update_config

from tests.workflow.conftest import CONFIG, run_snakemake


def smoke_content(project) -> dict:
    """The configuration at smoke size."""
    content = yaml.safe_load((project / CONFIG).read_text())
    update_config(content, yaml.safe_load((project / "config/smoke.yaml").read_text()))
    return content


def planned(project, content: dict, *arguments: str) -> str:
    """The output of a dry run with a configuration; an error is a failure."""
    (project / CONFIG).write_text(yaml.safe_dump(content, sort_keys=False))
    done = run_snakemake(project, "-n", *arguments)
    assert done.returncode == 0, done.stdout[-4000:]
    return done.stdout


@pytest.mark.parametrize("study", [True, False])
def test_a_sweep_with_a_single_time_step_is_simulated_but_not_tabulated(project, study):
    content = smoke_content(project)
    (steps,) = (sweep for sweep in content["sweeps"] if sweep["name"] == "timestep")
    content["sweeps"].append(steps | {"name": "one", "speeds_rpm": [300], "time_steps_s": [3e-6], "seeds": [0]})
    if not study:
        content["sweeps"].remove(steps)
    plan = planned(project, content, "convergence")
    assert "DEM emax/calibrated/d10_f0.10_n300_dt3e-06_s0" in plan
    tables = [line for line in plan.splitlines() if "Missing output files: results/convergence/timestep.tsv" in line]
    assert len(tables) == study
    # The target needs the case, but no table does.
    assert all("dt8e-06" in line and "dt3e-06" not in line for line in tables)


def test_the_chapters_can_have_a_planetary_mill(project):
    """Its motion has no key `amplitude_mm`; the rules of the yield models must not need it."""
    content = smoke_content(project) | {"mill": "planetary"}
    content["fingerprint"]["maps"]["speed_rpm"] = 300
    for sweep in content["sweeps"]:
        if sweep["name"] in ("fill_ratio", "speed", "timestep", "modulus"):
            sweep |= {"mills": ["planetary"], "speeds_rpm": [300]}
    content["sweeps"] = [sweep for sweep in content["sweeps"] if sweep["name"] != "amplitude"]
    plan = planned(project, content, "chapter5")
    for name in ("regimes", "next_experiments"):
        assert f"results/yield/{name}.tsv" in plan

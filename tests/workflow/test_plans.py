"""What Snakemake plans for other configurations."""

import re

import yaml
from snakemake.utils import update_config

from tests.workflow.conftest import CONFIG, copy_planetary, jobs_of, run_snakemake


def smoke_content(project) -> dict:
    """The configuration at smoke size."""
    content = yaml.safe_load((project / CONFIG).read_text())
    update_config(content, yaml.safe_load((project / "config/smoke.yaml").read_text()))
    return content


def on_its_own(project, content: dict, section: str) -> tuple[str, str]:
    """The arguments for a mill of one's own with a section and the simulation settings of this configuration."""
    # At this precision, twice the step is allowed too.
    own = {"mill": "mine", "dem": content["dem"], "mills": {"precision": "standard"}, section: content[section]}
    (project / "mine.yaml").write_text(yaml.safe_dump(own, sort_keys=False))
    return ("--configfile", "mine.yaml")


def planned(project, content: dict, *arguments: str) -> str:
    """The output of a dry run with a configuration; an error is a failure."""
    (project / CONFIG).write_text(yaml.safe_dump(content, sort_keys=False))
    done = run_snakemake(project, "-n", *arguments)
    assert done.returncode == 0, done.stdout[-4000:]
    return done.stdout


def test_a_sweep_with_a_single_time_step_is_simulated_but_not_tabulated(project):
    content = smoke_content(project)
    (steps,) = (sweep for sweep in content["sweeps"] if sweep["name"] == "timestep")
    content["sweeps"].append(steps | {"name": "one", "speeds_rpm": [300], "time_steps_s": [3e-6], "seeds": [0]})
    plan = planned(project, content, "convergence")
    assert "results/dem/emax/calibrated/d10_f0.10_n300_dt3e-06_s0/summary.json" in plan
    missing = [line for line in plan.splitlines() if "Missing output files: " in line]
    tables = [line for line in missing if "results/convergence/timestep.tsv" in line]
    assert len(tables) == 1
    # The target needs the case, but no table does.
    assert all("dt8e-06" in line and "dt3e-06" not in line for line in tables)


def test_a_file_that_names_a_mill_gives_the_same_plan_in_a_clone_and_in_an_empty_folder(project, tmp_path):
    """Here the mill of the thesis, described otherwise."""
    mill = "emax"
    sweep = {"speeds_rpm": [700], "ball_diameters_mm": [10], "fill_ratios": [0.1, 0.2, 0.3]}
    run = {"mill": mill, "contacts": ["steel"], "results": "here", "sweep": sweep}
    own = tmp_path / "own"
    (own / "config/mills").mkdir(parents=True)
    copy_planetary(own / "config/mills")
    plans = []
    for folder in (project, own):
        text = (own / "config/mills/mine.yaml").read_text().replace("name: mine", f"name: {mill}")
        (folder / f"config/mills/{mill}.yaml").write_text(text)
        (folder / "mine.yaml").write_text(yaml.safe_dump(run))
        place = ("--snakefile", str(project / "workflow/Snakefile"))
        for target in ([], ["explorer"]):
            done = run_snakemake(folder, *place, "-n", *target, "--configfile", "mine.yaml")
            assert done.returncode == 0, done.stdout[-4000:]
            plans.append((jobs_of(done.stdout), set(re.findall(r"Simulating (\S+)", done.stdout))))
    assert plans[:2] == plans[2:]
    (whole, simulated), (explorer, _) = plans[:2]
    # Three fill ratios of three seeds, and eight that the fingerprint does not see; neither knows of a chapter.
    assert len(simulated) == 17 and all(re.match(rf"{mill}/steel/d10_f0\.\d+_n700_s", case) for case in simulated)
    assert whole["draw_fingerprint"] == whole["write_crate"] == explorer["explore_mill"] == 1
    assert not {"write_pages", "sample_contacts", "write_card"} & set(whole)


def test_convergence_of_a_mill_of_ones_own_varies_its_settings_alone(project):
    """Six settings and the reference, two seeds each; no sweep of the thesis, and no case twice."""
    content = smoke_content(project)
    content["convergence"]["study"] = {"seeds": 2}
    copy_planetary(project / "config/mills")
    plan = planned(project, content, "convergence", *on_its_own(project, content, "convergence"))
    jobs = jobs_of(plan)
    assert jobs == {"compile_kernels": 1, "convergence": 1, "study_settings": 1, "run_dem_case": 14}
    simulated = set(re.findall(r"results/dem/(\S+)/summary.json", plan))
    changes = ["", "_y0.615", "_y6.15", "_facets24", "_facets96"]
    expected = {f"mine/calibrated/d10_f0.20_n300{change}_s{seed}" for change in changes for seed in (0, 1)}
    assert {case for case in simulated if "_dt" not in case} == expected
    assert len(set(re.findall(r"d10_f0.20_n300_dt\S+_s0", plan))) == 2
    assert "results/convergence/mine/verdict.txt" in plan


def test_one_case_that_is_asked_for_is_simulated_and_nothing_else(project):
    plan = planned(project, smoke_content(project), "results/dem/emax/calibrated/d10_f0.10_n300_s1/summary.json")
    assert jobs_of(plan) == {"compile_kernels": 1, "run_dem_case": 1}


def test_lammps_simulates_the_sweeps_and_compiles_nothing(project):
    content = smoke_content(project)
    content["dem"] |= {"engine": "lammps", "lammps": {"ranks": 3}}
    rules = project / "workflow/rules/dem.smk"
    text = rules.read_text()
    rules.write_text(text.replace('"Simulating {wildcards', '"{resources.mpi} -n {resources.tasks}: {wildcards'))
    assert rules.read_text() != text
    plan = planned(project, content, "simulations", "--cores", "4")
    simulated = plan.count("mpirun -n 3: ")
    assert jobs_of(plan) == {"run_dem_case": simulated, "simulations": 1}
    assert simulated > 10


def test_contact_parameters_of_a_mill_of_ones_own_are_sampled_in_a_few_jobs(project):
    content = smoke_content(project)
    copy_planetary(project / "config/mills")
    file = project / "config/mills/mine.yaml"
    mill = yaml.safe_load(file.read_text())
    # It is derived first.
    del mill["sweep"]
    file.write_text(yaml.safe_dump(mill))
    content["uncertainty"]["jobs"] = 2
    jobs = jobs_of(planned(project, content, "uncertainty", *on_its_own(project, content, "uncertainty")))
    assert jobs["sample_contacts"] == 2
    assert jobs["measure_uncertainty"] == jobs["add_uncertainty"] == jobs["derive_sweep"] == 1
    # The printed values of the thesis are about its own mill.
    assert "add_uncertainty_to_chapters" not in jobs

"""More of what is refused before the first job: names, paths, costs, and YAML that is more than plain data."""

import os

import pytest
import yaml
from snakemake.utils import update_config

from millprint.config.checks import load_workflow
from millprint.config.strict_yaml import DEEPEST, read_yaml
from millprint.errors import LONGEST_LINE, ConfigError
from millprint.preflight import check_before_running
from tests.workflow.conftest import run_snakemake
from tests.workflow.test_bad_input import CONFIG, edit_yaml, refusal  # noqa: F401

EMAX = "config/mills/emax.yaml"
POST = "config/mills/emax_post.yaml"
PLANETARY = "config/mills/planetary.yaml"
DRUM = "config/mills/drum.yaml"
MIXER = "config/mills/mixer.yaml"
ATTRITOR = "config/mills/attritor.yaml"
CALIBRATED = "config/contacts/calibrated.yaml"


@pytest.mark.parametrize(
    ("file", "place", "value", "parts"),
    [
        # Numbers that are none.
        (CONFIG, ("dem", "window_s"), True, ["dem.window_s", "True", "yes, no, on and off"]),
        (CONFIG, ("sweeps", 0, "speeds_rpm"), [False], ["sweeps.0.speeds_rpm", "yes, no, on and off"]),
        (CONFIG, ("dem", "window_s"), float("inf"), ["dem.window_s", "inf", "finite"]),
        (CONFIG, ("dem", "window_s"), 10**400, ["dem.window_s", "valid number"]),
        (EMAX, ("geometry", "height_mm"), float("nan"), ["emax.yaml", "height_mm", "nan"]),
        (EMAX, ("geometry", "end_radius_mm"), 50_000, ["emax.yaml", "end_radius_mm", "less than or equal to 10000"]),
        (EMAX, ("volume_ml",), 0, ["emax.yaml", "volume_ml = 0", "greater than"]),
        (CALIBRATED, ("density_kg_m3",), 0, ["calibrated.yaml", "density_kg_m3", "greater than"]),
        (CALIBRATED, ("young_modulus_gpa",), 1e12, ["calibrated.yaml", "young_modulus_gpa", "less than"]),
        # What would not end, or not fit into a machine.
        (CONFIG, ("sweeps", 0, "speeds_rpm"), [1e12], ["sweeps.0.speeds_rpm.0", "10000000"]),
        (CONFIG, ("sweeps", 0, "window_s"), 1e9, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "time_step_s"), 1e-15, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "time_step_s"), 5e-324, ["sweeps: case", "days on one core"]),
        (CONFIG, ("sweeps", 0, "snapshot_interval_s"), 1e-13, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "occupancy_cell_m"), 1e-9, ["sweeps: case", "GB", "occupancy_cell_m"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [0.001], ["ball_diameters_mm = 0.001", "too small to simulate"]),
        (CONFIG, ("sweeps", 0, "fill_ratios"), [1e-9], ["fill_ratios = 1e-09", "one ball needs at least"]),
        (CONFIG, ("sweeps", 0, "seeds"), [10**30], ["sweeps.0.seeds.0", "less than"]),
        (CONFIG, ("yields", "honest", "resamples"), 10**12, ["yields.honest.resamples", "less than"]),
        # Files outside of the project, and folders that are not for results.
        (CONFIG, ("data", "wear"), "../wear.tsv", ["data.wear = '../wear.tsv'", "inside the project"]),
        (CONFIG, ("data", "wear"), "/etc/passwd", ["data.wear = '/etc/passwd'", "inside the project"]),
        (CONFIG, ("doe", "literature"), "config/../../x", ["doe.literature", "inside the project"]),
        (CONFIG, ("data", "wear"), "a\0b", ["data.wear", "inside the project"]),
        (CONFIG, ("data", "wear"), "config/data", ["config/data", "cannot be read"]),
        (CONFIG, ("results",), "config/mills", ["results = 'config/mills'", "own files"]),
        (CONFIG, ("results",), "../out", ["results", "../out"]),
        # Names.
        (CONFIG, ("mill",), "emx", ["emx.yaml", "unknown mill 'emx'", "did you mean emax?"]),
        (CONFIG, ("sweeps", 1, "name"), "fill_ratio_10mm", ["sweeps: two have the name fill_ratio_10mm"]),
        (EMAX, ("geometry", "heigth_mm"), 3, ["emax.yaml: geometry.heigth_mm = 3", "did you mean height_mm?"]),
        (EMAX, ("geometry", "facets_per_half_circle"), 360, ["emax.yaml", "facets"]),
        # A volume that is not the geometry's.
        (
            PLANETARY,
            ("geometry",),
            {"kind": "cylinder", "radius_mm": 100, "height_mm": 125},
            [
                "planetary.yaml: volume_ml = 250: the cylinder of geometry holds 3916 mL",
                "its sizes",
                "volume_tolerance",
            ],
        ),
        (EMAX, ("volume_ml",), 130, ["emax.yaml: volume_ml = 130: the stadium of geometry holds 125 mL"]),
        (
            DRUM,
            ("geometry",),
            {"kind": "box", "x_mm": 60, "y_mm": 60, "z_mm": 60},
            ["the box of geometry holds 216 mL"],
        ),
        (POST, ("volume_tolerance",), 0.03, ["emax_post.yaml: volume_ml = 125", "holds 121.1 mL"]),
        (ATTRITOR, ("volume_ml",), 218, ["attritor.yaml: volume_ml = 218: the cylinder of geometry holds 230.2 mL"]),
        (EMAX, ("geometry", "volume_tolerance"), 0.1, ["geometry.volume_tolerance = 0.1", "belongs to the top level"]),
        # Speeds beyond any machine, with what they would mean.
        (
            PLANETARY,
            ("sweep", "speeds_rpm"),
            [300, 450000],
            [
                "planetary.yaml: sweep: speeds_rpm = 450000: the wall of vessel",
                "2.44e+07 g",
                "over 1000 g: at most 2870 rpm",
            ],
        ),
        (
            MIXER,
            ("sweep", "speeds_hz"),
            [18, 1800],
            ["mixer.yaml: sweep: speeds_hz = 1800:", "g and move", "at most 104 Hz"],
        ),
        (
            DRUM,
            ("sweep", "speeds_rpm"),
            [450000],
            ["drum.yaml: sweep: speeds_rpm = 450000:", "1.13e+07 g", "at most 42200 rpm"],
        ),
        (
            ATTRITOR,
            ("sweep", "speeds_rpm"),
            [450000],
            [
                "speeds_rpm = 450000: the wall of lower_arms",
                "5.48e+06 g",
                "1140 m/s",
                "than 250 m/s",
                "at most 98700 rpm",
            ],
        ),
        (
            CONFIG,
            ("sweeps", 0, "speeds_rpm"),
            [600, 9000],
            ["mill emax: speeds_rpm = 9000:", "1540 g", "at most 7250 rpm"],
        ),
        (CONFIG, ("sweeps", 0, "speeds_rpm"), [450000], ["mill emax: speeds_rpm = 450000:", "3.85e+06 g"]),
        (CONFIG, ("mills", "scale_up", "speed_rpm"), 9000, ["mills.scale_up.speed_rpm = 9000:", "1540 g"]),
        # A rotor without a spin of its own.
        (
            PLANETARY,
            ("motion", "ratio"),
            0,
            ["planetary.yaml: motion: ratio = 0: ", "centrifuge", "pivot_mm: [-70.5, 0"],
        ),
    ],
)
def test_bad_value(project, refusal, file, place, value, parts):  # noqa: F811
    if place[-1] == "facets_per_half_circle":
        edit_yaml(project / file, "geometry", "fillet_facets", value=180)
    edit_yaml(project / file, *place, value=value)
    line = refusal()
    for part in parts:
        assert part in line


def test_a_volume_within_its_tolerance_and_a_fast_mill_pass(project, monkeypatch):
    """What is refused above passes a little below: the tolerance is a key, and what is fast but possible is told."""
    monkeypatch.chdir(project)
    edit_yaml(project / EMAX, "volume_ml", value=127)
    edit_yaml(project / PLANETARY, "volume_ml", value=200)
    edit_yaml(project / PLANETARY, "volume_tolerance", value=0.25)
    edit_yaml(project / PLANETARY, "sweep", "speeds_rpm", value=[300, 1200])
    loaded = load_workflow(yaml.safe_load((project / CONFIG).read_text()), [CONFIG])
    (line,) = check_before_running(*loaded, CONFIG)
    for part in (
        "planetary.yaml: sweep: speeds_rpm = 1200: ",
        "174 g",
        "some 100 g",
        "usual are speeds up to 1110 rpm",
    ):
        assert part in line


def test_two_mills_of_one_name(project, refusal):  # noqa: F811
    (project / "config/mills/copy.yaml").write_text((project / EMAX).read_text())
    line = refusal()
    assert "config/mills/copy.yaml: name = 'emax': also the name of config/mills/emax.yaml" in line


def test_a_link_out_of_the_project_is_no_table(project, refusal):  # noqa: F811
    table = project / "config/data/wear.tsv"
    table.rename(project.parent / "wear.tsv")
    table.symlink_to(project.parent / "wear.tsv")
    assert "data.wear" in refusal()


BOMB = "a0: &a0 [x]\n" + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12))


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("a: 1\nb: 2\na: 3\n", "key 'a' twice"),
        ("x: {a: 1, a: 1}\n", "key 'a' twice"),
        (BOMB, "aliases"),
        ("a: &a [*a]\n", "alias"),
        ("a: &a\n  b: *a\n", "alias"),
        ("[" * 100_000, f"{DEEPEST} levels"),
        ("!!python/object/apply:os.system ['true']", "not valid YAML"),
        ("a: !!python/name:os.system\n", "not valid YAML"),
        ("x: !!int ''\n", "not valid YAML"),
        ("x: !!timestamp nothing\n", "not valid YAML"),
        ("x: 2020-99-99\n", "not valid YAML"),
        ("a: \x07\n", "not valid YAML"),
        ("a: [1\n", "line 2"),
        ("x: " + "y" * 5_000_000, "larger than"),
    ],
)
def test_yaml_that_is_more_than_plain_data(tmp_path, text, part):
    path = tmp_path / "a.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        read_yaml(path)
    (line,) = str(caught.value).splitlines()
    assert part in line
    assert line.startswith(str(path))


def test_yaml_that_cannot_be_read_as_text(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_bytes(b"a: \xff\xfe\n")
    with pytest.raises(ConfigError, match="not valid YAML"):
        read_yaml(path)
    with pytest.raises(ConfigError, match="cannot be read"):
        read_yaml(tmp_path)


def test_merged_keys_are_not_keys_given_twice(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("base: &base {a: 1, b: 2}\nother:\n  <<: *base\n  a: 3\n")
    assert read_yaml(path)["other"] == {"a": 3, "b": 2}


def test_a_line_stays_readable_whatever_the_value(project, refusal):  # noqa: F811
    edit_yaml(project / CONFIG, "dem", "window_s", value="x" * 100_000 + "\u202e\x1b[31m")
    line = refusal()
    assert len(line) < 2 * LONGEST_LINE
    assert line.isprintable()


def test_snakemake_refuses_a_key_given_twice(project):
    path = project / CONFIG
    path.write_text(path.read_text() + "mill: emax_smooth\n")
    done = run_snakemake(project)
    assert done.returncode == 1
    assert [line for line in done.stdout.splitlines() if line.startswith("error: ")] == [
        line for line in done.stdout.splitlines() if "key 'mill' twice" in line
    ]
    assert os.listdir(project / "results") == [".gitkeep"]


def test_all_faults_of_a_long_list_are_counted_and_some_shown(project, monkeypatch):
    monkeypatch.chdir(project)
    edit_yaml(project / CONFIG, "sweeps", 0, "seeds", value=["x"] * 1000)
    with pytest.raises(ConfigError) as caught:
        load_workflow(yaml.safe_load((project / CONFIG).read_text()), [CONFIG])
    lines = str(caught.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "... and 980 more"


def smoke_content(project) -> dict:
    """The configuration at smoke size, to be changed and written as the project's own."""
    content = yaml.safe_load((project / CONFIG).read_text())
    update_config(content, yaml.safe_load((project / "config/smoke.yaml").read_text()))
    return content


def planned(project, content: dict, *arguments: str) -> str:
    """What Snakemake would do for a configuration; fails where it does not come to a plan."""
    (project / CONFIG).write_text(yaml.safe_dump(content, sort_keys=False))
    done = run_snakemake(project, "-n", *arguments)
    assert done.returncode == 0, done.stdout[-4000:]
    return done.stdout


@pytest.mark.parametrize("study", [True, False])
def test_a_sweep_with_a_single_time_step_is_run_and_no_study(project, study):
    content = smoke_content(project)
    (steps,) = (sweep for sweep in content["sweeps"] if sweep["name"] == "timestep")
    content["sweeps"].append(steps | {"name": "one", "speeds_rpm": [300], "time_steps_s": [3e-6], "seeds": [0]})
    if not study:
        content["sweeps"].remove(steps)
    plan = planned(project, content, "convergence")
    assert "DEM emax/calibrated/d10_f0.10_n300_dt3e-06_s0" in plan
    tables = [line for line in plan.splitlines() if "Missing output files: results/convergence/timestep.tsv" in line]
    assert len(tables) == study
    # The target asks for the case, no table does.
    assert all("dt8e-06" in line and "dt3e-06" not in line for line in tables)


def test_the_chapters_can_be_about_a_planetary_mill(project):
    """Its motion has no key `amplitude_mm`, which the yield models' rules must not ask for."""
    content = smoke_content(project) | {"mill": "planetary"}
    content["fingerprint"]["maps"]["speed_rpm"] = 300
    for sweep in content["sweeps"]:
        if sweep["name"] in ("fill_ratio", "speed", "timestep", "modulus"):
            sweep |= {"mills": ["planetary"], "speeds_rpm": [300]}
    content["sweeps"] = [sweep for sweep in content["sweeps"] if sweep["name"] != "amplitude"]
    plan = planned(project, content, "chapter5")
    for name in ("regimes", "next_experiments"):
        assert f"results/yield/{name}.tsv" in plan

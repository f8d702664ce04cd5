"""Bad values are refused before a job starts, in one line that names file, key, value and what would be right."""

import subprocess

import numpy as np
import pytest
import trimesh

from millprint.checks import check_once
from millprint.config.checks import load_workflow
from millprint.config.errors import LONGEST_LINE, ConfigError
from millprint.config.strict_yaml import read_yaml
from tests.workflow.conftest import CONFIG, edit_yaml, error_lines, run_snakemake

STEEL = "config/contacts/steel.yaml"
EMAX = "config/mills/emax.yaml"
POST = "config/mills/emax_post.yaml"
PLANETARY = "config/mills/planetary.yaml"
DRUM = "config/mills/drum.yaml"
MIXER = "config/mills/mixer.yaml"
ATTRITOR = "config/mills/attritor.yaml"
CALIBRATED = "config/contacts/calibrated.yaml"
BARS = {"number": 8, "height_mm": 6, "width_mm": 8}
LIFTED = {"kind": "lifter_drum", "axis": "y", "radius_mm": 50, "length_mm": 30, "facets": 48, "lifters": BARS}
CHARGE = {"name": "two", "sizes_mm": [10, 8], "shares": [0.5, 0.5]}


@pytest.mark.parametrize(
    "fault",
    ["dem: {time_stp_s: 1.0e-6}", "dem: {rayleigh_fraction_max: 1.0e-4}"],
    ids=["unknown key", "impossible value"],
)
def test_snakemake_stops_before_any_job_and_names_the_last_configuration_file(project, fault):
    (project / "mine.yaml").write_text(fault)
    done = run_snakemake(project, "--configfile", "mine.yaml")
    assert done.returncode == 1, done.stdout
    (line,) = error_lines(done.stdout)
    assert "/mine.yaml: dem.time_st" in line
    assert "Traceback" not in done.stdout
    assert [path.name for path in (project / "results").iterdir()] == [".gitkeep"]
    assert not list((project / ".snakemake/locks").glob("*"))


def test_valid_input_is_checked_only_once(settings, monkeypatch):
    """What has passed is checked again only after a change of a file that it names; what is refused, every time."""
    monkeypatch.chdir(settings)
    config, mills, contacts, _ = load_workflow(read_yaml(CONFIG), [CONFIG])
    statuses, asked = [0, 1, 1], []

    def process(command, **_) -> subprocess.CompletedProcess:
        asked.append(command)
        return subprocess.CompletedProcess(command, statuses[len(asked) - 1])

    def check() -> None:
        check_once.check_once(config, mills, contacts, CONFIG, "python", [])

    monkeypatch.setattr(check_once.subprocess, "run", process)
    check()
    check()
    assert len(asked) == 1
    with (settings / "config/data/wear.tsv").open("a") as table:
        table.write("a line more")
    for count in (2, 3):
        with pytest.raises(SystemExit):
            check()
        assert len(asked) == count


@pytest.mark.parametrize(
    ("file", "place", "value", "parts"),
    [
        (CONFIG, ("dem", "time_stp_s"), 1e-6, ["dem.time_stp_s", "unknown key", "time_step_s"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [-10], ["sweeps.0.ball_diameters_mm.0", "-10", "greater than"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [0], ["sweeps.0.ball_diameters_mm.0", "greater than"]),
        (CONFIG, ("sweeps", 0, "fill_ratios"), [0.9], ["fill_ratios", "0.9", "fit"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [80], ["ball_diameters_mm", "80", "fit"]),
        (CONFIG, ("dem", "time_step_s"), 5e-5, ["dem.time_step_s", "5e-05", "Rayleigh"]),
        (CONFIG, ("dem", "time_step_s"), float("nan"), ["dem.time_step_s", "nan", "finite"]),
        (CONFIG, ("dem", "engine"), "lamps", ["dem.engine", "'lamps'", "'numba' or 'lammps'"]),
        (CONFIG, ("dem", "lammps"), {"ranks": 0}, ["dem.lammps.ranks", "0", "greater than"]),
        (
            CONFIG,
            ("dem", "counting_rules", 0, "gap_turns"),
            -1,
            ["dem.counting_rules.0.gap_turns", "-1", "greater than"],
        ),
        (
            CONFIG,
            ("dem", "counting_rules", 0, "gap_s"),
            0.002,
            ["dem.counting_rules.0", "gap_turns = gap_s * rpm / 60"],
        ),
        (
            CONFIG,
            ("sweeps", 4, "time_steps_s"),
            [1e-6, 5e-5],
            ["time_steps_s = 5e-05", "Rayleigh", "dt5e-05", "at most"],
        ),
        (CONFIG, ("fingerprint", "counting_rule"), "gap_0_09", ["fingerprint.counting_rule", "gap_0_09", "gap_0_03"]),
        (CONFIG, ("mill",), "emaks", ["emaks", "unknown mill", "emax"]),
        (CONFIG, ("contacts",), ["calibrated", "rubber"], ["rubber", "unknown contact set", "steel"]),
        (CONFIG, ("calibration", "drop_test", "measured"), "drops.tsv", ["drops.tsv", "no such table"]),
        (CONFIG, ("calibration", "oscillation", "experiments", 0, "track"), "t.tsv", ["t.tsv", "no such table"]),
        (CONFIG, ("calibration", "oscillation", "experiments", 0, "mill"), "emaks", ["emaks", "unknown mill"]),
        (CONFIG, ("data", "wear"), "config/data/no.tsv", ["config/data/no.tsv", "no such"]),
        (CONFIG, ("doe", "chemistry", "limiting"), "nabo2", ["doe.chemistry.limiting", "'nabo2'", "NaBO2.4H2O"]),
        (CONFIG, ("partition",), None, ["config.yaml", "partition is missing", "all of their sections, or none"]),
        (
            CONFIG,
            ("sweep",),
            {"speeds_rpm": [600], "ball_diameters_mm": [10]},
            ["sweep: give one of fill_ratios, numbers"],
        ),
        (EMAX, ("motion", "amplitude_mm"), -17, ["emax.yaml", "motion", "amplitude_mm", "-17"]),
        (EMAX, ("name",), "emaks", ["emax.yaml", "name", "emaks"]),
        (STEEL, ("restitution",), 1.5, ["steel.yaml", "restitution", "1.5"]),
        (CONFIG, ("provenance",), {"orcid": "1234"}, ["config.yaml", "provenance.orcid = '1234'", "pattern"]),
        (CONFIG, ("provenance",), {"licence": "my own"}, ["config.yaml", "provenance.licence", "pattern"]),
        # Values that are not numbers or lie out of bounds.
        (CONFIG, ("dem", "window_s"), True, ["dem.window_s", "True", "yes, no, on and off"]),
        (CONFIG, ("sweeps", 0, "speeds_rpm"), [False], ["sweeps.0.speeds_rpm", "yes, no, on and off"]),
        (CONFIG, ("dem", "window_s"), float("inf"), ["dem.window_s", "inf", "finite"]),
        (CONFIG, ("dem", "window_s"), 10**400, ["dem.window_s", "must be"]),
        (EMAX, ("geometry", "height_mm"), float("nan"), ["emax.yaml", "height_mm", "nan"]),
        (EMAX, ("geometry", "end_radius_mm"), 50_000, ["emax.yaml", "end_radius_mm", "less than or equal to 10000"]),
        (EMAX, ("volume_ml",), 0, ["emax.yaml", "volume_ml = 0", "greater than"]),
        (CALIBRATED, ("density_kg_m3",), 0, ["calibrated.yaml", "density_kg_m3", "greater than"]),
        (CALIBRATED, ("young_modulus_gpa",), 1e12, ["calibrated.yaml", "young_modulus_gpa", "less than"]),
        # Runs that would not end, or need too much memory.
        (CONFIG, ("sweeps", 0, "speeds_rpm"), [1e12], ["sweeps.0.speeds_rpm.0", "10000000"]),
        (CONFIG, ("sweeps", 0, "window_s"), 1e9, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "time_step_s"), 1e-15, ["sweeps: case", "days on one core"]),
        (CONFIG, ("dem", "time_step_s"), 5e-324, ["sweeps: case", "days on one core"]),
        (CONFIG, ("sweeps", 0, "snapshot_interval_s"), 1e-13, ["sweeps: case", "days on one core"]),
        (CONFIG, ("sweeps", 0, "snapshot_interval_s"), 1e-8, ["sweeps: case", "GB", "snapshot_interval_s"]),
        # The key of the step and of the cost is that of the section which asks for the simulation.
        (CONFIG, ("sweeps", 0, "rayleigh_fraction"), 0.9, ["config.yaml: sweeps: rayleigh_fraction = 0.9: at most"]),
        (
            CONFIG,
            ("mills", "rayleigh_fraction"),
            0.9,
            ["config.yaml: mills.rayleigh_fraction = 0.9, times 1.375 by mills.precision draft = 1.2375: at most dem."],
        ),
        (
            CONFIG,
            ("mills",),
            {"precision": "quick", "rayleigh_fraction": 0.15},
            ["config.yaml: mills.rayleigh_fraction = 0.15, times 1.375 by mills.precision quick = 0.20625: at most"],
        ),
        (CONFIG, ("mills", "precision"), "rough", ["config.yaml: mills.precision = 'rough'", "'quick', 'standard'"]),
        (CONFIG, ("sweeps", 0, "ball_diameters_mm"), [0.001], ["ball_diameters_mm.0 = 0.001", "is it in m"]),
        (CONFIG, ("sweeps", 0, "fill_ratios"), [1e-9], ["fill_ratios = 1e-09", "one ball needs at least"]),
        (CONFIG, ("sweeps", 0, "seeds"), [10**30], ["sweeps.0.seeds.0", "less than"]),
        (CONFIG, ("yields", "evaluation", "resamples"), 10**12, ["yields.evaluation.resamples", "less than"]),
        # Files outside the project, and folders that must not hold results.
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
        (EMAX, ("geometry", "facets_per_half_circle"), 361, ["emax.yaml", "facets"]),
        # Drums with lifters, charges of several sizes, and frictions of walls.
        (
            DRUM,
            ("geometry",),
            LIFTED | {"lifters": BARS | {"height_mm": 46}},
            ["lifters.height_mm", "no room for a ball"],
        ),
        (
            DRUM,
            ("geometry",),
            LIFTED | {"lifters": BARS | {"width_mm": 40}},
            ["lifters.width_mm", "lifters of that width"],
        ),
        (DRUM, ("geometry",), LIFTED | {"lifters": BARS | {"face_angle_deg": 100}}, ["face_angle_deg", "90"]),
        (DRUM, ("geometry",), LIFTED | {"lifters": BARS | {"number": 0}}, ["lifters.number", "greater than"]),
        (DRUM, ("geometry",), LIFTED | {"radius_mm": 30}, ["drum.yaml: volume_ml = 235", "lifter_drum"]),
        (DRUM, ("sweep", "ball_diameters_mm"), [CHARGE | {"shares": [0.5, 0.4]}], ["shares", "add up to 0.9"]),
        (DRUM, ("sweep", "ball_diameters_mm"), [CHARGE | {"shares": [1.0]}], ["shares", "one value for each of 2"]),
        (DRUM, ("sweep", "ball_diameters_mm"), [CHARGE | {"sizes_mm": [10, 60]}], ["60", "does not fit", "drum"]),
        (STEEL, ("wall_static_friction",), -0.1, ["steel.yaml", "wall_static_friction", "greater than"]),
        (
            STEEL,
            ("cohesion",),
            {"ball_wall_J_m2": 1e5},
            ["contact set steel: cohesion.ball_wall_J_m2 = 100000", "at most"],
        ),
        (STEEL, ("wall_restitution",), 2, ["steel.yaml", "wall_restitution", "less than"]),
        (
            STEEL,
            ("wall_restitution",),
            {"speeds_m_s": [0.5, 0.1], "values": [0.5, 0.6]},
            ["steel.yaml: wall_restitution: speeds_m_s = [0.5, 0.1]: must rise; 0.1 follows 0.5"],
        ),
        # What others measured, uncertainty, and the study of the settings.
        (CONFIG, ("validation",), {"setups": ["cannon"]}, ["validation", "unknown set-up 'cannon'", "alumina_impact"]),
        (
            CONFIG,
            ("validation",),
            {"setups": ["alumina_impact"], "measured": "config/data/no.tsv"},
            ["config/data/no.tsv", "no such"],
        ),
        (CONFIG, ("uncertainty",), {"base_samples": 100}, ["uncertainty", "base_samples = 100", "power of two"]),
        (CONFIG, ("uncertainty",), {"mills": ["emaks"]}, ["emaks", "unknown mill"]),
        (CONFIG, ("convergence", "study"), {"seeds": 1}, ["convergence.study.seeds", "greater than or equal to 2"]),
        # Heat, wear and spectra.
        (
            CONFIG,
            ("dose", "heat", "programme"),
            {"duration_h": 5, "cycle_min": 30, "pause_min": 40},
            ["config.yaml: dose.heat.programme", "pause_min = 40: must be shorter than cycle_min = 30"],
        ),
        (CONFIG, ("dose", "heat", "programme", "pause_min"), 30, ["pause_min = 30", "must be shorter than cycle_min"]),
        (CONFIG, ("dose", "heat", "programme", "pause_min"), -1, ["pause_min", "-1", "greater than or equal to 0"]),
        (CONFIG, ("dose", "heat", "powder_mass_g"), 0, ["dose.heat.powder_mass_g = 0", "greater than 0"]),
        (
            CONFIG,
            ("dose", "wear"),
            {"charges": [{"bpr": 0, "time_h": 5}]},
            ["dose.wear.charges.0.bpr", "greater than 0"],
        ),
        (CONFIG, ("dose", "wear"), {"mills": ["emaks"]}, ["emaks", "unknown mill", "emax"]),
        (CONFIG, ("dose", "wear"), {"material": "cheese"}, ["wear_materials.tsv", "dose.wear.material = 'cheese'"]),
        (CONFIG, ("dose", "heat", "mills"), ["spx"], ["spx.yaml: unknown mill 'spx'", "did you mean spex?"]),
        (CONFIG, ("dose", "heat", "jars"), {"spx": {}}, ["dose.heat.jars.spx: unknown mill", "did you mean spex?"]),
        (CONFIG, ("dose", "spectra", "counting_rules"), ["gap_0_09"], ["dose.spectra.counting_rules", "gap_0_09"]),
        (CONFIG, ("dem", "overlap_mx"), 2, ["dem.overlap_mx = 2: unknown key; did you mean overlap_max?"]),
        # Volumes that disagree with the geometry.
        (
            PLANETARY,
            ("geometry",),
            {"kind": "cylinder", "radius_mm": 100, "height_mm": 125},
            [
                "planetary.yaml: volume_ml = 250: the cylinder of geometry holds 3927 mL",
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
        (ATTRITOR, ("volume_ml",), 218, ["attritor.yaml: volume_ml = 218: the cylinder of geometry holds 230.9 mL"]),
        (EMAX, ("geometry", "volume_tolerance"), 0.1, ["geometry.volume_tolerance = 0.1", "belongs to the top level"]),
        # Speeds beyond any machine; the line tells the acceleration.
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
        # A planetary jar that does not turn on its wheel.
        (
            PLANETARY,
            ("motion", "ratio"),
            0,
            ["planetary.yaml: motion: ratio = 0: ", "centrifuge", "pivot_mm: [-70.5, 0"],
        ),
    ],
)
def test_bad_value(settings, refusal, file, place, value, parts):
    if place[-1] == "facets_per_half_circle":
        edit_yaml(settings / file, "geometry", "fillet_facets", value=180)
    edit_yaml(settings / file, *place, value=value)
    line = refusal()
    for part in parts:
        assert part in line


def test_a_step_of_the_validation_is_bounded_like_the_others(settings, refusal):
    edit_yaml(settings / CONFIG, "dem", "rayleigh_fraction_max", value=0.18)
    edit_yaml(settings / CONFIG, "validation", value={"setups": ["bond_mill"], "quick": True})
    assert "config.yaml: validation.bond_mill.rayleigh_fraction = 0.2: at most dem.rayleigh_fraction_max" in refusal()


def test_an_open_mesh_is_refused_and_a_closed_one_is_not(settings, check, refusal):
    box = trimesh.creation.box((50, 50, 50))
    box.export(settings / "config/mills/jar.stl")
    mill = settings / "config/mills/emax.yaml"
    edit_yaml(mill, "geometry", value={"kind": "stl", "path": "config/mills/jar.stl", "unit": "mm"})
    check()
    box.update_faces(np.arange(12) > 0)
    box.export(settings / "config/mills/jar.stl")
    line = refusal()
    for part in ("config/mills/emax.yaml: geometry.path = 'config/mills/jar.stl'", "open"):
        assert part in line


def test_levels_that_yaml_takes_for_truth_values(settings, refusal):
    edit_yaml(settings / CONFIG, "doe", "factors", 0, "levels", value=[False, True])
    line = refusal()
    assert "doe.factors.0.levels" in line
    assert "quote them" in line


def test_a_volume_within_its_tolerance_and_a_fast_mill_pass(settings, check):
    """Smaller faults than above pass: a volume within its tolerance, and with a warning a fast but possible speed."""
    edit_yaml(settings / EMAX, "volume_ml", value=127)
    edit_yaml(settings / PLANETARY, "volume_ml", value=200)
    edit_yaml(settings / PLANETARY, "volume_tolerance", value=0.25)
    edit_yaml(settings / PLANETARY, "sweep", "speeds_rpm", value=[300, 1200])
    (line,) = check()
    for part in ("planetary.yaml: sweep: speeds_rpm = 1200: ", "174 g", "some 100 g", "usual speeds go up to 1110 rpm"):
        assert part in line


def test_two_mills_of_one_name(settings, refusal):
    (settings / "config/mills/copy.yaml").write_text((settings / EMAX).read_text())
    line = refusal()
    assert "config/mills/copy.yaml: name = 'emax': also the name of config/mills/emax.yaml" in line


def test_a_line_stays_readable_whatever_the_value(settings, refusal):
    edit_yaml(settings / CONFIG, "dem", "window_s", value="x" * 100_000 + "\u202e\x1b[31m")
    line = refusal()
    assert len(line) < 2 * LONGEST_LINE
    assert line.isprintable()


def test_all_faults_of_a_long_list_are_counted_and_some_shown(settings, check):
    edit_yaml(settings / CONFIG, "sweeps", 0, "seeds", value=["x"] * 1000)
    with pytest.raises(ConfigError) as caught:
        check()
    lines = str(caught.value).splitlines()
    assert len(lines) == 21
    assert lines[-1] == "... and 980 more"

"""Arguments have the ranges of the keys that they stand for, and the likely mistake is named in one line."""

import os
import subprocess
import sys

import pytest

from millprint.cli.commands import main


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        ("match planetary --like mixer 25 10 0.3", ["speed_rpm = 25", "1080 to 1620 rpm", "Write 1500"]),
        ("match planetary --like mixer 10 1500 0.3", ["speed_rpm = 10", "the speed comes first"]),
        ("match planetary --like mixer 1500 0.010 0.3", ["ball_diameter_mm = 0.01", "is it in m? Write 10"]),
        ("match planetary --like mixer 1500 10 30", ["fill_ratio = '30'", "write 0.3 for 30 %"]),
        ("match planetary --like mixer 1,500 10 0.3", ["speed_rpm = '1,500'", "write 1500 or 1.500"]),
        ("match planetary --like mixer 1500 10 number=0.3", ["number = '0.3'", "a whole number"]),
        ("match planetary --like mixer 1500 10 0.3 --balls 0.010", ["--balls", "is it in m? Write 10"]),
        ("match planetary --like mixer 1500 10 0.3 --balls 0.10", ["ball_diameter_mm = 0.1", "Write 100"]),
        ("match planetary --like mixer 1500 10 0.3 --speeds 5 7", ["speed_rpm = 5", "Write 300"]),
        ("match planetary --energies nan 1", ["--energies", "a finite number"]),
        ("match planetary --frequency 9 --densities 7.8", ["--densities", "g/cm3? Write 7800"]),
        ("fingerprint planetary mixer", ["mixer: one mill at a time"]),
        ("fingerprint planetary --configfile nosuch.yaml", ["--configfile nosuch.yaml: no such file"]),
        ("plan fingerprint --configfile=nosuch.yaml", ["--configfile nosuch.yaml: no such file"]),
        ("fingerprint --cores 0", ["--cores", "'0'"]),
        ("warm card a.tsv --jar-kg 720", ["--jar-kg", "is it in g? Write 0.72"]),
        ("watt card a b --efficiency 60 75", ["--efficiency", "write 0.6 for 60 %"]),
        ("wear run --bpr 30 --hours 1e9", ["--hours", "'1e9'"]),
        ("yields a b c --level 95", ["--level", "write 0.95 for 95 %"]),
    ],
)
def test_the_likely_mistake_is_named(tmp_path, monkeypatch, capsys, words, parts):
    monkeypatch.chdir(tmp_path)
    try:
        assert main(words.split()) == 1
    except SystemExit as ended:
        assert ended.code == 2
    *_, line = capsys.readouterr().err.splitlines()
    assert line.startswith("error: ") and all(part in line for part in parts), line


def test_a_reader_that_ends_gets_no_traceback():
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run([sys.executable, "-m", "millprint.cli"], stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert done.returncode == 141 and not done.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("sun_radius_mm=12.5", "warning: config/mills/a.yaml: motion.sun_radius_mm = 12.5"),
        ("ball_diameters_mm=125", "a ball of that size does not fit"),
        ("speeds_rpm=12", "is the speed in Hz?"),
        pytest.param("ball_diameters_mm=1", "h of one core", marks=pytest.mark.slow),
        (
            "radius_mm=0.0375",
            "geometry.radius_mm = 0.0375: must be greater than or equal to 1 mm; is it in m? Write 37.5",
        ),
    ],
)
def test_a_new_mill_says_what_is_unlikely(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    main(["new", "planetary", "--name", "a", "--no-picture", "--set", words])
    assert said in capsys.readouterr().err


def test_powder_that_no_jar_holds_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = "name: a\nmill: planetary\nspeed_rpm: 400\nballs: {diameter_mm: 10, fill_ratio: 0.2}\n"
    (tmp_path / "a.yaml").write_text(text + "powder: {name: quartz, mass_g: 5.0e+9}\n")
    assert main(["card", "a.yaml"]) == 1
    assert "powder.mass_g = 5e+09: more than the jar" in capsys.readouterr().err

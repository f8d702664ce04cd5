"""What `import millprint` offers: its names, mills by name and by file, and two mills compared."""

import pytest

import millprint
from millprint.fingerprint.match_words import COMPARED
from millprint.observables.definitions import DESCRIPTOR_SETS
from tests.conftest import ROOT
from tests.unit.synthetic_mill import VOLUME, descriptors, fingerprint

# A planetary mill as a user writes it down, with a fault in one key.
FAULTY = (ROOT / "config/mills/planetary.yaml").read_text().replace("sun_radius_mm", "sun_radius")


def condition(of=None, **changes):
    return (of or fingerprint()).condition(**{"speed_hz": 12.0, "ball_diameter_m": 0.01, "fill_ratio": 0.12} | changes)


@pytest.mark.parametrize("name", millprint.__all__)
def test_every_name_is_there_and_explains_itself(name):
    assert getattr(millprint, name).__doc__ and name in dir(millprint)


def test_included_mills_are_found_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert millprint.load_mill("planetary").volume_ml == 250
    assert millprint.load_contact("steel").restitution == 0.68
    assert {"planetary", "spex", "emax"} <= set(millprint.included_mills())
    assert {"steel", "calibrated"} <= set(millprint.included_contacts())
    with pytest.raises(millprint.ConfigError, match="did you mean planetary"):
        millprint.load_mill("planetarry")


def test_a_file_of_ones_own_is_read_and_its_faults_are_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text(FAULTY)
    with pytest.raises(millprint.ConfigError, match=r"mine\.yaml: motion\.sun_radius .*did you mean sun_radius_mm"):
        millprint.load_mill("mine.yaml")
    (tmp_path / "mine.yaml").write_text(FAULTY.replace("sun_radius", "sun_radius_mm"))
    assert millprint.load_mill("mine.yaml") == millprint.load_mill("planetary")
    with pytest.raises(millprint.ConfigError, match=r"absent\.yaml: no such file"):
        millprint.load_mill("absent.yaml")


@pytest.mark.slow
def test_an_included_fingerprint_is_read_by_its_name_and_drawn():
    figure = millprint.plot(millprint.read_fingerprint("planetary"), ["Pn", "Et_star"])
    assert [len(axis.lines) for axis in figure.axes] == [1, 1]
    with pytest.raises(millprint.ConfigError, match=r"did you mean planetary\?"):
        millprint.read_fingerprint("planetry")


def test_bad_conditions_are_refused_before_anything_runs(tmp_path):
    mill = millprint.load_mill("planetary")
    with pytest.raises(millprint.ConfigError, match=r"sweep: fill_ratio .*unknown key"):
        millprint.take_fingerprint(mill, folder=tmp_path / "out", sweep={"fill_ratio": [0.1]})
    with pytest.raises(millprint.ConfigError, match="either speed_rpm or speed_hz"):
        millprint.simulate(mill, folder=tmp_path / "out", balls={"diameter_mm": 10, "fill_ratio": 0.2})
    with pytest.raises(millprint.ConfigError, match=r"fill_ratios = 0\.9: .* do not fit in mill planetary"):
        balls = {"diameter_mm": 10, "fill_ratio": 0.9}
        millprint.simulate(mill, folder=tmp_path / "out", speed_rpm=300, balls=balls)
    with pytest.raises(millprint.ConfigError, match="cores = 0"):
        balls = {"diameter_mm": 10, "fill_ratio": 0.2}
        millprint.simulate(mill, folder=tmp_path / "out", cores=0, speed_rpm=300, balls=balls)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_mills_that_count_differently_are_compared_by_what_needs_no_rule():
    rows = descriptors()
    other = millprint.Fingerprint.fit(rows.assign(collisions_by="facet"), VOLUME, 0.95)
    wider = millprint.Fingerprint.fit(rows, VOLUME, 0.5)
    compared = millprint.compare(fingerprint(), condition(), other, condition(other))
    assert list(compared.index) == [name for name in COMPARED if name not in DESCRIPTOR_SETS["per_collision"]]
    assert len(millprint.match(fingerprint(), condition(), other))
    with pytest.raises(millprint.ConfigError, match="use one rule for both"):
        millprint.match(fingerprint(), condition(), other, descriptors="per_collision")
    with pytest.raises(millprint.ConfigError, match=r"probability 0\.95, those of emax of 0\.5"):
        millprint.compare(fingerprint(), condition(), wider, condition(wider))
    with pytest.raises(millprint.ConfigError, match="speeds_rpm"):
        millprint.match(fingerprint(), condition(), fingerprint(), speeds_rpm=[900, 300])

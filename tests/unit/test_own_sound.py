"""A microphone: impacts of made-up recordings with noise, echo and a motor's hum, and what they say of a prediction."""

import numpy as np
import pytest

from millprint.cli.commands import main
from millprint.own_machine.estimates import mean_of
from millprint.own_machine.heard_impacts import Series, compare, recorded, through_ear
from millprint.own_machine.readings import read_recording
from millprint.own_machine.settings import ListenSettings
from millprint.own_machine.sound import Ear, impacts_in, listen, without_hum
from tests.unit.own_recordings import RATE_HZ, events, sound_of, write_condition, write_wav

SETTINGS = ListenSettings()
DURATION_S, RATE, GAIN = 12.0, 25.0, 2.0
CLICK = Ear(8000.0, np.array([1.0, 0.3, 0.1]))


def heard_rate(ear: Ear, rate_hz: float, seed: int = 99) -> float:
    """What an ear makes of very many collisions [1/s]."""
    long_s = 200.0
    time_s, energy = events(np.random.default_rng(seed), long_s, rate_hz)
    return len(through_ear(time_s, energy, long_s, ear, SETTINGS).time_s) / long_s


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.slow
def test_the_rate_of_a_recording_is_within_its_interval(seed):
    rng = np.random.default_rng(seed)
    time_s, energy = events(rng, DURATION_S, RATE)
    recording = listen(sound_of(time_s, energy, DURATION_S, rng, gain=GAIN), RATE_HZ, SETTINGS)
    rate = mean_of(recorded(recording.heard, DURATION_S).over(recording.floor_dB))
    assert rate.lower <= heard_rate(recording.ear, RATE) <= rate.upper
    # Each impact is a collision.
    away = np.abs(recording.heard.time_s[:, None] - time_s).min(axis=1)
    assert np.mean(away < 1.5e-3) > 0.95
    assert {50, 1190, 4760} <= {min((50, 1190, 4760), key=lambda tone: abs(tone - own)) for own in recording.tones_hz}


def test_intervals_of_rates_hold_the_truth_as_often_as_they_say():
    truth, held = heard_rate(CLICK, RATE), []
    for seed in range(100):
        time_s, energy = events(np.random.default_rng(seed), DURATION_S, RATE)
        heard = through_ear(time_s, energy, DURATION_S, CLICK, SETTINGS)
        rate = mean_of(recorded(heard, DURATION_S).over(-200.0))
        held.append(rate.lower <= truth <= rate.upper)
    assert 0.88 <= np.mean(held) <= 0.995


def test_a_tone_is_taken_out_and_a_click_is_not():
    clock = np.arange(5 * RATE_HZ) / RATE_HZ
    click = np.zeros(len(clock))
    click[RATE_HZ] = 1.0
    quiet, tones = without_hum(click + 0.3 * np.sin(2 * np.pi * 3000 * clock), RATE_HZ)
    assert tones[0] == pytest.approx(3000, abs=3) and quiet[RATE_HZ] == pytest.approx(1, abs=0.05)
    rest = np.delete(quiet, slice(RATE_HZ - 50, RATE_HZ + 50))[RATE_HZ // 10 : -RATE_HZ // 10]
    assert rest.std() < 0.1 * 0.3 / np.sqrt(2)


@pytest.mark.parametrize(
    ("away_ms", "share", "times_ms"),
    [(10, 0.3, [100]), (10, 0.6, [100, 110]), (40, 0.3, [100, 140]), (2, 0.9, [100]), (2, 1.5, [102])],
)
def test_an_echo_and_the_weaker_of_two_in_the_dead_time_are_no_impacts(away_ms, share, times_ms):
    track = np.full(2000, -100.0)
    for place, size in ((800, 1.0), (800 + 8 * away_ms, share)):
        track[place] = 20 * np.log10(size)
    heard = impacts_in(track, 8000.0, np.full(len(track), -50.0), SETTINGS)
    assert 1e3 * heard.time_s == pytest.approx(times_ms)


def of_events(seed: int, duration_s: float, scale: float = 1.0) -> Series:
    time_s, energy = events(np.random.default_rng(seed), duration_s, RATE)
    heard = through_ear(time_s, scale * energy, duration_s, CLICK, SETTINGS)
    kept = heard.time_s < duration_s
    blocks = int(5 * duration_s)
    return Series.of(heard.time_s[kept], 10 ** (heard.loudness_dB[kept] / 10), blocks, duration_s / blocks)


@pytest.mark.parametrize("exponent", [0.5, 0.6])
def test_the_exponent_and_the_energy_of_a_loudness_are_found_again(exponent):
    # Loudness that goes with a power of the energy that is simulated.
    measured, simulated = of_events(1, 30.0), of_events(2, 10.0)
    louder = Series(measured.time_s, 20 * exponent * np.log10(measured.size), measured.block, 150, 0.2)
    found = compare(louder, simulated, float(louder.size.min()))
    assert found.exponent.lower <= exponent <= found.exponent.upper < 1.5 * exponent
    row = found.levels.iloc[3]
    energy = 10 ** ((row["over_floor_dB"] + louder.size.min()) / 20 / exponent)
    assert row["energy_lower_J"] <= energy <= row["energy_upper_J"]
    spacing = found.spacing_ms.iloc[1]
    assert spacing["predicted_ms"] == pytest.approx(spacing["measured_ms"], rel=0.25)


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory):
    """A card with 12 s of collisions, a recording of as many others, and one of a ball dropped from 0.1 m."""
    folder = tmp_path_factory.mktemp("laboratory")
    write_condition(folder / "my_card", *events(np.random.default_rng(7), DURATION_S, RATE), DURATION_S, 5.0)
    rng = np.random.default_rng(8)
    time_s, energy = events(rng, DURATION_S, RATE)
    write_wav(folder / "mill.wav", sound_of(time_s, energy, DURATION_S, rng, gain=GAIN))
    lost_J = (1 - 0.3**2) * 0.004 * 9.81 * 0.1
    fell = sound_of(np.array([1.0, 3.0]), np.full(2, lost_J), 6.0, rng, gain=GAIN)
    write_wav(folder / "drop.wav", fell)
    return folder


@pytest.mark.slow
def test_a_drop_tells_the_energy_and_the_prediction_agrees(laboratory, capsys, monkeypatch):
    monkeypatch.chdir(laboratory)
    words = ["listen", "my_card", "mill.wav", "--table", "mine.tsv", "--figure", "heard"]
    assert main(words) == 0
    alone = capsys.readouterr().out
    assert "verdict: cannot be told from only the rate: it agrees if impacts of over" in alone
    assert main([*words, "--drop", "drop.wav", "--drop-mm", "100"]) == 0
    assert "verdict: agrees within both intervals" in capsys.readouterr().out
    rows = (laboratory / "mine.tsv").read_text().splitlines()
    assert [row.split("\t")[0] for row in rows[1:]] == ["other_impacts_a_second", "other_impacts_a_second_2"]
    assert (laboratory / "heard.png").stat().st_size > 10_000


def test_a_prediction_of_harder_hits_is_told(laboratory, capsys, monkeypatch):
    monkeypatch.chdir(laboratory)
    write_condition(laboratory / "hard", *scaled(10.0), DURATION_S, 5.0)
    assert main(["listen", "hard", "mill.wav", "--drop", "drop.wav", "--drop-mm", "100"]) == 0
    assert "times more" in capsys.readouterr().out


def scaled(factor: float) -> tuple[np.ndarray, np.ndarray]:
    time_s, energy = events(np.random.default_rng(7), DURATION_S, RATE)
    return time_s, factor * energy


def test_a_simulation_without_impacts_is_one_line(laboratory, capsys, monkeypatch):
    monkeypatch.chdir(laboratory)
    write_condition(laboratory / "still", *scaled(0.0), DURATION_S, 5.0)
    assert main(["listen", "still", "mill.wav"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: still/runs: 0 impacts in 60 turns are predicted; needs 30 in 3")


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32])
def test_every_kind_of_wav_is_read_and_the_louder_channel_is_taken(tmp_path, kind):
    sound = 0.5 * np.sin(np.arange(6 * RATE_HZ) / 7)
    read, rate = read_recording(write_wav(tmp_path / "a.wav", np.column_stack([0.1 * sound, sound]), kind))
    assert rate == RATE_HZ and np.abs(read - sound).max() < 0.01


@pytest.mark.parametrize(
    ("sound", "words"),
    [
        (np.clip(3 * np.sin(np.arange(6 * RATE_HZ) / 7), -1, 1), "peaks are clipped; record at a lower level"),
        (np.zeros(6 * RATE_HZ), "silent"),
        (np.sin(np.arange(RATE_HZ) / 7), "1.0 s at 32000 Hz: record 5 s or more"),
        (1e-2 * np.random.default_rng(0).standard_normal(6 * RATE_HZ), "impacts over the noise, 30 are needed"),
        (None, "not a WAV"),
    ],
)
def test_a_bad_recording_is_one_line(laboratory, capsys, sound, words):
    path = laboratory / "bad.wav"
    if sound is None:
        path.write_text("this is a text and no sound")
    else:
        write_wav(path, sound)
    assert main(["listen", str(laboratory / "my_card"), str(path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {path}: ") and words in line


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing", "mill.wav"], "nothing: no card.json in it, so nothing is predicted yet"),
        (["my_card", "no.wav"], "no.wav: no such recording"),
        (["my_card", "mill.wav", "--drop", "drop.wav"], "needs --drop-mm"),
        (["my_card", "mill.wav", "--low-hz", "9000"], "high_hz"),
    ],
)
def test_a_bad_option_is_one_line(laboratory, capsys, monkeypatch, words, said):
    monkeypatch.chdir(laboratory)
    assert main(["listen", *words]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line

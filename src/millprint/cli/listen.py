"""Impacts a second of your own mill, from a recording of a phone, and those predicted for its condition. Example:

    millprint listen my_card recording.wav --table mine.tsv
    millprint listen my_card recording.wav --drop drop.wav --drop-mm 100 --table mine.tsv

my_card is the folder of `millprint card` for the same speed and balls. The recording is a WAV of 20 s or more of one
jar, without automatic level. drop.wav, recorded with the same level from the same place, has single balls dropped onto
the wall of the open jar: it says how loud a known energy is. Without it, rates over several loudnesses are compared.
"""

import math
from pathlib import Path

import numpy as np

from millprint.cli.commands import parser_of
from millprint.config.arguments import value_of_key
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.fingerprint.readers import read_contacts
from millprint.mill.gravity import GRAVITY
from millprint.own_machine.heard_impacts import (
    FEWEST_IMPACTS,
    Drop,
    Series,
    compare,
    energy_of_drop,
    joined,
    place_of,
    predicted,
    rate_at,
    rate_over_drop,
    recorded,
    verdict_of,
)
from millprint.own_machine.prediction import Condition, read_condition
from millprint.own_machine.readings import read_recording
from millprint.own_machine.settings import ListenSettings
from millprint.own_machine.sound import Ear, Recording, listen
from millprint.own_machine.verdict_text import add_options, given, keep

# Turns of the simulation that an interval needs.
FEWEST_TURNS = 3
FLOAT_OPTIONS = {
    "low_hz": "lower end of the band [Hz]",
    "high_hz": "upper end of the band [Hz]",
    "dead_ms": "of two impacts within this time the louder one counts [ms]",
    "echo_ms": "an echo comes within this time [ms]",
    "echo_share": "loudest echo over its impact [-]",
    "drop_mm": "height of the drops of --drop [mm]",
}


def simulated_of(condition: Condition, ear: Ear, settings: ListenSettings) -> Series:
    """The collisions of all runs as they are heard. Raises ConfigError for histograms, and for too few collisions."""
    found = []
    for run, summary in zip(condition.runs, condition.summaries, strict=True):
        contacts = read_contacts(run / "run.h5")
        if contacts is None:
            raise ConfigError(f"{run / 'run.h5'}: has histograms of collisions only; a shorter window keeps all")
        found.append(predicted(contacts, summary["frequency_hz"], ear, settings))
    series = joined(found)
    if series.blocks < FEWEST_TURNS or len(series.size) < FEWEST_IMPACTS:
        raise ConfigError(
            f"{condition.runs[0].parent}: {len(series.size)} impacts in {series.blocks} turns are predicted; needs "
            f"{FEWEST_IMPACTS} in {FEWEST_TURNS}: more window_turns or seeds in card.yaml, or --pair both"
        )
    return series


def drop_of(path: Path, recording: Recording, condition: Condition, settings: ListenSettings) -> Drop:
    """The loudest drop of a recording, with the restitution of the card."""
    if settings.drop_mm is None:
        raise ConfigError("--drop: needs --drop-mm, the height of the drops")
    heard = listen(*read_recording(path), settings).heard
    if not heard.loudness_dB.size:
        raise ConfigError(f"{path}: no impact is heard over the noise")
    height = 1e-3 * settings.drop_mm
    restitution = condition.card.contact_set.restitution_at_wall(math.sqrt(2 * GRAVITY * height))
    energy = energy_of_drop(condition.summaries[0]["ball_mass_kg"], height, restitution)
    return Drop(float(heard.loudness_dB.max() - recording.floor_dB), energy)


def main(arguments: list[str], name: str = "listen") -> None:
    """Print rates, spacings and the verdict."""
    parser = parser_of(name, __doc__)
    parser.add_argument("card", type=Path, help="folder of `millprint card`")
    parser.add_argument("recording", type=Path, help="WAV of the running mill")
    parser.add_argument("--drop", type=Path, help="WAV of balls dropped onto the wall from --drop-mm")
    for option, text in FLOAT_OPTIONS.items():
        parser.add_argument(f"--{option.replace('_', '-')}", type=value_of_key(ListenSettings, option), help=text)
    parser.add_argument("--pair", choices=["ball_wall", "both"], help="collisions that are heard (default: ball_wall)")
    add_options(parser)
    options = parser.parse_args(arguments)
    settings = check_model(given(options, *FLOAT_OPTIONS, "pair"), ListenSettings, "options")
    condition = read_condition(options.card)
    recording = listen(*read_recording(options.recording), settings)
    impacts = len(recording.heard.time_s)
    if impacts < FEWEST_IMPACTS:
        raise ConfigError(
            f"{options.recording}: {impacts} impacts over the noise, {FEWEST_IMPACTS} are needed; record for longer, "
            "nearer to the jar, or change --low-hz and --high-hz"
        )
    simulated = simulated_of(condition, recording.ear, settings)
    found = compare(recorded(recording.heard, recording.duration_s), simulated, recording.floor_dB)
    drop = drop_of(options.drop, recording, condition, settings) if options.drop else None
    verdict = verdict_of(found, simulated, settings, drop)
    tones = ", ".join(f"{tone:.0f}" for tone in recording.tones_hz[:5]) or "none"
    print(f"{condition.card.name}: {condition.words}")
    print(f"{options.recording}: {recording.duration_s:.0f} s, {impacts} impacts; tones taken out at {tones} Hz")
    print(found.levels.to_string(index=False, float_format="{:.3g}".format))
    print(found.spacing_ms.to_string(index=False, float_format="{:.3g}".format))
    print(f"amplitude ~ energy^{found.exponent}; predicted in all {found.all_hz} impacts a second")
    if drop:
        told = f"{rate_over_drop(found, simulated, drop)} impacts a second over the energy of that loudness"
        print(f"drop: {drop.energy_J:.3g} J at {drop.over_floor_dB:.1f} dB over the floor; predicted {told}")
    place = place_of(found, drop)
    rate = rate_at(found, place)
    print(f"measured: {rate} impacts a second of {found.levels['over_floor_dB'][place]:.1f} dB over the floor or more")
    print(f"verdict: {verdict}")
    figure = None
    if options.figure:
        from millprint.figures.own_machine_figures import plot_impacts

        track_hz = recording.ear.track_hz
        time_s = np.arange(int(track_hz)) / track_hz
        shown = recording.heard.where(recording.heard.time_s < time_s[-1])
        figure = plot_impacts(time_s, recording.track_dB[: len(time_s)], shown, recording.floor_dB, found)
    keep(options, condition.row("impacts a second", "1/s", rate, verdict), figure)

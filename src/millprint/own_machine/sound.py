"""Impacts in a recording: hum taken out, a band passed, the envelope's peaks over a threshold that follows the noise.

Loudness is the peak of the envelope in dB. `impacts_in` finds the peaks of any track of loudness over time, so that
predicted collisions are heard through the same dead time and echo as recorded ones.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.ndimage import maximum_filter1d, median_filter, uniform_filter1d
from scipy.signal import butter, find_peaks, sosfiltfilt, welch

from millprint.own_machine.settings import ListenSettings

# Samples a second of a track of loudness.
TRACK_HZ = 8000
# The envelope is smoothed over this time [s].
SMOOTH_S = 5e-4
# A tone is this much over the spectrum about it; tones are told apart by this much [Hz].
TONE_RATIO, TONE_HZ = 10.0, 3.0
# An impact rises by this much over what goes before it, and is this much over the noise [dB].
RISE_DB, OVER_NOISE_DB = 6.0, 12.0
# The noise is the quantile of the envelope that is exceeded for most of the time, in each second.
NOISE_SHARE, NOISE_S = 0.2, 1.0


@dataclass(frozen=True)
class Heard:
    """Impacts of a track: times [s] and loudness [dB] (n,)."""

    time_s: np.ndarray
    loudness_dB: np.ndarray

    def where(self, kept: np.ndarray) -> "Heard":
        """Those of a mask (n,)."""
        return Heard(self.time_s[kept], self.loudness_dB[kept])


@dataclass(frozen=True)
class Ear:
    """How one impact is heard: power over time after it (k,), 1 at the impact, with track_hz values a second."""

    track_hz: float
    response: np.ndarray


@dataclass(frozen=True)
class Recording:
    """A recording's track of loudness, its impacts, and what was taken out."""

    track_dB: np.ndarray
    """loudness, ear.track_hz times a second"""
    threshold_dB: np.ndarray
    """threshold of an impact at the same times"""
    heard: Heard
    floor_dB: float
    """loudness that is over the threshold for nearly all of the time: quieter impacts are not counted"""
    ear: Ear
    duration_s: float
    tones_hz: np.ndarray
    """tones of the motor that were taken out, the strongest first"""


def without_hum(sound: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """The sound (n,) with every steady tone lowered to the spectrum about it, and the tones, the strongest first [Hz].

    Medians over time tell a tone from impacts, which are short.
    """
    length = min(len(sound), next_fast_len(int(rate_hz / TONE_HZ)))
    frequency, power = welch(sound, rate_hz, nperseg=length, average="median")
    level = median_filter(power, 61, mode="nearest")
    ratio = power / np.maximum(level, np.finfo(float).tiny)
    tones = find_peaks(ratio, height=TONE_RATIO)[0]
    # A tone leaks into its neighbours.
    is_tone = maximum_filter1d((ratio > TONE_RATIO).astype(float), 5) > 0
    gain = np.where(is_tone, 1 / np.sqrt(np.maximum(ratio, 1.0)), 1.0)
    size = next_fast_len(len(sound), real=True)
    spectrum = rfft(sound, size)
    spectrum *= np.interp(np.arange(len(spectrum)) * rate_hz / size, frequency, gain)
    return irfft(spectrum, size)[: len(sound)], frequency[tones[np.argsort(-power[tones])]]


def loudness_track(sound: np.ndarray, rate_hz: float, settings: ListenSettings) -> np.ndarray:
    """Loudness of the band [dB], some TRACK_HZ times a second: see `track_rate`."""
    band = (settings.low_hz, min(settings.high_hz, 0.45 * rate_hz))
    passed = sosfiltfilt(butter(4, band, "bandpass", fs=rate_hz, output="sos"), sound)
    square = uniform_filter1d(passed**2, max(int(SMOOTH_S * rate_hz), 1))
    quiet = np.finfo(float).tiny
    return 10 * np.log10(np.maximum(square[:: track_step(rate_hz)], quiet))


def track_step(rate_hz: float) -> int:
    """Samples of a recording for each value of its track."""
    return max(int(rate_hz / TRACK_HZ), 1)


def noise_threshold(track_dB: np.ndarray, track_hz: float) -> np.ndarray:
    """The threshold of an impact at each time: OVER_NOISE_DB over the noise of the second about it [dB]."""
    pieces = np.array_split(track_dB, max(int(len(track_dB) / (NOISE_S * track_hz)), 1))
    noise = [np.quantile(piece, NOISE_SHARE) for piece in pieces]
    middles = (np.arange(len(pieces)) + 0.5) * len(track_dB) / len(pieces)
    return np.interp(np.arange(len(track_dB)), middles, noise) + OVER_NOISE_DB


def impacts_in(track_dB: np.ndarray, track_hz: float, threshold_dB: np.ndarray, settings: ListenSettings) -> Heard:
    """The impacts of a track (n,): peaks over the threshold (n,), the louder one of two in the dead time, no echoes."""
    dead = max(int(1e-3 * settings.dead_ms * track_hz), 1)
    # A peak's rise is sought within the dead time on both sides.
    found = find_peaks(track_dB, height=threshold_dB, distance=dead, prominence=RISE_DB, wlen=4 * dead + 1)[0]
    heard = Heard(found / track_hz, track_dB[found])
    return heard.where(~_echoes(heard, 1e-3 * settings.echo_ms, settings.echo_share))


def _echoes(heard: Heard, within_s: float, share: float) -> np.ndarray:
    """Which impacts (n,) may be an echo: at most `share` of an impact within the time before them."""
    echo = np.zeros(len(heard.time_s), dtype=bool)
    if not share or not within_s:
        return echo
    first = np.searchsorted(heard.time_s, heard.time_s - within_s)
    for place in range(len(echo)):
        before = heard.loudness_dB[first[place] : place]
        echo[place] = before.size > 0 and heard.loudness_dB[place] <= before.max() + 20 * np.log10(share)
    return echo


def ear_of(track_dB: np.ndarray, track_hz: float, heard: Heard, settings: ListenSettings) -> Ear:
    """The mean power after the loudest tenth of the impacts, less the mean of all time: ringing and echoes."""
    power, length = 10 ** (track_dB / 10), max(int(1e-3 * max(settings.echo_ms, settings.dead_ms) * track_hz), 2)
    places = np.round(heard.time_s * track_hz).astype(int)
    inside = places + length <= len(power)
    loud = inside & (heard.loudness_dB >= np.quantile(heard.loudness_dB, 0.9)) if inside.any() else inside
    if not loud.any():
        return Ear(track_hz, np.eye(1, length)[0])
    mean = np.mean([power[place : place + length] for place in places[loud]], axis=0) - power.mean()
    return Ear(track_hz, np.maximum(mean / mean[0], 0.0))


def listen(sound: np.ndarray, rate_hz: float, settings: ListenSettings) -> Recording:
    """The impacts of a recording of one channel (n,), full scale 1."""
    quiet, tones = without_hum(sound, rate_hz)
    track, track_hz = loudness_track(quiet, rate_hz, settings), rate_hz / track_step(rate_hz)
    threshold = noise_threshold(track, track_hz)
    floor = float(np.quantile(threshold, 0.95))
    heard = impacts_in(track, track_hz, np.maximum(threshold, floor), settings)
    ear = ear_of(track, track_hz, heard, settings)
    return Recording(track, threshold, heard, floor, ear, len(sound) / rate_hz, tones)

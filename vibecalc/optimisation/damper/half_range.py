"""Highest and lowest value over a cycle of many signals of integer harmonics, refined in batch."""

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray

SAMPLES_PER_HARMONIC = 16
_TRIED = 3
_NEWTON_STEPS = 5
#: from farther away
_MORE_STEPS = 8


def extremes(
    amplitude: ComplexArray, harmonic: IntArray, near: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Phases (r, 2) and values (r, 2) of the highest and the lowest point.

    Rows (r, m) are Re sum_m X_m exp(i h_m phase), sampled 16 times in the period of the highest
    harmonic, so that the best sample lies less than 2 % of the size below its summit; the three
    highest summits are refined by Newton's method and the best is taken. With phases `near` (r, 2)
    it is the crest uphill of the first and the trough downhill of the second, be there higher and
    lower ones or not.
    """
    if near is None:
        up, down = _highest(amplitude, harmonic), _highest(-amplitude, harmonic)
    else:
        up = _climbed(amplitude, harmonic, near[:, :1], _MORE_STEPS)
        down = _climbed(-amplitude, harmonic, near[:, 1:], _MORE_STEPS)
    return np.hstack([up[0], down[0]]), np.hstack([up[1], -down[1]])


def crests(amplitude: ComplexArray, harmonic: IntArray, most: int) -> tuple[FloatArray, FloatArray]:
    """Phases (r, most) and values (r, most) of the highest crests; -infinity where there is none.

    Phases may lie a little beyond [0, 2 pi).
    """
    value = sampled(amplitude, harmonic, SAMPLES_PER_HARMONIC)
    summit = (value >= np.roll(value, 1, axis=-1)) & (value > np.roll(value, -1, axis=-1))
    rank = np.argsort(np.where(summit, -value, np.inf), axis=-1)[:, :most]
    start = 2.0 * np.pi / value.shape[-1] * rank
    phase, refined = _climbed(amplitude, harmonic, start, _NEWTON_STEPS)
    refined = np.where(np.take_along_axis(summit, rank, axis=-1), refined, -np.inf)
    return phase, refined


def sampled(amplitude: ComplexArray, harmonic: IntArray, per_harmonic: int) -> FloatArray:
    """Values (..., samples) over the cycle of rows (..., m)."""
    highest = int(harmonic.max())
    count = per_harmonic * highest
    spectrum = np.zeros((*amplitude.shape[:-1], highest + 1), dtype=complex)
    for column, h in enumerate(harmonic):
        spectrum[..., h] += amplitude[..., column]
    value: FloatArray = np.fft.irfft(spectrum, count, axis=-1) * (0.5 * count)
    return value


def _highest(amplitude: ComplexArray, harmonic: IntArray) -> tuple[FloatArray, FloatArray]:
    """Phase (r, 1) and value (r, 1)."""
    phase, refined = crests(amplitude, harmonic, _TRIED)
    # a signal that does not change has no crest
    best = np.argmax(refined, axis=-1)[:, None]
    found = np.take_along_axis(refined, best, axis=-1)
    return np.take_along_axis(phase, best, axis=-1), np.where(np.isfinite(found), found, 0.0)


def _climbed(
    amplitude: ComplexArray, harmonic: IntArray, start: FloatArray, steps: int
) -> tuple[FloatArray, FloatArray]:
    """Crests uphill of phases (r, q): Newton's method, sample by sample where the signal is hollow.

    Phases (r, q) and values (r, q).
    """
    phase = start
    sample = 2.0 * np.pi / (SAMPLES_PER_HARMONIC * int(harmonic.max()))
    for _ in range(steps):
        wave = amplitude[:, None, :] * np.exp(1j * phase[..., None] * harmonic)
        first = -(wave.imag @ harmonic)
        second = -(wave.real @ harmonic**2)
        step = np.divide(-first, second, out=np.sign(first) * sample, where=second < 0.0)
        phase = phase + np.clip(step, -sample, sample)
    value = np.sum((amplitude[:, None, :] * np.exp(1j * phase[..., None] * harmonic)).real, -1)
    return phase, value

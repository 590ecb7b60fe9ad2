"""Crests and troughs that all but reach the highest and the lowest of their cycle.

The half range of a cycle is the largest of (crest - trough) / 2 over all its pairs. Each pair is
smooth in speed and damper; their maximum has an edge where two change places. A search that sees
only the highest pair runs into that edge blindly, so that close ones are named here.
"""

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.optimisation.damper.half_range import crests
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.optimisation.damper.readings import signals
from vibecalc.optimisation.damper.relative import System

#: share of the half range below which a pair is left out
_CLOSE = 0.02
#: crests (and troughs) looked at, pairs kept of one cycle
_CRESTS, _PAIRS = 6, 4


def rivals(
    system: System, damper: Damper, speed: FloatArray, row: IntArray, phase: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Other pairs of readings row[i] at speed[i], read at phase[i] (s, 2): which i, phases (q, 2).

    Heat has none; travel has one extreme, which stands for both.
    """
    sections = system.twist.shape[0]
    which: list[int] = []
    found: list[list[float]] = []
    waves = np.flatnonzero(row != sections)
    if waves.size:
        amplitude = signals(system, damper, speed[waves], row[waves])
        up, high = crests(amplitude, system.harmonic, _CRESTS)
        down, low = crests(-amplitude, system.harmonic, _CRESTS)
    for i, place in enumerate(waves.tolist()):
        if row[place] > sections:
            at, height = (up[i], high[i]) if row[place] == sections + 1 else (down[i], low[i])
            pair, value = np.stack([at, at], axis=-1), height
        else:
            pair = np.stack(np.meshgrid(up[i], down[i], indexing="ij"), axis=-1).reshape(-1, 2)
            value = (0.5 * (high[i][:, None] + low[i])).ravel()
        order = np.argsort(-value, kind="stable")
        order = order[value[order] >= (1.0 - _CLOSE) * value[order[0]]]
        kept = 0
        for one in order[: _PAIRS + 1]:
            away = np.abs(np.angle(np.exp(1j * (pair[one] - phase[place]))))
            if np.any(away > 1e-6) and kept < _PAIRS:
                which.append(place)
                found.append(pair[one].tolist())
                kept += 1
    return np.array(which, dtype=np.int64), np.array(found, dtype=float).reshape(-1, 2)

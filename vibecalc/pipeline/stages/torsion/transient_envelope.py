"""Adapter, continued: the envelope of a change in time over a cycle that slides along it."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion_studies import TRANSIENT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_sliding import Sliding, sliding

#: times of the envelope
_TIMES = 200
_RESULTS = ("speed", "torque_low", "torque_high", "half_range", "quasi_steady")


def emit_envelope(scene: Scene, setup: Setup, run: TransientRun) -> Sliding | None:
    """Emit speed and extremes; None where nobody asks for them, or no cycle can slide."""
    if not scene.wants(*(TRANSIENT + name for name in _RESULTS)):
        return None
    found = sliding(run, setup.drive.firing.cycle, _TIMES)
    if found is None:
        scene.warn(
            "the change in time is watched for hardly a cycle of the machine: there is no "
            "envelope over a whole cycle; watch a longer time after it"
        )
        return None
    axes = {"section": setup.shaft.section_names, "transient_time": found.time}
    top = float(np.max(found.speed, initial=0.0))
    scene.emit(f"{TRANSIENT}speed", found.speed, 8.0 * EPSILON * top, axes)
    # an own torque has the sign of its shaft's sense
    ratio = setup.shaft.section_ratio
    ends = np.sort(np.stack([found.low / ratio, found.high / ratio]), axis=0)
    error = found.error / np.abs(ratio)
    scene.emit(f"{TRANSIENT}torque_low", ends[0].T, error, axes)
    scene.emit(f"{TRANSIENT}torque_high", ends[1].T, error, axes)
    return found


def emit_half_ranges(
    scene: Scene, setup: Setup, found: Sliding, speeds: FloatArray, steady: FloatArray,
    doubt: FloatArray,
) -> None:  # fmt: skip
    """Half ranges beside the largest steady ones (k, e) at the speeds (k,) of each window."""
    size = np.abs(setup.shaft.section_ratio)
    axes = {"section": setup.shaft.section_names, "transient_time": found.time}
    half = 0.5 * (found.high - found.low)
    ends = [
        np.stack([np.interp(side, speeds, part) for part in steady.T], axis=1)
        for side in (found.speed_low, found.speed_high)
    ]
    beside = np.maximum(*ends)
    first = np.searchsorted(speeds, found.speed_low)
    last = np.searchsorted(speeds, found.speed_high, side="right")
    for row in np.flatnonzero(last > first):
        beside[row] = np.maximum(beside[row], steady[first[row] : last[row]].max(axis=0))
    scene.emit(f"{TRANSIENT}half_range", (half / size).T, found.error / size, axes)
    scene.emit(f"{TRANSIENT}quasi_steady", (beside / size).T, doubt / size, axes)

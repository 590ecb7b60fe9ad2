"""Adapter: torque of the gears of a shaft line against speed, and where their teeth hammer."""

import numpy as np

from vibecalc.machine.shaft_line import ShaftLine
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.curves import Curves, sweep
from vibecalc.pipeline.stages.torsion.gears import (
    by_freedom,
    own_of_gears,
    station_means,
    steady_doubts,
    steady_gears,
)
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.barred import barred_ranges

SPEEDS = f"{ROOT}/speeds"
HAMMERING = tuple(f"{ROOT}/hammering/{name}" for name in ("from", "to", "gear"))


def emit_gears(
    scene: Scene,
    setup: Setup,
    speed: FloatArray,
    curves: Curves,
    shares: FloatArray,
    error: FloatArray,
    every: FloatArray,
) -> None:
    """Mean and alternating torques, the least over a cycle, ranges in which it changes its sign.

    `curves` at speeds (s,), with errors (g,) of referred torques of gears; `shares` say what the
    sections carry of the mean torques. Ranges are looked for between the speeds `every` (r,).
    """
    shaft = setup.shaft
    size = np.abs(own_of_gears(shaft))
    axes = {"speed": speed, "gear": tuple(one.name for one in shaft.gears)}
    through, doubt = _mean(setup, speed, shares)
    off = size * error + doubt
    scene.emit(f"{SPEEDS}/gear_mean_torque", through.T, doubt, axes)
    scene.emit(f"{SPEEDS}/gear_torque", (curves.gear * size).T, size * error, axes)
    least = _least(shaft, curves, through, doubt)
    scene.emit(f"{SPEEDS}/gear_least_torque", least.T, off, axes)
    hammers = least < -off
    scene.emit(f"{SPEEDS}/gear_hammers", hammers.astype(np.int64).T, 0.0, axes)
    if not scene.wants(*HAMMERING):
        return
    ends = [_ranges(setup, every, shares, gear, float(off[gear])) for gear in range(len(size))]
    rows = [(*one, number) for number, found in enumerate(ends, start=1) for one in found]
    low, high, doubts, number = (np.array([row[k] for row in rows]) for k in range(4))
    axes = {"hammering": np.arange(1, len(rows) + 1)}
    scene.emit(HAMMERING[0], low, doubts, axes)
    scene.emit(HAMMERING[1], high, doubts, axes)
    scene.emit(HAMMERING[2], number.astype(np.int64), 0.0, axes)


def _mean(setup: Setup, speed: FloatArray, shares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean torques (s, g) on the first wheels, and the largest error (g,) of each."""
    shaft, own = setup.shaft, own_of_gears(setup.shaft)
    mean, _ = station_means(shaft, setup.drive, speed, setup.speed)
    through = steady_gears(shaft, by_freedom(shaft, mean) @ shares.T, mean) * own
    error = steady_doubts(shaft, setup.drive, speed, mean, shares) * np.abs(own)
    return through, np.max(error, axis=0)


def _least(shaft: ShaftLine, curves: Curves, through: FloatArray, doubt: FloatArray) -> FloatArray:
    """Least torque (s, g) in the sense of the mean; minus infinity where nothing damps the line.

    A mean that is zero to within its error `doubt` (g,) has no sense: the lower one of both counts.
    """
    own = own_of_gears(shaft)
    size, turned = np.abs(own), (own < 0.0) != (through < 0.0)
    ends = curves.gear_highest, -curves.gear_lowest
    down = np.where(np.abs(through) <= doubt, np.maximum(*ends), np.where(turned, *ends)) * size
    bounded: BoolArray = ~curves.masked[:, None]
    return np.where(bounded, np.abs(through) - np.where(bounded, down, 0.0), -np.inf)


def _ranges(
    setup: Setup, speed: FloatArray, shares: FloatArray, gear: int, off: float
) -> list[tuple[float, float, float]]:
    """Ends of the ranges in which a gear hammers, in rad/s, and the error of both."""

    def reversed_by(at: FloatArray) -> FloatArray:
        curves = sweep(setup.model, setup.drive, at, setup.shaft, angles=False)
        through, doubt = _mean(setup, at, shares)
        return -off - _least(setup.shaft, curves, through, doubt)[:, gear]

    found = barred_ranges(reversed_by, speed)
    rows = []
    for start, end in zip(found.start.tolist(), found.end.tolist(), strict=True):
        at = np.array([start, end])
        step = 1e-7 * at
        beside = reversed_by(np.concatenate([at - step, at + step]))
        with np.errstate(invalid="ignore"):  # beside a speed without bound
            slope = np.abs(beside[2:] - beside[:2]) / (2.0 * step)
        # an end of the speeds that were asked for, or of the sense of the mean, is exact
        crosses = np.isfinite(slope) & (slope > 0.0) & (np.abs(reversed_by(at)) < slope * step)
        moved = np.where(crosses, 4.0 * off / np.where(crosses, slope, 1.0), 0.0)
        rows.append((start, end, float(np.max(moved + 8.0 * EPSILON * at))))
    return rows

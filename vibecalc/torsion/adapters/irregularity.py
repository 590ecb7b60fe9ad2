"""How evenly named stations of a shaft line turn, at one speed and over a range."""

from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray, distinct
from vibecalc.torsion.adapters.conditions import half_ranges, uncertainty
from vibecalc.torsion.adapters.critical import undamped_speeds
from vibecalc.torsion.adapters.curves import of_finite
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.signals import (
    Signal,
    some_rows,
    some_speeds,
    stations_of,
    tops,
    with_narrow,
)
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.curve_results import IRREGULARITY

# ----------------------------------------------------------------------------
# Adapter: degree of unevenness, (highest - lowest) / mean of the angular speed over the cycle.
#
# A station with the speed ratio r turns at r W and vibrates with r phi_q; of its angular speed
# i q W r phi_q the mean r W cancels: the half range of the sum of i q phi_q, referred, is half the
# degree of unevenness. What the line does as a rigid body is in phi_q.
# ----------------------------------------------------------------------------


def run_torsion_irregularity(scene: Scene) -> None:
    """Emit degrees of unevenness and electrical angles of the stations of the case."""
    setup = setup_of(scene)
    asked = tuple(one.on for one in setup.torsion.irregularity)
    place, at = stations_of(setup, asked), np.array([setup.speed])
    signals, axes = [Signal("unevenness", place), Signal("angle", place)], {"station": asked}
    half = _half_ranges(setup, signals, at)[:, 0]
    off = uncertainty(setup, signals, at)
    _emit(scene, setup, IRREGULARITY, Bounded(half, off), axes)
    if setup.torsion.speeds is not None:
        _range(scene, setup, signals, line_speeds(setup.torsion.speeds), axes)
    scene.cite(
        "half range of the sum of order times angle, twice",
        "cyclic irregularity",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )


def _half_ranges(setup: Setup, signals: list[Signal], speed: FloatArray) -> FloatArray:
    """Of all places of the signals (r, s)."""
    every = np.ones(sum(len(one.place) for one in signals), dtype=bool)
    return np.asarray(half_ranges([setup], signals, speed, every)[0])


def _emit(scene: Scene, setup: Setup, stem: str, both: Bounded, axes: dict[str, Any]) -> None:
    """Degrees, and behind them half ranges of angles, (r, ...)."""
    pairs = np.array([one.pole_pairs or 0 for one in setup.torsion.irregularity])
    scene.emit(f"{stem}/degree", both[: len(pairs)], axes=axes)
    some = np.flatnonzero(pairs)
    if len(some):
        each = pairs[some].reshape(-1, *[1] * (both.value.ndim - 1))
        own = {**axes, "station": tuple(axes["station"][k] for k in some)}
        electrical = of_finite(both[len(pairs) + some], lambda one: one * each)
        scene.emit(f"{stem}/electrical_angle", electrical, axes=own)


def _range(
    scene: Scene, setup: Setup, signals: list[Signal], speed: FloatArray, axes: dict[str, Any]
) -> None:
    """Over speeds (s,), and the largest degree of each station at any of them."""
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    grid = with_narrow(setup, speed, setup.drive.order)
    every = _half_ranges(setup, signals, grid)
    curve = every[: len(signals[0].place)]
    clear = np.all(np.isfinite(curve), axis=0)
    make = some_rows(lambda at: _half_ranges(setup, signals[:1], at))
    endless = signals[0].endless(setup, undamped)
    top = tops(make, curve[:, clear].T, grid[clear], undamped.speed, endless)
    telling = distinct(np.concatenate([some_speeds(speed), top.speed[np.isfinite(top.value)]]))
    off = uncertainty(setup, signals, telling)
    shown = every[:, np.isin(grid, speed)]
    both = Bounded(shown, np.broadcast_to(off[:, None], shown.shape))
    _emit(scene, setup, f"{IRREGULARITY}/speeds", both, {**axes, "speed": speed})
    value = Bounded(top.value, top.value_error + off[: len(curve)])
    scene.emit(f"{IRREGULARITY}/largest/degree", value, axes=axes)
    scene.emit(f"{IRREGULARITY}/largest/speed", top.speed, top.speed_error, axes)

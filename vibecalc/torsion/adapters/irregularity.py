"""How evenly named stations of a shaft line turn, at one speed and over a range."""

from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray, IntArray, distinct
from vibecalc.numerics.synthesis import sum_error, synthesis
from vibecalc.torsion.adapters.critical import undamped_speeds
from vibecalc.torsion.adapters.curves import ROWS, SAMPLES, bounded_orders, of_finite, solved
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.signals import Signal, blocks, tops, with_narrow
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.critical_speeds import Maxima, Value
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
    asked = setup.torsion.irregularity
    place = np.array([setup.shaft.station_names.index(one.on) for one in asked])
    pairs = np.array([one.pole_pairs or 0 for one in asked])
    axes = {"station": tuple(one.on for one in asked)}
    operating = np.array([setup.speed])
    _emit(scene, setup, IRREGULARITY, place, pairs, operating, operating, axes)
    if setup.torsion.speeds is not None:
        _range(scene, setup, place, pairs, line_speeds(setup.torsion.speeds), axes)
    scene.cite(
        "half range of the sum of order times angle, twice",
        "cyclic irregularity",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958",
    )


def degrees(setup: Setup, place: IntArray, speed: FloatArray) -> FloatArray:
    """Degrees of unevenness (r, s) and half ranges of the own angles, (2, r, s)."""
    cycles, parts = setup.drive.cycles, []
    ratio = np.abs(setup.shaft.station_ratio[place])[:, None]
    for part in blocks(setup.model, setup.drive, len(speed)):
        state = solved(setup.model, setup.drive, speed[part])
        angle = np.moveaxis(state.angle[..., setup.shaft.freedom[place]], -1, 0)
        rate = setup.drive.order_at(speed[part])
        both = synthesis(cycles, np.stack([1j * rate * angle, angle])).half_range
        both *= np.stack([np.full_like(ratio, 2.0), ratio])
        parts.append(np.where(np.any(state.masked, axis=-1), np.inf, both))
    return np.concatenate(parts, axis=-1)


def _uncertainty(setup: Setup, place: IntArray, at: FloatArray) -> FloatArray:
    """Largest errors (2, r) of both at some speeds (s,)."""
    found = np.zeros((2, len(place)))
    ratio = np.abs(setup.shaft.station_ratio[place])
    for start in range(0, len(at), ROWS):
        state = bounded_orders(setup, at[start : start + ROWS])
        clear = ~np.any(state.masked, axis=1)
        angle = state.angle[..., setup.shaft.freedom[place]][clear]
        rate = setup.drive.order_at(at[start : start + ROWS])[clear, :, None]
        both = (2.0 * sum_error(angle * rate, axis=1),
                ratio * sum_error(angle, axis=1))  # fmt: skip
        found = np.maximum(found, np.max(np.stack(both), axis=1, initial=0.0))
    return found


def _emit(
    scene: Scene,
    setup: Setup,
    stem: str,
    place: IntArray,
    pairs: IntArray,
    speed: FloatArray,
    telling: FloatArray,
    axes: dict[str, Any],
) -> FloatArray:
    """Both at speeds (s,), at a single one without an axis of speeds; gives the errors (2, r)."""
    values, off = degrees(setup, place, speed), _uncertainty(setup, place, telling)
    rows = [
        Bounded(value, np.broadcast_to(error[:, None], value.shape))
        for value, error in zip(values, off, strict=True)
    ]
    if "speed" not in axes:
        rows = [one[:, 0] for one in rows]
    scene.emit(f"{stem}/degree", rows[0], axes=axes)
    some = np.flatnonzero(pairs)
    if len(some):
        each = pairs[some] if "speed" not in axes else pairs[some, None]
        own = {**axes, "station": tuple(np.array(axes["station"], dtype=object)[some])}
        electrical = of_finite(rows[1][some], lambda one: one * each)
        scene.emit(f"{stem}/electrical_angle", electrical, axes=own)
    return off


def _range(
    scene: Scene,
    setup: Setup,
    place: IntArray,
    pairs: IntArray,
    speed: FloatArray,
    axes: dict[str, Any],
) -> None:
    """Over speeds (s,), and the largest degree of each station at any of them."""
    undamped = undamped_speeds(setup, speed[0], speed[-1])
    grid = with_narrow(setup, speed, setup.drive.order)
    curve = degrees(setup, place, grid)[0].T
    clear = np.all(np.isfinite(curve), axis=1)

    def make(rows: IntArray) -> Value:
        def value(at: FloatArray) -> FloatArray:
            flat, where = np.unique(at, return_inverse=True)
            found = degrees(setup, place, flat)[0]
            own = found[np.repeat(rows, at.shape[1]), where.ravel()]
            return np.asarray(own.reshape(at.shape))

        return value

    endless = Signal("angle", place).endless(setup, undamped)
    top: Maxima = tops(make, curve[clear], grid[clear], undamped.speed, endless)
    some = speed[np.linspace(0, len(speed) - 1, min(SAMPLES, len(speed))).astype(int)]
    telling = distinct(np.concatenate([some, top.speed[np.isfinite(top.value)]]))
    stem, over = f"{IRREGULARITY}/speeds", {**axes, "speed": speed}
    off = _emit(scene, setup, stem, place, pairs, speed, telling, over)
    scene.emit(f"{IRREGULARITY}/largest/degree", Bounded(top.value, top.value_error + off[0]),
               axes=axes)  # fmt: skip
    scene.emit(f"{IRREGULARITY}/largest/speed", top.speed, top.speed_error, axes)

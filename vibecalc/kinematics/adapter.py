"""Adapter: crank and rod to harmonics of the piston motion, and its curves where asked for."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.kinematics.harmonics import (
    dropped_with_error,
    harmonics_with_error,
    order_for_tolerance,
    pole,
)
from vibecalc.kinematics.results import OfPiston
from vibecalc.kinematics.truncated_series import (
    RELATIVE_ERROR,
    truncated_dropped_acceleration,
    truncated_harmonics,
    truncated_motion,
)
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.leading import agreed
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.parts.firing import shakes_with_torque

if TYPE_CHECKING:
    from vibecalc.parts.crank_train import CrankTrain
    from vibecalc.schema import Case

#: what is left after the guard orders, as a share of what was left before them
BEYOND_GUARD = 1e-7
MOST_GUARD_ORDERS = 256
ANGLES = 361
CURVES = paths_of(OfPiston, "position", "velocity", "acceleration")


class PistonMotion(NamedTuple):
    """Harmonics C_n of s / R (..., h + 1) for orders 0 .. highest_order, then guard orders.

    The guard orders tell what leaving out the rest costs; all dropped orders together weigh
    `tail` (...) times as much as they do.
    """

    harmonics: Bounded
    highest_order: int
    tail: np.ndarray
    dropped_after_guard: np.ndarray


def run_kinematics(scene: Scene) -> None:
    """Emit position and acceleration harmonics, what is left out of them, and the curves."""
    motion, dropped = _series(scene)
    scene.handed_on["motion"] = motion
    radius = rounded(scene.parts.crank_train.crank_radius, 4)
    square = np.square(scene.case.machine.speed)
    orders = np.arange(motion.highest_order + 1)
    place = motion.harmonics[..., orders] * radius[..., None]
    found = OfPiston(
        position_harmonics=place,
        acceleration_harmonics=place * -np.asarray(square)[..., None] * orders**2,
        dropped_acceleration=dropped * radius * square,
    )
    scene.emit_all(found, {"order": orders})
    if scene.case.machine.crank_train.has_slave_rods:
        from vibecalc.kinematics.slave_adapter import emit_cylinders

        emit_cylinders(scene, motion.highest_order)
    if scene.case.kinematics is not None and scene.wants(*CURVES):
        _emit_curves(scene)


def _series(scene: Scene) -> tuple[PistonMotion, Bounded]:
    """Harmonics as the case asks, and the acceleration (...) they lack in units of R w^2."""
    case, train = scene.case, scene.parts.crank_train
    options = case.kinematics
    if options is not None and options.series == "truncated":
        terms = options.terms or 1
        scene.cite(
            f"binomial series of the slider-crank, {terms} term{'s' if terms > 1 else ''}",
            "piston motion",
            "Gibson (2008), equations 1 to 4",
        )
        return _cut_series(case, train.crank_radius / train.rod_length, terms)
    scene.cite(
        "exact harmonics of the slider-crank",
        "piston motion",
        "hypergeometric coefficients, docs/theory.md; cf. Biezeno and Grammel (1953), ch. XI",
    )
    return exact_motion(case, train)


def exact_motion(case: "Case", train: "CrankTrain", least: int = 1) -> tuple[PistonMotion, Bounded]:
    """Exact harmonics of `least` orders or as many as the tolerance needs, and what they lack.

    Points with the same crank and rod share their motion; all keep equally many orders.
    """
    rtol, cylinders = case.accuracy.rtol, len(train.names)
    lengths = (train.crank_radius / train.rod_length, train.wrist_pin_offset / train.crank_radius)
    pairs = np.stack(np.broadcast_arrays(*lengths))
    cranks, crank = np.unique(pairs.reshape(2, -1), axis=1, return_inverse=True)
    crank = crank.reshape(pairs.shape[1:])
    known = tuple(map(tuple, cranks.tolist()))
    if case.machine.crank_train.has_slave_rods:
        from vibecalc.parts.articulated import steepest_ratio

        steepest = (steepest_ratio(case.machine.crank_train),), known[1]
        least = max(int(_highest_order(case, lambda: _enough(steepest, rtol))[0]), least)
    enough = _highest_order(case, lambda: _enough(known, rtol))
    highest = max(agreed(np.broadcast_to(enough, cranks[0].shape)[crank]), least)
    motion, dropped = _exact_series(known, highest, cylinders)
    names = ("harmonics", "tail", "dropped_after_guard")
    arrays = {name: getattr(motion, name)[crank] for name in names}
    return motion._replace(**arrays), dropped[crank]


def _cut_series(
    case: "Case", rod_ratio: float | FloatArray, terms: int
) -> tuple[PistonMotion, Bounded]:
    """A cut series has no orders beyond its own: the guard orders are all that is left out."""
    ratio = np.asarray(rod_ratio)
    highest = int(_highest_order(case, lambda: last_order(case, terms))[0])
    values = truncated_harmonics(ratio, terms, max(highest, last_order(case, terms)))
    tail = np.array(1.0 if values.shape[-1] > highest + 1 else 0.0)
    dropped = truncated_dropped_acceleration(ratio, terms, highest)
    # of this size unless R / L is so close to 1 that the closed form takes over
    relative = EPSILON * (8.0 + 4.0 * terms / (1.0 - ratio * ratio))
    relative = np.where(ratio < 0.99, relative, 1e-12)
    harmonics = _with_ratio_error(values, RELATIVE_ERROR * np.abs(values), ratio)
    motion = PistonMotion(harmonics, highest, tail, np.zeros(()))
    return motion, Bounded(dropped, relative * dropped)


def last_order(case: "Case", terms: int) -> int:
    """Highest order of a cut series; of its torque, a product of two, where that counts."""
    return 4 * terms if shakes_with_torque(case) else 2 * terms


#: R / L and e / R of some cranks
Cranks = tuple[tuple[float, ...], ...]


# A study changes masses and mounts far more often than the crank: these two need not run again.
@lru_cache(maxsize=16)
def _enough(cranks: Cranks, rtol: float) -> IntArray:
    ratio, offset = map(np.array, cranks)
    return np.asarray(order_for_tolerance(ratio, rtol, offset))


@lru_cache(maxsize=16)
def _exact_series(cranks: Cranks, highest: int, cylinders: int) -> tuple[PistonMotion, Bounded]:
    ratio, offset = map(np.array, cranks)
    # evenly spaced cranks may leave every 2 c-th order only, so the guard has to reach one
    decay = -np.log(pole(ratio, np.abs(offset)).radius)
    guard = max(math.ceil(np.max(-math.log(BEYOND_GUARD) / decay)) + 2, 2 * cylinders)
    guard = min(guard, MOST_GUARD_ORDERS)
    exact = harmonics_with_error(ratio, highest + guard, offset)
    dropped = dropped_with_error(ratio, highest, offset)
    beyond = dropped_with_error(ratio, highest + guard, offset).value
    shown = dropped.value - beyond
    tail = np.where(shown > 0.0, dropped.value / np.where(shown > 0.0, shown, 1.0), 1.0)
    harmonics = _with_ratio_error(exact.values, exact.error, ratio)
    motion = PistonMotion(harmonics, highest, tail, beyond)
    reach = ratio * (1.0 + np.abs(offset))
    slip = EPSILON * (highest + 2.0 + 1.0 / decay) / np.sqrt(1.0 - reach * reach)
    return motion, Bounded(dropped.value, dropped.error + slip * dropped.value)


def _highest_order(case: "Case", enough: Callable[[], int | IntArray]) -> IntArray:
    """Highest order: the case's own word, else enough for the series and every turning weight.

    How many are enough is asked only where the case does not say: close to R/L = 1 nobody can.
    """
    if case.excitation is not None and case.excitation.orders is not None:
        return np.atleast_1d(case.excitation.orders)
    shafts = case.machine.crank_train.balance_shafts
    return np.atleast_1d(np.maximum(enough(), max([1, *(abs(one.speed_ratio) for one in shafts)])))


def _with_ratio_error(values: np.ndarray, error: np.ndarray, ratio: FloatArray) -> Bounded:
    # R / L is itself rounded: d ln C_n / d ln(R / L) is about n / sqrt(1 - (R / L)^2)
    steepness = np.arange(values.shape[-1]) / np.sqrt(1.0 - ratio * ratio)[..., None]
    return Bounded(values, error + 0.5 * EPSILON * steepness * np.abs(values))


def _emit_curves(scene: Scene) -> None:
    from vibecalc.kinematics.slider_crank import piston_motion

    train = scene.parts.crank_train
    angle = np.linspace(0.0, 2.0 * np.pi, ANGLES)
    speed, radius, length, offset = (
        np.asarray(number)[..., None]
        for number in (
            scene.case.machine.speed,
            train.crank_radius,
            train.rod_length,
            train.wrist_pin_offset,
        )
    )
    options = scene.case.kinematics
    if options is not None and options.series == "truncated":
        motion = truncated_motion(angle, radius, length, options.terms or 1)
    else:
        motion = piston_motion(angle, radius, length, offset)
    curves = OfPiston(
        position=Bounded(motion.position, motion.position_error),
        velocity=Bounded(speed * motion.velocity, speed * motion.velocity_error),
        acceleration=Bounded(speed**2 * motion.acceleration, speed**2 * motion.acceleration_error),
    )
    scene.emit_all(curves, {"crank_angle": angle})

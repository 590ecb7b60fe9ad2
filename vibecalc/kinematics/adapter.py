"""Adapter: crank and rod to harmonics of the piston motion, and its curves where asked for."""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.kinematics.harmonics import (
    dropped_with_error,
    harmonics_with_error,
    order_for_tolerance,
    pole,
)
from vibecalc.kinematics.truncated_series import (
    RELATIVE_ERROR,
    truncated_dropped_acceleration,
    truncated_harmonics,
    truncated_motion,
)
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.firing import shakes_with_torque

if TYPE_CHECKING:
    from vibecalc.parts.crank_train import CrankTrain
    from vibecalc.schema import Case

#: what is left after the guard orders, as a share of what was left before them
BEYOND_GUARD = 1e-7
MOST_GUARD_ORDERS = 256
ANGLES = 361
CURVES = ("kinematics/position", "kinematics/velocity", "kinematics/acceleration")


class PistonMotion(NamedTuple):
    """Harmonics C_n of s / R for orders 0 .. highest_order, then guard orders.

    The guard orders tell what leaving out the rest costs; all dropped orders together weigh
    `tail` times as much as they do.
    """

    harmonics: np.ndarray
    error: np.ndarray
    highest_order: int
    tail: float
    dropped_after_guard: float


def run_kinematics(scene: Scene) -> None:
    """Emit position and acceleration harmonics, what is left out of them, and the curves."""
    motion, dropped = _series(scene)
    scene.handed_on["motion"] = motion
    train = scene.parts.crank_train
    radius, speed = train.crank_radius, scene.case.machine.speed
    orders = np.arange(motion.highest_order + 1)
    values, error = (
        motion.harmonics[: motion.highest_order + 1],
        motion.error[: motion.highest_order + 1],
    )
    rounding = 4.0 * EPSILON
    scene.emit(
        "kinematics/position_harmonics",
        radius * values,
        radius * (error + rounding * np.abs(values)),
        {"order": orders},
    )
    scale = radius * speed**2 * orders**2
    scene.emit(
        "kinematics/acceleration_harmonics",
        -scale * values,
        scale * (error + rounding * np.abs(values)),
        {"order": orders},
    )
    unit = radius * speed**2
    scene.emit(
        "kinematics/dropped_acceleration",
        unit * dropped.value,
        unit * (dropped.error + rounding * dropped.value),
    )
    if scene.case.kinematics is not None and scene.wants(*CURVES):
        _emit_curves(scene)


class LackingAcceleration(NamedTuple):
    """Acceleration that the chosen series and orders lack, in units of R w^2, and its error."""

    value: float
    error: float


def _series(scene: Scene) -> tuple[PistonMotion, LackingAcceleration]:
    """Harmonics as the case asks, and the acceleration they lack."""
    case, train = scene.case, scene.parts.crank_train
    ratio = train.crank_radius / train.rod_length
    offset = train.wrist_pin_offset / train.crank_radius
    options = case.kinematics
    if options is not None and options.series == "truncated":
        terms = options.terms or 1
        scene.cite(
            f"binomial series of the slider-crank, {terms} term{'s' if terms > 1 else ''}",
            "piston motion",
            "Gibson (2008), equations 1 to 4",
        )
        return _cut_series(case, ratio, terms)
    highest = _highest_order(case, _enough(ratio, case.accuracy.rtol, offset))
    motion, dropped = _exact_series(ratio, offset, highest, len(train.names))
    scene.cite(
        "exact harmonics of the slider-crank",
        "piston motion",
        "hypergeometric coefficients, docs/theory.md; cf. Biezeno and Grammel (1953), ch. XI",
    )
    return motion, dropped


def exact_motion(case: "Case", train: "CrankTrain", least: int) -> PistonMotion:
    """Exact harmonics of a crank train, of `least` orders or as many as the tolerance needs."""
    ratio = train.crank_radius / train.rod_length
    offset = train.wrist_pin_offset / train.crank_radius
    highest = max(_highest_order(case, _enough(ratio, case.accuracy.rtol, offset)), least)
    return _exact_series(ratio, offset, highest, len(train.names))[0]


def _cut_series(case: "Case", ratio: float, terms: int) -> tuple[PistonMotion, LackingAcceleration]:
    """A cut series has no orders beyond its own: the guard orders are all that is left out."""
    highest = _highest_order(case, last_order(case, terms))
    values = truncated_harmonics(ratio, terms, max(highest, last_order(case, terms)))
    error = RELATIVE_ERROR * np.abs(values)
    tail = 1.0 if values.shape[-1] > highest + 1 else 0.0
    dropped = float(truncated_dropped_acceleration(ratio, terms, highest))
    # of this size unless R / L is so close to 1 that the closed form takes over
    relative = EPSILON * (8.0 + 4.0 * terms / (1.0 - ratio * ratio)) if ratio < 0.99 else 1e-12
    motion = _with_ratio_error(values, error, ratio, highest, tail, 0.0)
    return motion, LackingAcceleration(dropped, relative * dropped)


def last_order(case: "Case", terms: int) -> int:
    """Highest order of a cut series; of its torque, a product of two, where that counts."""
    return 4 * terms if shakes_with_torque(case) else 2 * terms


# A study changes masses and mounts far more often than the crank: these two need not run again.
@lru_cache(maxsize=64)
def _enough(ratio: float, rtol: float, offset: float) -> int:
    return order_for_tolerance(ratio, rtol, offset)


@lru_cache(maxsize=64)
def _exact_series(
    ratio: float, offset: float, highest: int, cylinders: int
) -> tuple[PistonMotion, LackingAcceleration]:
    # evenly spaced cranks may leave every 2 c-th order only, so the guard has to reach one
    decay = -math.log(float(pole(np.asarray(ratio), np.asarray(abs(offset))).radius))
    guard = max(math.ceil(-math.log(BEYOND_GUARD) / decay) + 2, 2 * cylinders)
    guard = min(guard, MOST_GUARD_ORDERS)
    exact = harmonics_with_error(ratio, highest + guard, offset)
    dropped, dropped_error = (float(x) for x in dropped_with_error(ratio, highest, offset))
    beyond = float(dropped_with_error(ratio, highest + guard, offset).value)
    tail = dropped / (dropped - beyond) if dropped > beyond else 1.0
    motion = _with_ratio_error(exact.values, exact.error, ratio, highest, tail, beyond)
    for array in (motion.harmonics, motion.error):
        array.flags.writeable = False
    reach = ratio * (1.0 + abs(offset))
    slip = EPSILON * (highest + 2.0 + 1.0 / decay) / math.sqrt(1.0 - reach * reach)
    return motion, LackingAcceleration(dropped, dropped_error + slip * dropped)


def _highest_order(case: "Case", enough: int) -> int:
    """Highest order: the case's own word, else enough for the series and every turning weight."""
    if case.excitation is not None and case.excitation.orders is not None:
        return case.excitation.orders
    shafts = case.machine.crank_train.balance_shafts
    return max(enough, *(abs(shaft.speed_ratio) for shaft in shafts), 1)


def _with_ratio_error(
    values: np.ndarray,
    error: np.ndarray,
    ratio: float,
    highest: int,
    tail: float,
    beyond: float,
) -> PistonMotion:
    # R / L is itself rounded: d ln C_n / d ln(R / L) is about n / sqrt(1 - (R / L)^2)
    steepness = np.arange(values.shape[-1]) / math.sqrt(1.0 - ratio * ratio)
    total = error + 0.5 * EPSILON * steepness * np.abs(values)
    return PistonMotion(values, total, highest, tail, beyond)


def _emit_curves(scene: Scene) -> None:
    from vibecalc.kinematics.slider_crank import piston_motion

    train, speed = scene.parts.crank_train, scene.case.machine.speed
    angle = np.linspace(0.0, 2.0 * np.pi, ANGLES)
    options = scene.case.kinematics
    if options is not None and options.series == "truncated":
        motion = truncated_motion(angle, train.crank_radius, train.rod_length, options.terms or 1)
    else:
        motion = piston_motion(angle, train.crank_radius, train.rod_length, train.wrist_pin_offset)
    axes = {"crank_angle": angle}
    curves = (
        ("position", motion.position, motion.position_error, 1.0),
        ("velocity", motion.velocity, motion.velocity_error, speed),
        ("acceleration", motion.acceleration, motion.acceleration_error, speed**2),
    )
    for name, value, error, rate in curves:
        scene.emit(f"kinematics/{name}", rate * value, rate * error, axes)

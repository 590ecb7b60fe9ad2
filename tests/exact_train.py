"""Forces and couples of a crank train in many digits: every mass by itself, added up.

Written for tests from the sentences of docs/conventions.md, without anything from the package but
the case. Vectors are numpy object arrays of mpmath numbers.
"""

from typing import Any, NamedTuple

import mpmath
import numpy as np
from exact_motion import Motion, exact_motion
from mpmath import mpc, mpf

from vibecalc.schema import Case

Vector = np.ndarray
DIRECTIONS = ("x", "y", "z")


class Frame(NamedTuple):
    """Unit vectors along the crankshaft, along the stroke, and stroke x axis."""

    axis: Vector
    stroke: Vector
    across: Vector


class Shaking(NamedTuple):
    """Force and couple (3,) on the body per squared speed, for the orders that are driven."""

    orders: list[int]
    force: list[Vector]
    couple: list[Vector]


def vector(*entries: Any) -> Vector:
    """An object array of mpmath numbers."""
    return np.array([*map(mpmath.mpmathify, entries), None], dtype=object)[:-1]


def cross(a: Vector, b: Vector) -> Vector:
    """a x b."""
    (x, y, z), (u, v, w) = a, b
    return vector(y * w - z * v, z * u - x * w, x * v - y * u)


def frame_of(case: Case) -> Frame:
    """Directions of the train in the body."""
    train = case.machine.crank_train
    axis, stroke = (
        vector(*(float(name == d) for d in DIRECTIONS)) for name in (train.axis, train.stroke_axis)
    )
    return Frame(axis, stroke, cross(stroke, axis))


def motion_of(case: Case) -> Motion:
    """Motion of the pistons as the case asks for it."""
    train, options = case.machine.crank_train, case.kinematics
    cut = options is not None and options.series == "truncated"
    terms = (options.terms or 1) if options is not None and cut else None
    lengths = map(mpf, (train.crank_radius, train.rod_length, train.wrist_pin_offset))
    return exact_motion(*lengths, terms)


def masses_of(case: Case) -> tuple[list[mpf], list[mpf]]:
    """Mass with each piston and mass at each crank pin."""
    train = case.machine.crank_train
    rod, share = mpf(0), mpf(0)
    if train.rod is not None:
        rod, fraction = mpf(train.rod.mass), train.rod.reciprocating_fraction
        share = (
            mpf(train.rod.crank_pin_to_mass_centre or 0) / mpf(train.rod_length)
            if fraction is None
            else mpf(fraction)
        )
    common = mpf(train.piston_mass or 0) + mpf(train.pin_mass or 0) + rod * share
    if train.reciprocating_mass is not None:
        common = mpf(train.reciprocating_mass)
    with_piston = [
        common if c.reciprocating_mass is None else mpf(c.reciprocating_mass)
        for c in train.cylinders
    ]
    at_pin = [
        mpf(train.rotating_mass if c.rotating_mass is None else c.rotating_mass) + rod * (1 - share)
        for c in train.cylinders
    ]
    return with_piston, at_pin


def shaking_of(case: Case, motion: Motion) -> Shaking:
    """All forces on the body, d'Alembert's: minus mass times acceleration."""
    train, frame = case.machine.crank_train, frame_of(case)
    radius, offset = mpf(train.crank_radius), mpf(train.wrist_pin_offset)
    origin = vector(*train.origin)
    highest = len(motion.position) - 1
    force = [vector(0, 0, 0) for _ in range(highest + 1)]
    couple = [vector(0, 0, 0) for _ in range(highest + 1)]
    bears = case.excitation is None or case.excitation.driven_machine != "cancels_torque"
    with_piston, at_pin = masses_of(case)

    def push(order: int, place: Vector, pull: Vector) -> None:
        force[order] = force[order] + pull
        couple[order] = couple[order] + cross(place, pull)

    def turning(unbalance: mpf, ratio: int, phase: float, place: Vector) -> None:
        sense = 1 if ratio > 0 else -1
        along = frame.stroke + mpc(0, 1) * sense * frame.across
        push(abs(ratio), place, unbalance * ratio**2 * mpmath.expj(sense * mpf(phase)) * along)

    for cylinder, mass, pin in zip(train.cylinders, with_piston, at_pin, strict=True):
        bank = mpf(cylinder.bank_angle)
        outward = mpmath.cos(bank) * frame.stroke - mpmath.sin(bank) * frame.across
        ahead = -mpmath.sin(bank) * frame.stroke - mpmath.cos(bank) * frame.across
        on_axis = origin + mpf(cylinder.position) * frame.axis
        lead = mpf(cylinder.crank_phase) - bank
        for n in range(1, highest + 1):
            turn = mpmath.expj(n * lead)
            push(n, on_axis + offset * ahead, mass * n**2 * motion.position[n] * turn * outward)
            if bears:
                couple[n] = couple[n] - mass * motion.torque[n] * turn * frame.axis
        turning(pin * radius, 1, cylinder.crank_phase, on_axis)
    for weight in train.counterweights:
        place = origin + mpf(weight.position) * frame.axis
        turning(mpf(weight.unbalance), 1, weight.phase, place)
    for shaft in train.balance_shafts:
        place = origin + vector(*shaft.position)
        turning(mpf(shaft.unbalance), shaft.speed_ratio, shaft.phase, place)
    return Shaking(list(range(1, highest + 1)), force[1:], couple[1:])

"""Adapter, continued: the question of [damper_design] in the terms of the search."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.damper_tables import DamperDesign
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.problem import Damper, Limits, Problem
from vibecalc.optimisation.damper.speed_torque import SpeedTorque
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.modes import natural_modes

#: bounds of a search without any: shares of what the lowest and the highest excited mode ask for
_STIFFNESS, _DAMPING = (0.05, 4.0), (0.02, 4.0)


class Asked(NamedTuple):
    """`problem` and `limits` are referred; `ratio` is the own speed ratio of the damper's shaft.

    `element` (e,) are the places, among the sections of the case, of the elements of the line
    without the ring; `table` is the value to compare with, or None.
    """

    problem: Problem
    limits: Limits
    ratio: float
    element: np.ndarray
    table: Damper | None


def build_problem(setup: Setup, options: DamperDesign) -> Asked:
    """The line without the ring, its torque, the weights of its sections, bounds and limits."""
    if setup.torsion.damping_model is not None and setup.model.modal is not None:
        raise NumericalFailure(
            "damping ratios by mode hold for the line as it is; a search for a damper needs "
            "dampings of shafts and stations, or a damping_model of kind 'rayleigh'"
        )
    shaft = setup.shaft
    line, element, freedom = _without_ring(setup, options.on)
    if np.any(setup.model.speed_stiffness[element]):
        raise NumericalFailure(
            "pendulums change with the speed, which the search for another damper does not follow"
        )
    replaced = next((one for one in shaft.dampers if one.name == options.on), None)
    if replaced is not None:
        station, carrier = replaced.station, replaced.carrier
    else:
        station = shaft.station_names.index(options.on)
        carrier = int(shaft.freedom[station])
    ratio = float(shaft.station_ratio[station])
    asked = options.speeds or setup.torsion.speeds
    assert asked is not None
    speeds = (asked.start, asked.stop)
    own = None if replaced is None else Damper(
        replaced.inertia, replaced.stiffness, replaced.damping
    )  # fmt: skip
    limits = _limits(options, own, line, speeds, setup, ratio)
    problem = Problem(
        line=line,
        station=int(np.flatnonzero(freedom == carrier)[0]),
        order=setup.drive.order,
        cycle=setup.drive.firing.cycle,
        torque=_torque(setup, freedom),
        speed=speeds,
        weight=_weights(setup, options, element),
        quantity="twist" if options.objective == "twist" else "torque",
    )
    table = None
    if options.compare is not None:
        values = (options.compare.stiffness, options.compare.damping)
        inertia = limits.inertia[0] if own is None or options.inertia else own.inertia * ratio**2
        table = Damper(inertia, *(value * ratio**2 for value in values))
    return Asked(problem, limits, ratio, element, table)


def _without_ring(setup: Setup, name: str) -> tuple[Line, np.ndarray, np.ndarray]:
    """The line, and which elements and freedoms of the case's line it still has."""
    line, shaft = setup.model.line, setup.shaft
    replaced = next((one for one in shaft.dampers if one.name == name), None)
    n, e = line.inertia.size, line.stiffness.size
    if replaced is None:
        return line, np.arange(e), np.arange(n)
    freedom = np.flatnonzero(np.arange(n) != replaced.ring)
    element = np.flatnonzero(np.arange(e) != replaced.element)
    number = np.cumsum(np.arange(n) != replaced.ring) - 1
    return (
        Line(
            line.inertia[freedom], line.absolute_damping[freedom], line.ground_stiffness[freedom],
            number[line.first[element]], number[line.second[element]], line.stiffness[element],
            line.damping[element], line.loss_factor[element],
        ),
        element,
        freedom,
    )  # fmt: skip


def _weights(setup: Setup, options: DamperDesign, element: np.ndarray) -> FloatArray:
    """What turns a referred torque or twist of each section into what is made small."""
    shaft = setup.shaft
    names = np.array([shaft.section_names[place] for place in element], dtype=object)
    kinds = np.array([shaft.section_kinds[place] for place in element], dtype=object)
    counts = np.isin(names, options.sections) if options.sections else kinds != "damper"
    ratio, modulus = np.abs(shaft.section_ratio[element]), shaft.section_modulus[element]
    if options.objective == "twist":
        return np.asarray(np.where(counts, ratio, 0.0))
    if options.objective == "torque":
        return np.asarray(np.where(counts, 1.0 / ratio, 0.0))
    lacking = counts & (modulus <= 0.0)
    if options.sections and np.any(lacking):
        raise NumericalFailure(
            f"no stress in section {names[lacking][0]!r}: it has neither diameter nor section "
            "modulus"
        )
    known = counts & (modulus > 0.0)
    if not np.any(known):
        raise NumericalFailure("no section has a diameter or section modulus: no stress to lower")
    safe = np.where(known, modulus, 1.0)
    return np.asarray(np.where(known, 1.0 / (ratio * safe), 0.0))


def _torque(setup: Setup, freedom: np.ndarray) -> SpeedTorque:
    """Gas along straight lines between cards, inertia with the square of the speed."""
    drive, n = setup.drive, setup.model.line.inertia.size
    gas = np.zeros((len(drive.gas), len(drive.order), n), dtype=complex)
    inertia = np.zeros((len(drive.order), n), dtype=complex)
    gas[..., drive.freedom], inertia[:, drive.freedom] = drive.gas, drive.inertia
    gas, inertia = gas[..., freedom], inertia[:, freedom]
    if len(drive.card_speed) < 2:
        parts = np.stack([gas[0], np.zeros_like(inertia), inertia])
        return SpeedTorque(np.array([0.0, np.inf]), parts[None])
    knot = drive.card_speed
    slope = np.diff(gas, axis=0) / np.diff(knot)[:, None, None]
    begin = knot[:-1, None, None]
    pieces = np.stack(
        [gas[:-1] + begin**2 * inertia, slope + 2.0 * begin * inertia,
         np.broadcast_to(inertia, slope.shape)],
        axis=1,
    )  # fmt: skip
    return SpeedTorque(knot, pieces)


def _limits(
    options: DamperDesign, own: Damper | None, line: Line, speeds: tuple[float, float],
    setup: Setup, ratio: float,
) -> Limits:  # fmt: skip
    """Bounds of what is looked for, equal ones of what is not; referred."""
    square = ratio**2
    bounds = options.bounds
    given: dict[str, float | None] = {
        "inertia": options.inertia, "stiffness": options.stiffness, "damping": options.damping,
    }  # fmt: skip
    if own is not None:
        for name, value in own._asdict().items():
            given[name] = value if given[name] is None else given[name]
    ring = given["inertia"]
    asked = None if bounds is None else bounds.inertia
    if "inertia" in options.find:
        if asked is None:
            raise NumericalFailure("a ring inertia is looked for between bounds: give them")
        inertia = (asked[0] * square, asked[1] * square)
    elif ring is None:
        raise NumericalFailure(f"no inertia of the ring on {options.on!r} is known: give one")
    else:
        inertia = (ring * square, ring * square)
    natural = natural_modes(line).frequency
    natural = natural[natural > 0.0]
    if natural.size == 0:
        raise NumericalFailure("the line has no elastic mode that a damper could calm")
    reach = float(setup.drive.order[-1]) * speeds[1]
    excited = natural[natural <= reach]
    low, high = float(natural[0]), float(excited[-1] if excited.size else natural[0])
    middle = float(np.sqrt(inertia[0] * inertia[1]))
    usual = {
        "stiffness": (_STIFFNESS[0] * middle * low**2, _STIFFNESS[1] * middle * high**2),
        "damping": (_DAMPING[0] * middle * low, _DAMPING[1] * middle * high),
    }
    found: dict[str, tuple[float, float]] = {}
    for name, span in usual.items():
        said = None if bounds is None else getattr(bounds, name)
        if name in options.find:
            found[name] = span if said is None else (said[0] * square, said[1] * square)
        else:
            value = given[name]
            if value is None and name == "damping":
                raise NumericalFailure("the damping is neither looked for nor given")
            found[name] = ((value or 0.0) * square, (value or 0.0) * square)
    kept = options.limits
    heat = np.inf if kept is None or kept.heat is None else kept.heat
    travel = np.inf if kept is None or kept.travel is None else kept.travel / abs(ratio)
    return Limits(inertia, found["stiffness"], found["damping"], heat, travel)

"""Numbers of a case that are possible and most unlikely: each with the slip that makes them.

One rule a line: where the number comes from, from which size on it is said, and the words, in which
`{x}` is the number and `{what}` the part of the machine that has it.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from vibecalc.case.kinds import finds_speed, has_crank_train, has_speed
from vibecalc.case.schema import Case
from vibecalc.machine.body import build_body
from vibecalc.machine.crank_train import build_crank_train
from vibecalc.machine.mounts import build_mounts

#: what a rule looks at, with the words for the part that has it
Found = Iterator[tuple[str, float]]
TURN = 2.0 * math.pi
#: kg/m^3
STEEL = 7850.0
ANGLES = ("crank_phase", "bank_angle", "firing_angle", "phase")


class Rule(NamedTuple):
    """Numbers of a case whose magnitude is above `limit` get a sentence."""

    numbers: Callable[[Case], Found]
    limit: float
    words: str


def at(*path: str) -> Callable[[Case], Found]:
    """Every number at a path, `[]` after the name of a list standing for all of its entries."""

    def numbers(case: Case) -> Found:
        return _below(case, path, path[-1].replace("_", " "))

    return numbers


def _below(table: Any, path: tuple[str, ...], what: str) -> Found:
    if table is None:
        return
    if isinstance(table, tuple):
        for value in table:
            yield from _below(value, path, what)
        return
    if not path:
        yield what, float(table)
        return
    if not path[0].endswith("[]"):
        yield from _below(getattr(table, path[0], None), path[1:], what)
        return
    for entry in getattr(table, path[0][:-2], None) or ():
        name = getattr(entry, "name", None)
        yield from _below(entry, path[1:], f"{what} of '{name}'" if name else what)


def angles(case: Case) -> Found:
    """Angles of the crank train beyond a turn that look as if they were degrees.

    A phase of 480 degrees is no round number of radians, 180 without a unit is one.
    """
    if not has_crank_train(case.machine):
        return
    train = case.machine.crank_train
    parts: list[tuple[str, Any]] = [(f"cylinder '{one.name}'", one) for one in train.cylinders]
    parts += [(f"'{one.name}'", one) for one in train.counterweights]
    parts += [(f"'{one.name}'", one) for one in train.balance_shafts]
    for what, part in parts:
        for key in ANGLES:
            angle = getattr(part, key, None)
            if angle is None or abs(angle) <= TURN * (1.0 + 1e-9):
                continue
            if abs(angle) > 2.0 * TURN + 1e-6 or abs(2.0 * angle - round(2.0 * angle)) < 1e-9:
                yield f"{key} of {what}", angle


def piston_speed(case: Case) -> Found:
    """Mean speed of the pistons at the speed of the machine, or that its motor stays below."""
    machine = case.machine
    if has_crank_train(machine):
        motor, speed = machine.motor, machine.speed if has_speed(machine) else 0.0
        if motor is not None and finds_speed(machine):
            speed = motor.synchronous_speed or 0.0
        yield "", 2.0 * machine.crank_train.crank_radius * speed / math.pi


def bore(case: Case) -> Found:
    """Bore over stroke or the other way round, of machines whose pistons are about as long."""
    if case.machine.kind not in ("engine", "compressor"):
        return
    train = case.machine.crank_train
    if train.bore:
        ratio = train.bore / (2.0 * train.crank_radius)
        yield (
            f"{train.bore:.3g} m at a stroke of {2.0 * train.crank_radius:.3g} m",
            max(ratio, 1.0 / ratio),
        )


def unbalances(case: Case) -> Found:
    """Unbalance of each weight over that of all that moves, at the crank radius."""
    if not has_crank_train(case.machine):
        return
    written, train = case.machine.crank_train, build_crank_train(case.machine.crank_train)
    moving = float(train.reciprocating_mass.sum() + train.rotating_mass.sum()) * train.crank_radius
    weights = [(weight.name, weight.unbalance) for weight in written.counterweights]
    weights += [(shaft.name, shaft.unbalance) for shaft in written.balance_shafts]
    for name, unbalance in weights if moving > 0.0 else ():
        yield f"'{name}', {unbalance:.4g} kg*m,", unbalance / moving


def masses(case: Case) -> Found:
    """Masses of an engine over that of a cube of steel as long as its rod."""
    if case.machine.kind != "engine":
        return
    train = case.machine.crank_train
    rod, solid = train.rod, STEEL * train.rod_length**3
    for what, mass in (
        ("the rod", None if rod is None else rod.mass),
        ("what moves with a piston", train.reciprocating_mass),
        ("a piston", train.piston_mass),
        ("a wrist pin", train.pin_mass),
    ):
        if mass is not None:
            yield f"{what} weighs {mass:.3g} kg", mass / solid


def sag(case: Case) -> Found:
    """Sag of the body under its weight over the longest distance between its mounts."""
    machine, options = case.machine, case.isolation
    if options is None or machine.body is None or machine.mounts is None:
        return
    if machine.body.mass_matrix is not None or machine.mounts.stiffness_matrix is not None:
        return
    mounts, up = build_mounts(machine.mounts), "xyz".index(options.up)
    stiffness = float(mounts.stiffness.sum(axis=0)[up, up])
    away = mounts.position[:, None] - mounts.position
    size = float(np.sqrt(np.square(away).sum(axis=-1)).max())
    if machine.body.box is not None:
        size = max(size, *(getattr(machine.body.box, k) for k in ("length", "width", "height")))
    if stiffness > 0.0 and size > 0.0:
        deep = build_body(machine.body).mass * options.gravity / stiffness
        yield f"{deep:.3g} m", deep / size


RULES = (
    Rule(
        angles, 0.0,
        "the {what} is {x:.6g} rad, more than a turn: should it be '{x:.6g} deg'? Angles "
        "without a unit are in radians",
    ),
    Rule(
        piston_speed, 30.0,
        "the mean piston speed is {x:.3g} m/s, where machines stay below 30: is the speed in "
        "rad/s ('4900 rpm' otherwise) and the crank radius in m?",
    ),
    Rule(
        at("machine", "crank_train", "bore"), 2.0,
        "the {what} is {x:.4g} m: is it in m ('{x:.4g} mm' otherwise)?",
    ),
    Rule(
        at("machine", "crank_train", "crank_radius"), 3.0,
        "the {what} is {x:.4g} m: is it in m ('{x:.4g} mm' otherwise)?",
    ),
    Rule(
        at("machine", "crank_train", "cylinders[]", "position"), 50.0,
        "the {what} is {x:.4g} m: is it in m ('{x:.4g} mm' otherwise)?",
    ),
    Rule(
        at("machine", "mounts", "positions"), 50.0,
        "a mount stands {x:.4g} m away: is its place in m ('{x:.4g} mm' otherwise)?",
    ),
    Rule(
        at("machine", "mounts", "individual[]", "position"), 50.0,
        "the {what} is {x:.4g} m: is it in m ('{x:.4g} mm' otherwise)?",
    ),
    Rule(
        bore, 6.0,
        "the bore is {what}: engines and compressors have the two nearly alike; are both in m "
        "('76 mm' otherwise)?",
    ),
    Rule(
        unbalances, 10.0,
        "the unbalance of {what} is {x:.3g} times that of all that moves in the crank train: "
        "is it in kg*m ('26 kg*mm', '26 g*m' otherwise)?",
    ),
    Rule(
        masses, 1.0,
        "{what}, more than a cube of steel as long as the rod: is the mass in kg ('1 g' "
        "otherwise) and the length in m?",
    ),
    Rule(
        sag, 0.1,
        "under its weight the machine sinks by about {what}, more than a tenth of its length: "
        "is the stiffness of the mounts in N/m ('10 kN/m', '10 N/mm' otherwise)?",
    ),
    Rule(
        at("machine", "secondary", "mass_ratio"), 1.0,
        "the {what} is {x:.4g}, an absorber heavier than what it is to keep still: should it "
        "be '{x:.4g} %'?",
    ),
    Rule(
        at("machine", "secondaries[]", "mass_ratio"), 1.0,
        "the {what} is {x:.4g}, an absorber heavier than what it is to keep still: should it "
        "be '{x:.4g} %'?",
    ),
    Rule(
        at("machine", "motor", "synchronous_speed"), 378.0,
        "the {what} is {x:.4g} rad/s, above the 3600 rpm of two poles at 60 Hz: should it be "
        "'{x:.4g} rpm'?",
    ),
)  # fmt: skip


def implausible(case: Case) -> list[str]:
    """A sentence for every number of a case without problems that a slip is likely to have made."""
    return [
        rule.words.format(what=what, x=value)
        for rule in RULES
        for what, value in rule.numbers(case)
        if abs(value) > rule.limit
    ]

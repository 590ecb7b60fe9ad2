"""Warnings: numbers of a case that are possible and unlikely, or less exact than they look."""

import math
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibecalc.errors import NumericalFailure
from vibecalc.kinds import asks_roll, finds_speed, has_crank_train, has_speed
from vibecalc.parts import body_tables as parts
from vibecalc.parts.body import DIRECTIONS, RigidBody, build_body, build_frame
from vibecalc.parts.crank_train import build_crank_train, rod_share
from vibecalc.parts.firing import driven_machine, has_gas, moves_body, with_torque
from vibecalc.parts.mount_needs import loads_count, moves_with_machine
from vibecalc.parts.mount_state import mounts_of
from vibecalc.parts.mounts import Mounts, build_mounts, has_loss_factor, mount_entries
from vibecalc.schema import Case, Machine

# ----------------------------------------------------------------------------
# Numbers of a case that are possible and most unlikely: each with the slip that makes them.
#
# One rule a line: where the number comes from, from which size on it is said, and the words, in
# which `{x}` is the number and `{what}` the part of the machine that has it.
# ----------------------------------------------------------------------------

#: what a rule examines, with the words for the part that has it
NamedNumbers = Iterator[tuple[str, float]]
TURN = 2.0 * math.pi
Array = NDArray[np.float64]
#: kg/m^3
STEEL = 7850.0
ANGLES = ("crank_phase", "bank_angle", "firing_angle", "phase")


class Rule(NamedTuple):
    """Numbers of a case whose magnitude is above `limit` get a sentence."""

    numbers: Callable[[Case], NamedNumbers]
    limit: float
    words: str


def at(*path: str) -> Callable[[Case], NamedNumbers]:
    """Every number at a path, `[]` after the name of a list standing for all of its entries."""

    def numbers(case: Case) -> NamedNumbers:
        return _below(case, path, path[-1].replace("_", " "))

    return numbers


def _below(table: Any, path: tuple[str, ...], what: str) -> NamedNumbers:
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


def angles(case: Case) -> NamedNumbers:
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


def _crank_speed(machine: Machine) -> float:
    """Speed of the machine, rad/s, or the one that its motor stays below; 0 without one."""
    motor = machine.motor
    if motor is not None and finds_speed(machine):
        return motor.synchronous_speed or 0.0
    return (machine.speed if has_speed(machine) else 0.0) or 0.0


def piston_speed(case: Case) -> NamedNumbers:
    """Mean speed of the pistons."""
    if has_crank_train(case.machine):
        radius = case.machine.crank_train.crank_radius
        yield "", 2.0 * radius * _crank_speed(case.machine) / math.pi


def piston_acceleration(case: Case) -> NamedNumbers:
    """Acceleration of the pistons at the dead centre away from the crank, r W^2 (1 + r / L)."""
    if has_crank_train(case.machine):
        train = case.machine.crank_train
        ratio = train.crank_radius / train.rod_length
        yield "", train.crank_radius * _crank_speed(case.machine) ** 2 * (1.0 + ratio)


def rod_pressure(case: Case) -> NamedNumbers:
    """Largest force of gas and of inertia on each rod over the area of a piston as wide as its
    stroke, bar: a measure of the load of a crank train that no size and no material is in.
    """
    if not has_crank_train(case.machine):
        return
    written, train = case.machine.crank_train, build_crank_train(case.machine.crank_train)
    radius, card = written.crank_radius, written.gas_pressure
    shared = 0.0
    if card is not None and written.bore is not None:
        shared = 0.25 * math.pi * written.bore**2 * max(map(abs, card.pressure))
    ((_, acceleration),) = piston_acceleration(case)
    for cylinder, mass in zip(written.cylinders, train.reciprocating_mass, strict=True):
        gas = cylinder.gas_force
        pushed = shared if gas is None else max(map(abs, gas.force))
        force = max(pushed, float(mass) * acceleration)
        words = f"the rod of cylinder '{cylinder.name}' carries about {force:.4g} N"
        yield words, force / (math.pi * radius**2) / 1e5


def bore(case: Case) -> NamedNumbers:
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


def unbalances(case: Case) -> NamedNumbers:
    """Unbalance of each weight over that of all that moves, at the crank radius."""
    if not has_crank_train(case.machine):
        return
    written, train = case.machine.crank_train, build_crank_train(case.machine.crank_train)
    moving = float(train.reciprocating_mass.sum() + train.rotating_mass.sum()) * train.crank_radius
    weights = [(weight.name, weight.unbalance) for weight in written.counterweights]
    weights += [(shaft.name, shaft.unbalance) for shaft in written.balance_shafts]
    for name, unbalance in weights if moving > 0.0 else ():
        yield f"'{name}', {unbalance:.4g} kg*m,", unbalance / moving


def masses(case: Case) -> NamedNumbers:
    """Masses of an engine over that of a cube of steel as long as its rod."""
    if case.machine.kind != "engine":
        return
    train = case.machine.crank_train
    rod, solid = train.rod, STEEL * train.rod_length**3
    for what, mass in (
        ("the rod", None if rod is None else rod.mass),
        ("the reciprocating mass", train.reciprocating_mass),
        ("a piston", train.piston_mass),
        ("a wrist pin", train.pin_mass),
    ):
        if mass is not None:
            yield f"{what} weighs {mass:.3g} kg", mass / solid


def sag(case: Case) -> NamedNumbers:
    """Sag of the body under its weight over the longest distance between its mounts."""
    machine, options, built = case.machine, case.isolation, _built(case.machine)
    if options is None or built is None or machine.body is None or machine.mounts is None:
        return
    (body, mounts), up = built, "xyz".index(options.up)
    stiffness = float(mounts.stiffness.sum(axis=0)[up, up])
    away = mounts.position[:, None] - mounts.position
    size = float(np.sqrt(np.square(away).sum(axis=-1)).max())
    box = machine.body.box
    if box is not None:
        size = max(size, box.length, box.width, box.height)
    if loads_count(machine.mounts):
        deep = _sunk(case, up)
    else:
        deep = body.mass * options.gravity / stiffness if stiffness > 0.0 else 0.0
    if size > 0.0:
        yield f"{deep:.3g} m", deep / size


def _sunk(case: Case, up: int) -> float:
    """Sag of the mass centre on mounts that follow their load; 0 where there is no rest."""
    try:
        mounts = mounts_of(case)
    except NumericalFailure:
        return 0.0  # the run says it
    if mounts is None or mounts.rest is None:
        return 0.0
    return -float(mounts.rest.body.value[up])


RULES = (
    Rule(
        angles, 0.0,
        "the {what} is {x:.6g} rad, more than a revolution: should it be '{x:.6g} deg'? Angles "
        "without a unit are in radians",
    ),
    Rule(
        piston_speed, 30.0,
        "the mean piston speed is {x:.3g} m/s, above the usual 30: is the speed in "
        "rad/s ('4900 rpm' otherwise) and the crank radius in m?",
    ),
    Rule(
        piston_acceleration, 1e5,
        "the piston acceleration is up to {x:.3g} m/s^2, above that of racing engines, 1e5: "
        "is the speed in rad/s ('4900 rpm' otherwise) and the crank radius in m?",
    ),
    Rule(
        rod_pressure, 500.0,
        "{what}, which is {x:.4g} bar on a piston of bore = stroke, above the usual 500: "
        "are gas forces in N, pressures in Pa and masses in kg?",
    ),
    *(
        Rule(
            at(*path.split(".")), limit,
            "the {what} is {x:.4g} m: is it in m ('{x:.4g} mm' otherwise)?",
        )
        for path, limit in (
            ("machine.crank_train.bore", 2.0),
            ("machine.crank_train.crank_radius", 3.0),
            ("machine.crank_train.cylinders[].position", 50.0),
            ("machine.mounts.individual[].position", 50.0),
        )
    ),
    Rule(
        at("machine", "mounts", "positions"), 50.0,
        "a mount is {x:.4g} m away: is its position in m ('{x:.4g} mm' otherwise)?",
    ),
    Rule(
        bore, 6.0,
        "the bore is {what}: the two are usually nearly equal; are both in m "
        "('76 mm' otherwise)?",
    ),
    Rule(
        unbalances, 10.0,
        "the unbalance of {what} is {x:.3g} times that of all moving masses of the crank train: "
        "is it in kg*m ('26 kg*mm', '26 g*m' otherwise)?",
    ),
    Rule(
        masses, 1.0,
        "{what}, more than a cube of steel as long as the rod: is the mass in kg ('1 g' "
        "otherwise) and the length in m?",
    ),
    Rule(
        sag, 0.1,
        "the static deflection of the machine is about {what}, over a tenth of its length: "
        "is the stiffness of the mounts in N/m ('10 kN/m', '10 N/mm' otherwise)?",
    ),
    *(
        Rule(
            at("machine", table, "mass_ratio"), 1.0,
            "the {what} is {x:.4g}, an absorber heavier than the primary system: should it "
            "be '{x:.4g} %'?",
        )
        for table in ("secondary", "secondaries[]")
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


# ----------------------------------------------------------------------------
# What is possible but unlikely, or less exact than it looks.
# ----------------------------------------------------------------------------

NOTICEABLE = 1e-6


def part_warnings(case: Case) -> list[str]:
    """Sentences for the report, on a case without problems."""
    train = has_crank_train(case.machine)
    of_train = (_places, _orders, _pitch_coupling) if train else ()
    said = (implausible, *of_train, _without_effect, *((_rod,) if train else ()))
    return [text for some in said for text in some(case)]


def _built(machine: Machine) -> tuple[RigidBody, Mounts] | None:
    """Body and mounts, if neither is missing nor a matrix."""
    body, mounts = machine.body, machine.mounts
    if body is None or mounts is None or body.mass_matrix or mounts.stiffness_matrix:
        return None
    return build_body(body), build_mounts(mounts)


def _places(case: Case) -> Iterator[str]:
    roll = None if case.response is None else case.response.roll
    if not has_speed(case.machine) and not (roll is not None and roll.classical):
        return  # no couples are computed
    if case.machine.kind == "engine" and case.machine.body is None and case.excitation is None:
        return  # only torques on a shaft line
    train = build_crank_train(case.machine.crank_train)
    seen: dict[tuple[float, float], str] = {}
    for name, place, bank in zip(train.names, train.position, train.bank_angle, strict=True):
        spot = (float(place), float(bank))
        if spot in seen:
            yield (
                f"cylinders '{seen[spot]}' and '{name}' have the same position, "
                f"{place:.6g} m, and bank angle, {bank:.6g} rad: no couple between them"
            )
        seen.setdefault(spot, name)


def _orders(case: Case) -> Iterator[str]:
    highest = None if case.excitation is None else case.excitation.orders
    for shaft in case.machine.crank_train.balance_shafts:
        if highest is not None and abs(shaft.speed_ratio) > highest:
            yield (
                f"balance shaft '{shaft.name}' turns at {abs(shaft.speed_ratio)} times the crank "
                f"speed and is left out: excitation.orders = {highest}"
            )


_REACHES = (
    "it needs [response] or the model 'rigid_body' or 'planar', and a compressor, a pump or an "
    "engine with a firing order, without slave rods and driven_machine = 'cancels_torque'"
)


def _without_effect(case: Case) -> list[str]:
    machine, response = case.machine, case.response
    gas, reaches = has_crank_train(machine) and has_gas(case), with_torque(case)
    taken = moves_body(case) and driven_machine(case) != "cancels_torque"
    tables = ("isolation", *(("response",) * taken))
    takes = [
        one
        for one in tables
        if (table := getattr(case, one)) and "torque" in (table.loads or ("torque",))
    ]
    used = (
        (response is not None and (response.torsion is not None or response.impact is not None))
        or asks_roll(case)
        or case.bearing_loads is not None
    )
    mounts, switching = machine.mounts, None if response is None else response.switching
    impact = None if response is None else response.impact
    texts = {
        "[machine.motor] has no effect: its axial force needs [excitation]": (
            machine.motor is not None and not finds_speed(machine) and case.excitation is None
        ),
        "[machine.joints] has no effect: its play needs [response.impact]": (
            machine.joints is not None and impact is None
        ),
        "the gas has no effect: [response.torsion], [response.impact], [bearing_loads] and the "
        f"roll of the machine use it; for a body on mounts {_REACHES}": (
            gas and not reaches and not used and (bool(takes) or not case.isolation)
        ),
        "[response] operations and switching contain the shaking only, without the torque of the "
        "cylinders, which motion and energies contain": (
            response is not None and bool(response.operations) and "response" in reaches
        ),
        "[response] computes the body on rigid ground, [isolation] on the foundation": (
            moves_body(case) and moves_with_machine(case)
        ),
        f"the gas torque does not act on the body on its mounts: {_REACHES}": (
            gas and used and set(takes) != set(reaches)
        ),
    }
    if mounts is not None:
        tables = ("isolation", "foundation", "base_motion")
        others = [f"[{name}]" for name in tables if getattr(case, name) is not None]
        curved = [repr(one) for one in _overridden(case, mounts)]
        texts |= {
            f"modal_damping applies to [response] only, not to {', '.join(others)}": (
                bool(mounts.modal_damping) and bool(others)
            ),
            "load_deflection sets the stiffness along its axis, at rest and with dynamic_to_static "
            f"in motion: the `stiffness` in it of mount {', '.join(curved)} is ignored; write "
            "0": bool(curved),
            "in a change between operations the loss factor is replaced by the equivalent damping "
            "ratio of each mode at resonance": (has_loss_factor(mounts) and switching is not None),
        }
    return [text for text, holds in texts.items() if holds]


def _overridden(case: Case, mounts: parts.Mounts) -> Iterator[str]:
    """Names of mounts whose stiffness along the axis stands behind their load over deflection."""
    for one in mount_entries(mounts):
        static, options = one.static, case.isolation
        if static is None or static.load_deflection is None or one.over_load is not None:
            continue
        axis = static.axis or (options.up if options is not None else "z")
        given = one.stiffness
        if given[DIRECTIONS.index(axis)] if isinstance(given, tuple) else given:
            yield one.name


def _rod(case: Case) -> Iterator[str]:
    train = case.machine.crank_train
    rod, share = train.rod, rod_share(train)
    if rod is None or rod.inertia is None:
        return
    between = rod.mass * train.rod_length**2 * share * (1.0 - share)
    if rod.inertia > between * (1.0 + NOTICEABLE):
        yield (
            f"the rod's moment of inertia is {rod.inertia:.4g} kg*m^2, more than the "
            f"{between:.4g} kg*m^2 of a rod whose material lies between its bearings: is it about "
            "the mass centre?"
        )


def _pitch_coupling(case: Case) -> Iterator[str]:
    """What the pitch model leaves out of the body's other five motions, as shares."""
    machine = case.machine
    built = _built(machine)
    if case.isolation is None or case.isolation.model != "pitch" or built is None:
        return
    body, mounts = built
    frame = build_frame(machine.crank_train.axis, machine.crank_train.stroke_axis)
    place = mounts.position - body.centre

    pitch = np.cross(frame.across, place)  # displacement of each mount for a unit of pitch
    heights = (place @ frame.stroke)[:, None] * np.cross(frame.across, frame.stroke)
    exact = _work(mounts, pitch, pitch)
    model = _work(mounts, pitch - heights, pitch - heights)
    if abs(exact - model) > NOTICEABLE * model:
        yield (
            f"the pitch model leaves out {100.0 * abs(exact - model) / model:.3g} % of the pitch "
            "stiffness, from mounts above or below the mass centre; rigid_body has it"
        )
    turned = body.inertia @ frame.across
    coupled = []
    for along in (frame.axis, frame.across, frame.stroke):
        if _coupled(mounts, pitch, np.broadcast_to(along, place.shape), max(exact, model)):
            coupled.append(f"motion along {_name(along)}")
    for about in (frame.axis, frame.stroke):
        by_mass = abs(float(about @ turned)) > NOTICEABLE * float(frame.across @ turned)
        if by_mass or _coupled(mounts, pitch, np.cross(about, place), max(exact, model)):
            coupled.append(f"turning about {_name(about)}")
    if coupled:
        yield (
            "pitch is coupled with " + ", ".join(coupled) + ": the pitch model is then an "
            "approximation, and rigid_body is exact"
        )


def _coupled(mounts: Mounts, pitch: Array, motion: Array, stiffness: float) -> bool:
    scale = math.sqrt(stiffness * _work(mounts, motion, motion))
    return abs(_work(mounts, pitch, motion)) > NOTICEABLE * scale


def _work(mounts: Mounts, first: Array, second: Array) -> float:
    """Stiffness between two motions given by their displacements (n, 3) at the mounts."""
    return float(np.einsum("ni,nij,nj->", first, mounts.stiffness, second))


def _name(direction: Array) -> str:
    return "xyz"[int(np.argmax(np.abs(direction)))]

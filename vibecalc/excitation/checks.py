"""Physical checks of the cylinders of an engine or a pump: firing order, angles, pressure."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from vibecalc.core.case.raw import listed
from vibecalc.errors import KeyPath, NumericalFailure, Problem, listing
from vibecalc.kinds import TRAIN
from vibecalc.parts.crank_train import turns
from vibecalc.parts.drive_checks import degrees, turn_problems
from vibecalc.parts.firing import CYCLES, TURN
from vibecalc.parts.tables import CrankTrain
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Does a pump draw anything?
# ----------------------------------------------------------------------------

CYCLE: KeyPath = ("machine", "crank_train", "pump_cycle")
#: pressure difference over bulk modulus: below, a compression takes no angle that could be followed
STIFFEST = 1e-6


@listing
def pump_problems(case: Case) -> Iterator[Problem]:
    """Problems of dead volume and bulk modulus, which have to leave something to be drawn."""
    if case.machine.kind != "pump" or not turns(case.machine.crank_train):
        return
    train = case.machine.crank_train
    given, bore = train.pump_cycle, train.bore
    if given is None or bore is None:
        return
    strain = (given.discharge_pressure - given.suction_pressure) / given.bulk_modulus
    # the offset makes the stroke a little longer than this, which draws a little more
    swept, grown = 0.5 * math.pi * bore**2 * train.crank_radius, math.expm1(min(strain, 50.0))
    if strain < STIFFEST:
        yield Problem(
            path=(*CYCLE, "bulk_modulus"),
            message="the liquid is too stiff for its pressures: its valves would open at once",
            found=f"it gives way by {strain:.3g} of its volume",
            allowed=f"{STIFFEST:g} or more: water and oil have 1.5 to 2.3 GPa",
            also=(*CYCLE, "discharge_pressure"),
        )
    elif not given.dead_volume * grown < swept:
        yield Problem(
            path=(*CYCLE, "dead_volume"),
            message="the pump delivers nothing: the liquid in the dead volume expands by more "
            "than the swept volume",
            found=f"{1e6 * given.dead_volume * grown:.4g} cm^3 of {1e6 * swept:.4g} cm^3",
            allowed=f"dead_volume below {1e6 * swept / grown:.4g} cm^3 at these pressures",
            also=(*CYCLE, "bulk_modulus"),
        )


# ----------------------------------------------------------------------------
# Do the cylinders of an engine fire where their cranks let them, with gas over the whole cycle?
# ----------------------------------------------------------------------------

#: rad; angles of seven cylinders are typed with two decimals of a degree
AGREES = math.radians(0.1)


@listing
def engine_problems(case: Case) -> Iterator[Problem]:
    """Problems of firing and of gas, of a machine of kind "engine"."""
    machine = case.machine
    if machine.kind != "engine" or machine.cycle is None:
        return
    train, cycle = machine.crank_train, CYCLES[machine.cycle]
    yield from [*_order(train, cycle)] or [*_angles(train, cycle)] or _phases(case)
    yield from [*_cards(train, cycle)] or _cycle(case)


def _order(train: CrankTrain, cycle: float) -> Iterator[Problem]:
    """A firing order is a permutation of the cylinders, its intervals fill the cycle."""
    order, names = train.firing_order, [cylinder.name for cylinder in train.cylinders]
    if not order:
        return
    path: KeyPath = (*TRAIN, "firing_order")
    left = [name for name in names if name not in order]
    if left and len(order) < len(names):
        yield Problem(
            path=path,
            message="the firing order lacks cylinders",
            found=listed(left),
            allowed=f"each of the {len(names)} cylinders once",
        )
    yield from _intervals(train.firing_intervals, len(order), cycle)


def _intervals(given: Sequence[float], count: int, cycle: float) -> Iterator[Problem]:
    path: KeyPath = (*TRAIN, "firing_intervals")
    if given and len(given) != count:
        yield Problem(
            path=path,
            message="one interval per cylinder is needed, the last one back to the first",
            found=f"{len(given)} intervals of {count} cylinders",
            allowed=f"{count} intervals",
            also=(*TRAIN, "firing_order"),
        )
    elif given and abs(sum(given) - cycle) > AGREES:
        yield Problem(
            path=path,
            message="the firing intervals must add up to the cycle",
            found=f"{degrees(sum(given))} together",
            allowed=degrees(cycle),
        )


def _angles(train: CrankTrain, cycle: float) -> Iterator[Problem]:
    for place, cylinder in enumerate(train.cylinders):
        angle = cylinder.firing_angle
        if angle is not None and angle >= cycle + AGREES:
            yield Problem(
                path=(*TRAIN, "cylinders", place, "firing_angle"),
                message="the firing angle is beyond the cycle",
                found=degrees(angle),
                allowed=f"0 deg to below {degrees(cycle)}",
            )


def _phases(case: Case) -> Iterator[Problem]:
    """A cylinder fires at a dead centre: the throws have to stand as the firing has them."""
    from vibecalc.excitation.model import firing_angle

    train = case.machine.crank_train
    reported = bool(train.firing_order) or any(c.firing_angle is not None for c in train.cylinders)
    if not reported:
        return
    angles = firing_angle(case.machine).tolist()
    off = [
        math.remainder(angle + cylinder.crank_phase - cylinder.bank_angle, TURN)
        for cylinder, angle in zip(train.cylinders, angles, strict=True)
    ]
    wrong = [place for place, one in enumerate(off) if abs(one) > AGREES]
    for place in wrong[:1]:
        cylinder, angle = train.cylinders[place], angles[place]
        wanted = math.fmod(cylinder.bank_angle - angle, TURN) % TURN
        has_angle = cylinder.firing_angle is not None
        path: KeyPath = (*TRAIN, "cylinders", place)
        yield Problem(
            path=(*path, "crank_phase"),
            message=f"cylinder {cylinder.name[:60]!r} fires at {degrees(angle)}, where its crank "
            "is not at top dead centre",
            found=f"crank_phase {degrees(cylinder.crank_phase)}"
            + (f", and {len(wrong) - 1} more like it" if len(wrong) > 1 else ""),
            allowed=f"{degrees(wanted)}, or no crank_phase at any cylinder: it then follows",
            hint="crank_phase = bank_angle - firing angle, modulo 360 deg",
            also=(*path, "firing_angle") if has_angle else (*TRAIN, "firing_order"),
        )


def _cards(train: CrankTrain, cycle: float) -> Iterator[Problem]:
    """Each card is a curve over one cycle, at a speed of its own."""
    path: KeyPath = (*TRAIN, "gas_cards")
    if len(train.gas_cards) == 1:
        yield Problem(
            path=path,
            message="a single card does not define the gas at other speeds",
            allowed="two cards or more, at different speeds, or gas_pressure for all speeds",
        )
    for place, card in enumerate(train.gas_cards):
        where: KeyPath = (*path, place, "gas_pressure")
        yield from turn_problems(where, "gas pressure", card.gas_pressure, cycle)
    interpolation = train.gas_interpolation
    if interpolation is not None and interpolation not in ("linear", "cubic"):
        yield Problem(
            path=(*TRAIN, "gas_interpolation"),
            message="the gas of an engine is interpolated by straight lines or a cubic spline",
            found=repr(interpolation),
            allowed="'linear' or 'cubic'",
        )


def _cycle(case: Case) -> Iterator[Problem]:
    """A computed cycle: its events in their order, its pressure one that it can have."""
    train = case.machine.crank_train
    given = train.gas_cycle
    if given is None or train.bore is None or not turns(train):
        return
    from vibecalc.excitation.model import cycle_of, gas_cards

    path: KeyPath = (*TRAIN, "gas_cycle")
    made = cycle_of(case.machine)
    held = ("injection_ends",) if given.kind == "diesel" else ()
    events = ("inlet_closes", "combustion_starts", "combustion_ends", *held, "exhaust_opens")
    for earlier, later in pairwise(events):
        before, after = getattr(made, earlier), getattr(made, later)
        if after < before or (after == before and later not in held):
            said = [one for one in (later, earlier) if getattr(given, one) is not None]
            yield Problem(
                path=(*path, *said[:1]),
                message=f"{later} comes before {earlier}",
                found=f"{degrees(after)} and {degrees(before)}",
                allowed=", ".join(events) + ", in this order",
            )
            return
    if not made.exhaust_opens < math.pi:
        yield Problem(
            path=(*path, "exhaust_opens"),
            message="the exhaust opens before the lower dead centre",
            found=degrees(made.exhaust_opens),
            allowed="below 180 deg",
        )
        return
    try:
        gas_cards(case.machine)
    except NumericalFailure as error:
        key = "peak_pressure" if given.peak_pressure is not None else "mean_indicated_pressure"
        yield Problem(
            path=(*path, key),
            message=str(error),
            allowed="a pressure that this cycle can reach",
        )

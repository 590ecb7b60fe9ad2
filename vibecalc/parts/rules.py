"""Rules of one kind of machine: what an engine and a pump lack, or say twice; units of matrices."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from vibecalc.core.case.raw import misspelt, table_at, tables_at
from vibecalc.core.case.rules import Row, at, at_most_one, both, needs, one_of
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.kinds import FINDING_MOTORS, ROLL, TRAIN, motor_kind
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# An engine: gas and firing said once, and what its tables need.
# ----------------------------------------------------------------------------

GAS = ("gas_pressure", "gas_cards", "gas_cycle", "tangential_effort")


def _line_asked(row: Row) -> bool:
    """Whether anything is asked of the torsion of a shaft line."""
    return "damper_design" in row.case or "torsion" in table_at(row.case, "response")


def _of_one_turn(row: Row) -> Iterator[Problem]:
    for place, cylinder in tables_at(row.data, "cylinders"):
        if "gas_force" in cylinder:
            yield row.problem(
                (*row.path, "cylinders", place, "gas_force"),
                "gas_force covers one revolution, but an engine needs the gas of its cycle",
                allowed=f"one of {', '.join(GAS)} in [machine.crank_train], with a pressure_scale "
                "for this cylinder",
                also=("machine", "kind"),
            )


def _firing_counts(row: Row) -> bool:
    """Whether anything is asked that wants to know when cylinders fire."""
    loads = "bearing_loads" in row.case and not row.data.keys().isdisjoint(GAS)
    return loads or _line_asked(row)


def _firing(row: Row) -> Iterator[Problem]:
    """When each cylinder fires, in one of two ways."""
    cylinders = tables_at(row.data, "cylinders")
    with_angle = [place for place, cylinder in cylinders if "firing_angle" in cylinder]
    path: KeyPath = (*row.path, "cylinders")
    if "firing_order" in row and with_angle:
        yield row.problem(
            (*path, with_angle[0], "firing_angle"),
            "firing_angle and firing_order are mutually exclusive",
            allowed="firing_order, or a firing_angle for every cylinder",
            also="firing_order",
        )
    elif with_angle:
        for place, cylinder in cylinders:
            if place not in with_angle:
                yield row.problem(
                    (*path, place),
                    f"cylinder {str(cylinder.get('name', place + 1))[:60]!r} has no "
                    "firing_angle, and others have one",
                    allowed="a firing_angle for every cylinder, or firing_order",
                    also=(*path, with_angle[0], "firing_angle"),
                )
    elif (
        _firing_counts(row)
        and not row["firing_order"]
        and not (row.machine.get("cycle") == "two_stroke" and _throws_told(cylinders))
        and len(cylinders) > 1
        and not misspelt(row.data, row.path, "firing_order")
        and not any(misspelt(one, (*path, place), "firing_angle") for place, one in cylinders)
    ):
        two = row.machine.get("cycle") == "two_stroke"
        yield row.problem(
            "",
            "[machine.crank_train] does not define when its cylinders fire",
            allowed="firing_order = ['1', '3', '4', '2'], or "
            f"a firing_angle{' or crank_phase' if two else ''} for every cylinder",
            hint="without these all would fire at once"
            if two
            else "a throw passes its top dead centre twice in four strokes and fires once",
        )


def _throws_told(cylinders: Sequence[tuple[int, Mapping[str, Any]]]) -> bool:
    """Whether the case says how the throws stand: in two strokes a cylinder fires at each turn."""
    told = {"crank_phase", "bank_angle", "articulated"}
    return any(not told.isdisjoint(cylinder) for _, cylinder in cylinders)


OF_ENGINE = (
    at_most_one(
        "shaft_line",
        "rotor",
        allowed="one of them; the stations of the line have inertias of their own",
    ),
    at(
        "crank_train",
        one_of(
            *GAS,
            when=_line_asked,
            hint="for no gas at all set pressure_scale = 0 for each cylinder",
        ),
        *(needs(key, "bore", "the gas force is pressure times area") for key in GAS),
        _of_one_turn,
        _firing,
        needs("firing_intervals", "firing_order"),
    ),
)

# ----------------------------------------------------------------------------
# A pump: what its pressure needs.
# ----------------------------------------------------------------------------


OF_PUMP = (
    at(
        "crank_train",
        needs("", "pump_cycle", "the pressures between which a pump works"),
        needs("", "bore", "the diameter of the plunger, on which the pressure acts"),
    ),
)

# ----------------------------------------------------------------------------
# What impacts and the roll of a machine need of it.
# ----------------------------------------------------------------------------


def _gas_needs(row: Row, one: str, other: str, instead: str) -> Iterator[Problem]:
    """A key of the gas without the other one, where `row` asks for forces."""
    if one in table_at(row.case, *TRAIN) and other not in table_at(row.case, *TRAIN):
        yield row.problem(
            (*TRAIN, one),
            f"{row.header()} cannot use {one} without {other}: the gas force is pressure "
            "times area",
            allowed=f"{other} with it, or {instead}",
        )


def _gas_whole(row: Row, instead: str) -> Iterator[Problem]:
    """A bore without pressure, or a pressure without bore."""
    yield from _gas_needs(row, "bore", "gas_pressure", instead)
    yield from _gas_needs(row, "gas_pressure", "bore", instead)


def gas_of_impacts(row: Row) -> Iterator[Problem]:
    """Yield half of what makes a force of the gas, for [response.impact]."""
    yield from _gas_whole(row, "neither for impacts due to inertia alone")


def gas_of_bearings(row: Row) -> Iterator[Problem]:
    """Yield a pressure without area, for [bearing_loads]."""
    yield from _gas_needs(row, "gas_pressure", "bore", "neither for loads due to inertia alone")


def needed_of_roll(row: Row) -> Iterator[Problem]:
    """Yield what [response.roll], start_up and control miss of the machine."""
    asked = [name for name in ROLL if isinstance(row.data.get(name), dict)]
    machine = row.case.get("machine")
    if not asked or not isinstance(machine, dict):
        return
    first: KeyPath = (*row.path, asked[0])
    need = f"{both([f'[response.{name}]' for name in asked])} need{'s' * (len(asked) == 1)}"
    for part, what in (
        ("rotor", "the inertia of everything that turns with the crankshaft"),
        ("shell", "the inertia of what the motor's stator and the cylinders are fixed to"),
    ):
        if part not in machine:
            yield row.problem(first, f"{need} [machine.{part}]", allowed=f"inertia: {what}")
    motor = motor_kind(machine)
    if motor not in FINDING_MOTORS:
        yield row.problem(
            first,
            f"{need} a motor that determines the speed",
            found=f"a motor of kind {motor!r}" if motor else "no motor",
            allowed=f"[machine.motor] of kind {', '.join(map(repr, FINDING_MOTORS))}",
            also=("machine", "motor"),
        )
    placed = [part for part in ("body", "mounts") if part in machine]
    if placed:
        yield row.problem(
            ("machine", placed[0]),
            f"{need} no [machine.{placed[0]}]: the shell rolls about the crank axis, as one body",
            allowed="[machine.shell], with stiffness and damping of its mounts",
            hint="a body on mounts with six degrees of freedom, at a given speed, is another case",
            also=first,
        )
    cylinders = tables_at(machine, "crank_train", "cylinders")
    if not all("gas_force" in cylinder for _, cylinder in cylinders):
        yield from _gas_whole(replace(row, path=first), "a gas_force for each cylinder")


# ----------------------------------------------------------------------------
# Units of matrices.
# ----------------------------------------------------------------------------

_BLOCKS = ("translation", "coupling", "rotation")


def matrix_units(row: Row) -> Iterator[Problem]:
    """Yield the units of blocks that are no such units."""
    units, si_units = row.entries("units"), vars(row.model)["SI"]
    for position, unit in enumerate(units if len(units) == len(_BLOCKS) else ()):
        if isinstance(unit, str) and 0 < len(unit) <= 80:
            yield from _unit(row, position, unit, si_units[position])


def _unit(row: Row, position: int, unit: str, si: str) -> Iterator[Problem]:
    said, found, hint = "", f"{unit!r}", ""
    try:
        factor = convert(1.0, unit, si)
        if not 1e-100 < factor < 1e100:
            said = "too far from SI to compute with"
    except UnitError as error:
        said, hint = error.message, error.hint
        if said == "wrong dimension":
            found = f"{unit!r}, {error.found}"
    if "rad" in unit:
        hint = "an angle counts as a plain number here: leave rad out"
    if said:
        yield row.problem(
            (*row.path, "units", position),
            f"{row.path[-1]}, unit of the {_BLOCKS[position]} block: {said}",
            found=found,
            allowed=f"a unit that converts to {si}",
            hint=hint,
        )

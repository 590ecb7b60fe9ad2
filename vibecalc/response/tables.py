"""What is asked of the response of a machine on its suspension."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    Length,
    Name,
    Number,
    RunUp,
    Table,
    Time,
    Unit,
    key,
    later,
)
from vibecalc.core.case.raw import tables_at
from vibecalc.core.case.rules import Row, needs, once, refers, refuse, unique, wants
from vibecalc.core.results.named import named
from vibecalc.errors import KeyPath, Problem
from vibecalc.parts.tables import LOADS, Loads, Names, Throws, cylinders_in, shaking_acts

if TYPE_CHECKING:
    from vibecalc.absorber.asked_tables import AbsorberResponse
    from vibecalc.roll.tables import Control, Roll, StartUp
    from vibecalc.torsion.tables import Torsion
else:
    globals().update(
        later(
            {
                "vibecalc.absorber.asked_tables": "AbsorberResponse",
                "vibecalc.roll.tables": "Control Roll StartUp",
                "vibecalc.torsion.tables": "Torsion",
            }
        )
    )


class Operation(Table):
    """One operating mode of the machine: the working cylinders, and a weight for averages."""

    name: Name = key("label in tables and `where`")
    working: Names = key("names of the working cylinders")
    weight: Number = key("share in the weighted energy", 1.0, ge=0)
    RULES = cylinders_in("working")


class Balance(Table):
    """One balancing variant: cylinders whose rotating mass is balanced by weights."""

    name: Name = key("label in tables and `where`")
    balanced_for: Throws = key("names of the cylinders; none: no weights")
    RULES = cylinders_in("balanced_for")


class Switching(Table):
    """The change from one operation to the other and back, over time."""

    between: tuple[Name, Name] = key("names of two operations")
    run_down: Time = key("from operating speed to rest, linear in time", gt=0)
    stand: Time = key("at rest", 0.0, alias="dwell", ge=0)
    run_up: Time = key("from rest to operating speed, linear in time", gt=0)
    after: Time = key("time computed at operating speed afterwards", 1.0, alias="time_after", gt=0)
    reverses: bool = key("the crank turns the other way afterwards", True, strict=True)
    crank_angle: Angle = key("at the start of the change", 0.0)
    settled: Number = key(
        "deviation from the steady state at which it counts as settled",
        0.05,
        alias="settling_tolerance",
        gt=0,
        lt=1,
    )
    RULES = (
        refuse(
            "",
            "[response.switching] needs two operations, and there are none",
            lambda t: not tables_at(t.case, "response", "operations"),
            "operations in [response], two of them named in `between`",
        ),
        refers("between", "response.operations", "operation"),
        refuse(
            "between",
            "a change needs two different operations",
            lambda t: len({*map(str, t.entries("between"))}) == 1,
            "two different names",
            found="{between}",
        ),
    )


Clearance = Annotated[float, Field(gt=0), Unit("m")]


class Impact(Table):
    """Impacts in joints with clearance, as statistics over many runs."""

    method: Literal["event_exact", "euler", "heun", "rk4", "dormand_prince"] = key(
        "exact between contacts, or fixed time steps", "event_exact"
    )
    steps: int = key(
        "steps per revolution, for the fixed-step methods", 1024, strict=True, ge=64, le=1_000_000
    )
    pressure: Literal["towards_crank", "towards_head"] = key(
        "sense in which the gas pushes the piston", "towards_crank"
    )
    clearances: tuple[Clearance, ...] = key(
        "of the wrist pin, instead of its own: one study per value", (), max_length=32
    )
    members: int = key(
        "number of runs with slightly different starts", 64, strict=True, ge=2, le=10_000
    )
    revolutions: int = key("revolutions of each run that count", 30, strict=True, ge=2, le=10_000)
    discard: int = key("initial revolutions that do not count", 10, strict=True, ge=0, le=10_000)
    orders: int = key("highest order of the force spectrum", 100, strict=True, ge=1, le=2000)
    perturbation: Length = key(
        "initial distance of two neighbouring runs, for the divergence time", 2.54e-11, gt=0
    )
    RULES = (
        wants("machine.joints", "joints with clearance and stiffness, of the wrist pin at least"),
        "vibecalc.parts.rules:gas_of_impacts",
        once("clearances", "clearance"),
    )


_FIRST: KeyPath = ("response", "operations", 0)
_ASKED = ("WITHOUT_A_BODY", "OF_THE_BODY")


def _on_mounts(row: Row) -> Iterator[Problem]:
    """The motion of the body needs a body on mounts."""
    alone, of_the_body = (named(f"vibecalc.kinds:{name}") for name in _ASKED)
    if row.data.keys().isdisjoint(alone) or any(row.data.get(key) for key in of_the_body):
        without = f"impacts alone do not need it: omit {', '.join(of_the_body)}"
        hint = without if "impact" in row else "omit [response] if only forces are required"
        for part in ("body", "mounts"):
            yield from wants(f"machine.{part}", hint=hint)(row)


def _of_roll(row: Row) -> Iterator[Problem]:
    if not row.data.keys().isdisjoint(named("vibecalc.kinds:ROLL")):
        yield from named("vibecalc.parts.rules:needed_of_roll")(row)


class Response(Table):
    """Motion under the forces of the crank train: body on its mounts, impacts, roll."""

    method: Literal["modal", "direct"] = key(
        "modal superposition, or a direct solution per order", "direct"
    )
    loads: Loads | None = key(f"{LOADS}; default: all that the case gives", None, min_length=1)
    energies: bool = key("kinetic and potential energy, mean and peak", False, strict=True)
    operations: tuple[Operation, ...] = key(
        "operating modes to compare by their energies", (), max_length=16
    )
    balances: tuple[Balance, ...] = key(
        "balancing variants to combine with them; default: that of the case", (), max_length=16
    )
    run_up: RunUp | None = key("also energies over a speed range", None)
    switching: Switching | None = key("also the change between operations, over time", None)
    impact: Impact | None = key("also impacts in joints with clearance", None)
    roll: Roll | None = key("steady roll of the shell, with the speed from the motor", None)
    start_up: StartUp | None = key("roll from rest to running, over time", None)
    control: Control | None = key("roll with control of the motor", None)
    absorber: AbsorberResponse | None = key("of a primary system and its absorber", None)
    torsion: Torsion | None = key("torsional vibration of the shaft line", None)
    RULES = (
        _on_mounts,
        shaking_acts("the torque acts together with it"),
        needs(
            "balances",
            "operations",
            "each balance is computed for each operation",
            'operations = [{ name = "all", working = ["1", "2"] }], for example',
        ),
        unique("operations"),
        refuse(
            (*_FIRST, "weight"),
            "no operation has a weight above zero, so there is no weighted energy",
            lambda t: (
                t.entries("operations")
                and not any(operation.number("weight") for operation in t.each("operations"))
            ),
            "a weight above zero in one of them at least",
        ),
        unique("balances"),
        _of_roll,
    )

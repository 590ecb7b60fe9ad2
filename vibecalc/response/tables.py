"""What is asked of the response of a machine on its suspension."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import Angle, Length, Name, Number, RunUp, Table, Time, Unit, later
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
    """One way of running the machine: the cylinders that work, with a weight in averages."""

    name: Name = Field(description="label used in tables and in `where`")
    working: Names = Field(description="names of the cylinders that work")
    weight: Number = Field(1.0, ge=0, description="share in the weighted energy")
    RULES = cylinders_in("working")


class Balance(Table):
    """One way of balancing the crankshaft: the throws whose rotating mass weights cancel."""

    name: Name = Field(description="label used in tables and in `where`")
    balanced_for: Throws = Field(description="names of the cylinders; none: no weights")
    RULES = cylinders_in("balanced_for")


class Switching(Table):
    """The change from one operation to the other and back, in time."""

    between: tuple[Name, Name] = Field(description="names of two operations")
    run_down: Time = Field(gt=0, description="from operating speed to rest, linear in time")
    stand: Time = Field(0.0, ge=0, description="at rest")
    run_up: Time = Field(gt=0, description="from rest to operating speed, linear in time")
    after: Time = Field(1.0, gt=0, description="time watched at operating speed afterwards")
    reverses: bool = Field(True, strict=True, description="the crank turns the other way after")
    crank_angle: Angle = Field(0.0, description="where the change begins")
    settled: Number = Field(
        0.05, gt=0, lt=1, description="deviation from the steady state that counts as settled"
    )
    RULES = (
        refuse(
            "",
            "[response.switching] goes between two operations, and there are none",
            lambda t: not tables_at(t.case, "response", "operations"),
            "operations in [response], two of which `between` names",
        ),
        refers("between", "response.operations", "operation"),
        refuse(
            "between",
            "a change goes from one operation to another one",
            lambda t: len({*map(str, t.entries("between"))}) == 1,
            "two different names",
            found="{between}",
        ),
    )


Clearance = Annotated[float, Field(gt=0), Unit("m")]


class Impact(Table):
    """Impacts in the joints with play, as statistics over many runs."""

    method: Literal["event_exact", "euler", "heun", "rk4", "dormand_prince"] = Field(
        "event_exact", description="closed form between contacts, or fixed steps"
    )
    steps: Annotated[int, Field(strict=True, ge=64, le=1_000_000)] = Field(
        1024, description="steps per revolution, for the fixed-step methods"
    )
    pressure: Literal["towards_crank", "towards_head"] = Field(
        "towards_crank", description="sense in which the gas pushes the piston"
    )
    clearances: Annotated[tuple[Clearance, ...], Field(max_length=32)] = Field(
        (), description="of the wrist pin, instead of its own: one study for each"
    )
    members: Annotated[int, Field(strict=True, ge=2, le=10_000)] = Field(
        64, description="runs with slightly different starts"
    )
    revolutions: Annotated[int, Field(strict=True, ge=2, le=10_000)] = Field(
        30, description="revolutions that count, of each run"
    )
    discard: Annotated[int, Field(strict=True, ge=0, le=10_000)] = Field(
        10, description="revolutions before them, to forget the start"
    )
    orders: Annotated[int, Field(strict=True, ge=1, le=2000)] = Field(
        100, description="highest order of the force spectrum"
    )
    perturbation: Length = Field(
        2.54e-11, gt=0, description="distance of the neighbour whose parting is timed"
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
        without = f"impacts alone need none: leave {', '.join(of_the_body)} out"
        hint = without if "impact" in row else "leave [response] out for forces only"
        for part in ("body", "mounts"):
            yield from wants(f"machine.{part}", hint=hint)(row)


def _of_roll(row: Row) -> Iterator[Problem]:
    if not row.data.keys().isdisjoint(named("vibecalc.kinds:ROLL")):
        yield from named("vibecalc.parts.rules:needed_of_roll")(row)


class Response(Table):
    """Motion under the forces of the crank train: the body on its suspension, impacts, roll."""

    method: Literal["modal", "direct"] = Field(
        "direct", description="superposition of modes, or one solve per order"
    )
    loads: Loads | None = Field(
        None, min_length=1, description=f"{LOADS}; default: all that the case gives"
    )
    energies: bool = Field(
        False, strict=True, description="kinetic and potential energy, mean and peak"
    )
    operations: Annotated[tuple[Operation, ...], Field(max_length=16)] = Field(
        (), description="ways of running to compare by their energies"
    )
    balances: Annotated[tuple[Balance, ...], Field(max_length=16)] = Field(
        (), description="ways of balancing to combine them with; default: that of the case"
    )
    run_up: RunUp | None = Field(None, description="also energies over a range of speeds")
    switching: Switching | None = Field(None, description="also the change between operations")
    impact: Impact | None = Field(None, description="also impacts in the joints with play")
    roll: Roll | None = Field(None, description="roll of the shell with the motor's own speed")
    start_up: StartUp | None = Field(None, description="roll from rest to running, in time")
    control: Control | None = Field(None, description="roll under control of the motor")
    absorber: AbsorberResponse | None = Field(
        None, description="of a primary system and its absorber"
    )
    torsion: Torsion | None = Field(None, description="of the shaft line of an engine")
    RULES = (
        _on_mounts,
        shaking_acts("the torque acts together with it"),
        needs(
            "balances",
            "operations",
            "ways of balancing are combined with ways of running",
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

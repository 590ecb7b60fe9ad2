"""[response.torsion.transient] in a case: what happens in time, and the cycles that are counted."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from vibecalc.core.case.fields import (
    Angle,
    AngularSpeed,
    Frequency,
    Moment,
    Name,
    Number,
    Stress,
    Table,
    Time,
    Unit,
)
from vibecalc.core.case.rules import (
    ascending,
    by_kind,
    one_of,
    ordered,
    refers,
    same_length,
)
from vibecalc.torsion.study_results import PASSAGES

AngularAcceleration = Annotated[float, Field(gt=0), Unit("rad/s^2")]

#: changes of which the crank keeps its speed
AT_CONSTANT_SPEED = ("load_step", "misfire_onset", "short_circuit", "torque_history")

# ----------------------------------------------------------------------------
# What a section bears, and how its cycles are counted.
# ----------------------------------------------------------------------------


class FatigueLine(Table):
    """An S-N line: N = cycles (strength / amplitude)^slope down to its knee."""

    stress: Stress | None = Field(
        None, gt=0, description="amplitude of the shear stress at the knee"
    )
    torque: Moment | None = Field(
        None, gt=0, description="amplitude of the torque at the knee instead, on its own shaft"
    )
    cycles: Number = Field(1e6, ge=1e3, le=1e12, description="at the knee")
    slope: Number = Field(5.0, ge=1, le=50, description="k of the line above the knee")
    below: Literal["elementary", "haibach", "original"] = Field(
        "elementary",
        description="the knee: the same slope, 2 k - 1, or no damage at all",
    )
    RULES = (one_of("stress", "torque"),)


class CycleCounting(Table):
    """Cycles of the torque of sections over the change, by the rainflow method of ASTM E1049."""

    sections: Annotated[tuple[Name, ...], Field(max_length=64)] = Field(
        (), description="names of shafts; default: all sections of the line"
    )
    bins: Annotated[int, Field(strict=True, ge=2, le=256)] = Field(
        16, description="equal ones, up to the largest range of each section"
    )
    ignore: Number = Field(
        0.01, ge=0, lt=1, description="share of the largest range that a cycle has to reach"
    )
    slope: Number = Field(
        5.0, ge=1, le=50, description="of a section without an S-N line, for the equivalent number"
    )
    changes: Number = Field(
        1.0, gt=0, le=1e9, description="how many such changes the line goes through in its life"
    )


# ----------------------------------------------------------------------------
# Torques in time.
# ----------------------------------------------------------------------------


class DecayingTorque(Table):
    """amplitude exp(-t / time_constant) sin(2 pi frequency t + phase) from the change on."""

    amplitude: Moment = Field(description="at its begin, on its own shaft; positive brakes")
    frequency: Frequency = Field(
        0.0, ge=0, description="of the grid or twice that; 0: a torque that only decays"
    )
    time_constant: Time = Field(gt=0, description="in which it falls to 1 / e")
    phase: Angle = Field(0.0, description="of the sine; 90 deg for one of frequency 0")


Times = Annotated[tuple[Time, ...], Field(min_length=2, max_length=2000)]
Torques = Annotated[tuple[Moment, ...], Field(min_length=2, max_length=2000)]


class TorqueTable(Table):
    """A torque against the time, straight lines between the entries."""

    time: Times = Field(description="from the change on, ascending")
    torque: Torques = Field(
        description="on its own shaft, one per time; positive brakes more than before"
    )
    RULES = (same_length("time", "torque"), ascending("time", 0.0))


_PASS = "from to | acceleration duration"


class Transient(Table):
    """A change in time: through criticals, a step or jolt of the torque, two parts to one speed."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    kind: Literal[
        "run_up", "run_down", "start", "stop", "load_step", "misfire_onset", "short_circuit",
        "torque_history", "clutch_in",
    ] = Field(description="what happens")  # fmt: skip
    start: AngularSpeed | None = Field(
        None, alias="from", ge=0, description="speed at the begin, of run_up, run_down and stop"
    )
    stop: AngularSpeed | None = Field(
        None, alias="to", ge=0, description="speed at the end, of run_up, run_down and start"
    )
    acceleration: AngularAcceleration | None = Field(
        None, description="largest magnitude; it grows and fades evenly"
    )
    duration: Time | None = Field(None, gt=0, description="instead of acceleration")
    on: Name | None = Field(None, description="name of the station that the torque acts on")
    torque: Moment | None = Field(
        None, description="of a load step, on its own shaft; positive brakes more than before"
    )
    cylinder: Name | None = Field(None, description="name of the cylinder that stops firing")
    terms: Annotated[tuple[DecayingTorque, ...], Field(min_length=1, max_length=16)] = Field(
        (), description="air-gap torque of a short circuit, a sum of decaying sines"
    )
    history: TorqueTable | None = Field(
        None, description="a torque over the time: a table or a CSV"
    )
    clutch: Name | None = Field(None, description="name of the shaft that is the clutch")
    driven_speed: AngularSpeed | None = Field(
        None, ge=0, description="of what the clutch takes along, before, on the clutch's own shaft"
    )
    friction_torque: Moment | None = Field(
        None, gt=0, description="that the clutch slips at, on its own shaft"
    )
    engaging_time: Time | None = Field(
        None, gt=0, description="in which that grows along a straight line from 0; default: at once"
    )
    before: Time = Field(0.0, ge=0, description="time at the first state that is also computed")
    after: Time = Field(1.0, gt=0, description="time watched afterwards")
    counting: CycleCounting | None = Field(
        None, description="also count the cycles of torque and stress"
    )
    RULES = (
        refers("on", "machine.shaft_line.stations", "station"),
        refers("cylinder", "machine.crank_train.cylinders", "cylinder"),
        by_kind(
            "change",
            run_up=_PASS,
            run_down=_PASS,
            start="to | acceleration duration",
            stop="from | acceleration duration",
            load_step="on torque",
            misfire_onset="cylinder",
            short_circuit="on terms",
            torque_history="on history",
            clutch_in="clutch driven_speed friction_torque | engaging_time",
        ),
        one_of("acceleration", "duration", when=lambda t: t["kind"] in PASSAGES),
        ordered(
            "from",
            "to",
            "a run-up goes from a lower speed to a higher one",
            when=lambda t: t["kind"] == "run_up",
        ),
        ordered(
            "to",
            "from",
            "a run-down goes from a higher speed to a lower one",
            when=lambda t: t["kind"] == "run_down",
        ),
    )

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
    key,
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

    stress: Stress | None = key("amplitude of the shear stress at the knee", None, gt=0)
    torque: Moment | None = key(
        "amplitude of the torque at the knee instead, on its own shaft", None, gt=0
    )
    cycles: Number = key("at the knee", 1e6, ge=1e3, le=1e12)
    slope: Number = key("k of the line above the knee", 5.0, ge=1, le=50)
    below: Literal["elementary", "haibach", "original"] = key(
        "the knee: the same slope, 2 k - 1, or no damage at all", "elementary"
    )
    RULES = (one_of("stress", "torque"),)


class CycleCounting(Table):
    """Cycles of the torque of sections over the change, by the rainflow method of ASTM E1049."""

    sections: tuple[Name, ...] = key(
        "names of shafts; default: all sections of the line", (), max_length=64
    )
    bins: int = key(
        "equal ones, up to the largest range of each section", 16, strict=True, ge=2, le=256
    )
    ignore: Number = key("share of the largest range that a cycle has to reach", 0.01, ge=0, lt=1)
    slope: Number = key(
        "of a section without an S-N line, for the equivalent number", 5.0, ge=1, le=50
    )
    changes: Number = key(
        "how many such changes the line goes through in its life", 1.0, gt=0, le=1e9
    )


# ----------------------------------------------------------------------------
# Torques in time.
# ----------------------------------------------------------------------------


class DecayingTorque(Table):
    """amplitude exp(-t / time_constant) sin(2 pi frequency t + phase) from the change on."""

    amplitude: Moment = key("at its begin, on its own shaft; positive brakes")
    frequency: Frequency = key("of the grid or twice that; 0: a torque that only decays", 0.0, ge=0)
    time_constant: Time = key("in which it falls to 1 / e", gt=0)
    phase: Angle = key("of the sine; 90 deg for one of frequency 0", 0.0)


Times = Annotated[tuple[Time, ...], Field(min_length=2, max_length=2000)]
Torques = Annotated[tuple[Moment, ...], Field(min_length=2, max_length=2000)]


class TorqueTable(Table):
    """A torque against the time, straight lines between the entries."""

    time: Times = key("from the change on, ascending")
    torque: Torques = key("on its own shaft, one per time; positive brakes more than before")
    RULES = (same_length("time", "torque"), ascending("time", 0.0))


_PASS = "from to | acceleration duration"


class Transient(Table):
    """A change in time: through criticals, a step or jolt of the torque, two parts to one speed."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    kind: Literal[
        "run_up", "run_down", "start", "stop", "load_step", "misfire_onset", "short_circuit",
        "torque_history", "clutch_in",
    ] = key("what happens")  # fmt: skip
    start: AngularSpeed | None = key(
        "speed at the begin, of run_up, run_down and stop", None, alias="from", ge=0
    )
    stop: AngularSpeed | None = key(
        "speed at the end, of run_up, run_down and start", None, alias="to", ge=0
    )
    acceleration: AngularAcceleration | None = key(
        "largest magnitude; it grows and fades evenly", None
    )
    duration: Time | None = key("instead of acceleration", None, gt=0)
    on: Name | None = key("name of the station that the torque acts on", None)
    torque: Moment | None = key(
        "of a load step, on its own shaft; positive brakes more than before", None
    )
    cylinder: Name | None = key("name of the cylinder that stops firing", None)
    terms: tuple[DecayingTorque, ...] = key(
        "air-gap torque of a short circuit, a sum of decaying sines",
        (),
        min_length=1,
        max_length=16,
    )
    history: TorqueTable | None = key("a torque over the time: a table or a CSV", None)
    clutch: Name | None = key("name of the shaft that is the clutch", None)
    driven_speed: AngularSpeed | None = key(
        "of what the clutch takes along, before, on the clutch's own shaft", None, ge=0
    )
    friction_torque: Moment | None = key("that the clutch slips at, on its own shaft", None, gt=0)
    engaging_time: Time | None = key(
        "in which that grows along a straight line from 0; default: at once", None, gt=0
    )
    before: Time = key("time at the first state that is also computed", 0.0, ge=0)
    after: Time = key("time watched afterwards", 1.0, gt=0)
    counting: CycleCounting | None = key("also count the cycles of torque and stress", None)
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

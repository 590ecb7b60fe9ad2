"""Tables of the case on the roll of a machine: its parts, its motion, its start-up, its control."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    AngularStiffness,
    Force,
    Inertia,
    Level,
    Moment,
    Number,
    Table,
    Time,
    Unit,
    key,
)
from vibecalc.core.case.rules import (
    Row,
    ascending,
    at_most_one,
    needs,
    once,
    ordered,
    refuse,
    same_length,
)

# ----------------------------------------------------------------------------
# The parts of a machine whose shell turns about the crank axis: rotor, shell, friction.
# ----------------------------------------------------------------------------


class Rotor(Table):
    """The rotating parts, besides the rotating masses of the crank train."""

    inertia: Inertia = key("about the crank axis, with coupling and flywheel", gt=0)


class Shell(Table):
    """Stator, housing and baseplate as one rigid body that turns about the crank axis."""

    inertia: Inertia = key("about the crank axis, without what moves in it", gt=0)
    stiffness: AngularStiffness = key(
        "of the mounts in roll; with zero damping too: no mounts", 0.0, ge=0
    )
    damping: AngularDamping = key("of the mounts in roll; negative: would supply energy", 0.0, ge=0)


class Friction(Table):
    """Friction of crankshaft and pistons in the shell."""

    torque: Moment = key("constant, on the crankshaft; negative: drives it", 0.0, ge=0)
    viscous: AngularDamping = key("on the crankshaft; negative: would supply energy", 0.0, ge=0)
    piston_force: Force = key("constant, at each piston; negative: drives it", 0.0, ge=0)


# ----------------------------------------------------------------------------
# What is asked of the roll of a machine: its periodic motion, and how it gets there.
# ----------------------------------------------------------------------------

RollMethod = Literal["collocation", "fourier", "shooting", "dop853", "rk4", "euler"]


#: methods that need `step`; for the others it is without effect, which is a caution
STEPPING = ("euler", "rk4")


def _uses(row: Row, *methods: str) -> bool:
    """Whether the motion is computed, or compared, by one of these methods."""
    return any(name in methods for name in (row["method"], *row.entries("compare")))


class Roll(Table):
    """Steady motion of rotor, pistons and shell, with the speed from the motor."""

    method: RollMethod = key("Gauss collocation on panels, or another method", "collocation")
    orders: int = key("highest harmonic of the spectra", 10, strict=True, ge=1, le=400)
    points: Annotated[int, Field(strict=True, ge=1, le=4096)] | None = key(
        "nodes of each panel (collocation) or of a turn (fourier); default: from the tolerance",
        None,
    )
    step: Time | None = key("time step, for the methods euler and rk4", None, gt=0)
    started_at: AngularSpeed | None = key(
        "crank speed at crank angle zero with the shell at rest, which fixes the angular "
        "momentum of a machine without mounts; default: the shell does not drift",
        None,
        gt=0,
    )
    compare: tuple[RollMethod, ...] = key("methods to compare", (), max_length=6)
    interpolations: bool = key(
        "also the spread between interpolations of the gas tables", False, strict=True
    )
    sensitivity: bool = key(
        "also sensitivities of the levels, and the effect of 10 % more and less of each parameter",
        False,
        strict=True,
    )
    classical: bool = key(
        "also the forces at constant speed with the shell fixed", False, strict=True
    )
    RULES = (
        once("compare", "method"),
        refuse(
            "points",
            "points is for the methods collocation and fourier",
            lambda t: "points" in t and not _uses(t, "collocation", "fourier"),
            "no points, or one of these methods",
            found="method = {method!r}",
            also="method",
        ),
        refuse(
            "",
            "the methods euler and rk4 need a step",
            lambda t: "step" not in t and _uses(t, *STEPPING),
            "step = '0.1 ms', for example",
        ),
    )


#: below zero the gas would pull where it pushes
Factor = Annotated[float, Field(ge=0), Unit("")]


class Load(Table):
    """Factor on the gas forces in time, constant from each time to the next."""

    time: tuple[Time, ...] = key("ascending, the first is 0", min_length=1, max_length=2000)
    factor: tuple[Factor, ...] = key(
        "on the gas forces from that time on; 0: none", min_length=1, max_length=2000
    )
    RULES = (same_length("time", "factor"), ascending("time", start=0.0))


class StartUp(Table):
    """Start-up over time, from rest or a given speed past the breakdown torque."""

    duration: Time = key("computed time", gt=0)
    crank_angle: Angle = key("of the crank at the start", 0.0)
    speed: AngularSpeed = key("of the crank relative to the shell at the start", 0.0)
    load: Load | None = key("factor on the gas forces over time; default: 1", None)
    settled: Number = key(
        "change of the shell's acceleration per turn at which it counts as settled",
        0.01,
        alias="settling_tolerance",
        gt=0,
        lt=1,
    )
    angles: Annotated[int, Field(strict=True, ge=2, le=100_000)] | None = key(
        "number of start angles around the turn: from which of them does it start?", None
    )
    start_within: Time | None = key(
        "time within which a start has to pass the breakdown torque; default: duration",
        None,
        gt=0,
    )
    RULES = (
        needs("start_within", "angles", "it applies to starts from several angles", "angles = 24"),
    )


# ----------------------------------------------------------------------------
# What is asked of the control of a motor that is to keep the shell quiet.
# ----------------------------------------------------------------------------

#: another sign drives the speed away from its reference
Gain = Annotated[float, Field(gt=0), Unit("")]
MotorGain = Annotated[float, Field(gt=0), Unit("N*m*s/rad")]
Gains = Annotated[tuple[Gain, ...], Field(max_length=200)]
Order = Annotated[int, Field(strict=True, ge=1, le=400)]


class GainRange(Table):
    """Limits of the controller's gain."""

    lower: Number = key("smallest gain", gt=0, alias="min")
    upper: Number = key("largest gain", gt=0, alias="max")
    RULES = (ordered("min", "max"),)


class FeedbackRange(Table):
    """Limits of the feedback of the shell's acceleration."""

    lower: Time = key("smallest feedback, may be negative", alias="min")
    upper: Time = key("largest feedback", alias="max")
    RULES = (ordered("min", "max"),)


class Tune(Table):
    """Search for gain and feedback that minimise harmonics and keep stability margins."""

    orders: tuple[Order, ...] = key(
        "harmonics of the shell's acceleration; the largest of them is minimised",
        (1, 2),
        min_length=1,
        max_length=64,
    )
    gain: GainRange = key("limits of the gain")
    acceleration_feedback: FeedbackRange = key("limits of the feedback")
    gain_margin: Level = key("minimum gain margin, as a level", 6.0, ge=0)
    phase_margin: Angle = key("minimum phase margin", 0.5235987755982988, ge=0, lt=3.2)
    delay_margin: Time = key("minimum delay margin", 0.0, ge=0)
    RULES = (once("orders", "order"),)


class Control(Table):
    """Control of the motor's frequency from speed and shell acceleration, in the reduced model."""

    orders: Order = key("highest order of the results", 10)
    reduction: Literal["momentum", "rotor"] = key(
        "momentum: mean inertias, angular momentum kept; "
        "rotor: the rotor's inertia alone, as the source has it",
        "momentum",
    )
    reference: AngularSpeed | None = key(
        "set speed of the controller; default: synchronous speed", None, gt=0
    )
    gain: Number = key("gain K of the controller", 1.0, gt=0)
    speed_feedback: Number | None = key(
        "share of the speed that is fed back; default: to reach target_speed", None
    )
    acceleration_feedback: Time = key("speed per unit of the shell's acceleration", 0.0)
    target_speed: AngularSpeed | None = key(
        "wanted mean speed; default: that of the reduced model without control", None, gt=0
    )
    motor_gain: AngularDamping | None = key(
        "torque per unit of slip; default: slope of the motor's curve", None, gt=0
    )
    actuator_lag: Time = key("time constant of the frequency converter", 0.0, ge=0)
    delay: Time = key("from measurement to frequency", 0.0, ge=0)
    motor_gains: tuple[MotorGain, ...] = key(
        "motor gains to compare, without control", (), max_length=200
    )
    gains: Gains = key("controller gains to compare, combined with each feedback", ())
    feedbacks: tuple[Time, ...] = key(
        "feedbacks of the shell's acceleration to compare, combined with each gain",
        (),
        max_length=200,
    )
    full_model: bool = key("also the closed loop in the full nonlinear model", False, strict=True)
    tune: Tune | None = key("also find gain and feedback", None)
    RULES = (
        at_most_one("speed_feedback", "target_speed"),
        *(once(key, "value") for key in ("motor_gains", "gains", "feedbacks")),
    )

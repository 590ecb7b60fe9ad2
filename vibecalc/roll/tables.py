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
    """All that turns with the crankshaft, besides the rotating masses of the crank train."""

    inertia: Inertia = Field(gt=0, description="about the crank axis, with coupling and flywheel")


class Shell(Table):
    """Stator, housing and baseplate as one rigid body that turns about the crank axis."""

    inertia: Inertia = Field(gt=0, description="about the crank axis, without what moves in it")
    stiffness: AngularStiffness = Field(
        0.0, ge=0, description="of the mounts against roll; with a damping of zero too: no mounts"
    )
    damping: AngularDamping = Field(
        0.0, ge=0, description="of the mounts against roll; a negative one would feed energy in"
    )


class Friction(Table):
    """What opposes the motion of crankshaft and pistons in the shell."""

    torque: Moment = Field(
        0.0, ge=0, description="constant, on the crankshaft; a negative one would drive it"
    )
    viscous: AngularDamping = Field(
        0.0, ge=0, description="on the crankshaft; a negative one would feed energy in"
    )
    piston_force: Force = Field(
        0.0, ge=0, description="constant, at each piston; a negative one would drive it"
    )


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
    """The steady motion of rotor, pistons and shell, with the speed that the motor finds."""

    method: RollMethod = Field(
        "collocation", description="Gauss collocation on panels, or another way to the same motion"
    )
    orders: Annotated[int, Field(strict=True, ge=1, le=400)] = Field(
        10, description="highest harmonic of the spectra"
    )
    points: Annotated[int, Field(strict=True, ge=1, le=4096)] | None = Field(
        None,
        description="nodes of each panel (collocation) or of a turn (fourier); without it the "
        "tolerance decides",
    )
    step: Time | None = Field(None, gt=0, description="of time, for the methods euler and rk4")
    started_at: AngularSpeed | None = Field(
        None,
        gt=0,
        description="crank speed at crank angle zero with the shell at rest: it fixes the angular "
        "momentum of a machine without mounts; default: that which keeps the shell in place",
    )
    compare: Annotated[tuple[RollMethod, ...], Field(max_length=6)] = Field(
        (), description="methods to run side by side"
    )
    interpolations: bool = Field(
        False, strict=True, description="also the spread between ways to read the gas tables"
    )
    sensitivity: bool = Field(
        False,
        strict=True,
        description="also slopes of the levels, and what ten percent more and less of each "
        "parameter do: advice in the report",
    )
    classical: bool = Field(
        False, strict=True, description="also the forces at constant speed in a shell at rest"
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
            "the methods euler and rk4 need their step",
            lambda t: "step" not in t and _uses(t, *STEPPING),
            "step = '0.1 ms', for example",
        ),
    )


#: below zero the gas would pull where it pushes
Factor = Annotated[float, Field(ge=0), Unit("")]


class Load(Table):
    """Factor on the gas forces in time, constant from each time to the next."""

    time: tuple[Time, ...] = Field(
        min_length=1, max_length=2000, description="ascending, the first is 0"
    )
    factor: tuple[Factor, ...] = Field(
        min_length=1,
        max_length=2000,
        description="of the gas forces from that time on; 0 is none",
    )
    RULES = (same_length("time", "factor"), ascending("time", start=0.0))


class StartUp(Table):
    """From rest, or from a given speed, through the breakdown torque to running, in time."""

    duration: Time = Field(gt=0, description="time that is followed")
    crank_angle: Angle = Field(0.0, description="of the crank at the start")
    speed: AngularSpeed = Field(0.0, description="of the crank against the shell at the start")
    load: Load | None = Field(None, description="factor on the gas forces in time; default: 1")
    settled: Number = Field(
        0.01,
        gt=0,
        lt=1,
        description="change of the shell's acceleration from turn to turn that counts as settled",
    )
    angles: Annotated[int, Field(strict=True, ge=2, le=100_000)] | None = Field(
        None, description="start angles to examine, all around: from which does it start?"
    )
    start_within: Time | None = Field(
        None,
        gt=0,
        description="time in which a start from such an angle has to come over the breakdown "
        "torque; default: duration",
    )
    RULES = (needs("start_within", "angles", "it is for starts from many angles", "angles = 24"),)


# ----------------------------------------------------------------------------
# What is asked of the control of a motor that is to keep the shell quiet.
# ----------------------------------------------------------------------------

#: another sign drives the speed away from its reference
Gain = Annotated[float, Field(gt=0), Unit("")]
MotorGain = Annotated[float, Field(gt=0), Unit("N*m*s/rad")]
Gains = Annotated[tuple[Gain, ...], Field(max_length=200)]
Order = Annotated[int, Field(strict=True, ge=1, le=400)]


class GainRange(Table):
    """Bounds of the controller's gain."""

    lower: Number = Field(gt=0, description="smallest gain")
    upper: Number = Field(gt=0, description="largest gain")
    RULES = (ordered("lower", "upper"),)


class FeedbackRange(Table):
    """Bounds of the feedback of the shell's acceleration."""

    lower: Time = Field(description="smallest feedback; it may be negative")
    upper: Time = Field(description="largest feedback")
    RULES = (ordered("lower", "upper"),)


class Tune(Table):
    """Search for gain and feedback that make some harmonics small and keep the loop stable."""

    orders: Annotated[tuple[Order, ...], Field(min_length=1, max_length=64)] = Field(
        (1, 2),
        description="harmonics of the shell's acceleration to make small, the largest counts",
    )
    gain: GainRange = Field(description="bounds of the gain")
    acceleration_feedback: FeedbackRange = Field(description="bounds of the feedback")
    gain_margin: Level = Field(6.0, ge=0, description="least factor to instability, as a level")
    phase_margin: Angle = Field(
        0.5235987755982988, ge=0, lt=3.2, description="least phase to instability"
    )
    delay_margin: Time = Field(0.0, ge=0, description="least delay to instability")
    RULES = (once("orders", "order"),)


class Control(Table):
    """Control of the motor's frequency from speed and shell acceleration, in the reduced model."""

    orders: Order = Field(10, description="highest order of the results")
    reduction: Literal["momentum", "rotor"] = Field(
        "momentum",
        description="momentum: mean inertias, angular momentum kept; "
        "rotor: the rotor's inertia alone, as the source has it",
    )
    reference: AngularSpeed | None = Field(
        None, gt=0, description="speed that the controller is set to; default: synchronous speed"
    )
    gain: Number = Field(1.0, gt=0, description="gain K of the controller")
    speed_feedback: Number | None = Field(
        None, description="share of the speed that is fed back; default: what keeps target_speed"
    )
    acceleration_feedback: Time = Field(
        0.0, description="feedback of the shell's acceleration: speed for each unit of it"
    )
    target_speed: AngularSpeed | None = Field(
        None, gt=0, description="mean speed to keep; default: that of the reduced model alone"
    )
    motor_gain: AngularDamping | None = Field(
        None, gt=0, description="torque for each unit of slip; default: slope of the motor's curve"
    )
    actuator_lag: Time = Field(0.0, ge=0, description="time constant of what sets the frequency")
    delay: Time = Field(0.0, ge=0, description="time from measurement to frequency")
    motor_gains: Annotated[tuple[MotorGain, ...], Field(max_length=200)] = Field(
        (), description="motor gains to compare, without a controller"
    )
    gains: Gains = Field((), description="controller gains to compare, with every feedback")
    feedbacks: Annotated[tuple[Time, ...], Field(max_length=200)] = Field(
        (), description="feedbacks of the shell's acceleration to compare, with every gain"
    )
    full_model: bool = Field(
        False, strict=True, description="also the closed loop in the full nonlinear model"
    )
    tune: Tune | None = Field(None, description="also find gain and feedback")
    RULES = (
        at_most_one("speed_feedback", "target_speed"),
        *(once(key, "value") for key in ("motor_gains", "gains", "feedbacks")),
    )

"""What is asked of the control of a motor that is to keep the shell quiet."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.fields import (
    Angle,
    AngularDamping,
    AngularSpeed,
    Level,
    Number,
    Table,
    Time,
)

Gains = Annotated[tuple[Number, ...], Field(max_length=200)]
Order = Annotated[int, Field(strict=True, ge=1, le=400)]


class GainRange(Table):
    """Bounds of the controller's gain."""

    lower: Number = Field(gt=0, description="smallest gain")
    upper: Number = Field(gt=0, description="largest gain")


class FeedbackRange(Table):
    """Bounds of the feedback of the shell's acceleration."""

    lower: Time = Field(description="smallest feedback; it may be negative")
    upper: Time = Field(description="largest feedback")


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
    motor_gains: Annotated[tuple[AngularDamping, ...], Field(max_length=200)] = Field(
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

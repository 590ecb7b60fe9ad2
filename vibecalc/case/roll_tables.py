"""What is asked of the roll of a machine: its periodic motion, and how it gets there."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.fields import Angle, AngularSpeed, Number, Table, Time

RollMethod = Literal["collocation", "fourier", "shooting", "dop853", "rk4", "euler"]


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


class Load(Table):
    """Factor on the gas forces in time, constant from each time to the next."""

    time: tuple[Time, ...] = Field(
        min_length=1, max_length=2000, description="ascending, the first is 0"
    )
    factor: tuple[Number, ...] = Field(
        min_length=1, max_length=2000, description="of the gas forces from that time on; 0 is none"
    )


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

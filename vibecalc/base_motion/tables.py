"""The table [base_motion] of a case."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Acceleration,
    Angle,
    AngularSpeed,
    Frequency,
    Name,
    Number,
    Point,
    Table,
    Unit,
    key,
)
from vibecalc.core.case.raw import table_at
from vibecalc.core.case.rules import (
    ascending,
    at_most_one,
    needs,
    one_of,
    refuse,
    same_length,
    unique,
    wants,
)
from vibecalc.parts.body_tables import along_or_about, no_matrices

Velocity = Annotated[float, Unit("m/s")]
AngularAcceleration = Annotated[float, Unit("rad/s^2")]
Angles = tuple[Angle, Angle, Angle]
AngularAccelerations = tuple[AngularAcceleration, AngularAcceleration, AngularAcceleration]
_DENSITY = "a spectral density"
_Acceleration = Annotated[float, Field(ge=0), Unit("m^2/s^3", _DENSITY)]
_Velocity = Annotated[float, Field(ge=0), Unit("m^2/s", _DENSITY, "'1e-6 m^2/s'")]
_AngularAcceleration = Annotated[float, Field(ge=0), Unit("rad^2/s^3", _DENSITY)]
_Many = Field(min_length=2, max_length=20_000)
_LINEAR = ("displacement", "velocity", "acceleration")
_ANGULAR = ("angle", "angular_velocity", "angular_acceleration")


class BaseHarmonic(Table):
    """One harmonic of the base motion along and about the axes, 0 to peak."""

    name: Name = key("label in tables and `where`")
    frequency: Frequency | None = key("as '8 Hz'", None, gt=0)
    order: Number | None = key("multiple of machine.speed instead", None, gt=0)
    displacement: Point | None = key("of the base point along x, y, z", None)
    velocity: tuple[Velocity, Velocity, Velocity] | None = key("instead of displacement", None)
    acceleration: tuple[Acceleration, Acceleration, Acceleration] | None = key(
        "instead of displacement or velocity", None
    )
    phase: Angles = key("phase lead of each component", (0.0, 0.0, 0.0))
    angle: Angles | None = key("rotation of the base about x, y, z", None)
    angular_velocity: tuple[AngularSpeed, AngularSpeed, AngularSpeed] | None = key(
        "instead of angle", None
    )
    angular_acceleration: AngularAccelerations | None = key(
        "instead of angle or angular velocity", None
    )
    angular_phase: Angles = key("phase lead of each component", (0.0, 0.0, 0.0))
    RULES = (
        one_of("frequency", "order"),
        at_most_one(*_LINEAR),
        at_most_one(*_ANGULAR),
        needs(
            "",
            " ".join((*_LINEAR, *_ANGULAR)),
            allowed='a motion of the base, e.g. displacement = [0, 0, "1 mm"]',
        ),
        refuse(
            "order",
            "an order is a multiple of machine.speed, which this machine does not have",
            lambda t: "order" in t and "speed" not in table_at(t.case, "machine"),
            allowed="frequency",
        ),
    )


class _Densities(Table):
    """One-sided density at ascending frequencies."""

    frequency: Annotated[tuple[Annotated[Frequency, Field(gt=0)], ...], _Many] = key("ascending")
    RULES = (ascending("frequency"), same_length("frequency", "density"))


class AccelerationDensities(_Densities):
    """One-sided density of the acceleration, (m/s^2)^2/Hz, at ascending frequencies."""

    density: Annotated[tuple[_Acceleration, ...], _Many] = key("(m/s^2)^2/Hz is m^2/s^3")


class VelocityDensities(_Densities):
    """One-sided density of the velocity, (m/s)^2/Hz, at ascending frequencies."""

    density: Annotated[tuple[_Velocity, ...], _Many] = key("(m/s)^2/Hz is m^2/s")


class AngularDensities(_Densities):
    """One-sided density of the angular acceleration, (rad/s^2)^2/Hz, at ascending frequencies."""

    density: Annotated[tuple[_AngularAcceleration, ...], _Many] = key("(rad/s^2)^2/Hz is rad^2/s^3")


class BaseSpectrum(Table):
    """Random base motion in one direction, uncorrelated with the others."""

    direction: Literal["x", "y", "z", "rx", "ry", "rz"] = key("along an axis, or about it")
    acceleration: AccelerationDensities | None = key(
        "density over frequency; also the name of a CSV file", None
    )
    velocity: VelocityDensities | None = key("instead of acceleration", None)
    angular_acceleration: AngularDensities | None = key(
        "of a rotation; also the name of a CSV file", None
    )
    RULES = (
        one_of("acceleration", "velocity", "angular_acceleration"),
        *along_or_about(
            "acceleration velocity",
            "a rotation of the base has an angular_acceleration",
            "angular_acceleration",
            "an angular_acceleration is one about an axis",
            "x, y or z, or angular_acceleration",
        ),
    )


class BaseMotion(Table):
    """Rigid-body motion of the base below the mounts: harmonics, spectra, or both."""

    point: Point = key(
        "point of the base whose motion is given, from the body's reference point", (0.0, 0.0, 0.0)
    )
    harmonics: tuple[BaseHarmonic, ...] = key("one entry per harmonic", (), max_length=200)
    spectra: tuple[BaseSpectrum, ...] = key(
        "one entry per direction of random motion", (), max_length=6
    )
    interpolation: Literal["logarithmic", "linear"] = key(
        "of densities between two frequencies: straight on these scales", "logarithmic"
    )
    peak_factor: Number = key("peak over r.m.s. of random motion", 3.0, ge=1, le=10)
    RULES = (
        wants("machine.body"),
        wants("machine.mounts"),
        *no_matrices(),
        unique("harmonics"),
        unique("spectra", "spectra", "direction"),
        refuse(
            "",
            "[base_motion] says no motion",
            lambda t: t.lacks("harmonics", "spectra"),
            allowed="harmonics, spectra, or both",
        ),
    )

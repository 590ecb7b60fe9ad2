"""The table [foundation] of a case."""

from typing import Annotated, Any, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Damping,
    Frequency,
    Mass,
    Name,
    Number,
    Point,
    Stiffness,
    Table,
    Unit,
    key,
)
from vibecalc.core.case.rules import (
    Row,
    ascending,
    by_kind,
    one_of,
    refuse,
    same_length,
    wants,
    without,
)
from vibecalc.parts.body_tables import TURNS, Body, Mounts, along_or_about, no_matrices

_Stiffnesses = tuple[Annotated[float, Unit("N/m")], ...]
_Dampings = tuple[Annotated[float, Unit("N*s/m")], ...]
_Turnings = tuple[Annotated[float, Unit("N*m/rad")], ...]
_TurnDampings = tuple[Annotated[float, Unit("N*m*s/rad")], ...]


class _OverFrequency(Table):
    """Something complex at ascending frequencies."""

    frequency: Annotated[
        tuple[Annotated[Frequency, Field(gt=0)], ...],
        Field(min_length=1, max_length=20_000, description="ascending; beyond its ends they hold"),
    ]
    RULES = (ascending("frequency"), same_length("frequency", "real", "imaginary"))


class DynamicStiffness(_OverFrequency):
    """Force over displacement, complex, over frequency."""

    real: _Stiffnesses = key("in phase with the displacement; negative above a mode")
    imaginary: _Stiffnesses = key("in phase with the velocity (dissipative)")


class Impedance(_OverFrequency):
    """Force over velocity, complex, over frequency."""

    real: _Dampings = key("in phase with the velocity (dissipative)")
    imaginary: _Dampings = key("positive like a mass, negative like a spring")


class AngularDynamicStiffness(_OverFrequency):
    """Couple over rotation, complex, over frequency."""

    real: _Turnings = key("in phase with the rotation; negative above a mode")
    imaginary: _Turnings = key("in phase with the angular velocity")


class AngularImpedance(_OverFrequency):
    """Couple over angular velocity, complex, over frequency."""

    real: _TurnDampings = key("in phase with the angular velocity")
    imaginary: _TurnDampings = key("positive like an inertia")


_LINEAR = ("dynamic_stiffness", "impedance")
_ANGULAR = ("angular_dynamic_stiffness", "angular_impedance")
#: keys of a flexibility that have its curve
CURVES = (*_LINEAR, *_ANGULAR)


class Flexibility(Table):
    """Flexibility of the foundation in one direction; it is rigid in all others."""

    at: Literal["mounts", "whole"] = key(
        "at each mount separately, or of the foundation as one rigid plate", "mounts"
    )
    mounts: tuple[Name, ...] | None = key(
        "names of mounts; default: all", None, min_length=1, max_length=256
    )
    direction: Literal["x", "y", "z", "rx", "ry", "rz"] = key(
        "along an axis, or about it for a plate"
    )
    dynamic_stiffness: DynamicStiffness | None = key(
        "force over displacement; also the name of a CSV file", None
    )
    impedance: Impedance | None = key(
        "force over velocity instead; also the name of a CSV file", None
    )
    angular_dynamic_stiffness: AngularDynamicStiffness | None = key(
        "couple over rotation, of a plate about an axis", None
    )
    angular_impedance: AngularImpedance | None = key("couple over angular velocity instead", None)
    RULES = (
        one_of(*CURVES),
        *along_or_about(
            " ".join(_LINEAR),
            "the flexibility about an axis is an angular_dynamic_stiffness or angular_impedance",
            " ".join(_ANGULAR),
            "what is angular is about an axis",
        ),
        refuse(
            "direction",
            "a mount has no rotation of its own: it passes forces only",
            lambda t: t["direction"] in TURNS and t["at"] != "whole",
            found="direction = '{direction}'",
            allowed="x, y or z, or at = 'whole'",
            also="at",
        ),
        refuse(
            "mounts",
            "the flexibility of the whole foundation is not one of single mounts",
            lambda t: "mounts" in t and t["at"] == "whole",
            allowed="at = 'mounts'",
            also="at",
        ),
    )


def _kind(row: Row) -> Any:
    """Said, or told by what is there."""
    if "kind" in row:
        return row["kind"]
    if "body" in row:
        return "body"
    return "impedance" if "flexibilities" in row else "mass"


class Foundation(Table):
    """Flexible support below the mounts: a mass, a rigid body, or impedances."""

    kind: Literal["mass", "body", "impedance"] | None = key(
        "one mass on a spring, a rigid body (6 dof) on springs, or tables over frequency", None
    )
    mass: Mass | None = key("of the moving part of the floor, deck or block", None, gt=0)
    stiffness: Stiffness | None = key("vertical, below that mass", None, gt=0)
    damping: Damping = key("viscous, parallel to the stiffness", 0.0, ge=0)
    loss_factor: Number = key("of the stiffness", 0.0, ge=0, le=1)
    position: Point | None = key(
        "reference point of the foundation, from that of the machine", None
    )
    body: Body | None = key("mass and inertia of the rigid body", None)
    springs: Mounts | None = key(
        "between foundation and ground, from its own reference point", None
    )
    flexibilities: tuple[Flexibility, ...] | None = key(
        "one entry per direction", None, min_length=1, max_length=300
    )
    RULES = (
        by_kind(
            "foundation",
            _kind,
            mass="mass stiffness | damping loss_factor",
            body="position body springs |",
            impedance="flexibilities | position",
        ),
        wants("isolation", '[isolation] with model = "pitch", "rigid_body" or "planar"'),
        *no_matrices(),
        without(
            "body.mass_matrix",
            "the body of a foundation has a mass, and inertia or a box",
            allowed="mass with inertia or box, or parts",
        ),
        without(
            "springs.stiffness_matrix",
            "the springs of a foundation have places",
            allowed="positions of equal springs, or individual ones",
        ),
        without(
            "springs.modal_damping",
            "the springs of a foundation damp by dampers or a loss factor",
            allowed="damping and loss_factor of the springs",
        ),
        without(
            "springs.each.static springs.each.over_load springs.each.over_frequency "
            "springs.individual.*.static springs.individual.*.over_load "
            "springs.individual.*.over_frequency",
            "the springs of a foundation have constant stiffness",
            allowed="stiffness, damping and loss_factor",
            hint="[foundation] flexibilities take stiffness over frequency",
        ),
    )

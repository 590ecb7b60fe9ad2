"""A primary system and the absorbers on it, in ratios or in units of their own."""

from typing import Annotated

from pydantic import Field

from vibecalc.case.absorber_fields import LinearDamping, LinearStiffness, Positive, Share
from vibecalc.case.fields import AngularDamping, AngularStiffness, Inertia, Mass, Name, Table


class Primary(Table):
    """What is to be kept still: ratios alone, or a system in torsion, or one in translation.

    Every ratio is relative to it; without inertia or mass all results are ratios.
    """

    damping_ratio: Share | None = Field(
        None, description="c1 / (2 sqrt(K1 J1)); default: 0, undamped"
    )
    inertia: Inertia | None = Field(None, gt=0, description="J1, in torsion")
    stiffness: AngularStiffness | None = Field(
        None, gt=0, description="K1 to the ground, in torsion; or [machine.rod] gives it"
    )
    damping: AngularDamping | None = Field(
        None, ge=0, description="c1 to the ground, in torsion, instead of damping_ratio"
    )
    mass: Mass | None = Field(None, gt=0, description="in translation, instead of inertia")
    linear_stiffness: LinearStiffness | None = Field(
        None, gt=0, description="to the ground, in translation, instead of stiffness"
    )
    linear_damping: LinearDamping | None = Field(
        None, ge=0, description="to the ground, in translation, instead of damping"
    )


class Secondary(Table):
    """The absorber: its mass, and spring and damper unless [tuning] finds them."""

    mass_ratio: Positive | None = Field(
        None, description="J2 / J1, or the ratio of masses, instead of inertia or mass"
    )
    inertia: Inertia | None = Field(None, gt=0, description="J2, in torsion")
    mass: Mass | None = Field(None, gt=0, description="in translation")
    stiffness_ratio: Share | None = Field(
        None, description="K2 / K1, instead of stiffness; 0: no spring, a pure viscous damper"
    )
    stiffness: AngularStiffness | None = Field(
        None, ge=0, description="K2 to what carries it, in torsion"
    )
    linear_stiffness: LinearStiffness | None = Field(
        None, ge=0, description="to what carries it, in translation"
    )
    damping_ratio: Share | None = Field(
        None, description="c2 / (2 sqrt(K1 J1)): referred to the primary, not to its own frequency"
    )
    own_damping_ratio: Share | None = Field(
        None,
        description="c2 / (2 J2 w2) instead, on its own frequency; it needs a spring",
    )
    damping: AngularDamping | None = Field(
        None, ge=0, description="c2, in torsion; a negative one would feed energy in"
    )
    linear_damping: LinearDamping | None = Field(None, ge=0, description="in translation")


class NamedSecondary(Secondary):
    """One of several absorbers, beside each other or one on another."""

    name: Name = Field(description="label used in `on`, in tables and in `where`")
    on: Name = Field("primary", description="what carries it: the primary, or another one by name")


Secondaries = Annotated[tuple[NamedSecondary, ...], Field(max_length=8)]

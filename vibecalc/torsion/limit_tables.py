"""[[response.torsion.limits]]: what stresses and torques of a shaft line may be."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import AngularSpeed, Length, Moment, Name, Number, Stress, Table, key
from vibecalc.core.case.rules import (
    Row,
    Rule,
    ascending,
    at_most_one,
    needs,
    no,
    one_of,
    refuse,
    same_length,
)
from vibecalc.errors import Problem
from vibecalc.torsion.shaft_line_tables import CrankDimensions

# ----------------------------------------------------------------------------
# Limits against the speed, as tables.
# ----------------------------------------------------------------------------

_Speeds = Annotated[tuple[AngularSpeed, ...], Field(min_length=2, max_length=2000)]
_Stresses = Annotated[tuple[Stress, ...], Field(min_length=2, max_length=2000)]
_Torques = Annotated[tuple[Moment, ...], Field(min_length=2, max_length=2000)]
_PASSING = "amplitude that is allowed for passing through, one per speed; default: none is said"


def _no_less(transient: str, continuous: str) -> Rule:
    """Each number of one list is at least that of the other."""

    def rule(row: Row) -> Iterator[Problem]:
        pairs = zip(row.listed(continuous), row.listed(transient), strict=False)
        for place, (lasting, passing) in enumerate(pairs):
            if lasting is not None and passing is not None and passing < lasting:
                yield row.problem(
                    (*row.path, transient, place),
                    "less is allowed for passing through than for lasting operation",
                    found=f"{passing:.6g}{row.unit(transient)} in row {place + 1}",
                    allowed=f">= {lasting:.6g}{row.unit(continuous)}, that of {continuous}",
                    also=(*row.path, continuous, place),
                )
                return

    return rule


class StressCurve(Table):
    """A limit of the stress against the speed, straight lines between the entries."""

    speed: _Speeds = key("ascending, of the crankshaft")
    stress: _Stresses = key("amplitude that is allowed, one per speed")
    transient: tuple[Stress, ...] | None = key(_PASSING, None, max_length=2000)
    RULES = (
        same_length("speed", "stress", "transient"),
        ascending("speed"),
        _no_less("transient", "stress"),
    )


class TorqueCurve(Table):
    """A limit of the vibratory torque against the speed, straight lines between the entries."""

    speed: _Speeds = key("ascending, of the crankshaft")
    torque: _Torques = key("amplitude that is allowed, one per speed, on its own shaft")
    transient: tuple[Moment, ...] | None = key(_PASSING, None, max_length=2000)
    RULES = (
        same_length("speed", "torque", "transient"),
        ascending("speed"),
        _no_less("transient", "torque"),
        refuse(
            "torque",
            "a limit of nothing leaves no use of it to be told",
            lambda t: any(one is not None and one <= 0.0 for one in t.listed("torque")),
            "amplitudes > 0",
        ),
    )


# ----------------------------------------------------------------------------
# What the rule for crankshafts counts with.
# ----------------------------------------------------------------------------


class Crank(CrankDimensions):
    """A throw as the rule for crankshafts counts it, solid forged or cast."""

    pin_fillet: Length = key("radius between pin and web", gt=0)
    journal_fillet: Length = key("radius between journal and web", gt=0)


class CrankBending(Table):
    """Nominal alternating stresses of a throw that are not of torsion."""

    web: Stress = key("sigma_BFN: bending, of the web's cross-section", ge=0)
    compressive: Stress = key("sigma_QFN: by the radial force, of the web's cross-section", ge=0)
    oil_bore: Stress | None = key(
        "sigma_BON: bending at the oil bore, of the pin's cross-section", None, ge=0
    )
    additional: Stress = key(
        "sigma_add: 10 N/mm2 of trunk piston, 30 of crosshead engines", 10e6, ge=0
    )


# ----------------------------------------------------------------------------
# A limit.
# ----------------------------------------------------------------------------

#: what stands for c_K of IACS UR M68
ShaftKind = Literal[
    "flange",
    "shrink_fit",
    "keyway_taper",
    "keyway_cylinder",
    "radial_hole",
    "longitudinal_slot",
    "thrust_collar",
    "thrust_roller_bearing",
    "propeller_flange",
    "propeller_keyless",
    "propeller_keyed",
    "propeller_forward",
]
_CURVES = ("curve", "torque", "alternating_share")
_OF_RULES = (
    *("tensile_strength", "design_factor", "shaft_kind"),
    *("crank", "crankshaft_kind", "bending"),
)


_Names = Annotated[tuple[Name, ...], Field(max_length=64)]


class TorsionLimit(Table):
    """A limit of stress or torque: a class rule as data, a curve, or a share of the mean torque."""

    rule: Literal["iacs_m68", "iacs_m53"] | None = key(
        "of propulsion shafts (m68) or of crankshafts (m53); informative", None
    )
    curve: StressCurve | None = key("instead of a rule: stress over speed, a table or a CSV", None)
    torque: TorqueCurve | None = key(
        "instead: torque over speed of sections or gears, a table or a CSV", None
    )
    alternating_share: Number | None = key(
        "instead, of gears: alternating torque over the mean at the operating speed",
        None,
        gt=0,
        le=10,
    )
    sections: _Names = key("names of shafts; default: all with what the limit needs", ())
    gears: _Names = key("names of gears; default of alternating_share: all", ())
    tensile_strength: Stress | None = key(
        "of the material, for the rule, where the shaft does not say it", None, gt=0
    )
    design_factor: Number = key("c_K of m68: 1 for a plain intermediate shaft", 1.0, gt=0, le=1)
    shaft_kind: ShaftKind | None = key(
        "instead of design_factor: what the shaft is, for c_K of m68", None
    )
    crank: Crank | None = key("throw for m53, where the shafts have no `throw` with fillets", None)
    crankshaft_kind: Literal["continuous_grain_flow", "free_form", "cast_cold_rolled"] | None = key(
        "how it is made, for K of m53; default: free_form", None
    )
    bending: CrankBending | None = key("for m53: stresses not of torsion", None)
    RULES = (
        one_of("rule", *_CURVES),
        *(at_most_one(one, other) for one in _CURVES for other in _OF_RULES),
        at_most_one("design_factor", "shaft_kind"),
        at_most_one("alternating_share", "sections"),
        *(at_most_one(one, "gears") for one in ("rule", "curve")),
        needs("torque", "sections gears", "a limit of the torque is for some of them"),
        needs(
            "rule",
            "bending",
            "the rule for crankshafts judges bending and torsion together",
            "bending = { web = '30 MPa', compressive = '3 MPa' } with it",
            when=lambda t: t["rule"] == "iacs_m53",
        ),
        no(
            "design_factor shaft_kind",
            lambda t: t["rule"] == "iacs_m53",
            "{key} is of the rule for propulsion shafts, and this one is for crankshafts",
            "rule = 'iacs_m68', or no {key}",
        ),
        no(
            "crank crankshaft_kind bending",
            lambda t: t["rule"] == "iacs_m68",
            "{key} is of the rule for crankshafts, and this one is for propulsion shafts",
            "rule = 'iacs_m53', or no {key}",
        ),
    )

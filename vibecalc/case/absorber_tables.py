"""What is asked of an absorber: its response, and the tuning that keeps it small."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from vibecalc.case.absorber_fields import Positive, Share, Temperature
from vibecalc.case.fields import AngularSpeed, Table, Unit

AbsorberExcitation = Literal["force", "base", "unbalance"]
TunedResponse = Literal["displacement", "velocity", "acceleration", "transmitted_force"]
AnyResponse = Literal[
    "displacement",
    "velocity",
    "acceleration",
    "transmitted_force",
    "secondary_displacement",
    "relative_displacement",
]
TuningMethod = Literal["den_hartog", "nishihara_asami", "warburton", "numerical"]
Shares = Annotated[tuple[Share, ...], Field(max_length=64)]
#: of a number that a part may be off by
Fraction = Annotated[float, Field(gt=0, lt=1), Unit("")]
Positives = Annotated[tuple[Positive, ...], Field(max_length=64)]
Points = Annotated[int, Field(strict=True, ge=2, le=20_000)]


class Range(Table):
    """Numbers from one to another."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)


class FrequencyRatios(Range):
    """Frequencies over the primary's own."""

    start: Share = Field(0.0, alias="from", description="lowest")
    stop: Positive = Field(alias="to", description="highest")
    points: Points = Field(401, description="evenly spread, both ends included")


class Frequencies(Range):
    """Frequencies of the excitation."""

    start: AngularSpeed = Field(0.0, alias="from", ge=0, description="lowest")
    stop: AngularSpeed = Field(alias="to", gt=0, description="highest")
    points: Points = Field(401, description="evenly spread, both ends included")


class MassRatios(Range):
    """Mass ratios of a chart."""

    start: Positive = Field(alias="from", description="lowest")
    stop: Positive = Field(alias="to", description="highest")
    points: Annotated[int, Field(strict=True, ge=2, le=2000)] = Field(
        41, description="both ends included"
    )
    spacing: Literal["linear", "logarithmic"] = Field("linear", description="between them")


class TemperatureRange(Range):
    """Temperatures of the oil."""

    start: Temperature = Field(alias="from", description="lowest, '20 degC' or in K")
    stop: Temperature = Field(alias="to", description="highest")
    points: Annotated[int, Field(strict=True, ge=2, le=2000)] = Field(
        41, description="evenly spread, both ends included"
    )


class Vary(Table):
    """One ratio to draw a family of curves for; the others stay."""

    primary_damping: Shares = Field((), description="c1 / (2 sqrt(K1 J1))")
    mass_ratio: Positives = Field((), description="J2 / J1")
    stiffness_ratio: Shares = Field((), description="K2 / K1")
    secondary_damping: Shares = Field((), description="c2 / (2 sqrt(K1 J1))")
    own_damping: Shares = Field((), description="c2 / (2 J2 w2), on the secondary's own frequency")


class AbsorberResponse(Table):
    """Curves over the frequency, peaks, fixed points, poles of primary and secondary."""

    excitation: AbsorberExcitation | None = Field(
        None, description="what drives the primary; default: that of [tuning], or force"
    )
    response: AnyResponse | None = Field(
        None, description="what is read; default: that of [tuning], or displacement"
    )
    frequency_ratios: FrequencyRatios | None = Field(
        None, description="over the primary's own frequency; default: 0 to 2"
    )
    frequencies: Frequencies | None = Field(
        None, description="instead, of a primary with inertia or mass"
    )
    vary: Vary | None = Field(None, description="a family of curves")
    limits: bool = Field(
        False, strict=True, description="also the curves with the secondary locked and free"
    )


class Bounds(Table):
    """What a tuning has to keep."""

    stiffness_ratio: tuple[Share, Share] | None = Field(None, description="from and to")
    damping_ratio: tuple[Share, Share] | None = Field(
        None, description="from and to, of the secondary, referred to the primary"
    )
    travel: Positive | None = Field(
        None, description="largest motion of the secondary against the primary, over T0 / K1"
    )


class Chart(Table):
    """Tunings over the mass ratio, for a family of primary dampings."""

    primary_damping: Annotated[tuple[Share, ...], Field(min_length=1, max_length=64)] = Field(
        description="c1 / (2 sqrt(K1 J1)), one curve for each"
    )
    mass_ratio: MassRatios = Field(description="range of the chart")


class Tuning(Table):
    """The spring and the damper that make the response of the primary smallest."""

    norm: Literal["h_infinity", "h2"] = Field(
        "h_infinity", description="the largest amplitude over all frequencies, or the mean square"
    )
    excitation: AbsorberExcitation = Field("force", description="what drives the primary")
    response: TunedResponse = Field("displacement", description="of the primary, to be kept small")
    kind: Literal["free", "viscous", "undamped_spring", "lanchester"] = Field(
        "free",
        description="both found, no spring, no damper, or the damper for an undamped primary",
    )
    compare: Annotated[tuple[TuningMethod, ...], Field(max_length=8)] = Field(
        (), description="closed forms and a search to show beside it"
    )
    bounds: Bounds | None = Field(
        None, description="what has to be kept: the tuning found is the best that keeps it"
    )
    mistuning: Annotated[tuple[Fraction, ...], Field(max_length=16)] = Field(
        (), description="errors of spring and damper whose loss is told, as 0.05 or '5 %'"
    )
    sensitivity: bool = Field(
        False, strict=True, description="also how the optimum moves with the given ratios"
    )
    temperatures: TemperatureRange | None = Field(
        None, description="also what the tuning becomes as the oil warms"
    )
    chart: Chart | None = Field(None, description="also tunings over the mass ratio")

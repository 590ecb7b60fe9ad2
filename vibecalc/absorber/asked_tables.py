"""Tables of a case that ask of an absorber: its response, and the tuning that keeps it small."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field
from pydantic_core import core_schema

from vibecalc.absorber.readings import drifts
from vibecalc.absorber.tables import OILS, Positive, Share, Temperature
from vibecalc.core.case.fields import (
    Acceleration,
    Force,
    Frequency,
    Length,
    Moment,
    Table,
    Unbalance,
    Unit,
    key,
)
from vibecalc.core.case.raw import read_number, table_at
from vibecalc.core.case.rules import (
    Row,
    Rule,
    at_most_one,
    needs,
    no,
    once,
    one_of,
    ordered,
    pair_ordered,
    refuse,
)
from vibecalc.errors import UnitError

# ----------------------------------------------------------------------------
# What is asked of an absorber: its response, and the tuning that keeps it small.
# ----------------------------------------------------------------------------

#: key of an amplitude -> excitation
AMPLITUDES = {
    "force": "force",
    "torque": "force",
    "unbalance": "unbalance",
    "base_displacement": "base",
    "base_acceleration": "base_acceleration",
}


def excitation_and_response(asked: Mapping[str, Any], tuning: Mapping[str, Any]) -> tuple[str, str]:
    """What [response.absorber] draws: as said, as its amplitude is, as in [tuning], the usual."""
    by_size = next((kind for key, kind in AMPLITUDES.items() if asked.get(key) is not None), None)
    return (
        asked.get("excitation") or by_size or tuning.get("excitation") or "force",
        asked.get("response") or tuning.get("response") or "displacement",
    )


AbsorberExcitation = Literal["force", "base", "unbalance", "base_acceleration"]
TunedResponse = Literal[
    "displacement", "velocity", "acceleration", "transmitted_force", "deflection"
]
AnyResponse = Literal[
    "displacement",
    "velocity",
    "acceleration",
    "transmitted_force",
    "secondary_displacement",
    "relative_displacement",
]
TuningMethod = Literal["den_hartog", "nishihara_asami", "warburton", "numerical"]
#: entries of a family of curves
_MOST = 64


class Spread:
    """Marks a list that may also be a range, `{ from = 0.0, to = 1.0, points = 41 }`."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(_spread, handler(source))

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        ends = {"type": "number"}
        points = {"type": "integer", "minimum": 2, "maximum": _MOST}
        of = {"from": ends, "to": ends, "points": points}
        spread = {"type": "object", "properties": of, "required": [*of]}
        return {"anyOf": [handler(schema["schema"]), {**spread, "additionalProperties": False}]}


def _spread(value: Any) -> Any:
    """The entries of a range, evenly spread with both ends; anything else as it is."""
    if not isinstance(value, dict):
        return value
    low, high = (read_number(value.get(key), "") for key in ("from", "to"))
    points = value.get("points")
    few = isinstance(points, int) and 2 <= points <= _MOST  # true and false are fewer
    if low is None or high is None or points is None or not few or len(value) > 3:
        raise UnitError(
            "not a range",
            found=str(value)[:80],
            allowed=f"a list, or {{ from = 0.0, to = 1.0, points = 41 }} with 2 to {_MOST} points",
        )
    return [low + (high - low) * i / (points - 1) for i in range(points)]


Shares = Annotated[tuple[Share, ...], Field(max_length=_MOST), Spread()]
#: of a number that a part may be off by
Fraction = Annotated[float, Field(gt=0, lt=1), Unit("")]
Tolerance = Annotated[float, Field(ge=0, lt=0.9), Unit("")]
Positives = Annotated[tuple[Positive, ...], Field(max_length=_MOST), Spread()]
Points = Annotated[int, Field(strict=True, ge=2, le=20_000)]
FewPoints = Annotated[int, Field(strict=True, ge=2, le=2000)]


class Range(Table):
    """Numbers from one to another."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)
    RULES = (ordered("from", "to"),)


class Band(Range):
    """Band of frequencies or speeds over which the absorber is tuned."""

    start: Frequency = key("lower end, '7 Hz' or '400 rpm'", 0.0, alias="from", ge=0)
    stop: Frequency = key("upper end", alias="to", gt=0)


class BandRatios(Range):
    """The same over the primary's own frequency."""

    start: Share = key("lower end", 0.0, alias="from")
    stop: Positive = key("upper end", alias="to")


class Frequencies(Band):
    """Frequencies of the excitation."""

    points: Points = key("number of points, evenly spaced, ends included", 401)


class FrequencyRatios(BandRatios):
    """Excitation frequencies over the primary's natural frequency."""

    points: Points = key("number of points, evenly spaced, ends included", 401)


class Tolerances(Table):
    """Tolerances, plus and minus, in every combination."""

    natural_frequency: Tolerance = key("of the primary, in all its modes", 0.0)
    mass: Tolerance = key("of the absorber's mass", 0.0)
    stiffness: Tolerance = key("of the absorber's spring", 0.0)
    damping: Tolerance = key("of the absorber's damper", 0.0)
    RULES = (
        refuse(
            "",
            "[tuning.tolerances] has no tolerance above zero",
            lambda t: not any(map(t.number, t.data)),
            "natural_frequency = '5 %', for example",
        ),
    )


class MassRatios(Range):
    """Mass ratios of a chart."""

    start: Positive = key("smallest", alias="from")
    stop: Positive = key("largest", alias="to")
    points: FewPoints = key("number of points, ends included", 41)
    spacing: Literal["linear", "logarithmic"] = key("spacing of the points", "linear")


class TemperatureRange(Range):
    """Temperatures of the oil."""

    start: Temperature = key("lowest, '20 degC' or in K", alias="from")
    stop: Temperature = key("highest", alias="to")
    points: FewPoints = key("number of points, evenly spaced, ends included", 41)


#: key of [response.absorber.vary] -> words in the name of a curve
VARIED = {
    "primary_damping": "primary damping",
    "mass_ratio": "mass ratio",
    "stiffness_ratio": "stiffness ratio",
    "damping_over_primary_critical": "damping",
    "absorber_damping_ratio": "absorber damping ratio",
}


class Vary(Table):
    """One ratio to draw a family of curves for; the others stay."""

    primary_damping: Shares = key("c1 / (2 sqrt(K1 J1))", ())
    mass_ratio: Positives = key("J2 / J1", ())
    stiffness_ratio: Shares = key("K2 / K1", ())
    damping_over_primary_critical: Shares = key("c2 / (2 sqrt(K1 J1))", ())
    absorber_damping_ratio: Shares = key(
        "c2 / (2 J2 w2): over the critical damping of the absorber", ()
    )
    RULES = (
        one_of(
            *VARIED,
            allowed=f"one of {', '.join(VARIED)}, with its values",
        ),
        refuse(
            "",
            "one of several absorbers cannot vary: which one?",
            lambda t: (
                "secondaries" in t.machine and t.said(*VARIED) not in ([], ["primary_damping"])
            ),
            "primary_damping, or a sweep over keys of the secondaries",
            also=("machine", "secondaries"),
        ),
    )


def _driven(row: Row) -> list[Any]:
    """Excitations by the amplitudes that are said; without one the one that is."""
    return [AMPLITUDES[key] for key in row.said(*AMPLITUDES)] or [row["excitation"]]


class AbsorberResponse(Table):
    """Response curves, peaks, fixed points and poles of primary and absorber."""

    excitation: AbsorberExcitation | None = key(
        "excitation of the primary; default: as in [tuning], or force", None
    )
    response: AnyResponse | None = key(
        "response quantity; default: as in [tuning], or displacement", None
    )
    frequency_ratios: FrequencyRatios | None = key(
        "range over the primary's natural frequency; default: 0 to 2", None
    )
    frequencies: Frequencies | None = key(
        "range in Hz instead, for a primary with inertia or mass", None
    )
    vary: Vary | None = key("family of curves", None)
    limits: bool = key("also curves with the absorber locked and free", False, strict=True)
    force: Force | None = key("force amplitude, for motions in m and forces in N", None, gt=0)
    torque: Moment | None = key("torque amplitude, in torsion", None, gt=0)
    unbalance: Unbalance | None = key(
        "rotating unbalance, mass times radius: force amplitude is this times w^2", None, gt=0
    )
    base_displacement: Length | None = key(
        "displacement amplitude of the base, the same at all frequencies", None, gt=0
    )
    base_acceleration: Acceleration | None = key(
        "acceleration amplitude of the base, the same at all frequencies", None, gt=0
    )
    RULES = (
        at_most_one("frequency_ratios", "frequencies"),
        at_most_one(*AMPLITUDES),
        refuse(
            "excitation",
            "the excitation is not that of the amplitude",
            lambda t: "excitation" in t and t["excitation"] not in _driven(t),
            "no excitation: the amplitude says it",
        ),
    )


def _idle(kind: str, held: str, bound: str) -> Rule:
    return no(
        bound,
        lambda t: table_at(t.case, "tuning").get("kind") == kind,
        f"of kind {kind!r} {held}, and a bound holds nothing",
        f"no {bound} in the bounds, or kind = 'free'",
        also=("tuning", "kind"),
    )


class Bounds(Table):
    """Constraints on a tuning."""

    stiffness_ratio: tuple[Share, Share] | None = key("minimum and maximum", None)
    damping_over_primary_critical: tuple[Share, Share] | None = key(
        "minimum and maximum of c2 / (2 sqrt(K1 J1)), of the absorber", None
    )
    travel: Positive | None = key(
        "maximum displacement of the absorber relative to the primary, over T0 / K1, "
        "m_u r / M1 or the motion of the ground",
        None,
    )
    RULES = (
        pair_ordered("stiffness_ratio"),
        pair_ordered("damping_over_primary_critical"),
        _idle("viscous", "the spring is none", "stiffness_ratio"),
        _idle("undamped_spring", "the damper is none", "damping_over_primary_critical"),
    )


class Chart(Table):
    """Chart of tunings over the mass ratio, for a family of primary dampings."""

    primary_damping: tuple[Share, ...] = key(
        "c1 / (2 sqrt(K1 J1)), one curve each", min_length=1, max_length=64
    )
    mass_ratio: MassRatios = key("range of mass ratios")


def _banded(row: Row) -> bool:
    return bool(row.said("band", "band_ratios"))


def _several(row: Row) -> bool:
    return "secondaries" in row.machine


def _out_of_band(row: Row) -> bool:
    """Whether the frequency that an absorber is to swing at is not within its band."""
    band, place = row.below("band"), row.number("frequency")
    low, high = (band.number("from"), band.number("to")) if band else (None, None)
    if low is None or high is None or place is None:
        return False
    return not low <= place <= high


def _modal(row: Row) -> bool:
    return bool(table_at(row.machine, "primary").get("modes"))


def _over_all_frequencies(key: str, value: str) -> Callable[[Row], bool]:
    """Whether a value stands at a key without a band, nor for the mean square of one absorber."""

    def asked(row: Row) -> bool:
        white = row["norm"] == "h2" and row["excitation"] == "base_acceleration"
        return row[key] == value and not _banded(row) and (_several(row) or not white)

    return asked


#: excitations and responses for which Warburton gives the least largest amplitude
WARBURTON_PAIRS = (
    ("force", "displacement"),
    ("force", "transmitted_force"),
    ("base", "displacement"),
    ("base_acceleration", "acceleration"),
    ("force", "acceleration"),
    ("unbalance", "displacement"),
    ("base_acceleration", "deflection"),
    ("base_acceleration", "transmitted_force"),
)
#: what a tuning within a band asks for, and what only such a one is for
BANDED = (
    needs("tolerances", "band band_ratios", "the worst case is that within a band"),
    needs(
        "frequency",
        "band",
        "it says over what the speed may spread",
        when=lambda t: not _several(t),
    ),
    refuse(
        "frequency",
        "the frequency to swing at is not within the band, which is what the speed may spread over",
        _out_of_band,
        "a frequency within the band",
        found="{frequency}",
        also="band",
    ),
    at_most_one("frequency", "tolerances"),
    at_most_one("frequency", "compare"),
    refuse(
        "",
        "a primary of several modes is tuned within a band",
        lambda t: _modal(t) and not _banded(t),
        "band = { from = '5 Hz', to = '9 Hz' }",
        also=("machine", "primary", "modes"),
    ),
    *(
        refuse(
            key,
            f"{key} = {value!r} is tuned within a band",
            _over_all_frequencies(key, value),
            "band = { from = '5 Hz', to = '9 Hz' }, or band_ratios",
            hint="norm = 'h2' has, of one absorber, its mean square under a white acceleration of "
            "the ground",
        )
        for key, value in (("excitation", "base_acceleration"), ("response", "deflection"))
    ),
    refuse(
        "response",
        "under a constant acceleration the ground drifts, and what stands on it",
        lambda t: drifts(t["excitation"], t["response"]),
        "deflection, acceleration or transmitted_force",
        also="excitation",
    ),
    refuse(
        "response",
        "a deflection is against a ground that moves",
        lambda t: t["response"] == "deflection" and t["excitation"] in ("force", "unbalance"),
        "displacement, or excitation = 'base_acceleration'",
        also="excitation",
    ),
    refuse(
        "response",
        "the force on the ground is that of a single mode",
        lambda t: t["response"] == "transmitted_force" and _modal(t),
        "displacement, velocity or acceleration",
        also=("machine", "primary", "modes"),
    ),
    no(
        "chart temperatures sensitivity",
        _banded,
        "within a band the largest amplitude is made small by spring and damper, without {key}",
        "excitation, response, bounds, mistuning, tolerances",
        also="band",
    ),
    no(
        "chart temperatures sensitivity",
        lambda t: not _banded(t) and t["excitation"] == "base_acceleration",
        "of a mean square under the ground's acceleration there is no {key}",
        "compare, mistuning",
        also="excitation",
    ),
    refuse(
        "compare",
        "closed forms are those of a single mode",
        lambda t: "compare" in t and _modal(t),
        "no compare",
        also=("machine", "primary", "modes"),
    ),
    refuse(
        "compare",
        "Warburton has no closed form for the {response} under {excitation}",
        lambda t: (
            "warburton" in t.entries("compare")
            and (_banded(t) or t["excitation"] == "base_acceleration")
            and (t["excitation"], t["response"]) not in WARBURTON_PAIRS
        ),
        ", ".join(f"{response} under {excitation}" for excitation, response in WARBURTON_PAIRS),
    ),
    no(
        "norm kind",
        _banded,
        "within a band the largest amplitude is made small, by spring and damper both",
        "norm = 'h_infinity' and kind = 'free', as without these keys",
        also="band",
    ),
    refuse(
        ("tuning", "bounds", "stiffness_ratio"),
        "within a band spring and damper are both found, and the bounds leave no spring",
        lambda t: _banded(t) and table_at(t.data, "bounds").get("stiffness_ratio") == [0.0, 0.0],
        "a highest ratio > 0",
    ),
)


class Tuning(Table):
    """Spring and damper of an absorber that minimise the response of the primary."""

    norm: Literal["h_infinity", "h2"] = key(
        "what is minimised: maximum amplitude over all frequencies (h_infinity) or mean "
        "square (h2)",
        "h_infinity",
    )
    excitation: AbsorberExcitation = key("excitation of the primary", "force")
    response: TunedResponse = key("response quantity of the primary to minimise", "displacement")
    kind: Literal["free", "viscous", "undamped_spring", "lanchester"] = key(
        "spring and damper (free), damper alone (viscous), spring alone (undamped_spring), or "
        "the damper for an undamped primary (lanchester)",
        "free",
    )
    compare: tuple[TuningMethod, ...] = key(
        "closed forms and a numerical search to compare with", (), max_length=8
    )
    bounds: Bounds | None = key("constraints: the best tuning within them", None)
    mistuning: tuple[Fraction, ...] = key(
        "relative errors of spring and damper whose effect is reported, as 0.05 or '5 %'",
        (),
        max_length=16,
    )
    sensitivity: bool = key(
        "also the sensitivity of the optimum to the given ratios", False, strict=True
    )
    temperatures: TemperatureRange | None = key("also the tuning over the oil temperature", None)
    chart: Chart | None = key("also a chart of tunings over the mass ratio", None)
    band: Band | None = key(
        "minimise the maximum amplitude in this band; primary with inertia or mass", None
    )
    band_ratios: BandRatios | None = key("the same band over the primary's natural frequency", None)
    frequency: Frequency | None = key(
        "constant machine speed, '1500 rpm': the absorber is tuned to it with the least "
        "damping within bounds; band: expected variation of the speed",
        None,
        gt=0,
    )
    tolerances: Tolerances | None = key(
        "tolerances of the parts: the worst case in the band is minimised", None
    )
    RULES = (
        at_most_one("band", "band_ratios"),
        *BANDED,
        once("compare", "method"),
        no(
            "bounds excitation response",
            lambda t: t["kind"] == "lanchester" and t["norm"] != "h2",
            "Lanchester's damper is that of a formula for a force and the displacement, without "
            "{key}",
            "kind = 'viscous', whose damper is found for any of them",
            also="kind",
        ),
        no(
            "kind bounds",
            lambda t: t["norm"] == "h2",
            "a mean square is tuned with spring and damper both free, without {key}",
            "no {key}, or norm = 'h_infinity'",
            also="norm",
        ),
        refuse(
            "compare",
            "the closed forms den_hartog and nishihara_asami are for the largest amplitude",
            lambda t: (
                t["norm"] == "h2"
                and any(name in t.entries("compare") for name in ("den_hartog", "nishihara_asami"))
            ),
            "norm = 'h_infinity', or 'warburton' with 'h2'",
            found="norm = 'h2'",
            also="norm",
        ),
        no(
            "temperatures",
            lambda t: OILS.isdisjoint(t.machine),
            "temperatures needs an oil",
            "[machine.gap] with [machine.oil] or oils in stock",
        ),
        no(
            "compare temperatures chart norm kind sensitivity frequency",
            _several,
            "several absorbers are tuned for the largest amplitude, without {key}",
            "excitation, response, bounds, mistuning, band, tolerances",
            hint="one absorber in [machine.secondary] has it",
            also=("machine", "secondaries"),
        ),
    )

"""Results of absorbers: response, tuning, hardware, and pendulums on a rotor."""

from typing import Any, ClassVar

from vibecalc.absorber.motion_results import AXES as MOTION_AXES
from vibecalc.absorber.motion_results import BAND_ENTRIES, MOTION_ENTRIES
from vibecalc.core.results.described import Group, entries_of, lead, named, q
from vibecalc.core.results.record import CHECK, DIFFERENCE, PEAK, PLACE, Headline, entry

# ----------------------------------------------------------------------------
# Results of a primary system with its absorber: curves, peaks, fixed points, poles.
# ----------------------------------------------------------------------------

RESPONSE_ROOT = "response/absorber"
TUNING_ROOT = "tuning"
HARDWARE_ROOT = "hardware"
PENDULUM_ROOT = "pendulum"
FRICTION_ROOT = "friction_damper"
_TUNED = f"{TUNING_ROOT}/peak"
_TRAVEL = "travel ratio of the absorber, largest"
_OVER = "over T0 / K1, m_u r / M1 or the motion of the ground"
_LARGEST = Headline(
    "largest response of the primary",
    pick="first",
    at=f"{RESPONSE_ROOT}/largest_frequency_ratio",
    unless=_TUNED,
)


class Response(Group):
    """Curves of a primary with its absorbers, their largest values, and frequencies."""

    ROOT: ClassVar[str] = RESPONSE_ROOT
    curve: Any = q("curve frequency_ratio", "", "response of the primary as a ratio, complex", PEAK)
    relative_curve: Any = q("curve frequency_ratio", "",
        "motion of the absorber against the primary, as a ratio, complex", PEAK)  # fmt: skip
    frequency: Any = q("frequency_ratio", "rad/s", "frequency of the excitation")
    largest: Any = q("curve", "", "largest response at any frequency", headline=_LARGEST,
        name="largest response of the primary")  # fmt: skip
    largest_frequency_ratio: Any = q("curve", "",
        "where that is, over the primary's own frequency; infinite for a limit at high frequency",
        name="frequency ratio of the largest response",
    )  # fmt: skip
    largest_travel: Any = lead("curve", "", _TRAVEL, pick="first", unless=_TUNED,
        about=_OVER)  # fmt: skip
    natural_frequency_ratio: Any = q("mode", "",
        "undamped natural frequencies over the primary's own; infinite where parts are locked",
        name="undamped natural frequency ratio",
    )  # fmt: skip
    antiresonance: Any = q("", "", "frequency at which an undamped absorber stops the primary",
        name="frequency ratio of the antiresonance")  # fmt: skip
    locked_frequency_ratio: Any = q("", "", "natural frequency with the absorber locked",
        name="natural frequency ratio, absorber locked")  # fmt: skip
    primary_frequency: Any = named("", "rad/s", "natural frequency of the primary alone")
    pole: Any = q("pole", "", "damped pole over the primary's own frequency, complex")


class EachResponse(Group):
    """Motions of each of several absorbers."""

    ROOT: ClassVar[str] = f"{RESPONSE_ROOT}/each"
    relative_curve: Any = q("curve absorber frequency_ratio", "",
        "motion of each absorber against what carries it, as a ratio, complex", PEAK,
    )  # fmt: skip
    largest_travel: Any = q("curve absorber", "",
        "largest motion of each absorber against what carries it")  # fmt: skip


class Peaks(Group):
    """Maxima of all curves."""

    ROOT: ClassVar[str] = f"{RESPONSE_ROOT}/peak"
    magnitude: Any = q("curve peak", "", "maxima of the response; 0: none",
        name="maximum of the response")  # fmt: skip
    frequency_ratio: Any = q("curve peak", "", "frequency ratios of the maxima; 0: none",
        name="frequency ratio of a maximum")  # fmt: skip


class FixedPoints(Group):
    """Points that the curves of all dampings of the absorber pass."""

    ROOT: ClassVar[str] = f"{RESPONSE_ROOT}/fixed_point"
    frequency_ratio: Any = q("fixed_point", "",
        "frequency at which the absorber's damping does not matter",
        name="frequency ratio")  # fmt: skip
    magnitude: Any = q("fixed_point", "", "response at the fixed point", name="response")


# ----------------------------------------------------------------------------
# Results of a tuning: the optimum, what proves it, what errors cost, other methods, charts.
# ----------------------------------------------------------------------------


class Tuning(Group):
    """The best absorber, and what it brings."""

    ROOT: ClassVar[str] = TUNING_ROOT
    peak: Any = lead("", "", "largest response of the primary, tuned")
    peak_alone: Any = lead(
        "", "", "largest response without the absorber", about="at any frequency"
    )
    peak_less_one: Any = q("", "", "largest response less 1, with its own error")
    mean_square: Any = lead("", "", "mean square response, tuned",
        about="integral over all frequencies")  # fmt: skip
    mean_square_alone: Any = lead("", "", "mean square response without the absorber")
    mass_ratio: Any = q("", "", "inertia of the absorber over that of the primary",
        name="mass ratio, absorber / primary")  # fmt: skip
    primary_damping: Any = named("", "", "damping ratio of the primary")
    stiffness_ratio: Any = lead("", "", "stiffness ratio, absorber / primary",
        about="tuned", unless=f"{TUNING_ROOT}/secondary_frequency")  # fmt: skip
    damping_over_primary_critical: Any = lead("", "",
        "damping of the absorber / critical damping of the primary",
        unless=f"{TUNING_ROOT}/absorber_damping_ratio")  # fmt: skip
    absorber_damping_ratio: Any = lead("", "", "damping ratio of the absorber")
    travel: Any = lead("", "", _TRAVEL, unless=f"{RESPONSE_ROOT}/motion/in_band/travel",
        about=_OVER)  # fmt: skip
    certificate: Any = q("", "", "remainder of the gradients: 0 for an optimum",
        exempt=CHECK, diagnostic=True)  # fmt: skip
    helps: Any = q("", "", "1: a sprung or damped absorber helps, 0: none does")
    without_spring: Any = q("", "", "1: the best absorber has no spring")
    threshold: Any = q("", "", "damping of the primary above which no absorber helps")
    evaluations: Any = q("", "", "peak evaluations of the search", diagnostic=True)
    torsional_stiffness: Any = lead("", "N*m/rad", "spring of the absorber")
    torsional_damping: Any = lead("", "N*m*s/rad", "damper of the absorber")
    linear_stiffness: Any = lead("", "N/m", "spring of the absorber")
    linear_damping: Any = lead("", "N*s/m", "damper of the absorber")
    secondary_frequency: Any = lead("", "rad/s", "natural frequency of the absorber alone")


class Active(Group):
    """The peaks that hold a tuning."""

    ROOT: ClassVar[str] = f"{TUNING_ROOT}/active"
    frequency_ratio: Any = q("active", "", "frequency ratios of the governing peaks",
        exempt=DIFFERENCE)  # fmt: skip
    magnitude: Any = q("active", "", "response at the governing peaks", exempt=DIFFERENCE)
    weight: Any = q(
        "active", "", "weights with which the gradients of these peaks cancel", exempt=DIFFERENCE
    )


_BUILT = f"{TUNING_ROOT}/each/frequency"


class EachTuned(Group):
    """Mass, spring and damper of each of several absorbers."""

    ROOT: ClassVar[str] = f"{TUNING_ROOT}/each"
    mass_ratio: Any = q("absorber", "", "mass ratio of each absorber", exempt=DIFFERENCE)
    stiffness_ratio: Any = lead("absorber", "", "stiffness ratio of absorber",
        pick="each", unless=_BUILT, exempt=DIFFERENCE)  # fmt: skip
    damping_over_primary_critical: Any = q("absorber", "",
        "damping of absorber, c2 / (2 sqrt(K1 J1))", exempt=DIFFERENCE)  # fmt: skip
    absorber_damping_ratio: Any = lead("absorber", "", "damping ratio of absorber",
        pick="each", unless=_BUILT, exempt=DIFFERENCE)  # fmt: skip
    torsional_stiffness: Any = lead("absorber", "N*m/rad", "spring of absorber",
        pick="each", exempt=DIFFERENCE)  # fmt: skip
    torsional_damping: Any = lead("absorber", "N*m*s/rad", "damper of absorber",
        pick="each", exempt=DIFFERENCE)  # fmt: skip
    linear_stiffness: Any = lead("absorber", "N/m", "spring of absorber",
        pick="each", exempt=DIFFERENCE)  # fmt: skip
    linear_damping: Any = lead("absorber", "N*s/m", "damper of absorber",
        pick="each", exempt=DIFFERENCE)  # fmt: skip
    frequency: Any = q("absorber", "rad/s",
        "natural frequency of each absorber, with what carries it held", exempt=DIFFERENCE,
    )  # fmt: skip
    travel: Any = q("absorber", "",
        "largest motion of each absorber against what carries it", exempt=DIFFERENCE)  # fmt: skip


#: what a tuning finds, said of several tunings, and in short
_FOUND = (
    ("stiffness_ratio", "stiffness of the absorber over that of the primary", "stiffness ratio"),
    (
        "damping_over_primary_critical",
        "damping of the absorber, c2 / (2 sqrt(K1 J1))",
        "damping / critical damping of the primary",
    ),
    ("peak", "largest response of the primary", "peak response"),
    ("absorber_damping_ratio", "damping ratio of the absorber", "damping ratio"),
)
#: other tunings, in tables below that of the best one: their axes and words
_OTHERS = (
    *(entry(f"{TUNING_ROOT}/method/{name}", "method", "", words) for name, words, _ in _FOUND[:3]),
    entry(f"{TUNING_ROOT}/method/promised", "method", "", "peak predicted by the formula"),
    entry(f"{TUNING_ROOT}/method/loss", "method", "",
        "objective over its optimum, less 1"),
    entry(f"{TUNING_ROOT}/mistuning/loss", "mistuned deviation", "",
        "objective with a relative error of the part, over its optimum, less 1"),
    entry(f"{TUNING_ROOT}/mistuning/worst", "share", "",
        "the same with the worst combination of such errors of spring and damper"),
    *(entry(f"{TUNING_ROOT}/sensitivity/{name}", "ratio", "",
        f"derivative of the optimum {words}", exempt=DIFFERENCE) for name, words, _ in _FOUND[:3]),
    *(entry(f"{TUNING_ROOT}/unbounded/{name}", "", "", f"{words}, without the bounds")
        for name, words, _ in _FOUND[:3]),
    entry(f"{TUNING_ROOT}/unbounded/travel", "", "",
        "largest relative motion of the absorber, without the bounds"),
    entry(f"{TUNING_ROOT}/bounds/active", "tuning_bound", "", "1: this bound is active"),
    entry(f"{TUNING_ROOT}/bounds/penalty", "", "",
        "peak within the bounds over that without, less 1"),
    *(entry(f"{TUNING_ROOT}/chart/{name}", "primary_damping mass_ratio", "", f"optimum {words}",
        name=f"optimum {short}") for name, words, short in _FOUND),
    entry(f"{TUNING_ROOT}/map/peak", "stiffness_ratio damping_over_primary_critical", "",
        "largest response around the optimum"),
)  # fmt: skip

# ----------------------------------------------------------------------------
# Results of what a tuning is built of: rod, springs, ring, gap, oils, stock, bending.
# ----------------------------------------------------------------------------

_PENALTY = "that peak over that of the tuning, less 1"
_PRIMARY = "c2 / (2 sqrt(K1 J1))"


class Hardware(Group):
    """What single parts are, and what the tuning asks of them."""

    ROOT: ClassVar[str] = HARDWARE_ROOT
    rod_stiffness: Any = q("", "N*m/rad", "torsional stiffness of the rod")
    ring_mass: Any = q("", "kg", "mass of the seismic ring")
    ring_inertia: Any = q("", "kg*m^2", "inertia of the seismic ring about its axis")
    primary_frequency: Any = q("", "rad/s", "natural frequency of the primary alone")
    spring_rate: Any = q("", "N/m", "required rate of each spring")
    clearance: Any = q("", "m", "clearance of the gap at the rim")
    dynamic_viscosity: Any = q("", "Pa*s", "required viscosity in the gap")


class Built(Group):
    """What springs and oil that are in give."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/built"
    stiffness_ratio: Any = named("", "", "stiffness ratio, installed springs")
    damping_over_primary_critical: Any = named(
        "", "", "damping, installed oil / critical damping of the primary"
    )
    spring_rate: Any = named("", "N/m", "rate of each installed spring")
    peak: Any = named("", "", "largest response with the installed parts")
    peak_frequency: Any = named("", "rad/s", "peak frequency, installed parts")


class Films(Group):
    """Damping over dynamic viscosity of the films in the gap."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/gap"
    rim: Any = named("", "m^3", "damping / dynamic viscosity, rim")
    sides: Any = named("", "m^3", "damping / dynamic viscosity, sides")
    bore: Any = named("", "m^3", "damping / dynamic viscosity, bore")


class StockSprings(Group):
    """What springs that can be bought give."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/spring"
    rate: Any = q("stock_spring", "N/m", "rate of each spring")
    stiffness_ratio: Any = q("stock_spring", "", "stiffness ratio with these springs")


class StockOils(Group):
    """What oils that can be bought give."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/oil"
    kinematic_viscosity: Any = q("stock_oil", "m^2/s", "at the temperature of the gap")
    damping: Any = q("stock_oil", "N*m*s/rad", "damping of the gap with this oil")
    damping_over_primary_critical: Any = q("stock_oil", "", f"the same, {_PRIMARY}")
    right_temperature: Any = q("stock_oil", "K",
        "temperature at which the oil has the required viscosity; 0: never")  # fmt: skip


class StockDampers(Group):
    """What dampers that can be bought give."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/damper"
    damping: Any = q("stock_damper", "N*s/m", "damping of all such dampers together")
    damping_over_primary_critical: Any = q("stock_damper", "", "the same, c2 / (2 sqrt(K1 M1))")


class Pairs(Group):
    """The response with every pair of parts in stock."""

    peak: Any = q("stock_spring stock_{part}", "",
        "largest response with these springs and this {part}")  # fmt: skip
    penalty: Any = q("stock_spring stock_{part}", "", _PENALTY, exempt=DIFFERENCE)
    travel: Any = q("stock_spring stock_{part}", "", "largest relative motion of the absorber")
    allowed: Any = q("stock_spring stock_{part}", "", "1: within the bounds of the case")


class OilPairs(Pairs):
    """Springs with oils."""

    ROOT = f"{HARDWARE_ROOT}/pair"
    WORDS: ClassVar = {"part": "oil"}


class DamperPairs(Pairs):
    """Springs with dampers."""

    ROOT = f"{HARDWARE_ROOT}/damper_pair"
    WORDS: ClassVar = {"part": "damper"}


class Buy(Group):
    """The best pair in stock."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/buy"
    peak: Any = lead("", "", "largest response with the best stock parts")
    penalty: Any = q("", "", _PENALTY, exempt=DIFFERENCE)


class Warming(Group):
    """What the absorber becomes as its oil warms."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/warming"
    damping: Any = q("temperature", "N*m*s/rad", "damping of the best oil over temperature")
    damping_over_primary_critical: Any = q("temperature", "", _PRIMARY)
    peak: Any = q("temperature", "", "largest response with the same springs and oil")
    best_stiffness_ratio: Any = q("temperature", "",
        "optimum stiffness for this damping")  # fmt: skip
    best_peak: Any = q("temperature", "", "peak with such springs")


class Bending(Group):
    """Bending of the rod."""

    ROOT: ClassVar[str] = f"{HARDWARE_ROOT}/bending"
    frequency: Any = q("mode", "rad/s", "bending frequency of the rod with its flywheel")
    forward: Any = q("mode", "rad/s", "forward whirl frequency")
    backward: Any = q("mode", "rad/s", "backward whirl frequency")
    rayleigh: Any = q("", "rad/s", "Rayleigh quotient for half a sine")


# ----------------------------------------------------------------------------
# Results of a mass that dry friction drags along.
# ----------------------------------------------------------------------------


class FrictionDamped(Group):
    """A primary with a friction damper, by the first harmonic of the friction."""

    ROOT: ClassVar[str] = FRICTION_ROOT
    mass_ratio: Any = q("", "", "inertia of the damper over that of the primary")
    friction_ratio: Any = lead("", "", "friction ratio of the damper",
        about="friction over the amplitude of the force on the primary")  # fmt: skip
    friction_torque: Any = lead("", "N*m", "friction torque of the damper")
    friction_force: Any = lead("", "N", "friction force of the damper")
    largest: Any = q(
        "",
        "",
        "largest response with the damper, over T0 / K1",
        headline=Headline(
            "largest response with the damper", at=f"{FRICTION_ROOT}/largest_frequency_ratio"
        ),
    )
    largest_frequency_ratio: Any = named("", "", "frequency ratio of the largest response",
        exempt=PLACE)  # fmt: skip
    largest_angle: Any = lead("", "rad", "largest angle of the primary", PEAK)
    largest_displacement: Any = lead("", "m", "largest displacement of the primary", PEAK)
    best_friction_ratio: Any = named("", "", "optimum friction ratio",
        exempt=PLACE)  # fmt: skip
    best_largest: Any = named("", "", "largest response with the optimum friction")
    curve: Any = q("frequency_ratio", "", "response of the primary with the damper, over T0 / K1",
        PEAK, curve="friction_damper", name="response of the primary")  # fmt: skip


# ----------------------------------------------------------------------------
# Results of pendulums in the centrifugal field of a rotor.
# ----------------------------------------------------------------------------


class Pendulum(Group):
    """The order that pendulums follow, and the absorber that they are."""

    ROOT: ClassVar[str] = PENDULUM_ROOT
    order: Any = lead("", "", "order of the pendulum", about="of small swings")
    path_radius: Any = named("", "m", "radius of the path at its vertex")
    path_exponent: Any = named("", "", "path exponent (0 circle, 1 cycloid)")
    detuning: Any = named("", "1/rad^2", "relative change of order / swing squared")
    largest_swing: Any = named("", "rad", "maximum swing of the pendulum on its path")
    mass_ratio: Any = named("", "", "mass ratio of the equivalent absorber")
    inertia: Any = named("", "kg*m^2", "inertia of the equivalent absorber")
    stiffness: Any = named("", "N*m/rad", "stiffness of the equivalent absorber")
    order_of_swing: Any = q("swing", "", "order of the pendulum at this swing")


class SmallSwings(Group):
    """Motions under the torque of the case by equations for small swings, complex."""

    ROOT: ClassVar[str] = f"{PENDULUM_ROOT}/small"
    rotor: Any = named("", "rad", "motion of the rotor, small swings", PEAK)
    swing: Any = lead("", "rad", "swing of the pendulums under the torque, small swings", PEAK)
    rotor_without: Any = named("", "rad", "motion of the rotor, pendulums locked", PEAK)


class OverOrders(Group):
    """The same over the order of the torque."""

    ROOT: ClassVar[str] = f"{PENDULUM_ROOT}/response"
    rotor: Any = q("order_ratio", "rad", "motion of the rotor, complex", PEAK)
    without: Any = q("order_ratio", "rad", "the same, pendulums locked", PEAK)


class SteadySwings(Group):
    """Swings of an undamped pendulum by its exact equations."""

    ROOT: ClassVar[str] = f"{PENDULUM_ROOT}/steady"
    torque: Any = q("steady_swing", "N*m", "torque of a steady swing, undamped")
    largest_swing: Any = q("steady_swing", "rad", "largest angle of swing over the cycle")


class Jump(Group):
    """The end of the motion out of rest."""

    ROOT: ClassVar[str] = f"{PENDULUM_ROOT}/jump"
    torque: Any = lead("", "N*m", "torque at which the swing jumps", about="infinite: at none")
    swing: Any = lead("", "rad", "largest swing before the jump", about="infinite: no jump",
        exempt=DIFFERENCE)  # fmt: skip


#: axis name -> (unit, long name)
AXES = MOTION_AXES | {
    "tuning_bound": ("", "bound of the tuning"),
    "curve": ("", "absorber of the curve"),
    "fixed_point": ("", "point that all curves pass"),
    "absorber": ("", "absorber"),
    "mistuned": ("", "part with an error"),
    "deviation": ("", "relative error of the part"),
    "share": ("", "relative error, of either sign"),
    "ratio": ("", "given ratio"),
    "primary_damping": ("", "damping of the primary, c1 / (2 sqrt(K1 J1))"),
    "mass_ratio": ("", "inertia of the absorber over that of the primary"),
    "stiffness_ratio": ("", "stiffness of the absorber over that of the primary"),
    "damping_over_primary_critical": ("", "damping of the absorber, c2 / (2 sqrt(K1 J1))"),
    "stock_spring": ("", "spring that can be bought"),
    "stock_oil": ("", "oil that can be bought"),
    "stock_damper": ("", "damper that can be bought"),
    "temperature": ("K", "temperature of the oil"),
    "swing": ("rad", "angle of swing"),
    "steady_swing": ("rad", "first sine of the swing"),
    "order_ratio": ("", "order of the excitation over the required one"),
}
#: axis name -> names of its entries, where they are the same in every case
NAMES = {
    "fixed_point": ("P", "Q"),
    "mistuned": ("stiffness", "damping"),
    "ratio": ("primary_damping", "mass_ratio"),
    "toleranced": ("natural_frequency", "mass", "stiffness", "damping"),
}
#: the largest response and the maxima of its curves, of which a search sees each
MAXIMA = {f"{RESPONSE_ROOT}/largest": f"{RESPONSE_ROOT}/peak/magnitude"}
ENTRIES = (
    *entries_of(Tuning, Active, EachTuned),
    *_OTHERS,
    *BAND_ENTRIES,
    *entries_of(Response, EachResponse, Peaks, FixedPoints, Hardware, Built, Films),
    *entries_of(StockSprings, StockOils, StockDampers, OilPairs, DamperPairs, Buy, Warming),
    *entries_of(Bending, FrictionDamped, Pendulum, SmallSwings, OverOrders, SteadySwings, Jump),
    *MOTION_ENTRIES,
)

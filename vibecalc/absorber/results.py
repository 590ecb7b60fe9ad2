"""Results of absorbers: response, tuning, hardware, and pendulums on a rotor."""

from vibecalc.absorber.motion_results import AXES as MOTION_AXES
from vibecalc.absorber.motion_results import BAND_ENTRIES, MOTION_ENTRIES
from vibecalc.core.results.record import CHECK, DIFFERENCE, PEAK, Headline, entry

# ----------------------------------------------------------------------------
# Results of a primary system with its absorber: curves, peaks, fixed points, poles.
# ----------------------------------------------------------------------------

RESPONSE_ROOT = "response/absorber"

RESPONSE_ENTRIES = (
    entry(
        f"{RESPONSE_ROOT}/curve",
        "curve frequency_ratio",
        "",
        "response of the primary as a ratio, complex",
        PEAK,
    ),
    entry(
        f"{RESPONSE_ROOT}/relative_curve",
        "curve frequency_ratio",
        "",
        "motion of the absorber against the primary, as a ratio, complex",
        PEAK,
    ),
    entry(
        f"{RESPONSE_ROOT}/each/relative_curve",
        "curve absorber frequency_ratio",
        "",
        "motion of each absorber against what carries it, as a ratio, complex",
        PEAK,
    ),
    entry(f"{RESPONSE_ROOT}/frequency", "frequency_ratio", "rad/s", "frequency of the excitation"),
    entry(
        f"{RESPONSE_ROOT}/largest",
        "curve",
        "",
        "largest response at any frequency",
        headline=Headline(
            "largest response of the primary",
            pick="first",
            at="response/absorber/largest_frequency_ratio",
            unless="tuning/peak",
        ),
    ),
    entry(
        f"{RESPONSE_ROOT}/largest_frequency_ratio",
        "curve",
        "",
        "where that is, over the primary's own frequency; infinite for a limit at high frequency",
    ),
    entry(
        f"{RESPONSE_ROOT}/peak/magnitude",
        "curve peak",
        "",
        "maxima of the response; 0: no such one",
    ),
    entry(
        f"{RESPONSE_ROOT}/peak/frequency_ratio",
        "curve peak",
        "",
        "where they are; 0: no such one",
    ),
    entry(
        f"{RESPONSE_ROOT}/largest_travel",
        "curve",
        "",
        "largest relative motion of the absorber",
        headline=Headline(
            "largest travel of the absorber, as a ratio", pick="first", unless="tuning/peak"
        ),
    ),
    entry(
        f"{RESPONSE_ROOT}/each/largest_travel",
        "curve absorber",
        "",
        "largest motion of each absorber against what carries it",
    ),
    entry(
        f"{RESPONSE_ROOT}/fixed_point/frequency_ratio",
        "fixed_point",
        "",
        "frequency at which the absorber's damping does not matter",
    ),
    entry(f"{RESPONSE_ROOT}/fixed_point/magnitude", "fixed_point", "", "response there"),
    entry(
        f"{RESPONSE_ROOT}/natural_frequency_ratio",
        "mode",
        "",
        "undamped natural frequencies over the primary's own; infinite where parts are locked",
    ),
    entry(
        f"{RESPONSE_ROOT}/antiresonance",
        "",
        "",
        "frequency at which an undamped absorber holds still",
    ),
    entry(
        f"{RESPONSE_ROOT}/locked_frequency_ratio",
        "",
        "",
        "natural frequency with the absorber locked",
    ),
    entry(
        f"{RESPONSE_ROOT}/primary_frequency", "", "rad/s", "natural frequency of the primary alone"
    ),
    entry(
        f"{RESPONSE_ROOT}/pole", "pole", "", "damped pole over the primary's own frequency, complex"
    ),
)

# ----------------------------------------------------------------------------
# Results of a tuning: the optimum, what proves it, what errors cost, other methods, charts.
# ----------------------------------------------------------------------------

TUNING_ROOT = "tuning"

_FOUND = (
    ("stiffness_ratio", "stiffness of the absorber over that of the primary"),
    ("secondary_damping", "damping of the absorber, c2 / (2 sqrt(K1 J1))"),
    ("peak", "largest response of the primary"),
)
_OF_EACH = (
    *_FOUND[:2],
    ("own_damping", "damping of the absorber on its own frequency, c2 / (2 J2 w2)"),
)

_TUNED = {
    "stiffness_ratio": Headline("stiffness ratio, tuned", unless="tuning/secondary_frequency"),
    "secondary_damping": Headline(
        "damping of the absorber, c2/(2 sqrt(K1 J1))", unless="tuning/own_damping"
    ),
    "own_damping": Headline("damping ratio of the absorber, c2/(2 J2 w2)"),
}
_EACH_TUNED = {
    name: Headline(words, pick="each", unless="tuning/each/frequency")
    for name, words in (
        ("stiffness_ratio", "stiffness ratio of absorber"),
        ("own_damping", "damping ratio of absorber, c2/(2 J2 w2)"),
    )
}
_BUILT = {
    "torsional_stiffness": Headline("spring of absorber", "N*m/rad", pick="each"),
    "torsional_damping": Headline("damper of absorber", "N*m*s/rad", pick="each"),
    "linear_stiffness": Headline("spring of absorber", "N/mm", pick="each"),
    "linear_damping": Headline("damper of absorber", "N*s/m", pick="each"),
}

TUNING_ENTRIES = (
    entry(
        f"{TUNING_ROOT}/peak",
        "",
        "",
        "largest response of the primary with this tuning",
        headline=Headline("largest response of the primary, tuned"),
    ),
    entry(
        f"{TUNING_ROOT}/peak_alone",
        "",
        "",
        "largest response without an absorber",
        headline=Headline("the same without the absorber"),
    ),
    entry(
        f"{TUNING_ROOT}/peak_less_one",
        "",
        "",
        "that less 1, to its own digits",
        name="largest response less 1",
    ),
    entry(
        f"{TUNING_ROOT}/mean_square",
        "",
        "",
        "integral of the squared response over all frequencies",
        headline=Headline("mean square response, tuned"),
    ),
    entry(
        f"{TUNING_ROOT}/mean_square_alone",
        "",
        "",
        "the same without an absorber",
        headline=Headline("the same without the absorber"),
    ),
    entry(f"{TUNING_ROOT}/mass_ratio", "", "", "inertia of the absorber over that of the primary"),
    entry(
        f"{TUNING_ROOT}/primary_damping",
        "",
        "",
        "damping of the primary, c1 / (2 sqrt(K1 J1))",
        name="damping of the primary, c1/(2 sqrt(K1 J1))",
    ),
    *(
        entry(f"{TUNING_ROOT}/{name}", "", "", f"best {words}", headline=_TUNED.get(name))
        for name, words in _OF_EACH
    ),
    entry(
        f"{TUNING_ROOT}/travel",
        "",
        "",
        "largest motion of the absorber against the primary",
        headline=Headline(
            "largest travel of the absorber, as a ratio",
            unless="response/absorber/motion/in_band/travel",
        ),
    ),
    entry(
        f"{TUNING_ROOT}/active/frequency_ratio",
        "active",
        "",
        "frequencies of the peaks that hold it",
        exempt=DIFFERENCE,
    ),
    entry(f"{TUNING_ROOT}/active/magnitude", "active", "", "their heights", exempt=DIFFERENCE),
    entry(
        f"{TUNING_ROOT}/active/weight",
        "active",
        "",
        "weights with which their slopes cancel",
        exempt=DIFFERENCE,
    ),
    entry(
        f"{TUNING_ROOT}/certificate",
        "",
        "",
        "what is left of the slopes: 0 for an optimum",
        exempt=CHECK,
        diagnostic=True,
    ),
    entry(f"{TUNING_ROOT}/helps", "", "", "1: a sprung or damped absorber helps, 0: none does"),
    entry(f"{TUNING_ROOT}/without_spring", "", "", "1: the best absorber has no spring"),
    entry(
        f"{TUNING_ROOT}/threshold", "", "", "damping of the primary from which on no absorber helps"
    ),
    entry(
        f"{TUNING_ROOT}/evaluations",
        "",
        "",
        "evaluations of a peak that the search took",
        diagnostic=True,
    ),
    entry(
        f"{TUNING_ROOT}/torsional_stiffness",
        "",
        "N*m/rad",
        "best stiffness of the absorber",
        headline=Headline("spring of the absorber", "N*m/rad"),
    ),
    entry(
        f"{TUNING_ROOT}/torsional_damping",
        "",
        "N*m*s/rad",
        "best damping of the absorber",
        headline=Headline("damper of the absorber", "N*m*s/rad"),
    ),
    entry(
        f"{TUNING_ROOT}/linear_stiffness",
        "",
        "N/m",
        "best stiffness of the absorber",
        headline=Headline("spring of the absorber", "N/mm"),
    ),
    entry(
        f"{TUNING_ROOT}/linear_damping",
        "",
        "N*s/m",
        "best damping of the absorber",
        headline=Headline("damper of the absorber", "N*s/m"),
    ),
    entry(
        f"{TUNING_ROOT}/secondary_frequency",
        "",
        "rad/s",
        "natural frequency of the absorber alone",
        headline=Headline("natural frequency of the absorber alone", "Hz"),
    ),
    *(
        entry(
            f"{TUNING_ROOT}/each/{name}",
            "absorber",
            "",
            f"best {words}, of each absorber",
            headline=_EACH_TUNED.get(name),
            exempt=DIFFERENCE,
        )
        for name, words in (("mass_ratio", "mass ratio"), *_OF_EACH)
    ),
    *(
        entry(
            f"{TUNING_ROOT}/each/{name}",
            "absorber",
            unit,
            f"{words} of each absorber",
            headline=_BUILT.get(name),
            exempt=DIFFERENCE,
        )
        for name, unit, words in (
            ("torsional_stiffness", "N*m/rad", "best stiffness"),
            ("torsional_damping", "N*m*s/rad", "best damping"),
            ("linear_stiffness", "N/m", "best stiffness"),
            ("linear_damping", "N*s/m", "best damping"),
            ("frequency", "rad/s", "natural frequency, with what carries it held,"),
            ("travel", "", "largest motion against what carries it,"),
        )
    ),
    *(entry(f"{TUNING_ROOT}/method/{name}", "method", "", words) for name, words in _FOUND),
    entry(f"{TUNING_ROOT}/method/promised", "method", "", "peak that the formula itself promises"),
    entry(
        f"{TUNING_ROOT}/method/loss", "method", "", "what is made small over the optimum, less 1"
    ),
    entry(
        f"{TUNING_ROOT}/mistuning/loss",
        "mistuned deviation",
        "",
        "what a relative error of the part costs: what is made small over the optimum, less 1",
    ),
    entry(
        f"{TUNING_ROOT}/mistuning/worst",
        "share",
        "",
        "the same with spring and damper off by such a share, the worse way",
    ),
    *(
        entry(
            f"{TUNING_ROOT}/sensitivity/{name}",
            "ratio",
            "",
            f"slope of the best {words}, by a ratio",
            exempt=DIFFERENCE,
        )
        for name, words in _FOUND
    ),
    *(
        entry(f"{TUNING_ROOT}/unbounded/{name}", "", "", f"{words}, without the bounds")
        for name, words in _FOUND
    ),
    entry(
        f"{TUNING_ROOT}/unbounded/travel", "", "", "largest relative motion of the absorber there"
    ),
    entry(f"{TUNING_ROOT}/bounds/active", "tuning_bound", "", "1: this bound holds the tuning"),
    entry(
        f"{TUNING_ROOT}/bounds/penalty", "", "", "peak within the bounds over that without, less 1"
    ),
    *(
        entry(f"{TUNING_ROOT}/chart/{name}", "primary_damping mass_ratio", "", f"best {words}")
        for name, words in (*_OF_EACH, _FOUND[2])
    ),
    entry(
        f"{TUNING_ROOT}/map/peak",
        "stiffness_ratio secondary_damping",
        "",
        "largest response around the optimum",
    ),
)

# ----------------------------------------------------------------------------
# Results of what a tuning is built of: rod, springs, ring, gap, oils, stock, bending.
# ----------------------------------------------------------------------------

HARDWARE_ROOT = "hardware"
_ON_PAIR = "stock_spring stock_oil"
_WITH_DAMPER = "stock_spring stock_damper"

HARDWARE_ENTRIES = (
    entry(f"{HARDWARE_ROOT}/rod_stiffness", "", "N*m/rad", "torsional stiffness of the rod"),
    entry(f"{HARDWARE_ROOT}/ring_mass", "", "kg", "mass of the seismic ring"),
    entry(
        f"{HARDWARE_ROOT}/ring_inertia", "", "kg*m^2", "inertia of the seismic ring about its axis"
    ),
    entry(
        f"{HARDWARE_ROOT}/primary_frequency", "", "rad/s", "natural frequency of the primary alone"
    ),
    entry(
        f"{HARDWARE_ROOT}/built/stiffness_ratio",
        "",
        "",
        "of the springs that are in, over the primary",
    ),
    entry(
        f"{HARDWARE_ROOT}/built/secondary_damping",
        "",
        "",
        "of the oil that is in, c2 / (2 sqrt(K1 J1))",
    ),
    entry(f"{HARDWARE_ROOT}/built/spring_rate", "", "N/m", "rate of each spring that is in"),
    entry(f"{HARDWARE_ROOT}/built/peak", "", "", "largest response of the primary as built"),
    entry(f"{HARDWARE_ROOT}/built/peak_frequency", "", "rad/s", "where that is"),
    entry(f"{HARDWARE_ROOT}/spring_rate", "", "N/m", "rate of each spring that the tuning wants"),
    entry(f"{HARDWARE_ROOT}/clearance", "", "m", "clearance of the gap at the rim"),
    entry(f"{HARDWARE_ROOT}/gap/rim", "", "m^3", "damping over dynamic viscosity: at the rim"),
    entry(f"{HARDWARE_ROOT}/gap/sides", "", "m^3", "at the sides"),
    entry(f"{HARDWARE_ROOT}/gap/bore", "", "m^3", "in the bore"),
    entry(
        f"{HARDWARE_ROOT}/dynamic_viscosity",
        "",
        "Pa*s",
        "viscosity that the tuning wants in the gap",
    ),
    entry(f"{HARDWARE_ROOT}/spring/rate", "stock_spring", "N/m", "rate of each spring"),
    entry(f"{HARDWARE_ROOT}/spring/stiffness_ratio", "stock_spring", "", "what such springs give"),
    entry(
        f"{HARDWARE_ROOT}/oil/kinematic_viscosity",
        "stock_oil",
        "m^2/s",
        "at the temperature of the gap",
    ),
    entry(
        f"{HARDWARE_ROOT}/oil/damping",
        "stock_oil",
        "N*m*s/rad",
        "what such an oil gives in the gap",
    ),
    entry(
        f"{HARDWARE_ROOT}/oil/secondary_damping", "stock_oil", "", "the same, c2 / (2 sqrt(K1 J1))"
    ),
    entry(
        f"{HARDWARE_ROOT}/oil/right_temperature",
        "stock_oil",
        "K",
        "at which it is as thick as the tuning wants; 0: never",
    ),
    entry(
        f"{HARDWARE_ROOT}/pair/peak",
        _ON_PAIR,
        "",
        "largest response with these springs and this oil",
    ),
    entry(
        f"{HARDWARE_ROOT}/pair/penalty",
        _ON_PAIR,
        "",
        "that peak over the one of the tuning, less 1",
    ),
    entry(f"{HARDWARE_ROOT}/pair/travel", _ON_PAIR, "", "largest relative motion of the absorber"),
    entry(f"{HARDWARE_ROOT}/pair/allowed", _ON_PAIR, "", "1: it keeps the bounds of the case"),
    entry(
        f"{HARDWARE_ROOT}/damper/damping", "stock_damper", "N*s/m", "of all such dampers together"
    ),
    entry(
        f"{HARDWARE_ROOT}/damper/secondary_damping",
        "stock_damper",
        "",
        "the same, c2 / (2 sqrt(K1 M1))",
    ),
    *(
        entry(
            f"{HARDWARE_ROOT}/damper_pair/{name}",
            _WITH_DAMPER,
            "",
            words,
            exempt=DIFFERENCE * (name == "penalty"),
        )
        for name, words in (
            ("peak", "largest response with these springs and this damper"),
            ("penalty", "that peak over the one of the tuning, less 1"),
            ("travel", "largest relative motion of the absorber"),
            ("allowed", "1: it keeps the bounds of the case"),
        )
    ),
    entry(
        f"{HARDWARE_ROOT}/buy/peak",
        "",
        "",
        "largest response with the best pair of stock parts",
        headline=Headline("largest response with the best stock parts"),
    ),
    entry(
        f"{HARDWARE_ROOT}/buy/penalty",
        "",
        "",
        "that peak over the one of the tuning, less 1",
        exempt=DIFFERENCE,
    ),
    entry(
        f"{HARDWARE_ROOT}/warming/damping",
        "temperature",
        "N*m*s/rad",
        "of the best oil as it warms",
    ),
    entry(f"{HARDWARE_ROOT}/warming/secondary_damping", "temperature", "", "c2 / (2 sqrt(K1 J1))"),
    entry(
        f"{HARDWARE_ROOT}/warming/peak",
        "temperature",
        "",
        "largest response with springs and oil kept",
    ),
    entry(
        f"{HARDWARE_ROOT}/warming/best_stiffness_ratio",
        "temperature",
        "",
        "stiffness that would be best for this damping",
    ),
    entry(f"{HARDWARE_ROOT}/warming/best_peak", "temperature", "", "peak with such springs"),
    entry(
        f"{HARDWARE_ROOT}/bending/frequency",
        "mode",
        "rad/s",
        "bending of the rod with its flywheel",
    ),
    entry(f"{HARDWARE_ROOT}/bending/forward", "mode", "rad/s", "whirl with the spin"),
    entry(f"{HARDWARE_ROOT}/bending/backward", "mode", "rad/s", "whirl against the spin"),
    entry(f"{HARDWARE_ROOT}/bending/rayleigh", "", "rad/s", "Rayleigh's quotient for half a sine"),
)

# ----------------------------------------------------------------------------
# Results of pendulums in the centrifugal field of a rotor.
# ----------------------------------------------------------------------------

PENDULUM_ROOT = "pendulum"

PENDULUM_ENTRIES = (
    entry(
        f"{PENDULUM_ROOT}/order",
        "",
        "",
        "order that small swings follow",
        headline=Headline("order of the pendulum"),
    ),
    entry(
        f"{PENDULUM_ROOT}/path_radius",
        "",
        "m",
        "radius of curvature of the path at its vertex",
        name="radius of the path at its vertex",
    ),
    entry(
        f"{PENDULUM_ROOT}/path_exponent",
        "",
        "",
        "0: a circle, 1: a cycloid",
        name="form of the path (0 circle, 1 cycloid)",
    ),
    entry(
        f"{PENDULUM_ROOT}/detuning",
        "",
        "1/rad^2",
        "relative change of the order by the swing squared",
        name="change of the order by the swing squared",
    ),
    entry(
        f"{PENDULUM_ROOT}/largest_swing",
        "",
        "rad",
        "where the path ends",
        headline=Headline("swing at which the path of the pendulum ends", "deg"),
    ),
    entry(
        f"{PENDULUM_ROOT}/mass_ratio",
        "",
        "",
        "inertia of the equivalent absorber over the rotor's",
        name="mass ratio of the equivalent absorber",
    ),
    entry(
        f"{PENDULUM_ROOT}/inertia",
        "",
        "kg*m^2",
        "inertia of the equivalent absorber",
        name="inertia of the equivalent absorber",
    ),
    entry(
        f"{PENDULUM_ROOT}/stiffness",
        "",
        "N*m/rad",
        "stiffness of the equivalent absorber at this speed",
        name="stiffness of the equivalent absorber",
    ),
    entry(
        f"{PENDULUM_ROOT}/order_of_swing",
        "swing",
        "",
        "order that the pendulum keeps at this swing",
    ),
    entry(
        f"{PENDULUM_ROOT}/small/rotor",
        "",
        "rad",
        "motion of the rotor, small swings, complex",
        PEAK,
        name="motion of the rotor, small swings",
    ),
    entry(
        f"{PENDULUM_ROOT}/small/swing",
        "",
        "rad",
        "swing, small swings, complex",
        PEAK,
        name="swing of the pendulums, small swings",
    ),
    entry(
        f"{PENDULUM_ROOT}/small/rotor_without",
        "",
        "rad",
        "the same with the pendulums locked",
        PEAK,
        name="motion of the rotor, pendulums locked",
    ),
    entry(
        f"{PENDULUM_ROOT}/response/rotor",
        "order_ratio",
        "rad",
        "motion of the rotor, complex",
        PEAK,
    ),
    entry(
        f"{PENDULUM_ROOT}/response/without",
        "order_ratio",
        "rad",
        "the same, pendulums locked",
        PEAK,
    ),
    entry(
        f"{PENDULUM_ROOT}/steady/torque",
        "steady_swing",
        "N*m",
        "torque that holds a steady swing, undamped",
    ),
    entry(
        f"{PENDULUM_ROOT}/steady/largest_swing",
        "steady_swing",
        "rad",
        "largest angle of swing over the cycle",
    ),
    entry(
        f"{PENDULUM_ROOT}/jump/torque",
        "",
        "N*m",
        "torque beyond which the pendulum jumps; infinite",
        headline=Headline("torque at which the swing jumps", "N*m"),
    ),
    entry(
        f"{PENDULUM_ROOT}/jump/swing",
        "",
        "rad",
        "largest angle of swing, from which it jumps",
        exempt=DIFFERENCE,
        name="largest swing, from which it jumps",
    ),
)

#: axis name -> (unit, long name)
AXES = MOTION_AXES | {
    "tuning_bound": ("", "what may hold a tuning"),
    "curve": ("", "absorber that the curve is of"),
    "fixed_point": ("", "point that all curves pass"),
    "absorber": ("", "absorber"),
    "mistuned": ("", "part with an error"),
    "deviation": ("", "relative error of the part"),
    "share": ("", "relative error, of either sign"),
    "ratio": ("", "given ratio"),
    "primary_damping": ("", "damping of the primary, c1 / (2 sqrt(K1 J1))"),
    "mass_ratio": ("", "inertia of the absorber over that of the primary"),
    "stiffness_ratio": ("", "stiffness of the absorber over that of the primary"),
    "secondary_damping": ("", "damping of the absorber, c2 / (2 sqrt(K1 J1))"),
    "stock_spring": ("", "spring that can be bought"),
    "stock_oil": ("", "oil that can be bought"),
    "stock_damper": ("", "damper that can be bought"),
    "temperature": ("K", "temperature of the oil"),
    "swing": ("rad", "angle of swing"),
    "steady_swing": ("rad", "first sine of the swing"),
    "order_ratio": ("", "order of the excitation over the wanted one"),
}
#: axis name -> names of its entries, where they are the same in every case
NAMES = {
    "fixed_point": ("P", "Q"),
    "mistuned": ("stiffness", "damping"),
    "ratio": ("primary_damping", "mass_ratio"),
    "toleranced": ("natural_frequency", "mass", "stiffness", "damping"),
}
ENTRIES = (
    *TUNING_ENTRIES,
    *BAND_ENTRIES,
    *RESPONSE_ENTRIES,
    *HARDWARE_ENTRIES,
    *PENDULUM_ENTRIES,
    *MOTION_ENTRIES,
)

"""Results of a tuning: the optimum, what proves it, what errors cost, other methods, charts."""

from vibecalc.pipeline.entries.entry import entry

ROOT = "tuning"

_FOUND = (
    ("stiffness_ratio", "stiffness of the absorber over that of the primary"),
    ("secondary_damping", "damping of the absorber, c2 / (2 sqrt(K1 J1))"),
    ("peak", "largest response of the primary"),
)
_OF_EACH = (
    *_FOUND[:2],
    ("own_damping", "damping of the absorber on its own frequency, c2 / (2 J2 w2)"),
)

ENTRIES = (
    entry(f"{ROOT}/mass_ratio", "", "", "inertia of the absorber over that of the primary"),
    entry(f"{ROOT}/primary_damping", "", "", "damping of the primary, c1 / (2 sqrt(K1 J1))"),
    *(entry(f"{ROOT}/{name}", "", "", f"best {words}") for name, words in _OF_EACH),
    entry(f"{ROOT}/peak", "", "", "largest response of the primary with this tuning"),
    entry(f"{ROOT}/peak_less_one", "", "", "that less 1, to its own digits"),
    entry(f"{ROOT}/mean_square", "", "", "integral of the squared response over all frequencies"),
    entry(f"{ROOT}/mean_square_alone", "", "", "the same without an absorber"),
    entry(f"{ROOT}/peak_alone", "", "", "largest response without an absorber"),
    entry(f"{ROOT}/travel", "", "", "largest motion of the absorber against the primary"),
    entry(f"{ROOT}/active/frequency_ratio", "active", "", "frequencies of the peaks that hold it"),
    entry(f"{ROOT}/active/magnitude", "active", "", "their heights"),
    entry(f"{ROOT}/active/weight", "active", "", "weights with which their slopes cancel"),
    entry(f"{ROOT}/certificate", "", "", "what is left of the slopes: 0 for an optimum"),
    entry(f"{ROOT}/helps", "", "", "1: a sprung or damped absorber helps, 0: none does"),
    entry(f"{ROOT}/without_spring", "", "", "1: the best absorber has no spring"),
    entry(f"{ROOT}/threshold", "", "", "damping of the primary from which on no absorber helps"),
    entry(f"{ROOT}/evaluations", "", "", "evaluations of a peak that the search took"),
    entry(f"{ROOT}/torsional_stiffness", "", "N*m/rad", "best stiffness of the absorber"),
    entry(f"{ROOT}/torsional_damping", "", "N*m*s/rad", "best damping of the absorber"),
    entry(f"{ROOT}/linear_stiffness", "", "N/m", "best stiffness of the absorber"),
    entry(f"{ROOT}/linear_damping", "", "N*s/m", "best damping of the absorber"),
    entry(f"{ROOT}/secondary_frequency", "", "rad/s", "natural frequency of the absorber alone"),
    *(
        entry(f"{ROOT}/each/{name}", "absorber", "", f"best {words}, of each absorber")
        for name, words in (("mass_ratio", "mass ratio"), *_OF_EACH)
    ),
    *(
        entry(f"{ROOT}/each/{name}", "absorber", unit, f"{words} of each absorber")
        for name, unit, words in (
            ("torsional_stiffness", "N*m/rad", "best stiffness"),
            ("torsional_damping", "N*m*s/rad", "best damping"),
            ("linear_stiffness", "N/m", "best stiffness"),
            ("linear_damping", "N*s/m", "best damping"),
            ("frequency", "rad/s", "natural frequency, with what carries it held,"),
            ("travel", "", "largest motion against what carries it,"),
        )
    ),
    *(entry(f"{ROOT}/method/{name}", "method", "", words) for name, words in _FOUND),
    entry(f"{ROOT}/method/promised", "method", "", "peak that the formula itself promises"),
    entry(f"{ROOT}/method/loss", "method", "", "what is made small over the optimum, less 1"),
    entry(
        f"{ROOT}/mistuning/loss", "mistuned deviation", "",
        "what a relative error of the part costs: what is made small over the optimum, less 1",
    ),
    entry(
        f"{ROOT}/mistuning/worst", "share", "",
        "the same with spring and damper off by such a share, the worse way",
    ),
    *(
        entry(f"{ROOT}/sensitivity/{name}", "ratio", "", f"slope of the best {words}, by a ratio")
        for name, words in _FOUND
    ),
    *(
        entry(f"{ROOT}/unbounded/{name}", "", "", f"{words}, without the bounds")
        for name, words in _FOUND
    ),
    entry(f"{ROOT}/unbounded/travel", "", "", "largest relative motion of the absorber there"),
    entry(f"{ROOT}/bounds/active", "tuning_bound", "", "1: this bound holds the tuning"),
    entry(f"{ROOT}/bounds/penalty", "", "", "peak within the bounds over that without, less 1"),
    *(
        entry(f"{ROOT}/chart/{name}", "primary_damping mass_ratio", "", f"best {words}")
        for name, words in (*_OF_EACH, _FOUND[2])
    ),
    entry(
        f"{ROOT}/map/peak", "stiffness_ratio secondary_damping", "",
        "largest response around the optimum",
    ),
)  # fmt: skip

"""Results of a primary system with its absorber: curves, peaks, fixed points, poles."""

from vibecalc.pipeline.entries.entry import PEAK, entry

ROOT = "response/absorber"

ENTRIES = (
    entry(
        f"{ROOT}/curve", "curve frequency_ratio", "",
        "response of the primary as a ratio, complex", PEAK,
    ),
    entry(
        f"{ROOT}/relative_curve", "curve frequency_ratio", "",
        "motion of the absorber against the primary, as a ratio, complex", PEAK,
    ),
    entry(
        f"{ROOT}/each/relative_curve", "curve absorber frequency_ratio", "",
        "motion of each absorber against what carries it, as a ratio, complex", PEAK,
    ),
    entry(f"{ROOT}/frequency", "frequency_ratio", "rad/s", "frequency of the excitation"),
    entry(f"{ROOT}/largest", "curve", "", "largest response at any frequency"),
    entry(
        f"{ROOT}/largest_frequency_ratio", "curve", "",
        "where that is, over the primary's own frequency; infinite for a limit at high frequency",
    ),
    entry(f"{ROOT}/summit/magnitude", "curve summit", "", "maxima of the response; 0: no such one"),
    entry(f"{ROOT}/summit/frequency_ratio", "curve summit", "", "where they are; 0: no such one"),
    entry(f"{ROOT}/largest_travel", "curve", "", "largest relative motion of the absorber"),
    entry(
        f"{ROOT}/each/largest_travel", "curve absorber", "",
        "largest motion of each absorber against what carries it",
    ),
    entry(
        f"{ROOT}/fixed_point/frequency_ratio", "fixed_point", "",
        "frequency at which the absorber's damping does not matter",
    ),
    entry(f"{ROOT}/fixed_point/magnitude", "fixed_point", "", "response there"),
    entry(
        f"{ROOT}/natural_frequency_ratio", "mode", "",
        "undamped natural frequencies over the primary's own; infinite where parts are locked",
    ),
    entry(f"{ROOT}/antiresonance", "", "", "frequency at which an undamped absorber holds still"),
    entry(f"{ROOT}/locked_frequency_ratio", "", "", "natural frequency with the absorber locked"),
    entry(f"{ROOT}/primary_frequency", "", "rad/s", "natural frequency of the primary alone"),
    entry(f"{ROOT}/pole", "pole", "", "damped pole over the primary's own frequency, complex"),
)  # fmt: skip

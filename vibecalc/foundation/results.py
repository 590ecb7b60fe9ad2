"""Results of a machine on a foundation that moves."""

from vibecalc.core.results.record import PEAK, Headline, entry

ROOT = "foundation"
AXES = {
    "foundation_mode": ("", "mode of machine and foundation, up and down, lowest first"),
}
ENTRIES = (
    entry(f"{ROOT}/natural_frequency", "foundation_mode", "rad/s", "of machine and foundation"),
    entry(f"{ROOT}/machine", "order", "m", "motion of the machine up and down", PEAK),
    entry(f"{ROOT}/motion", "order", "m", "motion of the foundation up and down", PEAK),
    entry(f"{ROOT}/ground_force", "order", "N", "force on what carries the foundation", PEAK),
    entry(f"{ROOT}/rigid_force", "order", "N", "force on a foundation that does not move", PEAK),
    entry(f"{ROOT}/motion_peak", "", "m", "largest motion of the foundation over a cycle", PEAK),
    entry(
        f"{ROOT}/ground_force_peak", "", "N", "largest force on what carries the foundation", PEAK
    ),
    entry(
        f"{ROOT}/rigid_force_peak",
        "",
        "N",
        "largest force on one that does not move",
        PEAK,
    ),
)

#: what the reader of a report looks for first
HEADLINES = (
    Headline(
        "foundation/natural_frequency", "natural frequency, machine on foundation", "Hz", "each"
    ),
    Headline("foundation/motion_peak", "motion of the foundation, peak", "mm"),
    Headline("foundation/ground_force_peak", "force into the ground, peak", "N"),
    Headline("foundation/rigid_force_peak", "the same on a rigid foundation", "N"),
)

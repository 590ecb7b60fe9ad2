"""Results of a machine on a foundation that moves."""

from vibecalc.core.results.record import PEAK, Headline, entry
from vibecalc.foundation.coupled_results import AXES as COUPLED_AXES
from vibecalc.foundation.coupled_results import ENTRIES as COUPLED_ENTRIES

ROOT = "foundation"
AXES = {
    "foundation_mode": ("", "mode of machine and foundation, up and down, lowest first"),
    **COUPLED_AXES,
}
ENTRIES = (
    entry(
        f"{ROOT}/natural_frequency",
        "foundation_mode",
        "rad/s",
        "of machine and foundation",
        headline=Headline("natural frequency, machine on foundation", "Hz", pick="ends"),
    ),
    entry(f"{ROOT}/machine", "order", "m", "motion of the machine up and down", PEAK),
    entry(f"{ROOT}/motion", "order", "m", "motion of the foundation up and down", PEAK),
    entry(f"{ROOT}/ground_force", "order", "N", "force on what carries the foundation", PEAK),
    entry(f"{ROOT}/rigid_force", "order", "N", "force on a foundation that does not move", PEAK),
    entry(
        f"{ROOT}/motion_peak",
        "",
        "m",
        "largest motion of the foundation over a cycle",
        PEAK,
        headline=Headline("motion of the foundation, peak", "mm"),
    ),
    entry(
        f"{ROOT}/ground_force_peak",
        "",
        "N",
        "largest force on what carries the foundation",
        PEAK,
        headline=Headline("force into the ground, peak", "N"),
    ),
    entry(
        f"{ROOT}/rigid_force_peak",
        "",
        "N",
        "largest force on one that does not move",
        PEAK,
        headline=Headline("the same on a rigid foundation", "N"),
    ),
    *COUPLED_ENTRIES,
)

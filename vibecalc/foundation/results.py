"""Results of a machine on a foundation that moves."""

from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import entries_of, q
from vibecalc.core.results.record import PEAK, Headline
from vibecalc.foundation.coupled_results import AXES as COUPLED_AXES
from vibecalc.foundation.coupled_results import ENTRIES as COUPLED_ENTRIES


@dataclass(frozen=True)
class UpAndDown:
    """Machine and foundation as two masses."""

    ROOT: ClassVar[str] = "foundation"
    natural_frequency: Any = q(
        "foundation_mode", "rad/s", "of machine and foundation",
        headline=Headline("natural frequency, machine on foundation", "Hz", pick="ends"),
    )  # fmt: skip
    machine: Any = q("order", "m", "motion of the machine up and down", PEAK)
    motion: Any = q("order", "m", "motion of the foundation up and down", PEAK)
    ground_force: Any = q("order", "N", "force on what carries the foundation", PEAK)
    rigid_force: Any = q("order", "N", "force on a foundation that does not move", PEAK)
    motion_peak: Any = q(
        "", "m", "largest motion of the foundation over a cycle", PEAK,
        headline=Headline("motion of the foundation, peak", "mm"),
    )  # fmt: skip
    ground_force_peak: Any = q(
        "", "N", "largest force on what carries the foundation", PEAK,
        headline=Headline("force into the ground, peak", "N"),
    )  # fmt: skip
    rigid_force_peak: Any = q(
        "", "N", "largest force on one that does not move", PEAK,
        headline=Headline("the same on a rigid foundation", "N"),
    )  # fmt: skip


AXES = {
    "foundation_mode": ("", "mode of machine and foundation, up and down, lowest first"),
    **COUPLED_AXES,
}
ENTRIES = (*entries_of(UpAndDown), *COUPLED_ENTRIES)

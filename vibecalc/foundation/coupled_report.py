"""Machine and foundation in six degrees of freedom: the section of the report, and the picture."""

from vibecalc.core.report.curves import Curve, Curves, Panel, level
from vibecalc.core.report.rows import Cells, Rows, by_name, chosen, loud, percent, reduced, rows_of
from vibecalc.core.report.sections import Section, section, stacked
from vibecalc.core.report.sources import Look, Source, entry_of
from vibecalc.core.report.writing import paragraph
from vibecalc.core.results.record import Result
from vibecalc.foundation.results import COUPLED
from vibecalc.parts.body import COORDINATES

#: orders below this share of the largest stay in the result file, as those beyond so many
_LARGE = loud(1e-3, 12)

_OF_MODES = (
    Cells("natural_frequency", "Hz", "Hz"),
    Cells("damping_ratio", "damping ratio", ""),
    Cells("machine_share", "machine %", percent(1), note="%: share of the modal energy"),
    Cells("machine_share", "foundation %", lambda share, _: f"{100.0 - 100.0 * share:.1f}"),
)
_MODES = Rows("coupled_mode", "mode", _OF_MODES, f"{COUPLED}/modes")
_FORCE, _RIGID = (reduced(f"{COUPLED}/{name}/force") for name in ("ground", "rigid"))
_OF_ORDERS = (
    Cells(_FORCE, "on the ground N", ""),
    Cells(_RIGID, "rigid N"),
    Cells("ground/force_by_order", "efficiency %", percent(2)),
    Cells("rigid/force_by_order", "rigid %", percent(2)),
    Cells("power", "power W"),
)
_BY_ORDER = Rows("order", "order", _OF_ORDERS, COUPLED, label="{:g}",
                 places=lambda found: _LARGE(found[1:]))  # fmt: skip
_FEET = Rows("mount", "foundation at mount", (Cells("foot_velocity_rms", "r.m.s. mm/s", "mm/s"),),
             COUPLED, merge=True)  # fmt: skip


def coupled(result: Result) -> Section | None:
    """Modes, loads on the ground against a rigid foundation, motion of the feet; None without."""
    record = result.record
    if f"{COUPLED}/ground/force" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{COUPLED}/")}
    names = {f"{what}, r.m.s.": (what,) for what in ("force", "couple")}
    loads = by_name(record, "on the ground", names, _LOADS, COUPLED)[0]
    words = _WORDS + _MASS * (f"{COUPLED}/modes/natural_frequency" not in record)
    lines = stacked(rows_of(record, _MODES)[0], loads + paragraph(words), rows_of(record, _FEET)[0])
    details = {"force on the ground by order": rows_of(record, _BY_ORDER)}
    return section("Machine and foundation", [(lines, shown)], details)


_LOADS = (
    Cells("ground/{}_rms", "actual"),
    Cells("ground/{}_efficiency", "efficiency %", percent(2)),
    Cells("rigid/{}_rms", "rigid foundation"),
    Cells("rigid/{}_efficiency", "efficiency %", percent(2)),
)
_WORDS = "efficiency: 1 - load / load of the rigidly mounted machine"
_MASS = "; flexibility tables count as ground, including their mass"


# ----------------------------------------------------------------------------
# Transmissibility with and without the foundation; force by order.
# ----------------------------------------------------------------------------


def _both(ground: Source, rigid: Source, look: Look, bars: bool = False) -> tuple[Curve, Curve]:
    rigidly = Curve(rigid, "on a rigid foundation", look, bars=bars)
    return Curve(ground, "actual foundation", bars=bars), rigidly


def _panel(coordinate: str) -> Panel:
    place = COORDINATES.index(coordinate)
    ground, rigid = (entry_of(f"{COUPLED}/{name}/transmissibility", place)
                     for name in ("ground", "rigid"))  # fmt: skip
    curves = _both(ground, rigid, {"linestyle": "--"})
    words = f"load on the ground / load on the machine, {coordinate}"
    return Panel("transmissibility", (*curves, level(lambda _: 1.0)), words, log="xy")


_LENGTHS = _both(chosen(_FORCE, _LARGE, _RIGID), chosen(_RIGID, _LARGE, _RIGID), {}, bars=True)
FOUNDATION = Curves(
    "machine on its foundation",
    (
        *(_panel(one) for one in ("y", "z", "rx")),
        Panel("force", _LENGTHS, "force on the ground by order", log="y"),
    ),
    high=2.3,
)

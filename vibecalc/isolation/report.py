"""The body on its mounts in the report: modes, transmissibility, supports, run-up, torque."""

import numpy as np

from vibecalc.core.report.rows import (
    OTHERS,
    Cells,
    Found,
    Rows,
    in_decibels,
    left_out,
    loud,
    named_at,
    others,
    over_natural,
    percent,
    rows_of,
    whole,
)
from vibecalc.core.report.sections import Part, Section, scalars, section, table_of
from vibecalc.core.report.writing import paragraph, show_phase
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Result
from vibecalc.isolation.results import (
    OF_TORQUE,
    BodyModes,
    Masked,
    Pitch,
    RunUpMaxima,
    SupportDisplacement,
    SupportForce,
    TorqueReaction,
)
from vibecalc.numerics.rounding import ranked

# ----------------------------------------------------------------------------
# The body on its mounts: natural frequencies, what each mount bears, transmissibility.
# ----------------------------------------------------------------------------

_LEVER = tuple(
    f"isolation/couple_over_lever/{name}_peak" for name in ("blocked", "steady", "run_up")
)
#: what belongs to pictures; the shapes of modes carry no scale, and the energy says what moves
_DRAWN = ("_harmonics", "/run_up", "_curve", "modes/shape", "/centre", "run_up_peak_speed")
_MODES = Rows(
    "mode",
    "mode",
    (
        Cells("modes/natural_frequency", "Hz", "Hz"),
        Cells("modes/natural_frequency", "rpm", "rpm"),
        Cells("modes/damping_ratio", "damping ratio"),
        Cells("modes/energy_fraction", "{} %", percent(2), "%: share of the modal energy"),
        "torque_reaction/nearest_order",
        Cells("torque_reaction/margin", "f / f_n", over_natural, "nearest: of the torque orders "
              "that excite the mode, 0: none; f / f_n: its frequency / natural frequency"),
    ),
    root="isolation",
)  # fmt: skip
_SUPPORTS = Rows(
    "mount", "mount", (*paths_of(SupportForce), *paths_of(SupportDisplacement)), merge=True,
    note="loads: extremes over the cycle with weight and mean torque; negative: tension",
)  # fmt: skip
#: where the ground moves a displacement is no deflection
_MOVING = (
    "vertical: displacement of the body itself; static, total: deflection, of the body relative to "
    "the foundation"
)
_LEVELS = (
    "transmissibility",
    Cells("transmissibility", "dB", in_decibels),
    Cells("transmissibility", "phase deg", show_phase),
)


def isolation(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = {path for path in record if path.startswith("isolation/") and path.endswith(_DRAWN)}
    supports = _SUPPORTS
    if any(path.startswith("foundation/") for path in record):
        supports = supports._replace(note=f"{supports.note}; {_MOVING}")
    tables = [rows_of(record, one) for one in (_MODES, supports, left_out(Masked.ROOT))]
    blocks = [scalars(record, (*paths_of(Pitch), *_LEVER), "isolation/"), *tables]
    levels = rows_of(record, Rows("order", "order", _LEVELS, Pitch.ROOT))
    details = {"transmissibility by order": levels}
    return section("Isolation: body on its mounts", blocks, details, shown)


# ----------------------------------------------------------------------------
# Every local maximum of the run-up.
# ----------------------------------------------------------------------------

#: maxima shown, of a machine with many mounts
_MOST = 48


def _highest(found: Found) -> np.ndarray:
    """The highest, in the order of their speeds: equal ones of several mounts by their names."""
    force, speed = (one.values for one in found if one.path.endswith(("/force", "/speed")))
    places = np.sort(ranked(force)[:_MOST])
    return places[np.argsort(np.round(speed[places], 4), kind="stable")]


_AT_END = Cells(f"{RunUpMaxima.ROOT}/at_end", "end", lambda end, _: "end" * int(end),
                note="end: maximum at an end of the speed range")  # fmt: skip
_MOUNT = named_at(f"{RunUpMaxima.ROOT}/mount", "isolation/support_force/static")
_MAXIMA = Rows(
    "maximum", "", (Cells(_MOUNT, "mount"), *paths_of(RunUpMaxima)[1:-1], _AT_END), merge=True,
    note="order: dominant at the maximum, with its share of the peak; bending order: the order in "
    "resonance, with the mode nearest to its frequency",
    places=_highest, rest=others("{left} lower maxima in the result file"),
)  # fmt: skip


#: on a foundation that moves: the modes of both, which are more than those of the body
_COUPLED = Cells(f"{RunUpMaxima.ROOT}/mode", "coupled\nmode", whole)
_COUNTED = "coupled mode: counted in the table of machine and foundation"


def run_up_maxima(result: Result) -> Section | None:
    """A line for each maximum, equal ones of several supports as one; None without any."""
    maxima = _MAXIMA
    if BodyModes.WORDS["elsewhere"] in result.record:
        columns = [_COUPLED if one == _COUPLED.of else one for one in maxima.columns]
        maxima = maxima._replace(columns=columns, note=f"{maxima.note}; {_COUNTED}")
    return section("Maxima of the run-up, mount force", [rows_of(result.record, maxima)])


# ----------------------------------------------------------------------------
# A machine on its mounts under the torque of its cylinders: couple, supports, modes met.
# ----------------------------------------------------------------------------

_BY = "the reaction to the {} of all cylinders (gas and inertia) acts on the body"
_SEPARATE = f"The driven machine is not on the body: {_BY.format('torque')}, mean included."
_ON_BODY = (
    "The driven machine is on the body, its stator torque is constant: "
    f"{_BY.format('alternating torque')}. The stator balances the mean torque."
)
_ROTOR = " Only the share that accelerates the rotor acts; the reciprocating masses take the rest."
_LINE = (
    "The whole shaft line is on the body, its load torque is constant: the body takes the "
    "reaction to the rate of change of its angular momentum. The stator balances the mean torque."
)


_COUPLE = (
    Cells("torque_reaction/couple", "couple N m"),
    Cells("torque_reaction/couple", "phase deg", show_phase),
    Cells("body/rotation_harmonics", "rotation {} mrad", "mrad"),
)
#: the orders that matter, in their sequence
_ORDERS = Rows(
    "order", "order", _COUPLE, "isolation", label="{:g}", places=loud(1e-3, 16),
    rest=others(OTHERS),
)  # fmt: skip
_BY_CAUSE = (Cells("isolation/support_force/by_cause", "{} N"),)
_ALONE = "peak over the cycle for each cause alone; the peaks do not add"
_CAUSES = Rows("mount", "mount", _BY_CAUSE, note=_ALONE)


def torque_reaction(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record, machine = result.record, table_of(result.case, "machine")
    if f"{TorqueReaction.ROOT}/couple" not in record:
        return None
    separate = table_of(result.case, "excitation").get("driven_machine") == "separate"
    words = (_SEPARATE if separate else _ON_BODY) + _ROTOR * ("rotor" in machine)
    lines = paragraph(_LINE if machine.get("shaft_line") and not separate else words)
    if silent := table_of(result.case, "response", "torsion").get("misfire"):
        lines += paragraph(f"Without combustion in cylinder {', '.join(map(str, silent))}.")
    scalar = scalars(record, OF_TORQUE, TorqueReaction.ROOT)
    blocks: list[Part] = [lines, scalar, rows_of(record, _CAUSES)]
    details = {"couple of the torque by order": rows_of(record, _ORDERS)}
    return section("Torque reaction on the mounts, all orders", blocks, details, OF_TORQUE)

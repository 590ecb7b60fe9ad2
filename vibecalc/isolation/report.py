"""The body on its mounts in the report: modes, transmissibility, supports, run-up, torque."""

import numpy as np

from vibecalc.core.report.rows import (
    OTHERS,
    Cells,
    Found,
    Rows,
    in_decibels,
    loud,
    others,
    part_of,
    percent,
    relative,
    rows_of,
    whole,
)
from vibecalc.core.report.sections import Section, having, labels, scalars, section, table_of
from vibecalc.core.report.writing import paragraph, show_phase
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.isolation.results import (
    NEAREST,
    OF_TORQUE,
    Masked,
    Pitch,
    RunUpMaxima,
    SupportDisplacement,
    SupportForce,
    TorqueReaction,
)
from vibecalc.response.report import left_out

# ----------------------------------------------------------------------------
# The body on its mounts: natural frequencies, what each mount bears, transmissibility.
# ----------------------------------------------------------------------------

_LEVER = tuple(f"isolation/lever_force/{name}_peak" for name in ("rigid", "steady", "run_up"))
#: what belongs to pictures; the shapes of modes carry no scale, and the energy says what moves
_DRAWN = ("_harmonics", "/run_up", "_curve", "modes/shape", "lever_force/run_up_peak_speed")
_MODES = Rows(
    "mode",
    "mode",
    (
        Cells("modes/natural_frequency", "Hz", "Hz"),
        Cells("modes/natural_frequency", "rpm", "rpm"),
        Cells("modes/damping_ratio", "damping ratio"),
        Cells("modes/energy_fraction", "{} %", percent(2), "%: share of the energy of the mode"),
        "torque_reaction/nearest_order",
        Cells(
            "torque_reaction/margin",
            "margin",
            relative,
            "nearest: of the orders of the torque "
            "whose force on the mode is a thousandth of the largest or more, 0: none; a positive "
            "margin: it is above the mode",
        ),
    ),
    root="isolation",
)
_SUPPORTS = Rows(
    "mount",
    "support",
    (*paths_of(SupportForce), *paths_of(SupportDisplacement)),
    note="loads: over the cycle, with the weight and the mean torque; a negative one pulls the "
    "support",
    merge=True,
)
_TRANSMISSIBILITY = Rows(
    "order",
    "order",
    (
        "transmissibility",
        Cells("transmissibility", "dB", in_decibels),
        Cells("transmissibility", "phase deg", show_phase),
    ),
    root=Pitch.ROOT,
)


def isolation(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = {path for path in record if path.startswith("isolation/") and path.endswith(_DRAWN)}
    tables = [rows_of(record, one) for one in (_MODES, _SUPPORTS, left_out(Masked.ROOT))]
    blocks = [scalars(record, (*paths_of(Pitch), *_LEVER), "isolation/"), *tables]
    details = {"transmissibility by order": rows_of(record, _TRANSMISSIBILITY)}
    shown |= {*paths_of(Masked)}
    return section("Isolation: body on its mounts", blocks, details, shown)


# ----------------------------------------------------------------------------
# Every local maximum of the run-up.
# ----------------------------------------------------------------------------

#: maxima shown, of a machine with many mounts
_MOST = 48


def _mounts(record: Record) -> Quantity | None:
    """Names of the mounts at which the maxima are."""
    numbers = having(record, f"{RunUpMaxima.ROOT}/mount", "maximum")
    mounts = having(record, "isolation/support_force/static", "mount")
    if numbers is None or mounts is None:
        return numbers
    names = np.array(labels(mounts.axes[0]))
    return part_of(numbers, names[numbers.values.astype(int) - 1], numbers.axes[0])


def _highest(found: Found) -> np.ndarray:
    """The highest, in the order of their speeds: equal ones of several mounts by their names."""
    _, force, speed = (one.values for one in found[:3])
    places = np.sort(np.argsort(-force, kind="stable")[:_MOST])
    return places[np.argsort(np.round(speed[places], 4), kind="stable")]


_MAXIMA = Rows(
    "maximum",
    "",
    (
        Cells(_mounts, "mount", whole),
        *paths_of(RunUpMaxima)[1:-1],
        Cells(f"{RunUpMaxima.ROOT}/at_end", "end", lambda end, _: "end" * int(end)),
    ),
    note="order: the largest there, with its share of the peak of all; bending order: that which "
    "bends the curve, with the mode nearest to its frequency; end: the curve goes on beyond the "
    "range",
    places=_highest,
    rest=others("the other {left} are lower, and in the file"),
    merge=True,
)


def run_up_maxima(result: Result) -> Section | None:
    """A line for each maximum, equal ones of several supports as one; None without any."""
    return section("Maxima of the run-up, force on a support", [rows_of(result.record, _MAXIMA)])


# ----------------------------------------------------------------------------
# A machine on its mounts under the torque of its cylinders: couple, supports, modes met.
# ----------------------------------------------------------------------------

_BY = ("the body takes minus the {} of all cylinders about the crankshaft, of what is in them and "
       "of inertia")  # fmt: skip
_SEPARATE = f"The driven machine stands elsewhere: {_BY.format('torque')}, and its mean."
_ON_BODY = (
    "The driven machine stands on the body, and its stator follows no pulsation: "
    f"{_BY.format('alternating torque')}. The stator gives the mean back."
)
_ROTOR = " That is the share that turns the rotor: what moves with the pistons takes the rest."
_LINE = (
    "All of the shaft line stands on the body, under a load that does not alternate: the body "
    "takes minus the change of angular momentum of the line. The stator gives the mean torque back."
)


#: the orders that matter, in their sequence
_ORDERS = Rows(
    "half_order order",
    "order",
    (
        Cells("torque_reaction/couple", "couple N m"),
        Cells("torque_reaction/couple", "phase deg", show_phase),
        Cells("body/rotation_harmonics", "rotation {} mrad", "mrad"),
    ),
    root="isolation",
    label="{:g}",
    places=loud(1e-3, 16),
    rest=others(OTHERS),
)
_CAUSES = Rows(
    "mount",
    "support",
    (
        Cells(
            "by_cause",
            "{} N",
            note="peaks over the cycle by each cause alone: they do not add up to that of all",
        ),
    ),
    root="isolation/support_force",
)


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
    blocks = [lines, scalars(record, OF_TORQUE, TorqueReaction.ROOT), rows_of(record, _CAUSES)]
    details = {"couple of the torque by order": rows_of(record, _ORDERS)}
    title = "Torque reaction on the mounts, all orders"
    return section(title, blocks, details, (*OF_TORQUE, *NEAREST))

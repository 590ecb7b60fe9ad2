"""The body on its mounts in the report: modes, transmissibility, supports, run-up, torque."""

from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import (
    OTHERS,
    Cells,
    Rows,
    by_axis,
    loud,
    others,
    percent,
    relative,
    rows_of,
    short,
    whole,
)
from vibecalc.core.report.sections import (
    Part,
    Section,
    along,
    having,
    scalars,
    section,
    stacked,
    table_of,
)
from vibecalc.core.report.writing import (
    paragraph,
    rpm,
    show,
    show_phase,
)
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.isolation.results import OF_TORQUE, BodyModes, Masked, Pitch, TorqueReaction

# ----------------------------------------------------------------------------
# What each mount carries and how far the body moves there: one line for each mount.
# ----------------------------------------------------------------------------

ROOT = "isolation/torque_reaction/"
_FORCE = "isolation/support_force/"
_MOVE = "isolation/support_displacement/"
_LOADS = (
    "least and largest over the cycle, with the weight and the mean torque; a negative load pulls "
    "the support"
)
_FORCES = (
    (f"{_FORCE}static", "static", "N"),
    (f"{_FORCE}rigid_peak", "held\nstill", "N"),
    (f"{_FORCE}steady_peak", "peak at\nspeed", "N"),
    (f"{_FORCE}minimum_load", "least\nload", "N"),
    (f"{_FORCE}largest_load", "largest\nload", "N"),
    (f"{_FORCE}run_up_peak", "peak in the\nrun-up", "N"),
    (f"{_FORCE}run_up_peak_speed", "at", "rpm"),
)
_MOVES = (
    (f"{_MOVE}sag", "static", "mm"),
    (f"{_MOVE}vertical_peak", "vertical\npeak", "mm"),
    (f"{_MOVE}excursion", "largest", "mm"),
)


def supports(record: Record) -> tuple[list[str], set[str]]:
    """Tables of forces and of displacements per mount, and the paths shown."""
    forces = by_axis(record, "mount", "force", _FORCES)
    lines = stacked(forces, by_axis(record, "mount", "motion", _MOVES))
    return lines + (paragraph(_LOADS) if forces else []), {path for path, *_ in (*_FORCES, *_MOVES)}


# ----------------------------------------------------------------------------
# The run-up: largest couple over lever, and the speeds that were left out.
# ----------------------------------------------------------------------------

_PEAKS = tuple(f"isolation/lever_force/{name}" for name in ("run_up_peak", "run_up_peak_speed"))


def _half_width(record: Record) -> Quantity:
    """Of the interval around each speed left out: its ends agree to so many digits."""
    low, centre, high = (record[f"{Masked.ROOT}/{name}"] for name in ("low", "centre", "high"))
    return replace(centre, values=(high.values - low.values) / (2.0 * centre.values), unit="")


_LEFT_OUT = Rows(
    "masked",
    "",
    (
        Cells("order", "order", short),
        Cells("mode", "mode", whole),
        Cells("centre", "rpm", "rpm"),
        Cells(_half_width, "half width, relative", lambda share, _: f"{share:.1e}"),
    ),
    root=Masked.ROOT,
)


def run_up(record: Record) -> tuple[list[str], set[str]]:
    """Lines and the paths shown; nothing if the result has no run-up."""
    lines: list[str] = []
    hit = along(record, "isolation/lever_force/run_up", "speed")
    if hit is not None and hit[1].size:
        low, high = float(np.min(hit[1])), float(np.max(hit[1]))
        lines += paragraph(
            f"run-up over {hit[1].size} speeds from {show(rpm(low))} to {show(rpm(high))} rpm; "
            "at each the peak over the cycle"
        )
    masked = [path for path in record if path.startswith(f"{Masked.ROOT}/")]
    if any(record[path].values.size for path in masked):
        lines += [
            "",
            "  Speeds left out (an order on an undamped natural frequency: no bound there)",
        ]
        lines += rows_of(record, _LEFT_OUT)[0]
    return lines, {*_PEAKS, *masked}


# ----------------------------------------------------------------------------
# The body on its mounts: natural frequencies, transmissibility, response over one turn.
# ----------------------------------------------------------------------------

_PITCH = tuple(
    f"isolation/pitch/{name}"
    for name in (
        "inertia",
        "stiffness",
        "damping",
        "natural_frequency",
        "damping_ratio",
        "angle_peak",
        "force_left_out",
        "couple_left_out",
    )
)
_LEVER = ("isolation/lever_force/rigid_peak", "isolation/lever_force/steady_peak")
#: what belongs to pictures; the shapes of modes carry no scale, and the energy says what moves
_DRAWN = ("_harmonics", "/run_up", "_curve", "modes/shape")
_MODES = Rows(
    "mode",
    "mode",
    (
        Cells("natural_frequency", "Hz", "Hz"),
        Cells("natural_frequency", "rpm", "rpm"),
        Cells("damping_ratio", "damping ratio", ""),
        Cells("energy_fraction", "{} %", percent(2), note="%: share of the energy of the mode"),
    ),
    root=BodyModes.ROOT,
)


def _level(ratio: complex, _error: float) -> str:
    return f"{20.0 * np.log10(abs(ratio)):.2f}" if 0.0 < abs(ratio) < np.inf else "-"


def _isolated(ratio: complex, _error: float) -> str:
    return f"{100.0 * (1.0 - abs(ratio)):.2f} %"


_TRANSMISSIBILITY = Rows(
    "order",
    "order",
    (
        Cells("transmissibility", "transmissibility", ""),
        Cells("transmissibility", "dB", _level),
        Cells("transmissibility", "isolated", _isolated),
        Cells("transmissibility", "phase deg", show_phase),
    ),
    root=Pitch.ROOT,
)


def isolation(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    drawn = {path for path in record if path.startswith("isolation/") and path.endswith(_DRAWN)}
    lines, shown = scalars(record, (*_PITCH, *_LEVER), "isolation/")
    blocks = [(lines, shown | drawn), rows_of(record, _MODES), supports(record), run_up(record)]
    details = {"transmissibility by order": rows_of(record, _TRANSMISSIBILITY)}
    return section("Isolation: body on its mounts", blocks, details)


# ----------------------------------------------------------------------------
# A machine on its mounts under the torque of its cylinders: couple, supports, modes met.
# ----------------------------------------------------------------------------

_MEAN = "isolation/support_force/mean"
_SCALARS = (f"{ROOT}mean_couple", f"{ROOT}roll_peak")
_SEPARATE = (
    "The driven machine stands elsewhere: the body takes minus the torque of all cylinders about "
    "the crankshaft, of what is in them and of inertia, and its mean."
)
_ON_BODY = (
    "The driven machine stands on the body, and its stator follows no pulsation: the body takes "
    "minus the alternating torque of all cylinders about the crankshaft, of what is in them and of "
    "inertia. The stator gives the mean back."
)
_ROTOR = (
    " The torque is the share that turns the rotor: what moves with the pistons takes the rest."
)
_LINE = (
    "All of the shaft line stands on the body, under a load that does not alternate: the torque of "
    "the cylinders goes into the speed of the line, and the body takes minus the change of its "
    "angular momentum. The stator gives the mean torque back: none of it reaches the mounts."
)


def _rotation(record: Record) -> Quantity | None:
    """Rotation of the body at the orders of the torque."""
    found = having(record, "isolation/body/rotation_harmonics", "order", "direction")
    if found is None:
        return None
    return replace(found, axes=(replace(found.axes[0], name="half_order"), found.axes[1]))


#: the orders that matter, in their sequence
_ORDERS = Rows(
    "half_order",
    "order",
    (
        Cells("couple", "couple N m", ""),
        Cells("couple", "phase deg", show_phase),
        Cells(_rotation, "rotation {} mrad", "mrad"),
    ),
    root=TorqueReaction.ROOT,
    label="{:g}",
    places=loud(1e-3, 16),
    rest=others(OTHERS),
)
_CAUSES = Rows(
    "mount",
    "support",
    (
        Cells(OF_TORQUE[0], "{} N"),
        Cells(
            f"{_FORCE}steady_peak",
            "all N",
            note="peaks over the cycle by each cause alone: they do not add up",
        ),
    ),
)
_MODES_MET = Rows(
    "mode",
    "mode of the body",
    (
        Cells("nearest_order", "nearest order", lambda order, _: f"{order:g}" if order else "-"),
        Cells(
            "margin",
            "margin",
            relative,
            note="of the orders whose force on the mode is a thousandth of the largest or more; "
            "positive: the order is above it",
        ),
    ),
    root=TorqueReaction.ROOT,
)


def torque_reaction(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    if f"{ROOT}couple" not in record:
        return None
    options = table_of(result.case, "excitation")
    separate = options.get("driven_machine") == "separate"
    silent = tuple(table_of(result.case, "response", "torsion").get("misfire") or ())
    machine = table_of(result.case, "machine")
    if machine.get("shaft_line") and not separate:
        words = _LINE
    else:
        words = (_SEPARATE if separate else _ON_BODY) + _ROTOR * ("rotor" in machine)
    lines = paragraph(words)
    if silent:
        lines += paragraph(f"Without combustion in cylinder {', '.join(map(str, silent))}.")
    kind = machine.get("kind") or "engine"
    title = f"Torque reaction: {kind} on its mounts, all orders"
    causes: Part = rows_of(record, _CAUSES) if OF_TORQUE[0] in record else []
    blocks = [(lines, {_MEAN}), scalars(record, _SCALARS, ROOT), causes]
    details = {
        "couple of the torque by order": rows_of(record, _ORDERS),
        "orders next to the modes": rows_of(record, _MODES_MET),
    }
    return section(title, blocks, details)

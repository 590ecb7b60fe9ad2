"""The body on its mounts in the report: modes, transmissibility, supports, run-up, torque."""

import numpy as np

from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
    Section,
    along,
    having,
    labels,
    magnitudes,
    scalars,
    section,
    stacked,
    table_of,
)
from vibecalc.core.report.writing import (
    Column,
    hertz,
    number,
    paragraph,
    rpm,
    show,
    show_percent,
    show_phase,
    table,
)
from vibecalc.core.results.record import Record, Result
from vibecalc.isolation.results import OF_TORQUE

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
    forces = by_axis(record, "mount", "force", _FORCES, 10, 11)
    lines = stacked(forces, by_axis(record, "mount", "motion", _MOVES, 10, 11))
    return lines + (paragraph(_LOADS) if forces else []), {path for path, *_ in (*_FORCES, *_MOVES)}


# ----------------------------------------------------------------------------
# The run-up: largest couple over lever, and the speeds that were left out.
# ----------------------------------------------------------------------------

_PEAKS = tuple(f"isolation/lever_force/{name}" for name in ("run_up_peak", "run_up_peak_speed"))
_MASKED = "isolation/masked/"


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
    masked = [path for path in record if path.startswith(_MASKED)]
    if any(record[path].values.size for path in masked):
        lines += [
            "",
            "  Speeds left out (an order on an undamped natural frequency: no bound there)",
        ]
        lines += _left_out(record)
    return lines, {*_PEAKS, *masked}


def _left_out(record: Record) -> list[str]:
    """One row per interval; its ends agree to so many digits that its width says more."""
    low, centre, high, order, mode = (
        record[_MASKED + name].values for name in ("low", "centre", "high", "order", "mode")
    )
    rows = [
        [
            f"{order[i]:g}",
            str(int(mode[i])),
            show(rpm(float(centre[i]))),
            f"{(high[i] - low[i]) / (2.0 * centre[i]):.1e}",
        ]
        for i in range(len(centre))
    ]
    columns = (
        number("order", 8),
        number("mode", 8),
        number("rpm", 14),
        number("half width, relative", 22),
    )
    return table(columns, rows)


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
_RIGID = "lever_force/rigid_peak"
_LEVER = (f"isolation/{_RIGID}", "isolation/lever_force/steady_peak")


def isolation(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    # arrays that belong to pictures rather than to a page of words
    drawn = {
        path
        for path in record
        if path.startswith("isolation/") and path.endswith(("_harmonics", "/run_up", "_curve"))
    }
    lines, shown = scalars(record, (*_PITCH, *_LEVER), "isolation/")
    blocks = [(lines, shown | drawn), _modes(record), supports(record), run_up(record)]
    details = {"transmissibility by order": _transmissibility(record)}
    return section("Isolation: body on its mounts", blocks, details)


def _transmissibility(record: Record) -> tuple[list[str], set[str]]:
    hit = along(record, "isolation/pitch/transmissibility", "order")
    if hit is None:
        return [], set()
    quantity, orders = hit
    columns = (
        Column("order", 6),
        number("transmissibility", 18),
        number("dB", 10),
        number("isolated", 12),
        number("phase deg", 10),
    )
    rows = []
    for order, value in zip(orders, quantity.values, strict=True):
        size = abs(complex(value))
        rows.append(
            [
                str(int(order)),
                show(size, quantity.error_estimate),
                f"{20.0 * np.log10(size):.2f}" if 0.0 < size < np.inf else "-",
                f"{100.0 * (1.0 - size):.2f} %",
                show_phase(complex(value), quantity.error_estimate),
            ]
        )
    return table(columns, rows), {quantity.path}


def _modes(record: Record) -> tuple[list[str], set[str]]:
    """Frequency and damping of each mode, and the share of its energy in each coordinate."""
    hit = along(record, "isolation/modes/natural_frequency", "mode")
    if hit is None:
        return [], set()
    quantity, modes = hit
    damping = along(record, "isolation/modes/damping_ratio", "mode")
    energy = having(record, "isolation/modes/energy_fraction", "mode", "coordinate")
    error = quantity.error_estimate
    columns = [Column("mode", 4), number("Hz", 10), number("rpm", 10), number("damping ratio", 13)]
    if energy is not None:
        columns += [number(f"{name} %", 7) for name in labels(energy.axes[1])]
    rows = []
    for i, (mode, value) in enumerate(zip(modes, quantity.values, strict=True)):
        row = [
            str(int(mode)),
            show(hertz(float(value)), hertz(error)),
            show(rpm(float(value)), rpm(error)),
            show(damping[0].values[i], damping[0].error_estimate) if damping else "",
        ]
        if energy is not None:
            row += [f"{round(100.0 * float(share), 2) + 0.0:.2f}" for share in energy.values[i]]
        rows.append(row)
    lines = table(columns, rows)
    if energy is not None:
        lines += paragraph("%: share of the energy of the mode")
    shown = {quantity.path, *(one.path for one in (damping and damping[0], energy) if one)}
    # the shapes carry no scale; the energy says what moves in a mode
    return lines, shown | {"isolation/modes/shape"}


# ----------------------------------------------------------------------------
# A machine on its mounts under the torque of its cylinders: couple, supports, modes met.
# ----------------------------------------------------------------------------

_MEAN = "isolation/support_force/mean"
_SCALARS = (f"{ROOT}mean_couple", f"{ROOT}roll_peak")
#: orders below this share of the largest one stay in the result file
_SMALL = 1e-3
_MOST = 16
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
    blocks = [(lines, {_MEAN}), scalars(record, _SCALARS, ROOT), _causes(record)]
    details = {"couple of the torque by order": _orders(record)}
    return section(title, blocks, details | {"orders next to the modes": _modes_met(record)})


def _orders(record: Record) -> tuple[list[str], set[str]]:
    """Couple and largest rotation of the orders that matter, in their sequence."""
    couple = having(record, f"{ROOT}couple", "half_order")
    if couple is None:
        return [], set()
    turning = having(record, "isolation/body/rotation_harmonics", "order", "direction")
    size = magnitudes(couple)
    large = np.flatnonzero((size > 4.0 * couple.error_estimate) & (size >= _SMALL * size.max()))
    columns = [Column("order", 8), number("couple N m", 16), number("phase deg", 12)]
    if turning is not None:
        columns += [number(f"rotation {name} mrad", 16) for name in labels(turning.axes[1])]
    rows = []
    for place in large[:_MOST]:
        value = complex(couple.values[place])
        row = [
            f"{couple.axes[0].values[place]:g}",
            show(size[place], couple.error_estimate),
            show_phase(value, couple.error_estimate),
        ]
        if turning is not None:
            error = 1e3 * turning.error_estimate
            row += [show(1e3 * one, error) for one in magnitudes(turning)[place]]
        rows.append(row)
    left = len(size) - len(rows)
    lines = table(columns, rows) if rows else []
    words = f"the other {left} orders are zero or weaker, and in the result file"
    return lines + (paragraph(words) if left else []), {couple.path}


def _causes(record: Record) -> tuple[list[str], set[str]]:
    """Largest force on each support by each cause alone, and by all of them."""
    parts = having(record, OF_TORQUE[0], "mount", "cause")
    whole = having(record, f"{_FORCE}steady_peak", "mount")
    if parts is None or whole is None:
        return [], set()
    names = [*labels(parts.axes[1]), "all"]
    columns = [Column("support", 12), *(number(f"{name} N", 26) for name in names)]
    rows = [
        [label, *(show(one, parts.error_estimate) for one in (*alone, together))]
        for label, alone, together in zip(
            labels(parts.axes[0]), parts.values, whole.values, strict=True
        )
    ]
    words = "peaks over the cycle by each cause alone: they do not add up"
    return table(columns, rows) + paragraph(words), {parts.path}


def _modes_met(record: Record) -> tuple[list[str], set[str]]:
    nearest = along(record, f"{ROOT}nearest_order", "mode")
    margin = along(record, f"{ROOT}margin", "mode")
    if nearest is None or margin is None:
        return [], set()
    columns = (Column("mode of the body", 18), number("nearest order", 14), number("margin", 12))
    rows = []
    for label, order, away in zip(
        labels(nearest[0].axes[0]), nearest[0].values, margin[0].values, strict=True
    ):
        met = bool(np.isfinite(away))
        cells = [f"{order:g}", show_percent(float(away))] if met else ["-", "-"]
        rows.append([label, *cells])
    words = (
        "of the orders whose force on the mode is a thousandth of the largest or more; positive: "
        "the order is above it"
    )
    return table(columns, rows) + paragraph(words), {nearest[0].path, margin[0].path}

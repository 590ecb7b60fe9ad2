"""A machine on its mounts under the torque of its cylinders: couple, supports, modes met."""

import numpy as np

from vibecalc.report.lookup import along, having, labels, magnitudes, table_of
from vibecalc.report.numbers import show, show_percent, show_phase
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

ROOT = "isolation/torque_reaction/"
_SCALARS = (f"{ROOT}mean_couple", f"{ROOT}roll_peak")
#: orders below this share of the largest one stay in the result file
_SMALL = 1e-3
_MOST = 16
_SUPPORTS = (
    (f"{ROOT}support_force_of_torque", "torque alone N"),
    ("isolation/support_force/steady_peak", "shaking alone N"),
    (f"{ROOT}support_force_peak", "both N"),
    ("isolation/support_force/static", "weight N"),
    (f"{ROOT}least_load", "least load N"),
    (f"{ROOT}largest_load", "largest load N"),
)
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
_INERTIA = " The part of the inertia is in the steady forces under Isolation, that of the gas not."
_LINE = (
    "All of the shaft line stands on the body, under a load that does not alternate: the torque of "
    "the cylinders goes into the speed of the line, and the body takes minus the change of its "
    "angular momentum. The stator gives the mean torque back: none of it reaches the mounts."
)
_SHAKING = " The steady forces under Isolation are without this couple."
_RUN_UP = " Its run-up has all of it."
_LOADS = (
    "peaks are of all orders with their phases, over the cycle; the loads count weight, mean "
    "torque, torque and shaking; a negative load pulls the support"
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
        words = _LINE + _SHAKING
    else:
        words = (_SEPARATE if separate else _ON_BODY) + _ROTOR * ("rotor" in machine) + _INERTIA
    ran = bool(table_of(result.case, "isolation").get("run_up"))
    lines = paragraph(words + _RUN_UP * ran)
    if silent:
        lines += paragraph(f"Without combustion in cylinder {', '.join(map(str, silent))}.")
    blocks = (scalars(record, _SCALARS, ROOT), _orders(record), _supports(record), _modes(record))
    shown: set[str] = set()
    for block, paths in blocks:
        if block:
            lines += ["", *block]
        shown |= paths
    shown |= {
        f"{ROOT}{name}"
        for name in ("translation", "rotation", "support_force", "mean_support_force")
    }
    kind = machine.get("kind") or "engine"
    title = f"Torque reaction: {kind} on its mounts, all orders"
    return Section(title, lines, frozenset(shown & set(record)))


def _orders(record: Record) -> tuple[list[str], set[str]]:
    """Couple and largest rotation of the orders that matter, in their sequence."""
    couple = having(record, f"{ROOT}couple", "half_order")
    if couple is None:
        return [], set()
    turning = having(record, f"{ROOT}rotation", "half_order", "direction")
    size = magnitudes(couple)
    large = np.flatnonzero((size > 4.0 * couple.error_estimate) & (size >= _SMALL * size.max()))
    columns = [Column("order", 8), number("couple N*m", 16), number("phase deg", 12)]
    if turning is not None:
        columns += [number(f"rotation {name} rad", 16) for name in labels(turning.axes[1])]
    rows = []
    for place in large[:_MOST]:
        value = complex(couple.values[place])
        row = [
            f"{couple.axes[0].values[place]:g}",
            show(size[place], couple.error_estimate),
            show_phase(value, couple.error_estimate),
        ]
        if turning is not None:
            row += [show(one, turning.error_estimate, 4) for one in magnitudes(turning)[place]]
        rows.append(row)
    left = len(size) - len(rows)
    lines = table(columns, rows) if rows else []
    words = f"the other {left} orders are zero or weaker, and in the result file"
    return lines + (paragraph(words) if left else []), {couple.path}


def _supports(record: Record) -> tuple[list[str], set[str]]:
    found = [
        (hit[0], head)
        for path, head in _SUPPORTS
        if (hit := along(record, path, "mount")) is not None
    ]
    if not found:
        return [], set()
    columns = [Column("support", 12), *(number(head, 13) for _, head in found)]
    rows = [
        [
            name,
            *(
                show(float(quantity.values[place]), quantity.error_estimate)
                for quantity, _ in found
            ),
        ]
        for place, name in enumerate(labels(found[0][0].axes[0]))
    ]
    shown = {quantity.path for quantity, _ in found if quantity.path.startswith(ROOT)}
    return table(columns, rows) + paragraph(_LOADS), shown


def _modes(record: Record) -> tuple[list[str], set[str]]:
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

"""What each mount carries and how far the body moves there: one line for each mount."""

from vibecalc.report.lookup import along, labels, magnitudes
from vibecalc.report.numbers import rpm, show
from vibecalc.report.tables import Column, number, table
from vibecalc.results.record import Quantity, Record

_FORCE = "isolation/support_force/"
_MOVE = "isolation/support_displacement/"
_FORCES = (
    ("static", "static N"),
    ("rigid_peak", "held still N"),
    ("steady_peak", "steady peak N"),
    ("run_up_peak", "run-up peak N"),
)
_MOVES = (
    ("sag", "sag m"),
    ("vertical_peak", "vertical peak m"),
    ("excursion", "excursion m"),
)


def supports(record: Record) -> tuple[list[str], set[str]]:
    """Tables of forces and of displacements per mount, and the paths shown."""
    forces, shown = _per_mount(record, _FORCE, "force on the ground", _FORCES)
    moves, moved = _per_mount(record, _MOVE, "body at the mount", _MOVES)
    lines = forces + ([""] if forces and moves else []) + moves
    return lines, shown | moved


def _per_mount(
    record: Record, prefix: str, title: str, fields: tuple[tuple[str, str], ...]
) -> tuple[list[str], set[str]]:
    found: list[tuple[Quantity, str]] = []
    for name, head in fields:
        hit = along(record, prefix + name, "mount")
        if hit is not None:
            found.append((hit[0], head))
    if not found:
        return [], set()
    speed = along(record, prefix + "run_up_peak_speed", "mount")
    columns = [Column(title, 20), *(number(head, 15) for _, head in found)]
    if speed is not None:
        columns.append(number("at rpm", 10))
    rows = []
    for i, mount in enumerate(labels(found[0][0].axes[0])):
        cells = [show(magnitudes(quantity)[i], quantity.error_estimate) for quantity, _ in found]
        if speed is not None:
            quantity = speed[0]
            cells.append(show(rpm(float(quantity.values[i])), rpm(quantity.error_estimate)))
        rows.append([mount, *cells])
    shown = {quantity.path for quantity, _ in found}
    return table(columns, rows), shown | ({speed[0].path} if speed else set())

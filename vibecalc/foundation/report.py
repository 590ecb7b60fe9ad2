"""The section of a machine on a foundation that moves."""

from vibecalc.core.report.sections import Section, section
from vibecalc.core.report.writing import number, show, table
from vibecalc.core.results.record import Result
from vibecalc.foundation.results import ROOT

#: result, heading, factor from SI to what is shown
_COLUMNS = (
    ("machine", "machine um", 1e6),
    ("motion", "foundation um", 1e6),
    ("ground_force", "force on ground N", 1.0),
    ("rigid_force", "on a rigid one N", 1.0),
)


def foundation(result: Result) -> Section | None:
    """Natural frequencies, and motion and force by order; None without any."""
    record = result.record
    if f"{ROOT}/natural_frequency" not in record:
        return None
    found = [(record[f"{ROOT}/{name}"], factor) for name, _, factor in _COLUMNS]
    orders = [int(order) for order in found[0][0].axes[0].values]
    rows = [
        [str(order), *(show(abs(q.values[i]) * f, q.error_estimate * f) for q, f in found)]
        for i, order in enumerate(orders[:12])
    ]
    heads = [number("order", 6), *(number(head, 18) for _, head, _ in _COLUMNS)]
    shown = {path for path in record if path.startswith(f"{ROOT}/")}
    details = {"motion and force of the foundation by order": table(heads, rows)}
    return section("On a foundation that moves", (), details, shown)

"""The section of a machine on a foundation that moves."""

from vibecalc.core.report.rows import Cells, Rows, first, rows_of
from vibecalc.core.report.sections import Section, section
from vibecalc.core.results.record import Result
from vibecalc.foundation.results import UpAndDown

_COLUMNS = (
    Cells("machine", "machine um", "um"),
    Cells("motion", "foundation um", "um"),
    Cells("ground_force", "force on ground N"),
    Cells("rigid_force", "rigid foundation N"),
)
_BY_ORDER = Rows("order", "order", _COLUMNS, UpAndDown.ROOT, right=True, places=first(12))


def foundation(result: Result) -> Section | None:
    """Natural frequencies, and motion and force by order; None without any."""
    record = result.record
    if f"{UpAndDown.ROOT}/natural_frequency" not in record:
        return None
    shown = {path for path in record if path.startswith(f"{UpAndDown.ROOT}/")}
    details = {"motion and force of the foundation by order": rows_of(record, _BY_ORDER)}
    return section("Flexible foundation", (), details, shown)

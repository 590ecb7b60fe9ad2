"""The first page on a shaft line: cases by quantities with limit and flag, one sentence."""

from vibecalc.report.lookup import table_of
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.torsion_cases import cases_table
from vibecalc.report.sections.torsion_conclusion import conclusion
from vibecalc.report.sections.torsion_line import first_firing
from vibecalc.report.sections.torsion_terms import TORSION
from vibecalc.report.tables import paragraph
from vibecalc.results.record import Result

#: what has a section of its own
_APART = tuple(TORSION + name for name in ("variable_inertia/", "transient/", "as_published/"))
_CONVENTIONS = (
    "Conventions: half range = (highest - lowest) / 2 of the synthesis of all orders, with their "
    "phases, over the cycle; amplitudes of single orders are 0-to-peak. Torques and angles are "
    "own ones, of the shaft they belong to; a torque is stiffness and damping part together. "
    "Crank angle zero is the firing position of {first}, the first in the firing order; "
    "frequency = order times crank speed. Stress: torque over the section modulus of the plain "
    "section. Limits by a rule are informative: the society's own current text counts."
)
_OWN = " The other limits are those that the case sets."


def torsion(result: Result) -> Section | None:
    """The section, None if the result has nothing of a shaft line."""
    shown = frozenset(
        path for path in result.record if path.startswith(TORSION) and not path.startswith(_APART)
    )
    if not shown:
        return None
    lines = paragraph(conclusion(result))
    rows = cases_table(result)
    lines += ["", *rows] if rows else []
    words = _CONVENTIONS.format(first=first_firing(result.record)) + (
        _OWN if table_of(result.case).get("limit") else ""
    )
    lines += ["", *paragraph(words)]
    return Section("Torsional vibration of the shaft line", lines, shown)

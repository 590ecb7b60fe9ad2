"""The report as text: fixed columns and stable digits, so that two reports can be diffed."""

from collections.abc import Callable
from typing import Any

from vibecalc.absorber.report.hardware import absorber_parts
from vibecalc.absorber.report.tuning import absorber, absorber_tuning, pendulum
from vibecalc.excitation.report import excitation, motor, pump, rod
from vibecalc.impact.report import impact
from vibecalc.isolation.report import isolation, torque_reaction
from vibecalc.kinematics.report import kinematics
from vibecalc.measurement.report import measurement
from vibecalc.report.limits import judge_limits
from vibecalc.report.lookup import speed_of, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.references import judge_references, misses
from vibecalc.report.sections import closing, summary
from vibecalc.report.sections.find import find
from vibecalc.report.sections.optimisation import optimisation
from vibecalc.report.sections.other import other
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.tolerance import tolerance
from vibecalc.report.tables import fold, pairs, paragraph
from vibecalc.response.report import operations, response, switching
from vibecalc.results.record import Result
from vibecalc.roll.report.control import roll_control
from vibecalc.roll.report.motor import roll_motor
from vibecalc.roll.report.running import roll
from vibecalc.roll.report.start_up import start_up
from vibecalc.torsion.report.damper_design import damper_design
from vibecalc.torsion.report.excitation import torsion_excitation
from vibecalc.torsion.report.first_page import torsion
from vibecalc.torsion.report.limits import has_limits, torsion_limits
from vibecalc.torsion.report.line import torsion_line
from vibecalc.torsion.report.modes import torsion_modes
from vibecalc.torsion.report.studies import torsion_published, torsion_transient, torsion_variable
from vibecalc.torsion.report.vibration import torsion_speeds, torsion_steady

#: More references than these fill the first page: it shows some, and all stand further below.
_MOST_ON_TOP, _BRIEF = 40, 10

#: In the order of the pipeline, the optimum first since it is what the rest describes.
_STAGES: tuple[Callable[[Result], Section | None], ...] = (
    optimisation,
    find,
    torsion,
    torsion_line,
    torsion_modes,
    torsion_excitation,
    torsion_steady,
    torsion_speeds,
    torsion_limits,
    torsion_variable,
    torsion_transient,
    torsion_published,
    damper_design,
    kinematics,
    rod,
    excitation,
    motor,
    pump,
    response,
    operations,
    switching,
    impact,
    roll,
    start_up,
    roll_motor,
    roll_control,
    isolation,
    torque_reaction,
    measurement,
    absorber_tuning,
    absorber,
    absorber_parts,
    pendulum,
)


def render_report(result: Result, *, full: bool = False) -> str:
    """The whole report of one result, at most 100 columns wide.

    Sections appear only for what the result has; what no section knows is listed generically.
    What changes from run to run stands at the end, so that all above it is the same text for the
    same numbers. `full` lists the error estimate of every quantity instead of the worst few.

    Raises
    ------
    ResultError
        A reference or limit of the case names what the result does not have.
    """
    limits, references = judge_limits(result), judge_references(result)
    lines = _identity(result)
    words = summary.conclusion(references, limits)
    if not limits and not references and has_limits(result.record):
        words = "Limits of the stress in the shaft line stand beside the results below."
    lines += _titled("Summary", paragraph(words))
    many = len(references) > _MOST_ON_TOP
    on_top = summary.references(references, _BRIEF if many else None)
    for table in (summary.limits(limits), on_top):
        if table:
            lines += ["", *table]
    shown: set[str] = set()
    for stage in _STAGES:
        section = stage(result)
        if section is not None:
            lines += _titled(section.title, section.lines)
            shown |= section.shown
    if many:
        lines += _titled("Reference numbers, all", summary.references(references))
    closings = (
        other(result, shown),
        closing.warnings(result),
        tolerance(result),
        closing.accuracy(result, full),
        closing.methods(result),
        closing.plan(result),
        closing.provenance(result),
    )
    for section in closings:
        if section is not None:
            lines += _titled(section.title, section.lines)
    return "\n".join(lines) + "\n"


def render_verdicts(result: Result) -> str:
    """Limits and references of one result, each miss in words, and the conclusion."""
    limits, references = judge_limits(result), judge_references(result)
    lines = _titled(str(result.case.get("title") or result.name), [])[1:]
    for table in (summary.limits(limits), summary.references(references)):
        lines += [*table, ""] if table else []
    for miss in misses(references, limits):
        lines += paragraph(miss, "MISSED")
    return "\n".join([*lines, *paragraph(summary.conclusion(references, limits))]) + "\n"


def _identity(result: Result) -> list[str]:
    case = result.case
    title = fold(str(case.get("title") or result.name), 98)
    rows = [("case", result.name)]
    if case.get("source"):
        rows.append(("source", str(case["source"])))
    machine = _machine(result)
    if machine:
        rows.append(("machine", machine))
    rows += [("sha256 of the case", result.case_sha256), ("vibecalc", result.version)]
    return [*title, "=" * max(len(line) for line in title), *pairs(rows, 20)]


def _machine(result: Result) -> str:
    machine = table_of(result.case, "machine")
    words = [str(machine["kind"])] if machine.get("kind") else []
    cylinders: Any = table_of(machine, "crank_train").get("cylinders") or ()
    if cylinders:
        words.append("1 cylinder" if len(cylinders) == 1 else f"{len(cylinders)} cylinders")
    speed = speed_of(result)
    if speed is not None:
        words.append(f"{show(rpm(speed))} rpm ({show(speed)} rad/s)")
    return ", ".join(words)


def _titled(title: str, lines: list[str]) -> list[str]:
    return ["", title, "-" * len(title), *lines]

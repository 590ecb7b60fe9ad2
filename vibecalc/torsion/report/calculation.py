"""A torsional vibration calculation as it is handed in: its chapters and what stands in each."""

from vibecalc.core.report.calculation import Calculation, Chapter
from vibecalc.core.report.sections import having, stacked, table_of
from vibecalc.core.report.writing import paragraph
from vibecalc.core.results.record import Result
from vibecalc.torsion.report.conclusion import in_one_sentence
from vibecalc.torsion.report.first_page import CONVENTIONS, HEALTHY, variant_table, variants
from vibecalc.torsion.report.limits import (
    crank_places,
    exceeded_table,
    formulas,
    ranges_in_words,
    uses_by_section,
)
from vibecalc.torsion.report.line import TORSION

# ----------------------------------------------------------------------------
# The chapters in their order. What a result does not have is no chapter.
# ----------------------------------------------------------------------------


def _chapter(title: str, *parts: str, details: tuple[str, ...] = ()) -> Chapter:
    """Parts that are functions of the folder of reports are named by file and function."""
    return Chapter(title, tuple(map(_where, parts)), tuple(map(_where, details)))


def _where(part: str) -> str:
    return f"vibecalc.torsion.report.{part}" if ":" in part and "." not in part else part


CALCULATION = Calculation(
    title="Torsional vibration calculation",
    applies=_where("calculation:has_calculation"),
    summary=_where("calculation:summary"),
    chapters=(
        _chapter(
            "System data", "line:torsion_line", "vibecalc.torsion.pictures.system:draw_system"
        ),
        _chapter(
            "Natural frequencies and mode shapes",
            *("modes:torsion_modes", "modes:node_table", "torsion_shapes"),
        ),
        _chapter("Holzer tables", "modes:lowest_holzer"),
        _chapter(
            "Excitation",
            *("excitation:engine_torque", "excitation:cylinder_orders"),
            *("excitation:station_torques", "torsion_excitation"),
            details=("excitation:vector_sums", "torsion_vectors"),
        ),
        _chapter("Damping", "damping:torsion_damping", "damping_over_speed"),
        _chapter(
            "Forced vibration",
            *("calculation:conventions", "vibration:torsion_steady"),
            *("vibration:torsion_speeds", "torsion_speeds"),
            *("calculation:loads_and_limits", "torsion_limits", "gear_torque"),
            *("curves:torsion_curves", "torsion_curves", "torsion_station_curves"),
            *("couplings:torsion_couplings", "torsion_couplings", "torsion_dampers"),
            *("curves:torsion_irregularity", "cyclic_irregularity"),
            details=("torsion_orders", "station_angles", "section_stress"),
        ),
        _chapter(
            "Misfire and worst condition",
            *("calculation:misfire", "curves:torsion_conditions", "worst_condition"),
        ),
        _chapter(
            "Barred ranges and critical speeds",
            *("calculation:barred", "excitation:torsion_excitation", "torsion_campbell"),
        ),
        _chapter(
            "Changes in time and passage",
            *("studies:torsion_transient", "torsion_transient", "torsion_waterfall"),
            *("clutch_slip", "counted_cycles"),
        ),
        _chapter("Variable inertia", "studies:torsion_variable", "torsion_variable_inertia"),
        _chapter("As published", "studies:torsion_published"),
        _chapter(
            "Design of a damper", "damper_design:damper_design", "damper_map", "damper_response"
        ),
        _chapter("Conclusion", "conclusion:conclusion_table"),
    ),
    elsewhere=(_where("first_page:torsion"), _where("limits:torsion_limits")),
)


def has_calculation(result: Result) -> bool:
    """Whether a case asks for the vibration of a shaft line, and has it."""
    asks = bool(table_of(result.case, "response", "torsion"))
    return asks and TORSION + "modes/natural_frequency" in result.record


def summary(result: Result) -> list[str]:
    """The sentence of the first page."""
    return paragraph(in_one_sentence(result))


# ----------------------------------------------------------------------------
# What the text report has elsewhere, or not.
# ----------------------------------------------------------------------------


def conventions(result: Result) -> list[str]:
    """What a half range is."""
    driven = TORSION + "torque_half_range" in result.record
    return paragraph(CONVENTIONS) if driven else []


def loads_and_limits(result: Result) -> list[str]:
    """What each section bears and may bear, by each limit, with the formulas of the rules."""
    uses, places = uses_by_section(result), crank_places(result)
    return stacked(uses, places, formulas(result)) if uses else []


def misfire(result: Result) -> list[str]:
    """The line with all cylinders firing beside that of the case."""
    there = any(one.prefix == HEALTHY for one in variants(result))
    return variant_table(result) if there else []


def barred(result: Result) -> list[str]:
    """The ranges of speeds that are barred, and what bars them."""
    record = result.record
    if f"{TORSION}limit/largest_use" not in record:
        there = having(record, TORSION + "critical/speed", "mode", "half_order") is not None
        return paragraph("No limit is held over the speeds: none is barred.") if there else []
    words = "; ".join(ranges_in_words(result)) or "no range is barred"
    return stacked(paragraph(f"{words[0].upper()}{words[1:]}."), exceeded_table(record))

"""A torsional vibration calculation as it is handed in: its chapters and what stands in each."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.calculation import Calculation, Chapter
from vibecalc.core.report.sections import having, labels, stacked, table_of
from vibecalc.core.report.writing import Column, hertz, number, pairs, paragraph, show, table
from vibecalc.core.results.record import Result
from vibecalc.torsion.report.conclusion import in_one_sentence
from vibecalc.torsion.report.excitation import EXCITATION
from vibecalc.torsion.report.first_page import CONVENTIONS, HEALTHY, variant_table, variants
from vibecalc.torsion.report.limits import (
    crank_places,
    exceeded_table,
    formulas,
    ranges_in_words,
    uses_by_section,
)
from vibecalc.torsion.report.line import (
    TORSION,
    cell,
    elastic_modes,
    joined,
    line_of,
    mode_names,
    order_text,
    torque_unit,
    vector,
)
from vibecalc.torsion.report.modes import MODES, holzer

if TYPE_CHECKING:
    from vibecalc.torsion.model import ShaftLineModel

_HERE = "vibecalc.torsion.report"

# ----------------------------------------------------------------------------
# The chapters in their order. What a result does not have is no chapter.
# ----------------------------------------------------------------------------

CALCULATION = Calculation(
    title="Torsional vibration calculation",
    applies=f"{_HERE}.calculation:has_calculation",
    summary=f"{_HERE}.calculation:summary",
    chapters=(
        Chapter(
            "System data",
            (f"{_HERE}.line:torsion_line", "vibecalc.torsion.pictures.system:draw_system"),
        ),
        Chapter(
            "Natural frequencies and mode shapes",
            (
                f"{_HERE}.modes:torsion_modes",
                f"{_HERE}.calculation:node_table",
                "torsion_shapes",
            ),
        ),
        Chapter("Holzer tables", (f"{_HERE}.calculation:lowest_holzer",)),
        Chapter(
            "Excitation",
            (
                f"{_HERE}.calculation:engine_torque",
                f"{_HERE}.calculation:cylinder_harmonics",
                f"{_HERE}.calculation:station_torques",
                "torsion_excitation",
            ),
            (f"{_HERE}.calculation:cylinder_vector_sums", "torsion_vectors"),
        ),
        Chapter("Damping", (f"{_HERE}.damping:torsion_damping", "damping_over_speed")),
        Chapter(
            "Forced vibration",
            (
                f"{_HERE}.calculation:conventions",
                f"{_HERE}.vibration:torsion_steady",
                f"{_HERE}.vibration:torsion_speeds",
                "torsion_speeds",
                f"{_HERE}.calculation:loads_and_limits",
                "torsion_limits",
                "gear_torque",
                f"{_HERE}.curves:torsion_curves",
                "torsion_curves",
                "torsion_station_curves",
                f"{_HERE}.couplings:torsion_couplings",
                "torsion_couplings",
                "torsion_dampers",
                f"{_HERE}.curves:torsion_irregularity",
                "cyclic_irregularity",
            ),
            ("torsion_orders", "station_angles", "section_stress"),
        ),
        Chapter(
            "Misfire and worst condition",
            (
                f"{_HERE}.calculation:misfire",
                f"{_HERE}.curves:torsion_conditions",
                "worst_condition",
            ),
        ),
        Chapter(
            "Barred ranges and critical speeds",
            (
                f"{_HERE}.calculation:barred",
                f"{_HERE}.excitation:torsion_excitation",
                "torsion_campbell",
            ),
        ),
        Chapter(
            "Changes in time and passage",
            (
                f"{_HERE}.studies:torsion_transient",
                "torsion_transient",
                "torsion_waterfall",
                "clutch_slip",
                "counted_cycles",
            ),
        ),
        Chapter(
            "Variable inertia",
            (f"{_HERE}.studies:torsion_variable", "torsion_variable_inertia"),
        ),
        Chapter("As published", (f"{_HERE}.studies:torsion_published",)),
        Chapter(
            "Design of a damper",
            (f"{_HERE}.damper_design:damper_design", "damper_map", "damper_response"),
        ),
        Chapter("Conclusion", (f"{_HERE}.conclusion:conclusion_table",)),
    ),
    elsewhere=(f"{_HERE}.first_page:torsion", f"{_HERE}.limits:torsion_limits"),
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

#: of the largest angle of a mode: less is on a node
_NODE = 1e-9
#: modes whose shapes are tabled
_SHAPES = 4


def node_table(result: Result) -> list[str]:
    """Angles of the lowest elastic modes, how many nodes they have, and in which sections."""
    shape = having(result.record, MODES + "shape", "mode", "station")
    natural = vector(result.record, "modes/natural_frequency", "mode")
    line, modes = line_of(result), elastic_modes(result)[:_SHAPES]
    if shape is None or natural is None or line is None or not modes:
        return []
    known, angle = mode_names(result), np.real(shape.values)
    columns = [Column("station")]
    columns += [number(f"{known[i]}\n{show(hertz(natural[i]), digits=4)} Hz") for i in modes]
    rows = [
        [name, *(show(angle[i, place], shape.error_estimate, 4) for i in modes)]
        for place, name in enumerate(labels(shape.axes[1]))
    ]
    nodes = [nodes_in(line, angle[i]) for i in modes]
    totals = [["nodes", *(str(len(found)) for found in nodes)]]
    words = "; ".join(
        f"{known[i]}: {joined(found) or 'none'}" for i, found in zip(modes, nodes, strict=True)
    )
    rings = " Rings of dampers are not counted here." if line.dampers else ""
    return [
        *paragraph("Mode shapes: angles of the stations, each on its own shaft."),
        *table(columns, rows, totals),
        *paragraph(f"Nodes lie in: {words}.{rings}"),
    ]


def nodes_in(line: "ShaftLineModel", angle: np.ndarray) -> list[str]:
    """Names of the sections between whose ends the angles (s,), referred, change their sign."""
    own = angle / line.station_ratio
    least = _NODE * float(np.max(np.abs(own)))
    sides = np.where(np.abs(own) > least, np.sign(own), 0.0)
    return [
        line.section_names[place]
        for place, (first, second) in enumerate(line.section_ends)
        if second >= 0 and sides[first] * sides[second] < 0.0
    ]


def lowest_holzer(result: Result) -> list[str]:
    """Holzer tables of the two lowest elastic modes."""
    return holzer(result, most=2)


def engine_torque(result: Result) -> list[str]:
    """Power, mean torque and mean indicated pressure of the engine."""
    factor, unit = torque_unit(result.record)
    rows = []
    for name, by, words in (
        ("power", 1e-3, "kW"), ("mean_torque", factor, unit),
        ("mean_indicated_pressure", 1e-5, "bar"),
    ):  # fmt: skip
        found = result.record.quantities.get(EXCITATION + name)
        if found is not None:
            title = name.replace("_", " ") + (", indicated" if name == "power" else "")
            rows.append((title, f"{cell(found, (), by)} {words}"))
    return pairs(rows)


def cylinder_harmonics(result: Result) -> list[str]:
    """Torque of one cylinder by order."""
    from vibecalc.torsion.report.excitation import cylinder_orders

    there = having(result.record, EXCITATION + "total", "half_order") is not None
    return cylinder_orders(result) if there else []


def cylinder_vector_sums(result: Result) -> list[str]:
    """Vector sums of the cylinders by mode and order."""
    from vibecalc.torsion.report.excitation import vector_sums

    return vector_sums(result)


def station_torques(result: Result) -> list[str]:
    """Torques at stations that are not of cylinders alone, by order: amplitude."""
    torque = having(result.record, EXCITATION + "station_torque", "station", "half_order")
    line = line_of(result)
    given = table_of(result.case, "machine", "shaft_line").get("excitations")
    if torque is None or line is None or not given:
        return []
    factor, unit = torque_unit(result.record)
    values = np.abs(torque.values)
    noise = max(torque.error_estimate, _NODE * float(np.max(values)))
    at = {str(one.get("on")) for one in given}
    named = labels(torque.axes[0])
    columns = [number("order")]
    places = [i for i, name in enumerate(named) if name in at][:6]
    columns += [number(named[i]) for i in places]
    rows = [
        [order_text(order), *(show(factor * size, factor * noise, 4) for size in values[places, k])]
        for k, order in enumerate(torque.axes[1].values)
        if np.any(values[places, k] > noise)
    ]
    words = f"Torques at the stations by order of the crank or first shaft, 0-to-peak, in {unit}:"
    return [*paragraph(words), *table(columns, rows)] if rows else []


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

"""Cycles of the sections over a change in time, and what they use up of S-N lines."""

from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.line_part_tables import FatigueLine
from vibecalc.torsion.question_tables import CycleCounting
from vibecalc.torsion.study_results import TRANSIENT
from vibecalc.torsion.transient.counting import (
    Strength,
    equivalent_number,
    miner_sum,
    rainflow_cycles,
    range_table,
    slope_below,
)
from vibecalc.torsion.transient.trace import Trace

# ----------------------------------------------------------------------------
# Adapter: cycles of a change in time, torques of the sections' own shafts.
# ----------------------------------------------------------------------------


def emit_counting(scene: Scene, setup: Setup, options: CycleCounting, seen: list[Trace]) -> None:
    """Ranges with means and numbers, equivalent numbers, and sums of Miner."""
    shaft, names = setup.shaft, setup.shaft.section_names
    chosen = [names.index(one) for one in options.sections] or list(range(len(names)))
    given = scene.case.machine.shaft_line
    assert given is not None
    lines = {place: one.fatigue for place, one in enumerate(given.shafts) if one.fatigue}
    cycles = {}
    for one in chosen:
        own = float(shaft.section_ratio[one])
        value, error = seen[one].value / own, seen[one].error / abs(own)
        cycles[one] = rainflow_cycles(value, error, options.ignore)

    def emit(name: str, sections: list[int], values: Any, error: Any, **axes: Any) -> None:
        axes["section"] = tuple(names[one] for one in sections)
        scene.emit(f"{TRANSIENT}counted/{name}", np.array(values), error, axes)

    tables = [range_table(one, options.bins) for one in cycles.values()]
    bins = np.arange(1, options.bins + 1)
    off = {place: float(np.max(one.error, initial=0.0)) for place, one in cycles.items()}
    for name, slack in (
        ("range", max(off.values())),
        ("number", max(float(np.max(one.error)) for one in tables)),
        ("mean", max(one.mean_error for one in tables)),
    ):
        emit(name, chosen, [getattr(one, name) for one in tables], slack, range_bin=bins)
    slopes = [lines[one].slope if one in lines else options.slope for one in chosen]
    equal = [equivalent_number(cycles[one], k) for one, k in zip(chosen, slopes, strict=True)]
    number, error = np.array(equal).T
    emit("equivalent_number", chosen, number, error.max())
    largest = {one: float(cycles[one].range.max(initial=0.0)) for one in chosen}
    emit("largest_range", chosen, list(largest.values()), max(off.values()))
    stressed = [one for one in chosen if shaft.section_modulus[one]]
    if stressed:
        modulus = shaft.section_modulus[stressed]
        values, errors = (np.array([part[one] for one in stressed]) for part in (largest, off))
        emit("largest_stress_range", stressed, values / modulus, errors / modulus)
    lasting = [one for one in chosen if one in lines]
    if lasting:
        sums = np.array([
            miner_sum(cycles[one], _strength(lines[one], float(shaft.section_modulus[one])))
            for one in lasting
        ])  # fmt: skip
        emit("damage", lasting, sums[:, 0], sums[:, 1].max())
        whole = options.changes * sums
        emit("damage_of_all", lasting, whole[:, 0], whole[:, 1].max())
    scene.cite(
        "rainflow counting of the torques of sections, ranges and means",
        "transient",
        "ASTM E1049-85, 5.4.4; sum of n / N by Palmgren 1924 and Miner 1945",
    )


def _strength(line: FatigueLine, modulus: float) -> Strength:
    """An S-N line in torques of the own shaft."""
    amplitude = line.torque if line.torque is not None else (line.stress or 0.0) * modulus
    return Strength(amplitude, line.cycles, line.slope, slope_below(line.slope, line.below))

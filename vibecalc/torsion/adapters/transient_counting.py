"""Cycles of the sections over a change in time, and what they use up of S-N lines."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.study_results import TRANSIENT
from vibecalc.torsion.transient.counting import (
    Cycles,
    Reversals,
    Strength,
    equivalent_number,
    miner_sum,
    rainflow_cycles,
    range_table,
    reversals,
    slope_below,
)
from vibecalc.torsion.transient.march import TransientRun
from vibecalc.torsion.transient_tables import CycleCounting, FatigueLine

# ----------------------------------------------------------------------------
# Adapter: cycles of a change in time, torques of the sections' own shafts.
# ----------------------------------------------------------------------------


def emit_counting(scene: Scene, setup: Setup, options: CycleCounting, run: TransientRun) -> None:
    """Ranges with means and numbers, equivalent numbers, and sums of Miner."""
    shaft, stem = setup.shaft, f"{TRANSIENT}counted/"
    names = shaft.section_names
    chosen = np.array(
        [names.index(one) for one in options.sections] or range(len(names)), dtype=np.int64
    )
    given = scene.case.machine.shaft_line
    assert given is not None
    lines: dict[int, FatigueLine] = {
        place: one.fatigue for place, one in enumerate(given.shafts) if one.fatigue is not None
    }
    all_cycles = [
        _own(found, float(shaft.section_ratio[section]), options.ignore)
        for section, found in zip(chosen, reversals(run, chosen), strict=True)
    ]
    tables = [range_table(one, options.bins) for one in all_cycles]
    axes = {
        "section": tuple(names[one] for one in chosen),
        "range_bin": np.arange(1, options.bins + 1),
    }
    off = [float(np.max(one.error, initial=0.0)) for one in all_cycles]
    scene.emit(f"{stem}range", np.array([one.range for one in tables]), max(off), axes)
    number_error = max(float(np.max(one.error)) for one in tables)
    scene.emit(f"{stem}number", np.array([one.number for one in tables]), number_error, axes)
    mean_error = max(one.mean_error for one in tables)
    scene.emit(f"{stem}mean", np.array([one.mean for one in tables]), mean_error, axes)
    slopes = [lines[one].slope if one in lines else options.slope for one in chosen]
    equal = np.array([
        equivalent_number(one, slope) for one, slope in zip(all_cycles, slopes, strict=True)
    ])  # fmt: skip
    scene.emit(f"{stem}equivalent_number", equal[:, 0], equal[:, 1].max(), axes)
    largest = np.array([one.range.max(initial=0.0) for one in all_cycles])
    scene.emit(f"{stem}largest_range", largest, max(off), axes)
    _emit_stresses(scene, setup, chosen, largest, off)
    _emit_damage(scene, setup, options, lines, dict(zip(chosen.tolist(), all_cycles, strict=True)))
    scene.cite(
        "rainflow counting of the torques of sections, ranges and means",
        "transient",
        "ASTM E1049-85, 5.4.4; sum of n / N by Palmgren 1924 and Miner 1945",
    )


def _own(found: Reversals, ratio: float, ignore: float) -> Cycles:
    """Cycles on the own shaft of a section."""
    return rainflow_cycles(Reversals(found.value / ratio, found.error / abs(ratio)), ignore)


def _emit_stresses(
    scene: Scene, setup: Setup, chosen: np.ndarray, largest: np.ndarray, off: list[float]
) -> None:
    modulus = setup.shaft.section_modulus[chosen]
    stressed = np.flatnonzero(modulus)
    if len(stressed):
        axes = {"section": tuple(setup.shaft.section_names[chosen[k]] for k in stressed)}
        error = np.array(off)[stressed] / modulus[stressed]
        path = f"{TRANSIENT}counted/largest_stress_range"
        scene.emit(path, largest[stressed] / modulus[stressed], error, axes)


def _emit_damage(
    scene: Scene, setup: Setup, options: CycleCounting, lines: dict[int, FatigueLine],
    cycles: dict[int, Cycles],
) -> None:  # fmt: skip
    """Sums of Miner where a section has an S-N line, of one change and of all."""
    asked = [one for one in cycles if one in lines]
    if not asked:
        return
    sums = np.array([
        miner_sum(cycles[one], _strength(lines[one], float(setup.shaft.section_modulus[one])))
        for one in asked
    ])  # fmt: skip
    axes = {"section": tuple(setup.shaft.section_names[one] for one in asked)}
    stem = f"{TRANSIENT}counted/"
    scene.emit(f"{stem}damage", sums[:, 0], sums[:, 1].max(), axes)
    whole = options.changes * sums
    scene.emit(f"{stem}damage_of_all", whole[:, 0], whole[:, 1].max(), axes)


def _strength(line: FatigueLine, modulus: float) -> Strength:
    """An S-N line in torques of the own shaft."""
    amplitude = line.torque if line.torque is not None else (line.stress or 0.0) * modulus
    return Strength(amplitude, line.cycles, line.slope, slope_below(line.slope, line.below))

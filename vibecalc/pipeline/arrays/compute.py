"""Results of one case at many points by arrays, in blocks that bound the memory."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.errors import KeyPath, NumericalFailure
from vibecalc.numerics.typing import BoolArray, IntArray
from vibecalc.pipeline.arrays.columns import Columns
from vibecalc.pipeline.arrays.excitation import emit_excitation
from vibecalc.pipeline.arrays.forces import build_forces
from vibecalc.pipeline.arrays.mounted import build_mounted
from vibecalc.pipeline.arrays.pitch import emit_pitch, on_resonance, pitch_of
from vibecalc.pipeline.arrays.sheet import Column, Sheet
from vibecalc.pipeline.arrays.suspects import suspects

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

#: points times cylinders, weights and mounts in one block: with some fifty orders about 100 MB
_BLOCK = 16_384
#: machines whose running states are found together
_ROLL_BLOCK = 128
#: a block this small that fails is left to single runs
_SMALLEST = 8


class Part(NamedTuple):
    """Some of the points (n,), by their places, with what was found: `left` is nothing of it."""

    places: IntArray
    columns: Mapping[str, Column]


def compute(
    case: "Case", varied: Mapping[KeyPath, np.ndarray], count: int, keep: frozenset[str]
) -> tuple[list[Part], IntArray]:
    """Results `keep` at `count` points, and the places of the points that need a single run.

    `varied` maps key paths to values (count,). `unsupported` has to have nothing against it. A
    point needs a single run if a check may refuse it, if an order may stand on an undamped
    resonance, or if something in its arithmetic goes wrong: the single run then says what.
    """
    if case.machine.primary is not None:
        from vibecalc.pipeline.arrays.absorber import tunings

        done, columns, alone = tunings(case, varied, count, keep)
        return ([Part(done, columns)] if len(done) else []), alone
    whole = Columns(case, varied, count)
    doubtful = suspects(whole)
    clear = np.flatnonzero(~doubtful)
    left = [np.flatnonzero(doubtful)]
    train, mounts = case.machine.crank_train, case.machine.mounts
    mounted = 0 if mounts is None else len(mounts.individual or mounts.positions or ())
    turning = len(train.cylinders) + len(train.counterweights) + len(train.balance_shafts)
    size = max(1, _BLOCK // (turning + mounted))
    if case.response is not None and case.response.roll is not None:
        size = min(size, _ROLL_BLOCK)
    parts: list[Part] = []
    waiting = [clear[start : start + size] for start in range(0, len(clear), size)][::-1]
    while waiting:
        places = waiting.pop()
        try:
            part, met = _block(whole.rows(places), places, keep)
        except (NumericalFailure, FloatingPointError, OverflowError):
            if len(places) <= _SMALLEST:
                left.append(places)
            else:
                half = len(places) // 2
                waiting += [places[half:], places[:half]]
            continue
        left.append(places[met])
        if part is not None:
            parts.append(part)
    return parts, np.sort(np.concatenate(left))


def _block(
    columns: Columns, places: IntArray, keep: frozenset[str]
) -> tuple[Part | None, BoolArray]:
    """Results of one block, and which of its points (n,) are on a resonance instead."""
    met = np.zeros(len(places), dtype=bool)
    if columns.case.response is not None and columns.case.response.roll is not None:
        return _roll_block(columns, places, keep)
    with np.errstate(over="raise", divide="raise", invalid="raise", under="ignore"):
        forces = build_forces(columns)
        mounted = None
        if columns.case.isolation is not None:
            mounted = build_mounted(columns, forces.train)
            met = on_resonance(columns, forces, pitch_of(mounted))
            if met.any():
                clear = np.flatnonzero(~met)
                if not len(clear):
                    return None, met
                part, _ = _block(columns.rows(clear), places[clear], keep)
                return part, met
        sheet = Sheet(columns.count, keep)
        emit_excitation(columns, forces, sheet)
        if mounted is not None:
            emit_pitch(columns, forces, mounted, sheet)
    return Part(places, sheet.columns), met


def _roll_block(
    columns: Columns, places: IntArray, keep: frozenset[str]
) -> tuple[Part | None, BoolArray]:
    """Running states of one block, and which of its points (n,) have to be run alone."""
    from vibecalc.pipeline.arrays.roll import emit_roll  # loads what solves the motion

    sheet = Sheet(columns.count, keep)
    doubtful = emit_roll(columns, sheet)
    clear = np.flatnonzero(~doubtful)
    if not len(clear):
        return None, doubtful
    found = {
        path: column._replace(values=column.values[clear], errors=column.errors[clear])
        for path, column in sheet.columns.items()
    }
    return Part(places[clear], found), doubtful

"""Adapter: readings on a rigid plate to its motion, to levels anywhere, and to what is unsure."""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.measurement import results
from vibecalc.measurement.choosing import most_telling
from vibecalc.measurement.complex_motion import over_deviations
from vibecalc.measurement.harmonic_motion import OF_BOUNDS, HarmonicMotion, solve_all
from vibecalc.measurement.model import (
    InstrumentReading,
    build_harmonics,
    further_readings,
    position_rows,
    reading_name,
    reference_row,
    references,
)
from vibecalc.measurement.plate import PARTS, Rectangle, amplitude_map, grid, point_row, quietest
from vibecalc.measurement.record_orders import emit_records
from vibecalc.measurement.tables import Measurement
from vibecalc.numerics.bounded import Bounded, concatenate, stack
from vibecalc.numerics.level import DECIBEL, level_of
from vibecalc.numerics.rounding import EPSILON, FloatArray

Axes = dict[str, np.ndarray]

_MOTIONS = dict(zip(("translation", "roll", "pitch"), np.eye(3), strict=True))


def run_measurement(scene: Scene) -> None:
    """Solve every harmonic by itself, then emit what follows from the motions."""
    table = scene.case.measurement
    assert table is not None  # or the stage is not planned
    reference = reference_row(table)
    solutions = solve_all(build_harmonics(table), reference)
    further = [_further(one, table) for one in solutions]
    for one, next_one in zip(solutions, further, strict=True):
        warn_of(scene, one, next_one)
    orders = {"order": np.array(table.orders)}
    frequency = table.base_frequency or scene.case.machine.speed
    if frequency is not None:
        scene.emit_all(results.Whole(frequency=orders["order"] * frequency), orders)
    _emit_motion(scene, table, solutions, orders)
    if table.positions:
        _emit_positions(scene, table, solutions, orders)
    fit = results.Fit(
        motions=[len(one.candidates) for one in solutions],
        decided=[int(one.decided) for one in solutions],
    )
    scene.emit_all(fit, orders)
    misfit = stack([one.misfit for one in solutions])
    scene.emit("measurement/fit/misfit", misfit, axes=orders, terms=1.0)
    emit_readings(scene, solutions)
    emit_candidates(scene, solutions, reference, [one for one in further if one is not None])
    if table.plate is not None:
        plate = Rectangle(*table.plate.x, *table.plate.y)
        emit_plate(scene, solutions, plate, table.plate.points, orders)
    emit_records(scene, table)
    _cite(scene, solutions)


def _emit_motion(
    scene: Scene, table: Measurement, solutions: list[HarmonicMotion], axes: Axes
) -> None:
    zero, reference = references(table), reference_row(table)
    whole: dict[str, Bounded] = {}
    phases: dict[str, Bounded] = {}
    unsure: dict[str, Bounded] = {}
    for name, row in _MOTIONS.items():
        found = stack([one.taken.signal(row) for one in solutions])
        whole[name] = found
        scale = zero.linear if name == "translation" else zero.angular
        whole[f"{name}_level"] = level_of(found, scale)
        phases[name] = stack([one.phase(row, reference) for one in solutions])
        if name != "translation":
            origin = _MOTIONS["translation"]
            phases[f"{name}_to_translation"] = stack([one.phase(row, origin) for one in solutions])
        unsure[f"{name}_level"] = concatenate(
            [one.uncertain(one.level_deviation(row[None])) for one in solutions]
        )
        unsure[f"{name}_phase"] = concatenate(
            [one.uncertain(np.array([one.phase_deviation(row, reference)])) for one in solutions]
        )
    scene.emit_all(results.Whole(**whole), axes)
    scene.emit_all(results.Phase(**phases), axes)
    scene.emit_all(results.Uncertainty(**unsure), axes)


def _emit_positions(
    scene: Scene, table: Measurement, solutions: list[HarmonicMotion], orders: Axes
) -> None:
    zero, rows = references(table).linear, position_rows(table)
    axes = {"position": _names(table), **orders}
    signals = {
        part: stack([one.taken.signal(rows * np.array(mask)) for one in solutions])
        for part, mask in PARTS.items()
    }
    whole = signals["standard"]
    levels = {part: level_of(signal, zero) for part, signal in signals.items()}
    scene.emit_all(results.Whole(acceleration=whole), axes)
    scene.emit_all(results.Levels(**levels, all_orders=level_of(whole.norm(), zero)), axes)
    uncertainty = results.Uncertainty(
        level=stack([one.uncertain(one.level_deviation(rows)) for one in solutions]),
        level_bound=stack([one.uncertain(one.level_bound(rows)) for one in solutions]),
    )
    scene.emit_all(uncertainty, axes)


def _names(table: Measurement) -> np.ndarray:
    return np.array([position.name for position in table.positions], dtype=object)


# ----------------------------------------------------------------------------
# What instruments read next to what the motion found gives them.
# ----------------------------------------------------------------------------


def emit_readings(scene: Scene, solutions: list[HarmonicMotion]) -> None:
    """Emit levels read and computed, and of readings with a phase how far the motion is off."""
    each = [(one, read) for one in solutions for read in one.harmonic.reads]
    levels = [(one, read) for one, read in each if read.amplitude > 0.0]
    if levels:
        read = np.array([DECIBEL * np.log(read.amplitude / read.reference) for _, read in levels])
        # roundings of a level on its way to an amplitude and back
        known = Bounded(read, 8.0 * EPSILON * (np.abs(read) + DECIBEL))
        computed = stack(
            [level_of(one.taken.signal(read.row), read.reference) for one, read in levels]
        )
        group = results.Readings(
            order=[one.harmonic.order for one, _ in levels],
            read=known,
            computed=computed,
            residual=Bounded(computed.value - read, computed.error + known.error),
        )
        scene.emit_all(group, {"reading": _unique([read.name for _, read in levels])})
    phasors = [(one, read) for one, read in each if read.phase is not None]
    if phasors:
        signals = results.Signals(
            order=[one.harmonic.order for one, _ in phasors],
            residual=concatenate([_missed(one, read) for one, read in phasors]),
        )
        scene.emit_all(signals, {"signal": _unique([read.name for _, read in phasors])})


def _missed(one: HarmonicMotion, read: InstrumentReading) -> Bounded:
    """By how many standard uncertainties the motion misses a reading with a phase."""
    value, error = one.taken.signal(read.row)
    shown = np.array([read.amplitude * np.exp(1j * (read.phase or 0.0))])
    deviations = np.array([[read.deviation], [read.across[1]]])
    off = float(error) + 8.0 * EPSILON * read.amplitude
    residual = over_deviations(value - shown, shown, deviations)
    return Bounded(residual, np.asarray(off / np.min(deviations)))


def _unique(names: Sequence[str]) -> np.ndarray:
    """Names as entries of an axis; another of the same name gets a number."""
    seen: Counter[str] = Counter()
    entries = []
    for name in names:
        seen[name] += 1
        entries.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return np.array(entries, dtype=object)


# ----------------------------------------------------------------------------
# Maps of a plate, and its quietest places.
# ----------------------------------------------------------------------------


def emit_plate(
    scene: Scene, solutions: list[HarmonicMotion], plate: Rectangle, points: int, orders: Axes
) -> None:
    """Emit amplitudes over the plate and the places of least amplitude."""
    taken = [one.taken for one in solutions]
    motions = np.stack([one.motion for one in taken])
    x, y = grid(plate, points)
    corners = point_row(np.array(plate[:2])[:, None], np.array(plate[2:])[None, :])
    errors = np.array([np.max(one.signal(corners.reshape(-1, 3)).error) for one in taken])
    amplitudes, total = amplitude_map(motions, x, y), float(np.linalg.norm(errors))
    maps = results.Map(
        amplitude=Bounded(amplitudes, np.max(errors)),
        all_orders=Bounded(np.linalg.norm(amplitudes, axis=0), np.asarray(total)),
    )
    scene.emit_all(maps, {**orders, "plate_y": y, "plate_x": x})
    quiet = [
        quietest(motion[None], plate, error)
        for motion, error in zip(motions, errors.tolist(), strict=True)
    ]
    every = quietest(motions, plate, total)
    there = [one.signal(point_row(at.x, at.y)).error for one, at in zip(taken, quiet, strict=True)]
    off = np.linalg.norm([one.signal(point_row(every.x, every.y)).error for one in taken])
    at_x, at_y, least, apart = np.array(quiet).T
    x, y, amplitude, error = np.array(every)
    places = results.Quiet(
        x=Bounded(at_x, np.max(apart)),
        y=Bounded(at_y, np.max(apart)),
        amplitude=Bounded(least, np.max(there)),
        all_orders_x=Bounded(x, error),
        all_orders_y=Bounded(y, error),
        all_orders_amplitude=Bounded(amplitude, off + 8.0 * EPSILON * amplitude),
    )
    scene.emit_all(places, orders)


# ----------------------------------------------------------------------------
# All motions that levels leave, what would tell them apart, and what to say of it.
# ----------------------------------------------------------------------------

#: share of the largest amplitude; a further reading below it would drown in the others
_TOO_QUIET = 0.01
#: residuals of phases, root mean square over what is granted, that get a sentence
_SCATTER = 2.0


class FurtherReading(NamedTuple):
    """A reading not yet made that tells two motions apart, and its levels with either (2,), dB."""

    order: int
    name: str
    levels: Bounded


def _further(one: HarmonicMotion, table: Measurement) -> FurtherReading | None:
    """The reading, of those not yet made at named positions, where two motions differ most."""
    every = further_readings(table)
    if len(one.candidates) < 2 or not every:
        return None
    done = [read.row for read in one.harmonic.reads]
    fresh = [
        (names, row)
        for names, row in every
        if np.any(row) and not any(np.array_equal(np.abs(row), np.abs(old)) for old in done)
    ]
    motions = np.stack([candidate.motion for candidate in one.candidates[:2]])
    loudest = np.max(np.abs(np.stack([row for _, row in every]) @ motions.T))
    rows = np.array([row for _, row in fresh]).reshape(-1, 3)
    place = most_telling(motions, rows, _TOO_QUIET * loudest)
    if place is None:
        return None
    zero = references(table).linear
    levels = [level_of(each.signal(rows[place]), zero) for each in one.candidates[:2]]
    return FurtherReading(one.harmonic.order, reading_name(fresh[place][0]), stack(levels))


def emit_candidates(
    scene: Scene,
    solutions: list[HarmonicMotion],
    reference: FloatArray,
    further: list[FurtherReading],
) -> None:
    """Emit every motion under a name such as `2 +/-`: harmonic, signs of roll and pitch phase."""
    table = scene.case.measurement
    each = [(one, place) for one in solutions for place in range(len(one.of_levels))]
    if table is None or not each:
        return
    zero, every = references(table), [one.candidates[place] for one, place in each]
    found: dict[str, Bounded] = {}
    for name, row in _MOTIONS.items():
        scale = zero.linear if name == "translation" else zero.angular
        found[f"{name}_level"] = level_of(stack([one.signal(row) for one in every]), scale)
        found[f"{name}_phase"] = stack([one.phase(row, reference) for one in every])
    signs = np.where(np.stack([found[f"{name}_phase"].value for name in ("roll", "pitch")]) < 0,
                     "-", "+").T  # fmt: skip
    names = [f"{one.harmonic.order} {'/'.join(sign)}"
             for (one, _), sign in zip(each, signs, strict=True)]  # fmt: skip
    group = results.Candidates(
        order=[one.harmonic.order for one, _ in each],
        chosen=[int(place == 0) for _, place in each],
        worst_residual=stack([_worst(one, place) for one, place in each]),
        **found,
    )
    axes = {"candidate": _unique(names)}
    scene.emit_all(group, axes)
    if not table.positions:
        return
    rows = position_rows(table)
    bounds = np.stack([one.level_bound(rows, place) for one, place in each])
    levels = results.Candidates(
        level=level_of(stack([one.signal(rows) for one in every], axis=0), zero.linear),
        level_bound=Bounded(bounds, OF_BOUNDS * np.where(np.isfinite(bounds), bounds, 0.0)),
    )
    scene.emit_all(levels, {**axes, "position": _names(table)})
    # none where every harmonic has one motion, or all that is named has been read
    apart = np.array([one.levels.value for one in further]).reshape(-1, 2)
    off = np.array([one.levels.error for one in further]).reshape(-1, 2)
    telling = results.Further(
        order=[one.order for one in further],
        difference=Bounded(apart[:, 0] - apart[:, 1], np.sum(off, axis=1)),
    )
    entries = np.array([f"{one.order}: {one.name}" for one in further], dtype=object)
    scene.emit_all(telling, {"further": entries})


def _worst(one: HarmonicMotion, place: int) -> Bounded:
    """Largest residual in dB, with the largest error of the levels that a motion is judged by."""
    reads = [read for read in one.harmonic.reads if read.use == "choose" and read.phase is None]
    reads = reads or list(one.harmonic.solving)
    candidate, zero = one.candidates[place], reads[0].reference
    level = level_of(candidate.signal(np.array([read.row for read in reads])), zero)
    sizes = np.array([read.amplitude / read.reference for read in reads if read.amplitude > 0.0])
    known = 8.0 * EPSILON * (np.abs(DECIBEL * np.log(sizes)) + DECIBEL)
    return Bounded(np.asarray(candidate.worst), np.max(level.error) + np.max(known, initial=0.0))


def warn_of(scene: Scene, one: HarmonicMotion, further: FurtherReading | None) -> None:
    """Say where readings contradict each other, and where they leave two motions."""
    begin, misfit, level = f"harmonic {one.harmonic.order}:", one.misfit.value, one.taken.level
    if level is None:
        if misfit > _SCATTER:
            scene.warn(
                f"{begin} the readings scatter {misfit:.2g} times as much as stated, and "
                "uncertainties are scaled up: the plate bends, an accelerometer is off, or "
                "level_uncertainty and phase_uncertainty are missing"
            )
        return
    if level.clipped:
        least = misfit * max(read.half_width for read in one.harmonic.solving)
        scene.warn(
            f"{begin} no rigid plate has exactly these levels; the nearest differs by "
            f"{least:.2g} dB or more, within the rounding, with two of its signals in phase"
        )
    elif misfit > 1.0:
        scene.warn(
            f"{begin} no motion lies within the rounding of all its levels, the selected one "
            f"misses one by {np.max(np.abs(level.residual)):.2g} dB: the plate bends, or an "
            "accelerometer is off"
        )
    count = len(one.candidates)
    if one.folded:
        scene.warn(
            f"{begin} within the rounding of its levels signals come into phase: the "
            f"{'two motions are' if count > 1 else 'motion stands for'} one family; the bounds of "
            "levels cover all of it, phases have none"
        )
    if one.decided or count < 2:
        return
    words = "the selecting readings do not" if one.chosen_by_others else "no reading can"
    taken = "the nearer one" if one.chosen_by_others else "the first"
    hint = ""
    if further is not None:
        first, other = further.levels.value
        hint = f"; reading {further.name} would: {first:.1f} dB for one, {other:.1f} dB for "
        hint += "the next"
    scene.warn(
        f"{begin} the levels leave {count} motions, and {words} distinguish them; {taken} is used"
        f"{hint}"
    )


def _cite(scene: Scene, solutions: list[HarmonicMotion]) -> None:
    scene.cite(
        "rigid plate in small motion",
        "levels at any point from translation, roll and pitch",
        "Herold, Roll vibration of reciprocating machines, 1977, eqs. 1 to 43",
    )
    if any(one.of_levels for one in solutions):
        scene.cite(
            "second moments of phasors from levels",
            "all motions that levels allow",
            "a line through the cone of semidefinite matrices, docs/theory_measurement.md; with "
            "three points and two differences the permutations of Herold (1977), eqs. 32 and 33",
        )
    if any(one.harmonic.is_complex for one in solutions):
        scene.cite(
            "weighted linear least squares",
            "motion from complex amplitudes",
            "Lawson and Hanson, Solving Least Squares Problems, 1974",
        )
    scene.cite(
        "propagation of uncertainty, first order",
        "standard uncertainties of levels and phases",
        "JCGM 100:2008, Guide to the expression of uncertainty in measurement, 5.1",
    )

"""Adapter: motions of a plate from its readings."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.measurement.choosing import Reach, TellingApart, choose, most_telling, reach
from vibecalc.measurement.complex_motion import (
    complex_motion,
    growth_of_deviations,
    over_deviations,
)
from vibecalc.measurement.level_motions import (
    LevelMotion,
    MotionSpread,
    level_gradient,
    level_motions,
    phase_gradient,
)
from vibecalc.measurement.model import (
    Harmonic,
    InstrumentReading,
    build_harmonics,
    places,
    position_rows,
    reference_row,
    references,
)
from vibecalc.measurement.plate import (
    PARTS,
    Rectangle,
    amplitude_map,
    difference_row,
    grid,
    point_row,
    quietest,
)
from vibecalc.measurement.record_orders import emit_records
from vibecalc.measurement.tables import Measurement
from vibecalc.numerics.bounded import Bounded, stack
from vibecalc.numerics.level import DECIBEL, level_of
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# The motion of each harmonic from its readings, with all that levels leave open.
# ----------------------------------------------------------------------------

#: relative error where first order does not hold: rounding enters by its square root
_IN_LINE = 3e-7
_ROUNDINGS = 8.0
#: of a linear problem
_LINEAR = 4.0


class HarmonicMotion(NamedTuple):
    """The motion (3,) taken for a harmonic, and how its readings and rounding move it.

    `candidates` are all motions that levels leave, the one taken first, with their largest
    residual in dB; none where there are phases. `reach` bounds what they may be off. `excess` is
    the misfit of readings with phases over their deviations after all harmonics have determined
    these.
    """

    harmonic: Harmonic
    motion: ComplexArray
    spread: MotionSpread
    rounding: MotionSpread
    misfit: float
    misfit_error: float
    excess: float
    decided: bool
    chosen_by_others: bool
    clipped: bool
    candidates: tuple[LevelMotion, ...]
    worst: tuple[float, ...]
    roundings: tuple[MotionSpread, ...]
    reach: Reach | None

    @property
    def folded(self) -> bool:
        """Whether the motions are one family within the rounding, of which slopes say nothing."""
        return self.reach is not None and self.reach.folded

    def level_bound(self, rows: FloatArray, candidate: int = 0) -> FloatArray:
        """How far the levels (m,) at rows (m, 3) may be off, dB."""
        if self.reach is None:
            return self.spread.bound(level_gradient(rows, self.motion))
        return self.reach.bound(self.candidates[candidate], rows)

    def level_deviation(self, rows: FloatArray) -> FloatArray:
        """Standard uncertainty (m,) of the levels at rows (m, 3), dB."""
        if self.reach is None:
            return self.spread.deviation(level_gradient(rows, self.motion))
        return self.reach.deviation(self.candidates[0], rows)

    def phase_deviation(self, row: FloatArray, reference: FloatArray) -> float:
        """Standard uncertainty, rad, of the phase of a row (3,) against another."""
        turn = phase_gradient(row, self.motion) - phase_gradient(reference, self.motion)
        if self.folded:
            return float("inf") if np.any(turn != 0.0) else 0.0
        return float(self.spread.deviation(turn))

    def signal(self, rows: FloatArray) -> Bounded:
        """Signals (...) at rows (..., 3) with their numerical error."""
        return signal(self.motion, self.rounding, rows)


def solve_all(harmonics: Sequence[Harmonic], reference: FloatArray) -> list[HarmonicMotion]:
    """The motion of every harmonic; `reference` (3,) is the row where phases are zero."""
    try:
        growth = growth_of_deviations([one.phasors for one in harmonics if one.is_complex])
    except NumericalFailure:
        for one in harmonics:  # the harmonic that fails is named
            _solve(one, reference, np.ones(2))
        raise
    return [_solve(one, reference, growth) for one in harmonics]


def _solve(harmonic: Harmonic, reference: FloatArray, growth: FloatArray) -> HarmonicMotion:
    try:
        if harmonic.is_complex:
            return _from_phases(harmonic, growth)
        return _from_levels(harmonic, reference)
    except NumericalFailure as failure:
        raise NumericalFailure(f"harmonic {harmonic.order}: {failure}") from failure


def signal(motion: ComplexArray, rounding: MotionSpread, rows: FloatArray) -> Bounded:
    """Signals (...) of a motion at rows (..., 3), and what rounding makes of them."""
    zero = np.zeros_like(rows)
    parts = (np.concatenate([rows, zero], axis=-1), np.concatenate([zero, rows], axis=-1))
    moved = np.hypot(*(rounding.bound(part) for part in parts))
    size = np.abs(rows) @ np.abs(motion)
    moved = np.where(np.isfinite(moved), moved, _IN_LINE * size)
    return Bounded(rows @ motion, np.asarray(moved + 8.0 * EPSILON * size))


def _from_levels(harmonic: Harmonic, reference: FloatArray) -> HarmonicMotion:
    reads = harmonic.solving
    rows, sizes = _rows(reads), np.array([read.amplitude for read in reads])
    half = np.array([read.half_width for read in reads])
    deviations = np.array([read.deviation for read in reads])
    motions = level_motions(rows, sizes, half, reference, deviations)
    bounds = reach(rows, sizes, half)
    others = [read for read in harmonic.reads if read.use == "choose" and read.phase is None]
    choice = choose(
        motions,
        _rows(others),
        np.array([read.amplitude for read in others]),
        np.array([read.half_width for read in others]),
        bounds,
    )
    ranked = tuple(motions[place] for place in choice.ranking)
    by_others = choice.residuals[list(choice.ranking)] if others else None
    worst = tuple(
        float(np.max(np.abs(motion.residual if by_others is None else by_others[place])))
        for place, motion in enumerate(ranked)
    )
    best = ranked[0]
    # the levels carry a few roundings each, and so does the motion that has them
    widths = _ROUNDINGS * EPSILON * (1.0 + np.abs(np.log(sizes / np.max(sizes)))) * DECIBEL
    roundings = tuple(motion.spread._replace(half_widths=widths) for motion in ranked)
    return HarmonicMotion(
        harmonic=harmonic,
        motion=best.motion,
        spread=best.spread,
        rounding=roundings[0],
        misfit=best.misfit,
        misfit_error=2.0 * _ROUNDINGS * EPSILON * DECIBEL / float(np.min(half)),
        excess=0.0,
        decided=choice.decided,
        chosen_by_others=bool(others),
        clipped=best.clipped,
        candidates=ranked,
        worst=worst,
        roundings=roundings,
        reach=bounds,
    )


def _from_phases(harmonic: Harmonic, growth: FloatArray) -> HarmonicMotion:
    given = harmonic.phasors
    fit = complex_motion(given._replace(deviations=given.deviations * growth[:, None]))
    stated = over_deviations(fit.residual, given.readings, given.deviations)
    spare = 2 * (len(given.rows) - 3)
    # what is left over is felt by the condition once more
    felt = np.abs(given.readings) + fit.condition * np.abs(fit.residual)
    widths = _LINEAR * EPSILON * np.tile(felt, 2)
    misfit_error = float(np.max(widths / np.ravel(given.deviations)))
    # uncertainties grow with what the readings scatter, and what is not known of the one goes along
    grown = np.any(growth > 1.0) or fit.excess > 1.0
    share = float(np.max(widths / fit.spread.deviations)) if grown else 0.0
    return HarmonicMotion(
        harmonic=harmonic,
        motion=fit.motion,
        spread=fit.spread._replace(uncertainty=fit.spread.uncertainty + share),
        rounding=fit.spread._replace(half_widths=widths),
        misfit=float(np.sum(stated**2) / spare) ** 0.5 if spare else 0.0,
        misfit_error=misfit_error,
        excess=fit.excess,
        decided=True,
        chosen_by_others=False,
        clipped=False,
        candidates=(),
        worst=(),
        roundings=(),
        reach=None,
    )


def _rows(reads: "list[InstrumentReading] | tuple[InstrumentReading, ...]") -> FloatArray:
    return np.array([read.row for read in reads]).reshape(-1, 3)


# ----------------------------------------------------------------------------
# Phases of a measured motion against one another.
# ----------------------------------------------------------------------------


def phase_between(one: HarmonicMotion, row: FloatArray, other: FloatArray) -> Bounded:
    """Phase (rad) of the signal of a row (3,) against that of another; 0 where there is none."""
    try:
        return phase_of(one.motion, one.rounding, row, other)
    except NumericalFailure as failure:
        raise NumericalFailure(f"harmonic {one.harmonic.order}: {failure}") from failure


def phase_of(
    motion: ComplexArray, rounding: MotionSpread, row: FloatArray, other: FloatArray
) -> Bounded:
    """The same for any motion, in (-pi, pi]."""
    both, errors = signal(motion, rounding, np.stack([row, other]))
    if abs(both[1]) <= errors[1]:
        raise NumericalFailure("the signal that phases refer to is zero: a phase has no meaning")
    if abs(both[0]) <= errors[0]:
        return Bounded(np.array(0.0), np.array(0.0))
    phase = float(np.angle(both[0] * np.conj(both[1])))
    error = float(errors[0] / abs(both[0]) + errors[1] / abs(both[1])) + 8.0 * EPSILON
    if phase <= -math.pi + error:
        phase += 2.0 * math.pi
    return Bounded(np.array(phase), np.array(error))


# ----------------------------------------------------------------------------
# What instruments read next to what the motion found gives them.
# ----------------------------------------------------------------------------

#: roundings of a level on its way to an amplitude and back
_READ = 8.0 * EPSILON


def emit_readings(scene: Scene, solutions: list[HarmonicMotion]) -> None:
    """Emit levels read and computed, and of readings with a phase how far the motion is off."""
    levels: list[tuple[str, int, float, float, float]] = []
    signals: list[tuple[str, int, float, float]] = []
    for one in solutions:
        order = one.harmonic.order
        for read in one.harmonic.reads:
            value, error = one.signal(read.row)
            if read.amplitude > 0.0:
                computed, off = level_of(Bounded(value, error), read.reference)
                measured, _ = level_of(read.amplitude, read.reference)
                levels.append((read.name, order, float(measured), float(computed), float(off)))
            if read.phase is not None:
                shown = read.amplitude * np.exp(1j * read.phase)
                deviations = np.array([[read.deviation], [read.across[1]]])
                shift = np.array([complex(value) - shown])
                apart = float(over_deviations(shift, np.array([shown]), deviations)[0])
                rounding = float(error) + 8.0 * EPSILON * read.amplitude
                rounding /= float(np.min(deviations))
                signals.append((read.name, order, apart, rounding))
    if levels:
        names, orders, measured_, computed_, off_ = (
            np.array(column) for column in zip(*levels, strict=True)
        )
        axes = {"reading": _unique([str(name) for name in names])}
        scene.emit("measurement/reading/order", orders, 0.0, axes)
        known = _READ * (np.abs(measured_) + DECIBEL)
        scene.emit("measurement/reading/read", measured_, known, axes)
        scene.emit("measurement/reading/computed", computed_, off_, axes)
        scene.emit("measurement/reading/residual", computed_ - measured_, off_ + known, axes)
    if signals:
        names, orders, apart_, error_ = (np.array(column) for column in zip(*signals, strict=True))
        axes = {"signal": _unique([str(name) for name in names])}
        scene.emit("measurement/signal/order", orders, 0.0, axes)
        scene.emit("measurement/signal/residual", apart_, error_, axes)


def _unique(names: list[str]) -> np.ndarray:
    """Names as entries of an axis; a second instrument at one place gets a number."""
    seen: dict[str, int] = {}
    entries = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        entries.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return np.array(entries, dtype=object)


# ----------------------------------------------------------------------------
# Maps of a plate, and its quietest places.
# ----------------------------------------------------------------------------


def emit_plate(
    scene: Scene, solutions: list[HarmonicMotion], orders: dict[str, np.ndarray]
) -> None:
    """Emit amplitudes over the plate and the places of least amplitude, if its edges are known."""
    table = scene.case.measurement
    if table is None or table.plate is None:
        return
    plate = Rectangle(*table.plate.x, *table.plate.y)
    motions = np.stack([one.motion for one in solutions])
    x, y = grid(plate, table.plate.points)
    corners = point_row(np.array(plate[:2])[:, None], np.array(plate[2:])[None, :])
    errors = [float(np.max(one.signal(corners.reshape(-1, 3)).error)) for one in solutions]
    axes = {**orders, "plate_y": y, "plate_x": x}
    amplitudes = amplitude_map(motions, x, y)
    scene.emit("measurement/map/amplitude", amplitudes, max(errors), axes)
    total = np.linalg.norm(amplitudes, axis=0)
    scene.emit("measurement/map/all_orders", total, float(np.linalg.norm(errors)), axes)
    quiet = [
        quietest(motion[None], plate, error) for motion, error in zip(motions, errors, strict=True)
    ]
    apart = max(place.error for place in quiet)
    for key in ("x", "y"):
        values = [getattr(place, key) for place in quiet]
        scene.emit(f"measurement/quiet/{key}", values, apart, orders)
    least = [place.amplitude for place in quiet]
    there = [
        float(one.signal(point_row(place.x, place.y)).error)
        for one, place in zip(solutions, quiet, strict=True)
    ]
    scene.emit("measurement/quiet/amplitude", least, max(there), orders)
    all_orders = quietest(motions, plate, float(np.linalg.norm(errors)))
    scene.emit("measurement/quiet/all_orders_x", all_orders.x, all_orders.error)
    scene.emit("measurement/quiet/all_orders_y", all_orders.y, all_orders.error)
    row = point_row(all_orders.x, all_orders.y)
    uncertainty = float(np.linalg.norm([float(one.signal(row).error) for one in solutions]))
    uncertainty += 8.0 * EPSILON * all_orders.amplitude
    scene.emit("measurement/quiet/all_orders_amplitude", all_orders.amplitude, uncertainty)


# ----------------------------------------------------------------------------
# All motions that levels leave, what would tell them apart, and what to say of it.
# ----------------------------------------------------------------------------

_PARTS = ("translation", "roll", "pitch")
#: share of the largest amplitude; a further reading below it would drown in the others
_TOO_QUIET = 0.01
#: residuals of phases, root mean square over what is granted, that get a sentence
_SCATTER = 2.0


def emit_candidates(scene: Scene, solutions: list[HarmonicMotion], reference: np.ndarray) -> None:
    """Emit every motion under a name such as `2 +/-`: harmonic, signs of roll and pitch phase."""
    table = scene.case.measurement
    each = [(one, place) for one in solutions for place in range(len(one.candidates))]
    if table is None or not each:
        return
    zero = references(table)
    phases = np.array([_phases(one, place, reference) for one, place in each])
    axes = {"candidate": _names(each, phases[:, 0])}
    scene.emit("measurement/candidate/order", [one.harmonic.order for one, _ in each], 0.0, axes)
    scene.emit("measurement/candidate/chosen", [int(place == 0) for _, place in each], 0.0, axes)
    worst = [one.worst[place] for one, place in each]
    scene.emit(
        "measurement/candidate/worst_residual", worst, [_rounded(*one) for one in each], axes
    )
    signals = [
        signal(one.candidates[place].motion, one.roundings[place], np.eye(3)) for one, place in each
    ]
    for part, name in enumerate(_PARTS):
        values, errors = (
            np.array([getattr(one, key)[part] for one in signals]) for key in ("value", "error")
        )
        scale = zero.linear if name == "translation" else zero.angular
        level = level_of(Bounded(values, errors), scale)
        scene.emit(f"measurement/candidate/{name}_level", level, axes=axes)
        phase, off = phases[:, :, part].T
        scene.emit(f"measurement/candidate/{name}_phase", phase, off, axes)
    if table.positions:
        rows = position_rows(table)
        both = [
            signal(one.candidates[place].motion, one.roundings[place], rows) for one, place in each
        ]
        level = level_of(stack(both, axis=0), zero.linear)
        names = np.array([position.name for position in table.positions], dtype=object)
        scene.emit("measurement/candidate/level", level, axes={**axes, "position": names})
        bounds = np.stack([one.level_bound(rows, place) for one, place in each])
        error = 1e-5 * np.where(np.isfinite(bounds), bounds, 0.0)
        scene.emit("measurement/candidate/level_bound", bounds, error, {**axes, "position": names})
        _emit_further(scene, solutions, table)


def _rounded(one: HarmonicMotion, place: int) -> float:
    """dB; the largest error of the levels that a motion has at the readings it is judged by."""
    reads = [read for read in one.harmonic.reads if read.use == "choose" and read.phase is None]
    reads = reads or list(one.harmonic.solving)
    rows = np.array([read.row for read in reads])
    there = signal(one.candidates[place].motion, one.roundings[place], rows)
    level = level_of(there, reads[0].reference)
    known = [8.0 * EPSILON * (abs(DECIBEL * np.log(r.amplitude / r.reference)) + DECIBEL)
             for r in reads if r.amplitude > 0.0]  # fmt: skip
    return float(np.max(level.error) + max(known, default=0.0))


def warn_of(scene: Scene, one: HarmonicMotion, table: Measurement) -> None:
    """Say where readings contradict each other, and where they leave two motions."""
    order = one.harmonic.order
    if one.clipped:
        least = one.misfit * max(read.half_width for read in one.harmonic.solving)
        scene.warn(
            f"harmonic {order}: no rigid plate has just these levels; one has levels that are off "
            f"by {least:.2g} dB or more, within the rounding, with two of its signals in line"
        )
    elif one.harmonic.is_complex and one.misfit > _SCATTER:
        scene.warn(
            f"harmonic {order}: the readings scatter {one.misfit:.2g} times as much as they are "
            "said to, and uncertainties have grown with it: the plate bends, an accelerometer is "
            "off, or level_uncertainty and phase_uncertainty are to be stated"
        )
    elif not one.harmonic.is_complex and one.misfit > 1.0:
        residual = np.max(np.abs(one.candidates[0].residual))
        scene.warn(
            f"harmonic {order}: no motion lies within the rounding of all its levels, the one "
            f"taken misses one by {residual:.2g} dB: the plate bends, or an accelerometer is off"
        )
    if one.folded:
        scene.warn(
            f"harmonic {order}: within the rounding of its levels signals come into line: the "
            f"{'two motions are' if len(one.candidates) > 1 else 'motion stands for'} one family, "
            "the bounds of levels hold for all of it, and of phases there are none"
        )
    if one.decided or len(one.candidates) < 2:
        return
    words = "the readings that choose do not" if one.chosen_by_others else "nothing read can"
    taken = "the nearer one" if one.chosen_by_others else "the first"
    further = _further(one, table)
    hint = "" if further is None else f"; reading {further.name} would: {_levels(further, table)}"
    scene.warn(
        f"harmonic {order}: the levels leave {len(one.candidates)} motions, and {words} tell them "
        f"apart; {taken} is taken{hint}"
    )


def _levels(further: "FurtherReading", table: Measurement) -> str:
    sizes, scale = further.apart.amplitudes, references(table).linear
    first, other = (float(level_of(size, scale).value) for size in sizes)
    return f"{first:.1f} dB with the one, {other:.1f} dB with the next"


class FurtherReading(NamedTuple):
    """A reading not yet made, what it would tell, and the error of that in dB."""

    name: str
    apart: TellingApart
    error: float


def _further(one: HarmonicMotion, table: Measurement) -> FurtherReading | None:
    """The reading, of those not yet made at named positions, where two motions differ most."""
    if len(one.candidates) < 2 or not table.positions:
        return None
    known, done = places(table), [read.row for read in one.harmonic.reads]
    rows, names = [], []
    for place, name in enumerate(known):
        rows.append(point_row(*known[name]))
        names.append(f"at {name}")
        for other in list(known)[:place]:
            rows.append(difference_row(known[other], known[name]))
            names.append(f"between {other} and {name}")
    fresh = [
        place
        for place, row in enumerate(rows)
        if np.any(row) and not any(np.array_equal(np.abs(row), np.abs(old)) for old in done)
    ]
    motions = np.stack([candidate.motion for candidate in one.candidates[:2]])
    loudest = max(float(np.max(np.abs(motions @ row))) for row in rows)
    if not fresh:
        return None
    choice = most_telling(motions, np.stack([rows[place] for place in fresh]), _TOO_QUIET * loudest)
    if choice is None:
        return None
    row = rows[fresh[choice.place]]
    both = [signal(one.candidates[place].motion, one.roundings[place], row) for place in range(2)]
    errors = [float(level_of(each, 1.0).error) for each in both]
    return FurtherReading(names[fresh[choice.place]], choice, sum(errors))


def _emit_further(scene: Scene, solutions: list[HarmonicMotion], table: Measurement) -> None:
    telling = [(one.harmonic.order, _further(one, table)) for one in solutions]
    rows = [(order, further) for order, further in telling if further is not None]
    # none where every harmonic has one motion, or all that is named has been read
    names = np.array([f"{order}: {one.name}" for order, one in rows], dtype=object)
    axes = {"further": names}
    scene.emit("measurement/further/order", [order for order, _ in rows], 0.0, axes)
    difference = np.array([one.apart.difference for _, one in rows], dtype=float)
    error = np.array([one.error for _, one in rows], dtype=float)
    scene.emit("measurement/further/difference", difference, error, axes)


def _phases(one: HarmonicMotion, place: int, reference: np.ndarray) -> list[list[float]]:
    motion, rounding = one.candidates[place].motion, one.roundings[place]
    each = [phase_of(motion, rounding, np.eye(3)[part], reference) for part in range(3)]
    return [[float(phase.value) for phase in each], [float(phase.error) for phase in each]]


def _names(each: list[tuple[HarmonicMotion, int]], phases: np.ndarray) -> np.ndarray:
    names: list[str] = []
    for (one, _), (_, roll, pitch) in zip(each, phases, strict=True):
        signs = "/".join("-" if phase < 0.0 else "+" for phase in (roll, pitch))
        name = f"{one.harmonic.order} {signs}"
        twins = sum(known.split(" (")[0] == name for known in names)
        names.append(f"{name} ({twins + 1})" if twins else name)
    return np.array(names, dtype=object)


# ----------------------------------------------------------------------------
# Adapter: readings on a rigid plate to its motion, to levels anywhere, and to what is unsure.
# ----------------------------------------------------------------------------

#: relative error of bounds that linear programs may have found
_OF_BOUNDS = 1e-5
_ROWS = {"translation": 0, "roll": 1, "pitch": 2}


def run_measurement(scene: Scene) -> None:
    """Solve every harmonic by itself, then emit what follows from the motions."""
    table = scene.case.measurement
    if table is None:
        raise ValueError("the case has no [measurement]")
    reference = reference_row(table)
    solutions = solve_all(build_harmonics(table), reference)
    for one in solutions:
        warn_of(scene, one, table)
    orders = {"order": np.array(table.orders)}
    _emit_motion(scene, solutions, reference, orders)
    _emit_positions(scene, solutions, orders)
    _emit_fit(scene, solutions, orders)
    emit_readings(scene, solutions)
    emit_candidates(scene, solutions, reference)
    emit_plate(scene, solutions, orders)
    emit_records(scene, table)
    frequency = table.base_frequency or scene.case.machine.speed
    if frequency is not None:
        scene.emit("measurement/frequency", orders["order"] * frequency, 0.0, orders)
    _cite(scene, solutions)


def _emit_motion(
    scene: Scene,
    solutions: list[HarmonicMotion],
    reference: np.ndarray,
    axes: dict[str, np.ndarray],
) -> None:
    table = scene.case.measurement
    assert table is not None
    zero = references(table)
    for name, place in _ROWS.items():
        row = np.eye(3)[place]
        scale = zero.linear if name == "translation" else zero.angular
        values, errors = _stacked([one.signal(row) for one in solutions])
        scene.emit(f"measurement/{name}", values, errors, axes)
        scene.emit(f"measurement/{name}_level", level_of(Bounded(values, errors), scale), axes=axes)
        phases = _stacked([phase_between(one, row, reference) for one in solutions])
        scene.emit(f"measurement/phase/{name}", phases, axes=axes)
        uncertainties = np.array([float(one.level_deviation(row[None])[0]) for one in solutions])
        _emit_uncertainty(scene, f"{name}_level", uncertainties, solutions, axes)
        uncertainties = np.array([one.phase_deviation(row, reference) for one in solutions])
        _emit_uncertainty(scene, f"{name}_phase", uncertainties, solutions, axes)
        if name != "translation":
            phases = _stacked([phase_between(one, row, np.eye(3)[0]) for one in solutions])
            scene.emit(f"measurement/phase/{name}_to_translation", phases, axes=axes)


def _emit_uncertainty(
    scene: Scene,
    name: str,
    values: np.ndarray,
    solutions: list[HarmonicMotion],
    axes: dict[str, np.ndarray],
) -> None:
    """Emit uncertainties, the last axis over the harmonics; an infinite one is as it is."""
    finite = np.where(np.isfinite(values), values, 0.0)
    share = np.array(
        [one.spread.uncertainty + (one.reach is not None) * _OF_BOUNDS for one in solutions]
    )
    scene.emit(f"measurement/uncertainty/{name}", values, finite * share, axes)


def _emit_positions(
    scene: Scene, solutions: list[HarmonicMotion], orders: dict[str, np.ndarray]
) -> None:
    table = scene.case.measurement
    assert table is not None
    if not table.positions:
        return
    zero = references(table).linear
    rows = position_rows(table)
    names = np.array([position.name for position in table.positions], dtype=object)
    axes = {"position": names, **orders}
    for part, mask in PARTS.items():
        values, errors = _stacked([one.signal(rows * np.array(mask)) for one in solutions])
        scene.emit(f"measurement/level/{part}", level_of(Bounded(values, errors), zero), axes=axes)
        if part == "standard":
            scene.emit("measurement/acceleration", values, errors, axes)
            total = level_of(Bounded(values, errors).norm(), zero)
            scene.emit("measurement/level/all_orders", total, axes=axes)
    deviations = np.stack([one.level_deviation(rows) for one in solutions], axis=-1)
    _emit_uncertainty(scene, "level", deviations, solutions, axes)
    bounds = np.stack([one.level_bound(rows) for one in solutions], axis=-1)
    _emit_uncertainty(scene, "level_bound", bounds, solutions, axes)


def _emit_fit(scene: Scene, solutions: list[HarmonicMotion], axes: dict[str, np.ndarray]) -> None:
    motions = np.array([max(len(one.candidates), 1) for one in solutions])
    scene.emit("measurement/fit/motions", motions, 0.0, axes)
    decided = np.array([int(one.decided) for one in solutions])
    scene.emit("measurement/fit/decided", decided, 0.0, axes)
    misfit = np.array([one.misfit for one in solutions])
    error = np.array([one.misfit_error for one in solutions])
    scene.emit("measurement/fit/misfit", misfit, error, axes, terms=1.0)


def _stacked(each: list[Bounded]) -> Bounded:
    """Results of the harmonics, one next to the other along the last axis."""
    return Bounded(
        np.stack([np.asarray(one.value) for one in each], axis=-1),
        np.stack([np.asarray(one.error) for one in each], axis=-1),
    )


def _cite(scene: Scene, solutions: list[HarmonicMotion]) -> None:
    scene.cite(
        "rigid plate in small motion",
        "levels at any point from translation, roll and pitch",
        "Herold, Roll vibration of reciprocating machines, 1977, eqs. 1 to 43",
    )
    if any(one.candidates for one in solutions):
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

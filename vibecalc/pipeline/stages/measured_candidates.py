"""All motions that levels leave, what would tell them apart, and what to say of it."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.measurement_tables import Measurement
from vibecalc.machine.measurement import places, position_rows, references
from vibecalc.measurement.level import DECIBEL, level_of
from vibecalc.measurement.rigid_plate import difference_row, point_row
from vibecalc.measurement.telling_apart import TellingApart, most_telling
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.measured_motion import Found, signal
from vibecalc.pipeline.stages.measured_phase import phase_of

_PARTS = ("translation", "roll", "pitch")
#: share of the largest amplitude; a further reading below it would drown in the others
_TOO_QUIET = 0.01
#: residuals of phases, root mean square over what is granted, that get a sentence
_SCATTER = 2.0


def emit_candidates(scene: Scene, found: list[Found], reference: np.ndarray) -> None:
    """Emit every motion under a name such as `2 +/-`: harmonic, signs of roll and pitch phase."""
    table = scene.case.measurement
    each = [(one, place) for one in found for place in range(len(one.candidates))]
    if table is None or not each:
        return
    own = references(table)
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
        scale = own.linear if name == "translation" else own.angular
        level = level_of(values, errors, scale)
        scene.emit(f"measurement/candidate/{name}_level", *level, axes)
        phase, off = phases[:, :, part].T
        scene.emit(f"measurement/candidate/{name}_phase", phase, off, axes)
    if table.positions:
        rows = position_rows(table)
        both = [
            signal(one.candidates[place].motion, one.roundings[place], rows) for one, place in each
        ]
        level = level_of(
            np.stack([one.value for one in both]), np.stack([one.error for one in both]), own.linear
        )
        names = np.array([position.name for position in table.positions], dtype=object)
        scene.emit("measurement/candidate/level", *level, {**axes, "position": names})
        bounds = np.stack([one.level_bound(rows, place) for one, place in each])
        error = 1e-5 * np.where(np.isfinite(bounds), bounds, 0.0)
        scene.emit("measurement/candidate/level_bound", bounds, error, {**axes, "position": names})
        _emit_further(scene, found, table)


def _rounded(one: Found, place: int) -> float:
    """dB; the largest error of the levels that a motion has at the readings it is judged by."""
    reads = [read for read in one.harmonic.reads if read.use == "choose" and read.phase is None]
    reads = reads or list(one.harmonic.solving)
    rows = np.array([read.row for read in reads])
    there = signal(one.candidates[place].motion, one.roundings[place], rows)
    level = level_of(*there, reads[0].reference)
    known = [8.0 * EPSILON * (abs(DECIBEL * np.log(r.amplitude / r.reference)) + DECIBEL)
             for r in reads if r.amplitude > 0.0]  # fmt: skip
    return float(np.max(level.error) + max(known, default=0.0))


def warn_of(scene: Scene, one: Found, table: Measurement) -> None:
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


def _levels(further: "Further", table: Measurement) -> str:
    sizes, scale = further.apart.amplitudes, references(table).linear
    first, other = (float(level_of(size, 0.0, scale).value) for size in sizes)
    return f"{first:.1f} dB with the one, {other:.1f} dB with the next"


class Further(NamedTuple):
    """A reading not yet made, what it would tell, and the error of that in dB."""

    name: str
    apart: TellingApart
    error: float


def _further(one: Found, table: Measurement) -> Further | None:
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
    found = most_telling(motions, np.stack([rows[place] for place in fresh]), _TOO_QUIET * loudest)
    if found is None:
        return None
    row = rows[fresh[found.place]]
    both = [signal(one.candidates[place].motion, one.roundings[place], row) for place in range(2)]
    errors = [float(level_of(*each, 1.0).error) for each in both]
    return Further(names[fresh[found.place]], found, sum(errors))


def _emit_further(scene: Scene, found: list[Found], table: Measurement) -> None:
    telling = [(one.harmonic.order, _further(one, table)) for one in found]
    rows = [(order, further) for order, further in telling if further is not None]
    # none where every harmonic has one motion, or all that is named has been read
    names = np.array([f"{order}: {one.name}" for order, one in rows], dtype=object)
    axes = {"further": names}
    scene.emit("measurement/further/order", [order for order, _ in rows], 0.0, axes)
    difference = np.array([one.apart.difference for _, one in rows], dtype=float)
    error = np.array([one.error for _, one in rows], dtype=float)
    scene.emit("measurement/further/difference", difference, error, axes)


def _phases(one: Found, place: int, reference: np.ndarray) -> list[list[float]]:
    motion, rounding = one.candidates[place].motion, one.roundings[place]
    each = [phase_of(motion, rounding, np.eye(3)[part], reference) for part in range(3)]
    return [[float(phase.value) for phase in each], [float(phase.error) for phase in each]]


def _names(each: list[tuple[Found, int]], phases: np.ndarray) -> np.ndarray:
    names: list[str] = []
    for (one, _), (_, roll, pitch) in zip(each, phases, strict=True):
        signs = "/".join("-" if phase < 0.0 else "+" for phase in (roll, pitch))
        name = f"{one.harmonic.order} {signs}"
        twins = sum(known.split(" (")[0] == name for known in names)
        names.append(f"{name} ({twins + 1})" if twins else name)
    return np.array(names, dtype=object)

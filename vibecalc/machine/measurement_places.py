"""Do the places of the readings tell the motion of a plate, and if not, which part is hidden?"""

from collections.abc import Iterator

import numpy as np

from vibecalc.case.measurement_tables import Measurement
from vibecalc.errors import KeyPath, Problem
from vibecalc.machine.measurement import Harmonic, build_harmonics, places, row_of
from vibecalc.measurement.level_motions import NEEDED
from vibecalc.measurement.observable import Observable, helpful, observable
from vibecalc.measurement.rigid_plate import difference_row, point_row
from vibecalc.numerics.typing import FloatArray

TABLE: KeyPath = ("measurement",)
_NAMED = 6
_SMALL = 1e-9


def place_problems(table: Measurement) -> list[Problem]:
    """One problem for each set of places that leaves a motion free, with the harmonics it has."""
    problems = list(_nowhere(table))
    if problems:
        return problems
    found: dict[str, tuple[Problem, list[int]]] = {}
    for harmonic in build_harmonics(table):
        problem = _problem(harmonic, table)
        if problem is not None:
            found.setdefault(problem.message, (problem, []))[1].append(harmonic.order)
    for problem, orders in found.values():
        which = "harmonic" if len(orders) == 1 else "harmonics"
        said = f"{which} {', '.join(map(str, orders))}: {problem.message}"
        problems.append(
            Problem(path=TABLE, message=said, allowed=problem.allowed, hint=problem.hint)
        )
    return problems


def _nowhere(table: Measurement) -> Iterator[Problem]:
    """Differences between two names of one place, which are zero however the plate moves."""
    known = places(table)
    for place, reading in enumerate(table.readings):
        if reading.between is not None and not np.any(row_of(reading, known)):
            yield Problem(
                path=(*TABLE, "readings", place, "between"),
                message="the two positions of a difference are one place",
                found=f"{reading.between[0]!r} and {reading.between[1]!r}",
                allowed="positions some way apart",
            )


def _problem(harmonic: Harmonic, table: Measurement) -> Problem | None:
    rows = [read.row for read in harmonic.solving]
    if not rows:
        return Problem(
            path=TABLE,
            message="there is no reading to find the motion from",
            allowed='readings with use = "solve"',
        )
    stacked = np.stack(rows)
    told = observable(stacked)
    if len(told.unseen):
        return Problem(
            path=TABLE,
            message="the readings do not see " + " nor ".join(_words(told)),
            allowed="three points that are not on a line, or two with a rotation beside them",
            hint=_further(stacked, table),
        )
    if harmonic.is_complex or told.levels >= NEEDED:
        return None
    return Problem(
        path=TABLE,
        message=f"the levels determine {told.levels} of the {NEEDED} numbers of a motion (three "
        "amplitudes and two phases)",
        allowed=f"{NEEDED} independent levels, such as three points and two differences; "
        "or phases beside the levels",
        hint=_further(stacked, table),
    )


def _words(told: Observable) -> list[str]:
    """Each motion that no reading sees, as translation, roll and pitch."""
    if len(told.unseen) > 1:
        return [f"{len(told.unseen)} of the three motions translation, roll and pitch"]
    texts = []
    for unseen in told.unseen:
        translation, roll, pitch = unseen / np.array([1.0, told.span, told.span])
        turn = float(np.hypot(roll, pitch))
        if turn <= _SMALL * abs(translation):
            texts.append("translation")
            continue
        roll, pitch, rise = roll / turn, pitch / turn, translation / turn
        if roll < 0.0 or (roll == 0.0 and pitch < 0.0):
            roll, pitch, rise = -roll, -pitch, -rise
        texts.append(_line(roll, pitch, rise, told.span))
    return texts


def _line(roll: float, pitch: float, rise: float, span: float) -> str:
    """A rotation about a line on which all points of the readings lie."""
    if abs(pitch) <= _SMALL:
        return f"roll about the line y = {-rise / roll + 0.0:.4g} m, on which the points lie"
    if abs(roll) <= _SMALL:
        return f"pitch about the line x = {rise / pitch + 0.0:.4g} m, on which the points lie"
    at = rise * np.array([pitch, -roll])
    return (
        f"rotation about the line on which the points lie, through ({at[0]:.4g}, {at[1]:.4g}) m: "
        f"{roll:.3g} of roll with {pitch:.3g} of pitch"
    )


def _further(rows: FloatArray, table: Measurement) -> str:
    """Readings at the named positions that would tell more."""
    known = places(table)
    names = list(known)
    further, texts = [], []
    for place, name in enumerate(names):
        further.append(point_row(*known[name]))
        texts.append(f"at {name!r}")
        for other in names[:place]:
            further.append(difference_row(known[other], known[name]))
            texts.append(f"between {other!r} and {name!r}")
    if not further:
        return ""
    telling = [texts[place] for place in helpful(rows, np.stack(further))][:_NAMED]
    return f"it would help to read {', or '.join(telling)}" if telling else ""

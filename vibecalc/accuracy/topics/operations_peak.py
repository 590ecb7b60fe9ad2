"""Topic of the operations: range of the peak energy over all angles of a balance weight."""

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.grids import golden_maximum
from vibecalc.accuracy.yardsticks.weight_angles import (
    TURN,
    Curve,
    both_ends,
    whole_turn,
    words_of,
)
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.rounding import WithError
from vibecalc.response.accuracy.combinations import Combination
from vibecalc.response.energy_signal import energy_signal
from vibecalc.response.phase_search import Rows, search_phases

#: grids begin here, in rad: at zero, the nominal angle, an end may lie by luck
START = 0.1
GRIDS = tuple(float(4 * 4**k) for k in range(5))
REFERENCE_GRID = 128
#: tolerance of the search that the reference is held against
PROVEN = 1e-13


def peak_range(one: Combination, rtol: float) -> Topic:
    """The range of the peak over the cycle; vibecalc seeks it to within `rtol`."""
    rows = _rows(one)

    def at(phase: np.ndarray) -> np.ndarray:
        signal = np.repeat(rows.harmonics, len(phase), axis=0)
        first = int(np.flatnonzero(rows.orders == 1)[0])
        signal[..., first] += np.exp(1j * phase)[:, None] * rows.turned
        return np.asarray(0.5 * np.square(vector_cycle_peak(signal, rows.orders).value))

    def later(phase: np.ndarray) -> np.ndarray:
        return at(START + phase)

    def bounded(tolerance: float) -> Answer:
        found = search_phases(rows, tolerance)
        return Answer(np.array([found.low[0], found.high[0]]), float(found.peaks[0]))

    def brent(points: float) -> Answer:
        return _brent(at, int(points))

    tolerances = sorted({1e-1, 1e-2, 1e-3, 1e-4, 1e-6, rtol}, reverse=True)
    return Topic(
        stage="operations",
        name="range of the peak energy",
        words=words_of(one, "peak"),
        quantity="response/operations/kinetic_energy/peak_low, peak_high",
        unit="J",
        work="peaks over the cycle",
        reference=lambda: _peak_reference(at, rows),
        ladders=(
            Ladder(
                "branch and bound",
                "intervals that can hold neither end are dropped, the others halved",
                "rtol",
                tuple(tolerances),
                bounded,
                default=rtol,
                theory="what is left open falls with the square of the intervals",
                citation="docs/theory.md",
            ),
            Ladder(
                "grid",
                "lowest and highest of N angles",
                "angles",
                GRIDS,
                lambda points: both_ends(later, points, whole_turn),
                theory="order 2, at kinks order 1",
            ),
            Ladder(
                "scipy minimize_scalar",
                "bounded Brent search around the lowest and highest of N angles",
                "angles",
                (4.0, 8.0, 16.0, 32.0, 64.0),
                brent,
            ),
        ),
        default_extra=4.0,
        default_why="no angle is left out: the ends are proven to within rtol",
    )


def _rows(one: Combination) -> Rows:
    """Signals whose squared length is twice the energy, as `peak_energy_range` makes them."""
    shaking = energy_signal(one.weight, one.state.shaking)
    part = one.state.residual
    residual = energy_signal(one.weight, WithError(part.value[:, 0, None], part.error[:, 0, None]))
    used = shaking.used.copy()
    used[one.state.first] = True
    return Rows(shaking.harmonics[..., used], one.orders[used], residual.harmonics[..., 0])


def _brent(curve: Curve, points: int) -> Answer:
    from scipy.optimize import minimize_scalar

    ends, work, step = [], float(points), TURN / points
    phase = START + step * np.arange(points)
    values = curve(phase)
    for sign in (1.0, -1.0):
        best = float(phase[int(np.argmin(sign * values))])
        found = minimize_scalar(
            lambda at, sign=sign: sign * float(curve(np.array([at]))[0]),
            bounds=(best - step, best + step),
            method="bounded",
            options={"xatol": 1e-10},
        )
        ends.append(sign * float(found.fun))
        work += float(found.nfev)
    return Answer(np.array(ends), work)


def _peak_reference(curve: Curve, rows: Rows) -> Reference:
    """Golden section about the ends of a fine grid, against the proven range."""
    phase = START + TURN * np.arange(REFERENCE_GRID) / REFERENCE_GRID
    values, step = curve(phase), TURN / REFERENCE_GRID
    ends = []
    for sign in (-1.0, 1.0):

        def turned(at: np.ndarray, sign: float = sign) -> np.ndarray:
            return sign * curve(at)

        # the three best grid points: next to a kink the best one may lie in the wrong valley
        best = phase[np.argsort(-sign * values)[:3]].tolist()
        found = [golden_maximum(turned, at - step, at + step, 50).value for at in best]
        ends.append(sign * max(found))
    known = search_phases(rows, PROVEN)
    proven = np.array([known.low[0], known.high[0]])
    reference = np.array(ends)
    agreement = float(np.max(np.abs(proven - reference)) / np.max(np.abs(reference)))
    return Reference(
        reference,
        agreement,
        f"golden section about the best of {REFERENCE_GRID} angles; branch and bound at rtol "
        f"{PROVEN:g} agrees to {agreement:.1e}",
    )

"""Hard cases of shared methods: peaks, cyclic recursions, roots, rank."""

from functools import cache

import mpmath
import numpy as np
from exact_peaks import cycle_peak as exact_peak
from stability.hard_case import HardCase, Numbers, Way, condition_of, singular

from vibecalc.measurement.complex_motion import Phasors, complex_motion
from vibecalc.measurement.plate import point_row
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.periodic.panels import solve_blocks, solve_scalar
from vibecalc.numerics.rounding import EPSILON

#: a narrow beat: orders 59, 60, 61 in phase once a turn, 7e-4 rad off every grid of a degree
ORDERS = np.array([1, 59, 60, 61, 200])
HARMONICS = np.array([1e-3, 1.0, 1.0 + 0.3j, 1.0 - 0.2j, 0.7j])


@cache
def peak_truth() -> Numbers:
    with mpmath.workdps(50):
        row = [mpmath.mpc(complex(one)) for one in HARMONICS]
        return [exact_peak([row], ORDERS.tolist())[0]]


def own_peak() -> Bounded:
    found = cycle_peak(HARMONICS, ORDERS)
    return Bounded(found.value[None], found.error[None])


def grid_peak(count: int) -> np.ndarray:
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.array([np.max(np.abs((np.exp(1j * np.outer(angle, ORDERS)) @ HARMONICS).real))])


#: growth and decay in turn over a cycle: shooting over half of it multiplies rounding by 1e17
PANELS = 40
TRANSFER = np.exp(np.where(np.arange(PANELS) < PANELS // 2, 2.0, -2.05))
OFFSET = np.cos(1.0 + np.arange(PANELS))


def exact_cycle(*factors: mpmath.mpf) -> list[mpmath.mpf]:
    shifts = [mpmath.mpf(float(one)) for one in OFFSET]
    product, total = mpmath.mpf(1), mpmath.mpf(0)
    for factor, shift in zip(factors, shifts, strict=True):
        product, total = product * factor, factor * total + shift
    value, found = total / (1 - product), []
    for factor, shift in zip(factors, shifts, strict=True):
        found.append(value)
        value = factor * value + shift
    return found


@cache
def cycle_truth() -> Numbers:
    with mpmath.workdps(60):
        return exact_cycle(*(mpmath.mpf(float(one)) for one in TRANSFER))


def own_cycle() -> Bounded:
    """With the growth of an error around the turn, over the largest value."""
    value = solve_scalar(TRANSFER[None], OFFSET[None])[0]
    product = np.prod(TRANSFER)
    growth = (1.0 + product) / abs(1.0 - product)
    return Bounded(value, np.full(PANELS, EPSILON * growth * np.max(np.abs(value))))


def by_blocks() -> np.ndarray:
    return solve_blocks(TRANSFER[None, :, None, None], OFFSET[None, :, None]).ravel()


def dense_cycle() -> np.ndarray:
    matrix = np.roll(np.eye(PANELS), 1, axis=1) - np.diag(TRANSFER)
    return np.asarray(np.linalg.solve(matrix, OFFSET))


def line_rows() -> np.ndarray:
    """Three accelerometers along one line: the turning about it cannot be seen."""
    return np.array([point_row(x, 0.3 * x) for x in (0.1, 0.2, 0.7)])


READ = np.array([1.0 + 0j, 1.1, 1.4])


def own_plate(rows: np.ndarray) -> Bounded:
    found = complex_motion(Phasors(rows, READ, np.full((2, 3), 1e-3), np.full((2, 3), 1e-3)))
    return Bounded(
        found.motion, EPSILON * found.condition * np.abs(found.motion).max() * np.ones(3)
    )


def nearly_rows() -> np.ndarray:
    rows = line_rows()
    rows[1] = point_row(0.2, 0.06 + 1e-6)
    return rows


@cache
def plate_truth() -> Numbers:
    with mpmath.workdps(40):
        found = mpmath.lu_solve(mpmath.matrix(nearly_rows().tolist()),
                                mpmath.matrix([complex(one).real for one in READ]))  # fmt: skip
        return list(found)


def normal_equations() -> np.ndarray:
    rows = nearly_rows()
    return np.asarray(np.linalg.solve(rows.T @ rows, rows.T @ READ))


def cases() -> tuple[HardCase, ...]:
    return (
        HardCase(
            "peak over a cycle of orders 1 to 200 with a beat",
            lambda: float(np.sum(np.abs(HARMONICS)) / own_peak().value[0]), peak_truth, own_peak,
            (Way("grid of 1 degree", lambda: grid_peak(360)),
             Way("grid of .001 rad", lambda: grid_peak(6283))),
        ),
        HardCase(
            "cyclic recursion that grows by 1e17 and decays by more",
            lambda: condition_of(lambda *t: exact_cycle(*t), *TRANSFER.tolist()), cycle_truth,
            own_cycle,
            (Way("orthogonal elimination in pairs", by_blocks, loose=True),
             Way("numpy.linalg.solve of the whole", dense_cycle, loose=True)),
        ),
        HardCase(
            "three accelerometers on one line", singular, None,
            lambda: own_plate(line_rows()),
            (Way("numpy.linalg.lstsq",
                 lambda: np.linalg.lstsq(line_rows(), READ, rcond=None)[0]),),
        ),
        HardCase(
            "three accelerometers 1e-6 m off one line",
            lambda: float(np.linalg.cond(nearly_rows())), plate_truth,
            lambda: own_plate(nearly_rows()),
            (Way("normal equations", normal_equations, loose=True),),
        ),
    )  # fmt: skip

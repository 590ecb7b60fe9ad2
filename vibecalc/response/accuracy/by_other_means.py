"""A body on mounts as plain arrays: what every way of finding its steady motion needs."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import (
    Rates,
    harmonics_of_samples,
    march_fixed,
    march_scipy,
)
from vibecalc.errors import NumericalFailure

DIGITS = 34


class Mounted(NamedTuple):
    """M, K, C and H (n, n) in SI; loads per crank speed squared (orders, n) of `orders` (orders,).

    `spring` and `damper` (components, n) read a result from displacements and velocities; the
    spring may be complex where it has a loss factor.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    structural: np.ndarray
    load: np.ndarray
    orders: np.ndarray
    spring: np.ndarray
    damper: np.ndarray

    @property
    def lasts(self) -> bool:
        """Whether its motion can be followed in time: a loss factor has no equation there."""
        return not np.any(self.structural)

    def first(self, count: int) -> "Mounted":
        """The same with the first `count` orders."""
        return self._replace(load=self.load[:count], orders=self.orders[:count])


def solved(body: Mounted, speed: float) -> np.ndarray:
    """Amplitudes (orders, n), one `numpy.linalg.solve` after the other."""
    found = np.zeros(body.load.shape, dtype=complex)
    for row, order in enumerate(body.orders.tolist()):
        rate = order * speed
        system = body.stiffness - rate * rate * body.mass
        system = system + 1j * (body.structural + rate * body.damping)
        found[row] = np.linalg.solve(system, speed * speed * body.load[row])
    return found


def read(body: Mounted, amplitudes: np.ndarray, speed: float) -> np.ndarray:
    """Harmonics (components, orders) of what is read."""
    rates = 1j * (body.orders * speed)[:, None] * amplitudes
    return np.asarray((amplitudes @ body.spring.T + rates @ body.damper.T).T)


def solved_exactly(body: Mounted, speed: float) -> np.ndarray:
    """Amplitudes (orders, n) by mpmath in 34 digits, rounded once; orders without load are 0."""
    import mpmath

    found = np.zeros(body.load.shape, dtype=complex)
    with mpmath.workdps(DIGITS):
        m, k, c, h = (
            mpmath.matrix(part.tolist())
            for part in (body.mass, body.stiffness, body.damping, body.structural)
        )
        turning = mpmath.mpf(float(speed))
        for row, order in enumerate(body.orders.tolist()):
            if not np.any(body.load[row]):
                continue
            rate = order * turning
            system = k - rate**2 * m + mpmath.mpc(0, 1) * (h + rate * c)
            load = mpmath.matrix([mpmath.mpc(complex(x)) for x in body.load[row]])
            motion = mpmath.lu_solve(system, turning**2 * load)
            found[row] = [complex(x) for x in motion]
    return found


def first_order(body: Mounted, speed: float, columns: int = 0) -> tuple[np.ndarray, Rates]:
    """State matrix (2n, 2n) of displacements and velocities, and the right-hand side.

    With `columns` the state is (2n, columns) and the load acts on its last column alone, so that
    one march gives the free motion from every start and the forced one from rest.

    Raises
    ------
    NumericalFailure
        The mounts have a loss factor, which has no equation in time.
    """
    if not body.lasts:
        raise NumericalFailure("a loss factor has no equation of motion in time")
    n = len(body.mass)
    inverse = np.linalg.inv(body.mass)
    matrix = np.block(
        [[np.zeros((n, n)), np.eye(n)], [-inverse @ body.stiffness, -inverse @ body.damping]]
    )
    pushes = speed * speed * (inverse @ body.load.T)
    used = np.any(pushes != 0.0, axis=0)
    pushes, factor = pushes[:, used], 1j * body.orders[used] * speed

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        result: np.ndarray = matrix @ state
        push = (pushes @ np.exp(factor * time)).real
        if columns:
            result[n:, -1] += push
        else:
            result[n:] += push
        return result

    return matrix, rates


def by_shooting(body: Mounted, speed: float, steps: int) -> tuple[np.ndarray, int]:
    """Amplitudes (orders, n) of the periodic motion, by RK4 over one turn, and products taken.

    All 2n free motions and the forced one are marched together; the start that repeats itself
    follows from one linear system, the amplitudes from the samples of the turn.

    Raises
    ------
    NumericalFailure
        Unstable step, a loss factor, or fewer samples than the orders need.
    """
    n = len(body.mass)
    _, rates = first_order(body, speed, 2 * n + 1)
    start = np.hstack([np.eye(2 * n), np.zeros((2 * n, 1))])
    run = march_fixed(rates, start, 0.0, 2.0 * np.pi / speed, steps)
    free, forced = run.states[..., :-1], run.states[..., -1]
    size = np.max(np.abs(free[-1]))
    if not size < 1e6:
        raise NumericalFailure(
            f"RK4 with {steps} steps per turn is unstable: free motions grow by {size:.1e}"
        )
    first = np.linalg.solve(np.eye(2 * n) - free[-1], forced[-1])
    turn = (free[:-1] @ first + forced[:-1])[:, :n].T
    return _amplitudes(turn, body.orders), run.evaluations * (2 * n + 1)


def from_rest(
    body: Mounted, speed: float, turns: int, rtol: float, method: str = "DOP853"
) -> tuple[np.ndarray, int]:
    """Amplitudes (orders, n) read from the last of some turns after a start at rest.

    Also evaluations of the right-hand side. Raises NumericalFailure as the integrator does.
    """
    n = len(body.mass)
    _, rates = first_order(body, speed)
    count = max(64, 4 * int(body.orders.max()))
    turn = 2.0 * np.pi / speed
    times = np.concatenate([[0.0], turn * (turns - 1 + np.arange(count + 1) / count)])
    times = times[1:] if turns == 1 else times
    still = solved(body.first(1), speed)[0]
    size = float(np.max(np.abs(still))) + 1e-300
    atol = np.repeat([1e-3 * rtol * size, 1e-3 * rtol * size * speed], n)
    run = march_scipy(rates, np.zeros(2 * n), times, rtol, atol, method)
    return _amplitudes(run.states[-count - 1 : -1, :n].T, body.orders), run.evaluations


def _amplitudes(samples: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """Of samples (n, count) of a turn; orders beyond what they tell are zero."""
    reach = min(int(orders.max()), (samples.shape[-1] - 1) // 2)
    found = harmonics_of_samples(samples, reach)
    amplitudes = np.zeros((len(orders), len(samples)), dtype=complex)
    told = orders <= reach
    amplitudes[told] = found[:, orders[told]].T
    return amplitudes

"""Methods for the forced response, against other ways to it."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import (
    Rates,
    harmonics_of_samples,
    march_fixed,
    march_scipy,
)
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.inertia_forces import as_loads, at_speed
from vibecalc.response.adapters.response import LinearSystem, forcing_of, linear_system
from vibecalc.response.energies import energy_by_order, mass_of, velocity
from vibecalc.response.forced import dynamics, modal_response, response

# ----------------------------------------------------------------------------
# A body on mounts as plain arrays: what every way of finding its steady motion needs.
# ----------------------------------------------------------------------------

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
    reported = orders <= reach
    amplitudes[reported] = found[:, orders[reported]].T
    return amplitudes


# ----------------------------------------------------------------------------
# Topics of the response: translations of the body by order at operating speed.
# ----------------------------------------------------------------------------

#: multiplications of one solution with a matrix of six, and of six eigenpairs, in solutions
INVERSE_AND_REFINEMENT = 4.0
MODES = 25.0
#: a response as a sum of modes: two products with the shapes, one step of refinement
MODAL, PLAIN_MODAL = 2.0, 0.5
RTOL = 1e-8


def response_steady_topics(scene: Scene) -> list[Topic]:
    """The translations of the kept orders that are driven; none where nothing shakes."""
    forcing, system = forcing_of(scene), linear_system(scene)
    load = as_loads(forcing.per_speed_squared)
    value = np.where(np.abs(load.value) > 4.0 * load.error, load.value, 0.0)
    driven = np.any(value != 0.0, axis=-1) & (
        forcing.orders <= forcing.orders[forcing.retained - 1]
    )
    if not np.any(driven):
        return []
    options = scene.case.response
    if options is None:
        return []
    body = Mounted(
        *system.matrices[:4],
        load=value[driven],
        orders=forcing.orders[driven],
        spring=np.eye(3, 6),
        damper=np.zeros((3, 6)),
    )
    error = as_loads(at_speed(forcing.per_speed_squared, scene.case.machine.speed)).error[driven]
    return [_steady_topic(body, system, error, scene.case.machine.speed, options.method)]


def _steady_topic(
    body: Mounted, system: LinearSystem, error: np.ndarray, speed: float, method: str
) -> Topic:
    count, frequency = len(body.orders), body.orders * speed
    load, shape = speed * speed * body.load, system.shapes.shape

    def moved(amplitudes: np.ndarray, work: float) -> Answer:
        return Answer(amplitudes[:, :3], work)

    def direct(_: float) -> Answer:
        found = response(dynamics(system.matrices, frequency), load, error)
        return moved(found.value, INVERSE_AND_REFINEMENT * count)

    def modal(_: float) -> Answer:
        found = modal_response(system.matrices, shape, frequency, load, error)
        return moved(found.value, MODES + MODAL * count)

    def few_modes(modes: float) -> Answer:
        found = _sum_of_modes(body, shape[:, : int(modes)], speed)
        return moved(found, MODES + PLAIN_MODAL * modes / 6.0 * count)

    def looped(_: float) -> Answer:
        return moved(solved(body, speed), count)

    def timed(way: Callable[[float], tuple[np.ndarray, int]]) -> Callable[[float], Answer]:
        def solve(setting: float) -> Answer:
            amplitudes, work = way(setting)
            return moved(amplitudes, work)

        return solve

    solvers = [
        Solver(
            "direct",
            "dynamic stiffness of all orders inverted together, one step of refinement",
            "",
            NOTHING_TO_SET,
            direct,
            default=1.0 if method == "direct" else None,
            citation="Harris and Piersol (2002), ch. 3",
        ),
        Solver(
            "modal",
            "sum of all modes, coupled where the damping couples them, one step of refinement",
            "",
            NOTHING_TO_SET,
            modal,
            default=1.0 if method == "modal" else None,
            citation="Thomson and Dahleh (1998), ch. 6",
        ),
        Solver(
            "sum of the first modes",
            "each mode with its own damping alone, the lowest N of them",
            "modes",
            (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
            few_modes,
            citation="Ong (2000), chapter 4",
        ),
        Solver(
            "loop of solutions",
            "numpy.linalg.solve for one order after the other",
            "",
            NOTHING_TO_SET,
            looped,
        ),
    ]
    if body.lasts:
        least = 2 * int(body.orders.max()) + 1
        steps = sorted({max(2**k, 16) for k in range(4, 9)} | {64 * (1 + least // 64)})
        solvers.append(
            Solver(
                "RK4 shooting",
                "classical Runge-Kutta over one turn, the start that repeats itself solved for",
                "steps per turn",
                tuple(float(x) for x in steps),
                timed(lambda setting: by_shooting(body, speed, int(setting))),
                theory="order 4",
            )
        )
        solvers.append(
            Solver(
                "DOP853 from rest",
                f"scipy from rest at rtol {RTOL:g}, the last of N turns read",
                "turns",
                (4.0, 16.0, 64.0),
                timed(lambda setting: from_rest(body, speed, int(setting), RTOL)),
                theory="as the free motion dies away",
            )
        )
    return Topic(
        stage="response",
        name="translations by order",
        words=f"translations of the body, {count} driven orders at {speed:.6g} rad/s",
        quantity="response/translation_harmonics",
        unit="m",
        work="solutions of, or products with, the system's matrices",
        reference=lambda: _steady_reference(body, speed),
        solvers=tuple(solvers),
        default_extra=_extra(method, count),
        default_why="the modes are results themselves; the step of refinement gives every entry "
        "an error of its own",
    )


def _extra(method: str, count: int) -> float:
    """Work of the default over that of a loop of solutions, rounded up."""
    if method == "direct":
        return INVERSE_AND_REFINEMENT
    return float(np.ceil(10.0 * (MODES / count + MODAL)) / 10.0)


def _sum_of_modes(body: Mounted, shape: np.ndarray, speed: float) -> np.ndarray:
    """Amplitudes (orders, n) as textbooks add them: no mode acts on another."""

    def own(matrix: np.ndarray) -> np.ndarray:
        return np.asarray(np.einsum("im,ij,jm->m", shape, matrix, shape))

    rate = (body.orders * speed)[:, None]
    stiffness = own(body.stiffness) - rate**2 * own(body.mass)
    stiffness = stiffness + 1j * (own(body.structural) + rate * own(body.damping))
    return np.asarray((speed * speed * (body.load @ shape) / stiffness) @ shape.T)


def _steady_reference(body: Mounted, speed: float) -> Reference:
    exact = solved_exactly(body, speed)[:, :3]
    other = solved(body, speed)[:, :3]
    agreement = float(np.max(np.abs(other - exact)) / np.max(np.abs(exact)))
    return Reference(
        exact,
        agreement,
        f"solved in 34 digits (mpmath), numpy.linalg.solve agrees to {agreement:.1e}",
    )


# ----------------------------------------------------------------------------
# Topic of the energies over speed: the mean kinetic energy of the body at speeds of the range.
# ----------------------------------------------------------------------------

#: speeds at which methods are compared: off the even grids, and few enough for the reference
SPEEDS = 10
GRIDS = tuple(float(10 * 3**power) for power in range(6))


#: digits of the reference
_DIGITS = 40


def response_speeds_topics(scene: Scene) -> list[Topic]:
    """One topic; none where no order shakes the body."""
    options = scene.case.response
    if options is None or options.run_up is None:
        return []
    forcing, system = forcing_of(scene), linear_system(scene)
    load = as_loads(forcing.per_speed_squared)
    value, error = load.value[: forcing.retained], load.error[: forcing.retained]
    driven = np.any(np.abs(value) > 4.0 * error, axis=-1)
    orders = forcing.orders[: forcing.retained][driven]
    if not len(orders):
        return []
    start, stop = options.run_up.start, options.run_up.stop
    # golden steps: no speed is on an even grid, and resonances are met by chance only
    share = np.modf(0.6180339887498949 * np.arange(1, SPEEDS + 1))[0]
    speed = start + (stop - start) * np.sort(share)
    return [_speeds_topic(system, orders, value[driven], error[driven], speed, (start, stop))]


def _speeds_topic(
    system: LinearSystem,
    orders: np.ndarray,
    load: np.ndarray,
    error: np.ndarray,
    speed: np.ndarray,
    ends: tuple[float, float],
) -> Topic:
    def direct(_: float) -> Answer:
        square = np.square(speed)[:, None, None]
        frequency = speed[:, None] * orders
        stiffness = dynamics(system.matrices, frequency)
        motion = response(stiffness, square * load, square * error)
        energy = energy_by_order(mass_of(system.matrices), velocity(motion, frequency))
        return Answer(energy.mean.sum(-1), INVERSE_AND_REFINEMENT * frequency.size)

    def looped(_: float) -> Answer:
        return Answer(_one_by_one(system, orders, load, speed), float(len(speed) * len(orders)))

    def interpolated(points: float) -> Answer:
        grid = np.linspace(*ends, int(points))
        curve = _together(system, orders, load, grid)
        return Answer(np.interp(speed, grid, curve), points * len(orders))

    solvers = (
        Solver(
            name="direct",
            words="dynamic stiffness of all orders and speeds inverted together, one step of "
            "refinement, error estimates",
            setting="",
            settings=NOTHING_TO_SET,
            solve=direct,
            default=NOTHING_TO_SET[0],
            citation="Harris and Piersol (2002), ch. 3",
        ),
        Solver(
            name="loop of solutions",
            words="numpy.linalg.solve for one order at one speed after the other",
            setting="",
            settings=NOTHING_TO_SET,
            solve=looped,
        ),
        Solver(
            name="even grid",
            words="numpy.linalg.solve on N even speeds, straight lines between them",
            setting="speeds",
            settings=GRIDS,
            solve=interpolated,
            theory="order 2 once the grid resolves every resonance",
        ),
    )
    return Topic(
        stage="speeds",
        name="mean kinetic energy over speed",
        words=f"mean kinetic energy at {len(speed)} speeds from {ends[0]:.6g} to {ends[1]:.6g} "
        f"rad/s, {len(orders)} orders",
        quantity="response/run_up/kinetic_energy",
        unit="J",
        work="solutions with a 6 x 6 matrix",
        reference=lambda: _speeds_reference(system, orders, load, speed),
        solvers=solvers,
        default_extra=INVERSE_AND_REFINEMENT,
        default_why="the inverse gives the error estimate of every amplitude, the refinement full "
        "digits next to a resonance",
    )


def _stiffness(system: LinearSystem, frequency: float) -> np.ndarray:
    mass, stiffness, damping, structural = system.matrices[:4]
    return np.asarray(
        stiffness - frequency**2 * mass + 1j * (frequency * damping + structural), dtype=complex
    )


def _one_by_one(
    system: LinearSystem, orders: np.ndarray, load: np.ndarray, speed: np.ndarray
) -> np.ndarray:
    mass = system.matrices.mass
    total = np.zeros(len(speed))
    for place, at in enumerate(speed.tolist()):
        for order, force in zip(orders.tolist(), load, strict=True):
            moved = np.linalg.solve(_stiffness(system, order * at), at**2 * force)
            rate = order * at * moved
            total[place] += 0.25 * float(np.real(np.conj(rate) @ mass @ rate))
    return total


def _together(
    system: LinearSystem, orders: np.ndarray, load: np.ndarray, speed: np.ndarray
) -> np.ndarray:
    mass, stiffness, damping, structural = system.matrices[:4]
    frequency = (speed[:, None] * orders)[..., None, None]
    matrix = stiffness - frequency**2 * mass + 1j * (frequency * damping + structural)
    force = np.square(speed)[:, None, None] * load
    rate = frequency[..., 0] * np.linalg.solve(matrix, force[..., None])[..., 0]
    each = np.einsum("soi,ij,soj->so", rate.conj(), mass, rate).real
    return np.asarray(0.25 * each.sum(-1))


def _speeds_reference(
    system: LinearSystem, orders: np.ndarray, load: np.ndarray, speed: np.ndarray
) -> Reference:
    """The sums in mpmath; by elimination and, at one speed, by Cramer's rule."""
    import mpmath as mp

    with mp.workdps(_DIGITS):
        mass, stiffness, damping, structural = (mp.matrix(m.tolist()) for m in system.matrices[:4])

        def energy(at: float, by_cramer: bool) -> Any:
            total = mp.mpf(0)
            for order, force in zip(orders.tolist(), load, strict=True):
                w = mp.mpf(order) * mp.mpf(at)
                matrix = stiffness - w**2 * mass + 1j * (w * damping + structural)
                right = mp.matrix([mp.mpf(at) ** 2 * mp.mpc(x) for x in force.tolist()])
                solve = _cramer if by_cramer else mp.lu_solve
                rate = solve(matrix, right) * w
                total += mp.re((rate.H * mass * rate)[0]) / 4
            return total

        values = [energy(at, False) for at in speed.tolist()]
        peak = max(range(len(values)), key=lambda place: values[place])
        apart = abs(energy(float(speed[peak]), True) / values[peak] - 1)
        return Reference(
            np.array([float(value) for value in values]),
            max(float(apart), 10.0 ** (6 - _DIGITS)),
            f"elimination in {_DIGITS} digits (mpmath), Cramer's rule at the speed of the largest",
        )


def _cramer(matrix: Any, right: Any) -> Any:
    """Solution by determinants."""
    import mpmath as mp

    whole = mp.det(matrix)
    found = mp.matrix(matrix.rows, 1)
    for column in range(matrix.cols):
        other = matrix.copy()
        other[:, column] = right
        found[column] = mp.det(other) / whole
    return found

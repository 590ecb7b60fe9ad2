"""Topic of the energies over speed: the mean kinetic energy of the body at speeds of the range."""

from typing import Any

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.excitation.inertia_forces import as_loads
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.linear_system import LinearSystem, forcing_of, linear_system
from vibecalc.response.direct import dynamics, response
from vibecalc.response.energies import energy_by_order, mass_of, velocity

#: speeds at which methods are compared: off the even grids, and few enough for the reference
SPEEDS = 10
GRIDS = tuple(float(10 * 3**power) for power in range(6))

#: one inversion and one step of refinement of a matrix of six, in solutions with it
INVERSE_AND_REFINEMENT = 4.0

#: digits of the reference
_DIGITS = 40


def topics(scene: Scene) -> list[Topic]:
    """One topic; none where no order shakes the body."""
    options = scene.case.response
    if options is None or options.run_up is None:
        return []
    forcing, system = forcing_of(scene), linear_system(scene)
    load = as_loads(forcing.per_speed_squared)
    value, error = load.value[: forcing.kept], load.error[: forcing.kept]
    driven = np.any(np.abs(value) > 4.0 * error, axis=-1)
    orders = forcing.orders[: forcing.kept][driven]
    if not len(orders):
        return []
    start, stop = options.run_up.start, options.run_up.stop
    # golden steps: no speed is on an even grid, and resonances are met by chance only
    share = np.modf(0.6180339887498949 * np.arange(1, SPEEDS + 1))[0]
    speed = start + (stop - start) * np.sort(share)
    return [_topic(system, orders, value[driven], error[driven], speed, (start, stop))]


def _topic(
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

    ladders = (
        Ladder(
            name="direct",
            words="dynamic stiffness of all orders and speeds inverted together, one step of "
            "refinement, error estimates",
            setting="",
            settings=NOTHING_TO_SET,
            solve=direct,
            default=NOTHING_TO_SET[0],
            citation="Harris and Piersol (2002), ch. 3",
        ),
        Ladder(
            name="loop of solutions",
            words="numpy.linalg.solve for one order at one speed after the other",
            setting="",
            settings=NOTHING_TO_SET,
            solve=looped,
        ),
        Ladder(
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
        reference=lambda: _reference(system, orders, load, speed),
        ladders=ladders,
        default_extra=INVERSE_AND_REFINEMENT,
        default_why="the inverse gives the error estimate of every amplitude, the refinement full "
        "digits beside a resonance",
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


def _reference(
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

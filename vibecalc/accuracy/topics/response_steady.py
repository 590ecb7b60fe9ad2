"""Topics of the response: translations of the body by order at operating speed."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.excitation.inertia_forces import as_loads, at_speed
from vibecalc.isolation.accuracy.by_other_means import (
    Mounted,
    by_shooting,
    from_rest,
    solved,
    solved_exactly,
)
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.linear_system import LinearSystem, forcing_of, linear_system
from vibecalc.response.direct import dynamics, response
from vibecalc.response.modal import modal_response

#: multiplications of one solution with a matrix of six, and of six eigenpairs, in solutions
INVERSE_AND_REFINEMENT = 4.0
MODES = 25.0
#: a response as a sum of modes: two products with the shapes, one step of refinement
MODAL, PLAIN_MODAL = 2.0, 0.5
RTOL = 1e-8


def topics(scene: Scene) -> list[Topic]:
    """The translations of the kept orders that are driven; none where nothing shakes."""
    forcing, system = forcing_of(scene), linear_system(scene)
    load = as_loads(forcing.per_speed_squared)
    value = np.where(np.abs(load.value) > 4.0 * load.error, load.value, 0.0)
    driven = np.any(value != 0.0, axis=-1) & (forcing.orders <= forcing.orders[forcing.kept - 1])
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
    return [_topic(body, system, error, scene.case.machine.speed, options.method)]


def _topic(
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

    ladders = [
        Ladder(
            "direct",
            "dynamic stiffness of all orders inverted together, one step of refinement",
            "",
            NOTHING_TO_SET,
            direct,
            default=1.0 if method == "direct" else None,
            citation="Harris and Piersol (2002), ch. 3",
        ),
        Ladder(
            "modal",
            "sum of all modes, coupled where the damping couples them, one step of refinement",
            "",
            NOTHING_TO_SET,
            modal,
            default=1.0 if method == "modal" else None,
            citation="Thomson and Dahleh (1998), ch. 6",
        ),
        Ladder(
            "sum of the first modes",
            "each mode with its own damping alone, the lowest N of them",
            "modes",
            (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
            few_modes,
            citation="Ong (2000), chapter 4",
        ),
        Ladder(
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
        ladders.append(
            Ladder(
                "RK4 shooting",
                "classical Runge-Kutta over one turn, the start that repeats itself solved for",
                "steps per turn",
                tuple(float(x) for x in steps),
                timed(lambda setting: by_shooting(body, speed, int(setting))),
                theory="order 4",
            )
        )
        ladders.append(
            Ladder(
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
        reference=lambda: _reference(body, speed),
        ladders=tuple(ladders),
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


def _reference(body: Mounted, speed: float) -> Reference:
    exact = solved_exactly(body, speed)[:, :3]
    other = solved(body, speed)[:, :3]
    agreement = float(np.max(np.abs(other - exact)) / np.max(np.abs(exact)))
    return Reference(
        exact,
        agreement,
        f"solved in 34 digits (mpmath), numpy.linalg.solve agrees to {agreement:.1e}",
    )

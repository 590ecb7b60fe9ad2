"""The change between two operations as plain arrays: physical matrices, loads and course."""

from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.yardsticks.integrators import Rates
from vibecalc.excitation.inertia_forces import add, as_loads
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.linear_system import (
    LinearSystem,
    forcing_of,
    linear_system,
    ratios_of,
)
from vibecalc.pipeline.stages.operation_loads import operation_loads
from vibecalc.response.switching.steady import steady_motion, steady_state
from vibecalc.response.switching.system import Loads, ModalLoads, ModalSystem, modal_loads


class Change(NamedTuple):
    """From the first to the second operation of the case, at the case's crank angle.

    `inverse` (6, 6) is the inverse of the mass matrix; `stiffness`, `damping` (6, 6) carry each
    mode's own damping alone, as the stage takes it; `load` (2, orders, 6) per crank speed squared
    of `orders` (orders,); `start` (12,) the steady displacements and velocities at the change.
    """

    system: ModalSystem
    loads: Loads
    modal: ModalLoads
    speed: float
    angle: float
    inverse: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    load: np.ndarray
    orders: np.ndarray
    start: np.ndarray


def change_of(scene: Scene) -> Change | None:
    """What `[response.switching]` asks for, the dropped orders left out; None without it."""
    response = scene.case.response
    if response is None or response.switching is None:
        return None
    options = response.switching
    known = {operation.name: operation for operation in response.operations}
    found = operation_loads(scene, [known[name] for name in options.between])
    each = [
        as_loads(add(shaking, residual[0]))
        for shaking, residual in zip(found.shaking, found.residual, strict=True)
    ]
    kept = forcing_of(scene).kept
    load = np.stack([one.value[:kept] for one in each])
    doubt = np.stack([one.error[:kept] for one in each])
    load = np.where(np.abs(load) > 4.0 * doubt, load, 0.0)
    matrices, shapes = linear_system(scene)
    ratio = ratios_of(scene, LinearSystem(matrices, shapes)).value
    system = ModalSystem(shapes.shape, shapes.natural_frequency, ratio)
    orders = np.arange(1, kept + 1)
    loads = Loads(orders, load, np.zeros((2, 6)))
    modal = modal_loads(system, loads)
    speed, angle = scene.case.machine.speed, options.crank_angle
    momentum = matrices.mass @ shapes.shape
    own = 2.0 * ratio * shapes.natural_frequency
    steady = steady_state(
        steady_motion(system, modal, 0, speed), modal.orders, speed, np.asarray(angle)
    )
    return Change(
        system,
        loads,
        modal,
        speed,
        angle,
        shapes.shape @ shapes.shape.T,
        (momentum * np.square(shapes.natural_frequency)) @ momentum.T,
        (momentum * own) @ momentum.T,
        load,
        orders,
        np.concatenate([shapes.shape @ steady[:, 0], shapes.shape @ steady[:, 1]]),
    )


def rates_of(change: Change, operation: int, acceleration: float = 0.0) -> tuple[np.ndarray, Rates]:
    """State matrix (12, 12) and right-hand side of (x, x') under one operation.

    `acceleration` is that of the crank, rad/s^2, from the operating speed on. Each order loads the
    body with P (w^2 - i w'/n) exp(i n theta).
    """
    matrix = np.block(
        [
            [np.zeros((6, 6)), np.eye(6)],
            [-change.inverse @ change.stiffness, -change.inverse @ change.damping],
        ]
    )
    pushes = change.inverse @ change.load[operation].T
    used = np.any(pushes != 0.0, axis=0)
    pushes, orders = pushes[:, used], change.orders[used]

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        speed = change.speed + acceleration * time
        theta = change.angle + time * (change.speed + 0.5 * acceleration * time)
        wave = (speed * speed - 1j * acceleration / orders) * np.exp(1j * orders * theta)
        result: np.ndarray = matrix @ state
        result[6:] += (pushes @ wave).real
        return result

    return matrix, rates

"""Small lines with torques, and an independent way to read them: dense solves, sampled cycles."""

import numpy as np
from torsion_lines import ring_on

from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, SpeedTorque
from vibecalc.torsion.line import Line, chain, dynamic_stiffness

RING = 27.5126
TABLE_VALUE = Damper(RING, 5.9712e5, 2131.976)
FIRING = (1, 5, 3, 6, 2, 4)


def torque_of_parts(gas: np.ndarray, inertia: np.ndarray | float) -> SpeedTorque:
    """gas + inertia speed^2, (m, n) each, at any speed."""
    first, second = np.broadcast_arrays(np.asarray(gas, complex), np.asarray(inertia, complex))
    parts = np.stack([first, np.zeros_like(first), second])
    return SpeedTorque(np.array([0.0, np.inf]), parts[None])


def engine_torque(order: np.ndarray) -> SpeedTorque:
    """Six cylinders fired 1-5-3-6-2-4, gas falling with order, inertia of orders 1, 2 and 3."""
    gas = np.zeros((order.size, 7), dtype=complex)
    inertia = np.zeros_like(gas)
    for place, cylinder in enumerate(FIRING):
        lag = np.exp(-1j * order * place * 2.0 * np.pi / 3.0)
        uneven = 1.0 + 0.03 * np.sin(2.0 * cylinder)
        gas[:, cylinder - 1] = 8000.0 * uneven * np.exp((-0.25 + 0.7j) * order) * lag
        for whole, amplitude in ((1, 0.12), (2, -0.5), (3, -0.36)):
            inertia[:, cylinder - 1] += 1j * amplitude * lag * (order == whole)
    return torque_of_parts(gas, inertia)


def engine(orders: int = 24, speed: tuple[float, float] = (20.0, 100.0)) -> DamperProblem:
    """The published six-cylinder line with half orders 0.5 to orders / 2."""
    order = np.arange(1, orders + 1) / 2.0
    line = chain(np.array([18.64] * 6 + [2655.0]), np.array([22.82e6] * 5 + [19.21e6]))
    return DamperProblem(line, 0, order, 4.0 * np.pi, engine_torque(order), speed, np.ones(6))


def branched() -> DamperProblem:
    """Four inertias as a star with a lossy, damped and grounded line, two-stroke."""
    line = Line(
        inertia=np.array([2.0, 1.5, 3.0, 8.0]),
        absolute_damping=np.array([0.0, 1.0, 0.0, 2.0]),
        ground_stiffness=np.array([0.0, 0.0, 0.0, 50.0]),
        first=np.array([0, 1, 2]),
        second=np.array([3, 3, 3]),
        stiffness=np.array([4e4, 9e4, 6e4]),
        damping=np.array([30.0, 20.0, 10.0]),
        loss_factor=np.array([0.0, 0.01, 0.02]),
    )
    torque = np.zeros((3, 4), dtype=complex)
    torque[:, 0] = [100.0, 60.0 - 30.0j, 25.0j]
    torque[:, 1] = [-40.0j, 50.0, 30.0 + 10.0j]
    order = np.array([1.0, 2.0, 3.0])
    source = torque_of_parts(torque, 0.0)
    return DamperProblem(
        line, 0, order, 2.0 * np.pi, source, (30.0, 200.0), np.array([2.0, 0.4, 1.0])
    )


def with_ring(problem: DamperProblem, damper: Damper) -> Line:
    """The ring as a freedom of its own, the last, on an element of its own, the last."""
    return ring_on(problem.line, problem.station, (*damper, 0.0))


def direct(problem: DamperProblem, damper: Damper, speed: np.ndarray, samples: int) -> np.ndarray:
    """Sections, heat and travel (s, e + 2) by `dynamic_stiffness`, numpy and sampled cycles."""
    line = with_ring(problem, damper)
    w = speed[:, None] * problem.order
    gas, _, inertia = problem.torque.coefficient[0]
    torque = gas + speed[:, None, None] ** 2 * inertia
    torque = np.concatenate([torque, np.zeros((*w.shape, 1))], axis=-1)
    angle = np.linalg.solve(dynamic_stiffness(line, w), torque[..., None])[..., 0]
    twist = angle[..., line.first] - angle[..., line.second]
    factor = line.stiffness * (1.0 + 1j * line.loss_factor) + 1j * w[..., None] * line.damping
    theta = problem.cycle * np.arange(samples) / samples
    wave = np.exp(1j * problem.order[:, None] * theta)
    torque_course = np.einsum("sme,mt->set", factor * twist, wave).real[:, :-1]
    ring_course = np.einsum("sm,mt->st", twist[..., -1], wave).real
    half = 0.5 * (torque_course.max(axis=-1) - torque_course.min(axis=-1)) * problem.weight
    heat = 0.5 * damper.damping * np.sum(np.abs(w * twist[..., -1]) ** 2, axis=-1)
    return np.column_stack([half, heat, np.abs(ring_course).max(axis=-1)])

"""Lines with variable inertias: one freedom, a three-cylinder ship engine, the published one."""

import numpy as np

from vibecalc.excitation.inertia_forces import inertia_torque
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.torsion.line import Line, chain, stiffness_matrix
from vibecalc.torsion.variable_inertia.motion import VariableLine, inertia_variation, variable_line


def piston_variation(rod_ratio: float, highest: int) -> np.ndarray:
    """Orders 1 .. highest of (ds/dtheta)^2 / R^2 less its mean."""
    torque = inertia_torque(motion_harmonics(rod_ratio, 24), highest).value[1:]
    return inertia_variation(torque)


def one_freedom(variation: float, *, damping: float = 0.0, turns: int = 1) -> VariableLine:
    """J = 1 + variation cos 2 theta on a spring of 1 to the turning frame."""
    line = chain(np.array([1.0]), np.zeros(0))
    line = line._replace(ground_stiffness=np.ones(1), absolute_damping=np.array([damping]))
    return variable_line(line, [[0.0, variation]], turns=turns)


def ship_engine(scale: float = 1.0, *, damping: float = 1.0) -> VariableLine:
    """Three cylinders, dJ / J = .4 at full scale, and a flywheel that takes the mean torque."""
    line = chain(np.array([10.0, 10.0, 10.0, 60.0]), np.array([2e6, 2e6, 2.5e6]))
    line = line._replace(
        absolute_damping=damping * np.array([100.0, 100.0, 100.0, 0.0]),
        damping=damping * np.full(3, 200.0),
    )
    crank = np.array([0.0, 2.0, 4.0, 0.0]) * np.pi / 3.0
    turned = np.exp(-1j * np.outer(crank, np.arange(1, 9)))
    mass = scale * np.array([8.0, 8.0, 8.0, 0.0])[:, None]
    return variable_line(line, mass * piston_variation(0.28, 8) * turned, load=[0, 0, 0, 1])


def ship_torque(scale: float = 1.0) -> np.ndarray:
    """Gas torque of the three cylinders, half orders to 6, made up: smooth and with phases."""
    k = np.arange(13)[:, None]
    firing = np.array([0.0, 4.0, 8.0]) * np.pi / 3.0
    each = np.where(k > 0, 2000.0 / (1.0 + k / 3.0), 1000.0) * np.exp(-0.5j * k)
    torque = np.zeros((13, 4), dtype=complex)
    torque[:, :3] = scale * np.where(k > 0, each, each.real) * np.exp(-0.5j * k * firing)
    return torque


def modes_of(line: Line) -> tuple[np.ndarray, np.ndarray]:
    """Natural frequencies and mass-normalised shapes (m, n) of a well-scaled small line."""
    root = np.sqrt(line.inertia)
    squares, shapes = np.linalg.eigh(stiffness_matrix(line) / np.outer(root, root))
    free = squares < 1e-9 * squares[-1]
    return np.where(free, 0.0, np.sqrt(np.abs(squares))), (shapes / root[:, None]).T

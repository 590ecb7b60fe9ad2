"""States to start from: everything at rest, or the steady vibration at the first speed."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.transient_motion import Stretch
from vibecalc.response.torsion.transient_system import TransientSystem
from vibecalc.response.torsion.transient_torque import load_at, torque_law


def rest(system: TransientSystem) -> FloatArray:
    """The state (s,) without twist and relative velocity."""
    return np.zeros(system.state_matrix.shape[0])


def steady_start(
    system: TransientSystem, order: FloatArray, part: Stretch, speed: float, angle: float = 0.0
) -> FloatArray:
    """State (s,) of the steady vibration at a speed in rad/s and a crank angle in rad.

    Torques and loads are those at the beginning of `part`, its acceleration is left out; at speed
    zero it is the static twist under the torque of that angle. Twists of elements of dashpots only
    start from zero. Raises NumericalFailure if an order meets an undamped natural frequency.
    """
    law = torque_law(
        order,
        part._replace(acceleration=0.0, acceleration_rate=0.0),
        system.balance,
        system.inertia,
        np.array([speed, speed]),
    )
    m = law.power.size
    both = law.harmonic[0] + speed**2 * law.harmonic[2]
    torque = part.scale_start * (both[:, :m] - 1j * both[:, m:])
    moving = (law.power > 0.0) & (speed > 0.0) & np.any(torque != 0.0, axis=0)
    phase = np.exp(0.5j * law.power * angle)

    still = ~moving
    mean = load_at(law, np.array(speed)) + (torque[:, still] * phase[still]).real.sum(axis=1)
    state = static_state(system, mean)
    if not moving.any():
        return state
    size = system.state_matrix.shape[0]
    frequency = 0.5 * law.power[moving] * speed
    matrix = 1j * frequency[:, None, None] * np.eye(size) - system.state_matrix
    lost = UNIT_ROUNDOFF * np.linalg.cond(matrix)
    if np.any(lost > SINGULAR):
        worst = 0.5 * law.power[moving][np.argmax(lost)]
        raise NumericalFailure(
            f"no steady vibration to start from: order {worst:g} meets an undamped natural "
            f"frequency at {speed:.6g} rad/s"
        )
    source = (system.input_matrix @ torque[:, moving]).T[..., None]
    amplitude = np.linalg.solve(matrix, source)[..., 0]
    together: FloatArray = state + (amplitude * phase[moving, None]).real.sum(axis=0)
    return together


def static_state(system: TransientSystem, torque: FloatArray) -> FloatArray:
    """State (s,) held by constant balanced torques (n,): the least energy among all solutions."""
    state = rest(system)
    if not np.any(torque):
        return state
    used = ~system.idle
    source = system.input_matrix @ torque
    matrix = system.state_matrix[np.ix_(used, used)]
    state[used] = np.linalg.lstsq(matrix, -source[used], rcond=None)[0]
    left = matrix @ state[used] + source[used]
    if np.linalg.norm(left) > 1e-8 * np.linalg.norm(source):
        raise NumericalFailure("the mean torque has nothing that holds it: no static twist exists")
    return state

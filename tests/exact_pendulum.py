"""A pendulum on its path from first principles: places of mass and roller by integration, kinetic
energy by their velocities, in many digits. Only `rates`, to march large swings, takes terms of the
package, which the energy holds.
"""

import mpmath as mp
import numpy as np

from vibecalc.absorber.pendulum_order import terms


def place(pendulum, angle):
    """Place of the mass centre on the rotor: the tangent (-sin, cos) times the radius, summed."""
    far, near, bend = (mp.mpf(float(v)) for v in pendulum[1:4])
    x = far - mp.quad(lambda t: near * mp.cos(bend * t) * mp.sin(t), [0, angle])
    y = mp.quad(lambda t: near * mp.cos(bend * t) * mp.cos(t), [0, angle])
    return x, y


def kinetic_energy(pendulum, angle, rotor_speed, swing_speed):
    """Energy of mass and rollers; velocities on the rotor by differences of places."""
    mass, far, near, bend, own, rolling, across, diameter, roller_own = (
        mp.mpf(float(v)) for v in pendulum
    )
    step = mp.mpf(10) ** -15
    x, y = place(pendulum, angle)
    ahead, behind = place(pendulum, angle + step), place(pendulum, angle - step)
    along = [(p - q) / (2 * step) * swing_speed for p, q in zip(ahead, behind, strict=True)]

    def translation(heavy, px, py, vx, vy):
        return heavy / 2 * ((vx - rotor_speed * py) ** 2 + (vy + rotor_speed * px) ** 2)

    total = translation(mass, x, y, *along) + own / 2 * (rotor_speed + swing_speed) ** 2
    centre = (across + (x - far) / 2, y / 2)
    total += translation(rolling, *centre, along[0] / 2, along[1] / 2)
    way = near * mp.cos(bend * angle) * swing_speed
    return total + roller_own / 2 * (rotor_speed - way / diameter) ** 2


def rates(pendulum, rotor_inertia, state, torque=0.0, damping=0.0):
    """Time derivative of states (..., 4): rotor angle, swing angle, rotor speed, swing speed.

    Torque on the rotor in N m; damping in N m s/rad, torque on the swing angle per swing speed.
    """
    swung, speed, swinging = state[..., 1], state[..., 2], state[..., 3]
    term = terms(pendulum, swung)
    rotor = np.asarray(rotor_inertia) + term.carried
    first = (
        np.asarray(torque)
        - term.carried_slope * swinging * speed
        - term.coupling_slope * swinging * swinging
    )
    second = (
        0.5 * term.carried_slope * speed * speed
        - 0.5 * term.swing_slope * swinging * swinging
        - np.asarray(damping) * swinging
    )
    whole = rotor * term.swing - term.coupling * term.coupling
    rotor_rate = (term.swing * first - term.coupling * second) / whole
    swing_rate = (rotor * second - term.coupling * first) / whole
    return np.stack(np.broadcast_arrays(speed, swinging, rotor_rate, swing_rate), axis=-1)

"""Rates over the crank angle where a controller sets the speed of the motor's field.

The controller asks for u* = K (R - k_R w - k_S ds/dt), with w the speed of the crank against the
shell and ds/dt the acceleration of the shell. The actuator follows with a first-order lag,
tau du/dt = u* - u, and the slip of the motor is u - w (Herold 1977, Fig. 26, in the equations of
`inertia.py`). The acceleration is linear in the torque of the motor, and the torque a function of
the slip: without a lag, u = u* is one equation for the slip at every angle.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.slip_torque import slip_torque
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.rates import Place, place_at, shell_speed

_ROUNDS = 80


class Law(NamedTuple):
    """Gain K (1), speed feedback k_R (1), acceleration feedback k_S (s), reference R (rad/s), lag
    tau of the actuator (s), zero for none.
    """

    gain: float
    speed_feedback: float
    acceleration_feedback: float
    reference: float
    lag: float = 0.0


class Driven(NamedTuple):
    """What the motor does (..., k): slip in rad/s and torque in N m, with its slopes by the states
    (..., k, n).
    """

    slip: FloatArray
    torque: FloatArray
    torque_by: FloatArray


class _Bare(NamedTuple):
    """Accelerations without the torque of the motor, their slopes by the states, and what one N m
    of it adds.
    """

    shell: FloatArray
    crank: FloatArray
    shell_by: FloatArray
    crank_by: FloatArray
    shell_gain: FloatArray
    crank_gain: FloatArray


class ControlledRates:
    """dy/db at (B, P, s) crank angles for a machine under control.

    y = (w,) of a free shell, with `momentum` (B,) its angular momentum, or (w, shell angle, shell
    speed) with mounts, `momentum` being None; with a lag of the actuator u follows behind.
    """

    def __init__(
        self, machine: RollMachine, drive: RollDrive, law: Law, momentum: FloatArray | None
    ):
        self.machine, self.drive, self.law, self.momentum = machine, drive, law, momentum
        self.states = (1 if momentum is not None else 3) + (law.lag > 0.0)
        self._angles: FloatArray | None = None
        self._place: Place | None = None

    def __call__(
        self, crank_angle: FloatArray, state: FloatArray, piece: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        members, panels, points = crank_angle.shape
        flat = state.reshape(members, panels * points, self.states)
        flat = np.where(flat[..., :1] > 0.0, flat, np.nan)
        chosen = None if piece is None else np.repeat(piece, points, axis=1)
        value, jacobian = self._rates(self.place(crank_angle), flat, chosen)
        return value.reshape(state.shape), jacobian.reshape(*state.shape, self.states)

    def place(self, crank_angle: FloatArray) -> Place:
        """Inertia and torques at the angles (B, P, s), as (B, P s)."""
        if self._place is None or self._angles is not crank_angle:
            flat = crank_angle.reshape(len(crank_angle), -1)
            self._place = place_at(self.machine, self.drive, flat)
            self._angles = crank_angle
        return self._place

    def driven(self, place: Place, state: FloatArray, piece: IntArray | None = None) -> Driven:
        """Slip and torque at states (B, k, n)."""
        return self._driven(self._bare(place, state), state, piece)

    def lagged_slip(self, state: FloatArray) -> FloatArray:
        """Slip at states (B, P, s, n) of an actuator with a lag."""
        return np.asarray(state[..., -1] - state[..., 0])

    def _rates(
        self, place: Place, state: FloatArray, piece: IntArray | None
    ) -> tuple[FloatArray, FloatArray]:
        law, speed = self.law, state[..., 0]
        bare = self._bare(place, state)
        motor = self._driven(bare, state, piece)
        shell = bare.shell + bare.shell_gain * motor.torque
        crank = bare.crank + bare.crank_gain * motor.torque
        shell_by = bare.shell_by + bare.shell_gain[..., None] * motor.torque_by
        crank_by = bare.crank_by + bare.crank_gain[..., None] * motor.torque_by
        value, by = np.empty_like(state), np.zeros((*state.shape, self.states))
        value[..., 0], by[..., 0, :] = crank, crank_by
        if self.momentum is None:
            value[..., 1], by[..., 1, 2] = state[..., 2], 1.0
            value[..., 2], by[..., 2, :] = shell, shell_by
        if law.lag > 0.0:
            asked, asked_by = self._asked(speed, shell, shell_by)
            value[..., -1] = (asked - state[..., -1]) / law.lag
            by[..., -1, :] = asked_by / law.lag
            by[..., -1, -1] -= 1.0 / law.lag
        value /= speed[..., None]
        by /= speed[..., None, None]
        by[..., :, 0] -= value / speed[..., None]
        return value, by

    def _asked(
        self, speed: FloatArray, shell: FloatArray, shell_by: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """What the controller asks of the actuator, rad/s, and its slopes by the states."""
        law = self.law
        asked = law.gain * (
            law.reference - law.speed_feedback * speed - law.acceleration_feedback * shell
        )
        by = -law.gain * law.acceleration_feedback * shell_by
        by[..., 0] -= law.gain * law.speed_feedback
        return asked, by

    def _driven(self, bare: _Bare, state: FloatArray, piece: IntArray | None) -> Driven:
        law, scale = self.law, self.machine.motor_scale[..., None]
        speed = state[..., 0]
        if law.lag > 0.0:
            slip = state[..., -1] - speed
            found = slip_torque(self.drive.motor, slip, piece)
            by = np.zeros(state.shape)
            by[..., 0], by[..., -1] = -scale * found.slope, scale * found.slope
            return Driven(slip, scale * found.value, by)
        asked, by = self._asked(speed, bare.shell, bare.shell_by)
        back = law.gain * law.acceleration_feedback * bare.shell_gain * scale
        slip = self._implicit(asked - speed, back)
        found = slip_torque(self.drive.motor, slip, piece)
        by[..., 0] -= 1.0
        # a loop that answers itself more than once has no motion of its own
        firm = 1.0 + back * found.slope
        slope = np.where(firm > 0.0, scale * found.slope / firm, np.nan)
        return Driven(slip, scale * found.value, slope[..., None] * by)

    def _implicit(self, free: FloatArray, back: FloatArray) -> FloatArray:
        """The slip (...,) that solves slip + back torque(slip) = free."""
        motor = self.drive.motor
        if not len(motor.threshold):
            offset, gain = motor.coefficient[0, 0], motor.coefficient[0, 1]
            return np.asarray((free - back * offset) / (1.0 + back * gain))
        most = float(np.max(np.abs(slip_torque(motor, _samples(motor.threshold)).value)))
        reach = 1.5 * np.abs(back) * most
        low, high = free - reach, free + reach
        slip = free - back * slip_torque(motor, free).value
        for _ in range(_ROUNDS):
            slip = np.where((slip > low) & (slip < high), slip, 0.5 * (low + high))
            found = slip_torque(motor, slip)
            over = slip + back * found.value - free
            low, high = np.where(over < 0.0, slip, low), np.where(over > 0.0, slip, high)
            step = over / (1.0 + back * found.slope)
            if not np.any(np.abs(step) > 1e-15 * (1.0 + np.abs(slip))):
                break
            slip = slip - step
        return np.asarray(slip)

    def _bare(self, place: Place, state: FloatArray) -> _Bare:
        """Rotor, shell and load, all but the motor; the equations are those of `inertia.py`."""
        moved, speed = place.moved, state[..., 0]
        outer, outer_by = np.zeros_like(speed), np.zeros(state.shape)
        inner_by = np.zeros(state.shape)
        if self.momentum is not None:
            shell = shell_speed(place, self.momentum, speed)
        else:
            shell = state[..., 2]
            stiffness, damping = (
                field[..., None]
                for field in (self.machine.shell_stiffness, self.machine.shell_damping)
            )
            outer = -stiffness * state[..., 1] - damping * shell
            outer_by[..., 1], outer_by[..., 2] = -stiffness, -damping
        outer = outer - moved.shell_slope * speed * shell - moved.coupling_slope * speed**2
        inner = place.load - place.drag * speed
        inner = inner + 0.5 * (moved.shell_slope * shell**2 - moved.crank_slope * speed**2)
        outer_by[..., 0] -= moved.shell_slope * shell + 2.0 * moved.coupling_slope * speed
        inner_by[..., 0] = -place.drag - moved.crank_slope * speed
        # the speed of a free shell is no state: it follows the crank's
        free = self.momentum is not None
        row = 0 if free else 2
        rate = -moved.coupling / moved.shell if free else np.ones_like(speed)
        outer_by[..., row] -= moved.shell_slope * speed * rate
        inner_by[..., row] += moved.shell_slope * shell * rate
        j, n, q, over = moved.shell, moved.coupling, moved.crank, moved.determinant
        wide = [part[..., None] for part in np.broadcast_arrays(j, n, q, over)]
        return _Bare(
            (q * outer - n * inner) / over,
            (j * inner - n * outer) / over,
            (wide[2] * outer_by - wide[1] * inner_by) / wide[3],
            (wide[0] * inner_by - wide[1] * outer_by) / wide[3],
            np.asarray(-n / over),
            np.asarray(j / over),
        )


def _samples(threshold: FloatArray) -> FloatArray:
    """Slips that show how large a motor's torque gets, from its pieces."""
    return np.asarray(np.linspace(threshold[0], threshold[-1], 40 * len(threshold)))

"""A second way to the periodic state of a free roll machine: scipy, one smooth piece after another.

Without mounts the angular momentum H = J s + N w is constant, and the energy over the crank angle,
E = mu w^2 / 2 + H^2 / (2 J) with mu = Q - N^2 / J, obeys dE/db = torque between shell and crank.
This one equation is integrated over a turn by `solve_ivp` (DOP853 or Radau), stopped at each node
of a gas table and where the slip passes a node of the motor's; the start value comes from secants.
Inertias and accelerations are formulas of their own, one number at a time.
"""

from itertools import pairwise
from math import exp, inf, pi
from typing import NamedTuple

import numpy as np
from exact_roll_model import Model, Stall
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vibecalc.roll.mechanism import RollDrive, RollMachine
from vibecalc.roll.turn import Turn

TURN = 2.0 * pi
GAUSS = np.polynomial.legendre.leggauss(10)


class ExactTurn(NamedTuple):
    """One turn at quadrature points (k,); SI. `multiplier` is that of the energy at angle zero."""

    crank_angle: np.ndarray
    weight: np.ndarray
    time: np.ndarray
    crank_speed: np.ndarray
    shell_speed: np.ndarray
    crank_acceleration: np.ndarray
    shell_acceleration: np.ndarray
    motor_torque: np.ndarray
    gas_torque: np.ndarray
    period: float
    momentum: float
    start_speed: float
    multiplier: float


def one_turn(model, energy, momentum, method, rtol, longest):
    """Energy after a turn from crank angle zero, and the pieces (solution, gas, motor piece)."""
    thresholds, pieces = model.drive.motor.threshold.tolist(), []
    rest = model.masses(0.0)
    slip = model.synchronous - model.speed(0.0, energy, momentum)
    piece = int(np.searchsorted(thresholds, slip, side="right"))
    atol = 1e-15 * (abs(energy) + 0.5 * rest.crank * model.synchronous**2)
    for begin, end in pairwise(model.edges):
        gas, at, stayed = model.gas_pieces(0.5 * (begin + end)), begin, 0
        while at < end:
            # the numbers of the piece are bound here: the loop goes on before they are used again
            def rate(beta, state, piece=piece, gas=gas):
                now = model.masses(beta)
                w = model.speed(beta, state[0], momentum, now)
                torque = model.motor(w, piece) + model.gas_torque(beta, now.strokes, gas)
                return [torque - model.friction(w, now.strokes), 1.0 / w]

            def leaves(beta, state, piece=piece):
                slip = model.synchronous - model.speed(beta, state[0], momentum)
                low = thresholds[piece - 1] if piece else -inf
                high = thresholds[piece] if piece < len(thresholds) else inf
                return min(slip - low, high - slip)

            run = solve_ivp(
                rate,
                (at, end),
                [energy, 0.0],
                method=method,
                rtol=rtol,
                atol=[atol, 1e-16],
                max_step=longest,
                dense_output=True,
            )
            if not run.success:
                raise Stall(run.message)
            cut = first_exit(run, leaves)
            if cut is None:
                pieces.append((run.sol, np.asarray(run.t), gas, piece))
                at, energy = end, float(run.y[0, -1])
                continue
            stayed = stayed + 1 if cut == at else 0
            if stayed > 1:
                raise ArithmeticError("the motion grazes a node of the motor's table")
            if cut > at:
                pieces.append((run.sol, np.append(run.t[run.t < cut], cut), gas, piece))
            at, energy = cut, float(run.sol(cut)[0])
            slip = model.synchronous - model.speed(cut, energy, momentum)
            low = thresholds[piece - 1] if piece else -inf
            high = thresholds[piece] if piece < len(thresholds) else inf
            piece += 1 if abs(slip - high) < abs(slip - low) else -1
    return energy, pieces


def first_exit(run, leaves):
    """Where the motion first leaves its piece of the motor's curve, or None.

    Each step is examined in four places. It is the start where that lies on an edge and the
    motion goes out of the piece.
    """
    points = np.unique(np.concatenate([
        np.linspace(a, b, 5) for a, b in pairwise(run.t)
    ]))  # fmt: skip
    before = points[0]
    for point in points[1:]:
        if leaves(point, run.sol(point)) < 0.0:
            if leaves(before, run.sol(before)) <= 0.0:
                start, before = before, 0.5 * (before + point)
                if leaves(before, run.sol(before)) <= 0.0:
                    return start
            return brentq(lambda b: leaves(b, run.sol(b)), before, point, xtol=1e-15, rtol=1e-15)
        before = point
    return None


def periodic(model, momentum, speed, method, rtol, longest):
    """Energy at crank angle zero that comes back after a turn, and the pieces of that turn."""
    energy = model.energy(0.0, speed, momentum)
    for _ in range(3):
        energy, _ = one_turn(model, energy, momentum, "DOP853", 1e-6, 0.2)
    before = None
    for _ in range(60):
        after, pieces = one_turn(model, energy, momentum, method, rtol, longest)
        slope = 0.0
        if before is not None and before[0] != energy:
            slope = (after - before[1]) / (energy - before[0])
        step = (after - energy) / (1.0 - slope)
        if abs(step) <= max(1e-3 * rtol, 1e-14) * energy:
            return energy, pieces
        before = energy, after
        energy += step
    raise ArithmeticError("no periodic state within 60 secants")


def exact_turn(
    machine: RollMachine,
    drive: RollDrive,
    *,
    started_at: float | None = None,
    speed: float | None = None,
    method: str = "DOP853",
    rtol: float = 1e-13,
    longest: float = 0.06,
    place: tuple[int, ...] = (),
) -> ExactTurn:
    """The periodic state that a machine without mounts runs into from a high speed.

    The momentum is that of the crank at `started_at` (rad/s) at crank angle zero in a resting
    shell, or by default the one with which the shell does not turn on average. `speed` is where
    the search begins, by default the synchronous one. `place` picks one machine of many.
    """
    model = Model(machine, drive, place)
    assert not model.shell_stiffness and not model.shell_damping
    begin = model.synchronous if speed is None else speed
    rest = model.masses(0.0)
    momentum = rest.coupling * (begin if started_at is None else started_at)
    while True:
        energy, pieces = periodic(model, momentum, begin, method, rtol, longest)
        turn = read(model, pieces, momentum, energy)
        if started_at is not None:
            return turn
        now = [model.masses(b) for b in turn.crank_angle]
        shell, coupling = np.array([m.shell for m in now]), np.array([m.coupling for m in now])
        rate = turn.weight / turn.crank_speed
        better = np.sum(rate * coupling * turn.crank_speed / shell) / np.sum(rate / shell)
        if abs(better - momentum) <= 10.0 * rtol * abs(better):
            return turn
        momentum, begin = float(better), turn.start_speed


def read(model, pieces, momentum, energy) -> ExactTurn:
    """Values at Gauss points in every step that the integrator has taken."""
    rows, weights, elapsed, decay = [], [], 0.0, 0.0
    for solution, ends, gas, piece in pieces:
        for a, b in pairwise(ends):
            for x, weight in zip(*GAUSS, strict=True):
                beta = 0.5 * (a + b + (b - a) * x)
                state = solution(beta)
                now = model.masses(beta)
                w = model.speed(beta, state[0], momentum, now)
                s = (momentum - now.coupling * w) / now.shell
                motor = model.motor(w, piece)
                pressed = model.gas_torque(beta, now.strokes, gas)
                torque = motor + pressed - model.friction(w, now.strokes)
                share = now.coupling / now.shell
                effective = now.crank - now.coupling * share
                slope = (
                    now.crank_slope
                    - 2.0 * share * now.coupling_slope
                    + share * share * now.shell_slope
                )
                # energy's equation, differentiated by hand; then that of the momentum
                crank = torque - 0.5 * slope * w * w
                crank += 0.5 * (momentum / now.shell) ** 2 * now.shell_slope
                crank /= effective
                shell = -(
                    now.coupling_slope * w * w + now.coupling * crank + now.shell_slope * w * s
                )
                rows.append(
                    (beta, elapsed + state[1], w, s, crank, shell / now.shell, motor, pressed)
                )
                weights.append(0.5 * (b - a) * weight)
                grip = model.motor_slope(w, piece) + model.friction_damping
                decay += weights[-1] * grip / (effective * w)
        elapsed += float(solution(ends[-1])[1])
    beta, time, w, s, crank, shell, motor, pressed = np.array(rows).T
    return ExactTurn(
        beta,
        np.array(weights),
        time,
        w,
        s,
        crank,
        shell,
        motor,
        pressed,
        elapsed,
        momentum,
        model.speed(0.0, energy, momentum),
        exp(-decay),
    )


def exact_harmonics(turn: ExactTurn, values: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """A_n - i B_n of equations 95 and 96 of Herold (1977), time zero at crank angle zero."""
    phase = TURN / turn.period * turn.time
    share = values * turn.weight / turn.crank_speed * 2.0 / turn.period
    cosine = np.array([np.sum(share * np.cos(n * phase)) for n in orders])
    sine = np.array([np.sum(share * np.sin(n * phase)) for n in orders])
    return cosine - 1j * sine


def exact_levels(turn: ExactTurn, orders: np.ndarray) -> np.ndarray:
    """Levels of the shell's acceleration, dB against 1 rad/s^2, zero-to-peak."""
    return 20.0 * np.log10(np.abs(exact_harmonics(turn, turn.shell_acceleration, orders)))


def as_turn(turn: ExactTurn) -> Turn:
    """The same motion for vibecalc's readings; the angle of the shell counts for mounts only."""
    return Turn(
        turn.crank_angle,
        turn.weight,
        turn.time,
        turn.crank_speed,
        turn.shell_speed,
        np.zeros_like(turn.time),
        np.asarray(turn.period),
    )

"""Critical speeds of a shaft line: every order against every mode."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.line import stiffness_matrix
from vibecalc.response.torsion.line_modes import (
    NO_PEAK,
    mode_number,
    own_pole,
    vibrating_guesses,
)
from vibecalc.response.torsion.modes import natural_modes

#: secant steps to where a pole that follows the speed meets an order
_ROUNDS = 30


def emit_critical(scene: Scene, setup: Setup) -> None:
    """Speeds (mode, order) in rad/s; 0 for a mode that does not vibrate, infinite where none is."""
    path = f"{ROOT}/critical/speed"
    if not scene.wants(path):
        return
    speed, error = critical(setup)
    axes = {"mode": np.arange(1, len(speed) + 1), "half_order": setup.drive.order}
    scene.emit(path, speed, error, axes)


def critical(setup: Setup) -> tuple[FloatArray, FloatArray]:
    """Critical speeds (m, q) and their absolute errors, 0 for those without end.

    A mode that is damped so strongly that no response peaks near its frequency has none.
    """
    modes, order = setup.natural(), setup.drive.order
    speed = modes.frequency[:, None] / order
    error = modes.frequency_error[:, None] / order + EPSILON * speed
    if np.any(setup.model.speed_stiffness) and modes.damped:
        return _damped_met(setup)
    none = modes.silent & (modes.frequency > 0.0)
    speed[none], error[none] = np.inf, 0.0
    if not np.any(setup.model.speed_stiffness):
        return speed, error
    for place, one in enumerate(order.tolist()):
        speed[:, place], error[:, place] = _met(setup, one)
    return speed, error


def _met(setup: Setup, order: float) -> tuple[FloatArray, FloatArray]:
    """Speeds (m,) at which the modes, which rise with the speed, meet an order; or infinity.

    There K + w^2 S - q^2 w^2 J is singular. The frequency of a mode over the speed falls as the
    speed rises, so each mode is met once at most.
    """
    line, modes = setup.model.line, setup.modes
    grown = line._replace(stiffness=setup.model.speed_stiffness)
    added = stiffness_matrix(grown._replace(ground_stiffness=np.zeros_like(line.inertia)))
    inertia = order**2 * np.diag(line.inertia) - added
    stiffness = stiffness_matrix(line)
    square = np.linalg.eigvals(np.linalg.solve(inertia, stiffness))
    doubt = 64.0 * EPSILON * len(square) * float(np.max(np.abs(square)))
    real = np.abs(square.imag) <= 1e-6 * np.abs(square)
    kept = np.sort(square.real[real & (square.real > doubt)])
    speed = np.where(modes.frequency > 0.0, np.inf, 0.0)
    error = np.zeros(len(speed))
    for met in np.sqrt(kept).tolist():
        there = natural_modes(setup.model.at(met))
        mode = int(np.argmin(np.abs(there.frequency - order * met)))
        # one step of Newton's method on w(speed) - order speed; its slope is negative
        own, shape = there.frequency[mode], there.shape[mode]
        rise = met * float(shape @ added @ shape) / (there.modal_inertia[mode] * own)
        left = own - order * met
        speed[mode] = met + left / (order - rise)
        rounding = there.frequency_error[mode] + 4.0 * EPSILON * own
        # the step leaves the square of what it mends
        error[mode] = rounding / (order - rise) + left**2 / (own * (order - rise))
    return speed, error


def _damped_met(setup: Setup) -> tuple[FloatArray, FloatArray]:
    """The same of poles, |s| = q speed, where pendulums stiffen the line with the square of it.

    On s = i q speed they take S / q^2 off the inertia, which tells where to begin; secant steps
    follow with the line as it is at each speed.
    """
    model, natural, order = setup.model, setup.natural(), setup.drive.order
    none = np.where(natural.frequency > 0.0, np.inf, 0.0)
    speed = np.repeat(none[:, None], len(order), axis=1)
    error = np.zeros_like(speed)
    line = model.line
    field = line._replace(stiffness=model.speed_stiffness, ground_stiffness=0.0 * line.inertia)
    added = stiffness_matrix(field)
    for place, one in enumerate(order.tolist()):
        for guess in vibrating_guesses(line, added / one**2).tolist():
            met = _met_by_pole(setup, one, guess)
            if met is None:  # nothing peaks there, or no speed meets it
                continue
            at, off, pole = met
            mode = mode_number(model.at(at), pole, len(natural.frequency))
            speed[mode, place], error[mode, place] = at, off
    return speed, error


def _met_by_pole(setup: Setup, order: float, guess: complex) -> tuple[float, float, complex] | None:
    """Speed, its error and the pole there; None for a mode that has no peak or is not met."""
    # what the field of a pendulum turns unstable is no motion of the line
    if guess.imag < 0.5 * abs(guess) or guess.real > 0.1 * abs(guess):
        return None
    at, pole, last = abs(guess) / order, guess, None
    for _ in range(_ROUNDS):
        try:
            pole, _, doubt, _ = own_pole(setup.model.at(at), pole)
        except NumericalFailure:
            return None
        left = abs(pole) - order * at
        slope = -order if last is None or at == last[0] else (left - last[1]) / (at - last[0])
        doubt += 4.0 * EPSILON * abs(pole)
        if slope >= 0.0 or doubt > 1e-4 * abs(pole) or -pole.real >= NO_PEAK * abs(pole):
            return None
        if abs(left) <= 4.0 * doubt:
            return at, (doubt + abs(left)) / -slope, pole
        last, at = (at, left), at - left / slope
        if not 0.0 < at < 1e3 * abs(guess) / order:
            return None
    return None

"""Poles of a line with loss factors, each mode with dashpots that equal them at its frequency.

A loss factor has no free motion in time. A dashpot eta k / w takes the same heat from a vibration
at w; put in for every loss factor at the natural frequency w of one mode, it gives that mode a
pole. Every mode has its own set of dashpots: the poles are of different lines.
"""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import ComplexArray
from vibecalc.response.torsion.damped_modes import DampedModes, mended_pole
from vibecalc.response.torsion.damped_state import line_matrices
from vibecalc.response.torsion.line import Line, damping_matrix
from vibecalc.response.torsion.modes import Modes

#: in so many steps of the damping a pole is followed from the undamped frequency
_STEPS = (1, 12)
#: shapes of two steps that agree less belong to two modes
_ALIKE = 0.5


def equivalent_line(line: Line, frequency: float) -> Line:
    """The line with dashpots eta k / w in place of its loss factors; w in rad/s."""
    dashpot = line.damping + np.abs(line.loss_factor) * line.stiffness / frequency
    return line._replace(damping=dashpot, loss_factor=np.zeros_like(line.loss_factor))


def equivalent_modes(line: Line, modes: Modes) -> DampedModes:
    """One pole (m,) for each undamped mode of the line; a rigid one stays exactly 0.

    Raises `NumericalFailure` where a pole cannot be followed from its mode: damping so strong that
    a mode does not swing any more, or cannot be told from another one.
    """
    poles = np.zeros(len(modes.frequency), dtype=complex)
    errors = np.zeros(len(poles))
    shapes = np.asarray(modes.shape, dtype=complex).copy()
    for place, frequency in enumerate(modes.frequency.tolist()):
        if frequency == 0.0:
            continue
        dashed = equivalent_line(line, frequency)
        ways = (_followed(dashed, frequency, shapes[place], steps) for steps in _STEPS)
        found = next((one for one in ways if one is not None), None)
        if found is None:
            raise NumericalFailure(
                f"loss factors as dashpots at {frequency:.6g} rad/s: the mode there is damped so "
                "strongly that its pole cannot be followed"
            )
        poles[place], shapes[place], errors[place] = found
    size = np.abs(poles)
    ratio = np.divide(-poles.real, size, out=np.zeros_like(size), where=size > 0.0)
    return DampedModes(poles, size, ratio, shapes, errors)


def _followed(
    line: Line, frequency: float, shape: ComplexArray, steps: int
) -> tuple[complex, ComplexArray, float] | None:
    """The pole that grows out of a natural frequency as dashpots grow; None where it is lost."""
    work = np.real(shape @ damping_matrix(line) @ shape)
    pole, error = 1j * frequency, 0.0
    step = complex(-0.5 * work / (line.inertia @ np.real(shape) ** 2) / steps)
    for share in np.arange(1, steps + 1) / steps:
        partly = line._replace(
            damping=share * line.damping, absolute_damping=share * line.absolute_damping
        )
        matrices, _ = line_matrices(partly)
        found, kept, error = mended_pole(matrices, pole + step)
        turned = matrices.full @ kept
        lost = found.imag <= 0.0 or error > 1e-4 * abs(found)
        if lost or _alike(line, shape, turned) < _ALIKE:
            return None
        pole, step, shape = found, found - pole, turned
    return pole, shape / shape[np.argmax(np.abs(shape))], error


def _alike(line: Line, one: ComplexArray, other: ComplexArray) -> float:
    """1 for shapes that differ by a factor, 0 for shapes of two undamped modes."""
    joint = np.abs(np.vdot(one, line.inertia * other)) ** 2
    sizes = [float(np.vdot(v, line.inertia * v).real) for v in (one, other)]
    return float(joint / (sizes[0] * sizes[1]))

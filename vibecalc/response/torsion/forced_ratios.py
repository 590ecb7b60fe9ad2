"""Forced response as a sum over undamped modes that nothing couples, each with its own damping."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, SINGULAR
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.torsion.forced import Masked
from vibecalc.response.torsion.forced_modal import UNCOUPLED, modal_damping
from vibecalc.response.torsion.line import Line
from vibecalc.response.torsion.modes import Modes


class ModalLine(NamedTuple):
    """Modes with dashpot (m,) in N m s/rad and loss (m,) in N m/rad, of their modal inertia."""

    modes: Modes
    dashpot: FloatArray
    loss: FloatArray


def modal_line(
    modes: Modes, *, ratios: FloatArray | None = None, line: Line | None = None
) -> ModalLine:
    """From damping ratios (m,), 2 ratio modal inertia frequency, or from the damping of a line.

    Raises NumericalFailure for a line whose damping couples the modes.
    """
    if line is None:
        given = np.zeros(len(modes.frequency)) if ratios is None else ratios
        return ModalLine(modes, 2.0 * given * modes.modal_inertia * modes.frequency, 0.0 * given)
    found = modal_damping(line, modes.shape)
    if found.coupling > UNCOUPLED:
        raise NumericalFailure(
            f"modal response: damping couples the undamped modes (by {found.coupling:.2g} of "
            "their own damping), so that a sum over modes is not the response; use elimination"
        )
    return ModalLine(modes, found.dashpot, found.loss)


def ratio_response(
    modal: ModalLine, frequency: FloatArray, torque: ComplexArray, freedom: IntArray
) -> Masked:
    """Angles (..., n) for torques (..., k) on k freedoms at frequencies (...) in rad/s.

    A frequency on a mode that is driven and not damped, to within four digits, is masked. The
    error counts the rounding of the sum and the errors of frequencies and shapes.
    """
    modes, w = modal.modes, np.asarray(frequency)[..., None]
    natural, inertia = modes.frequency, modes.modal_inertia
    own = modes.shape[:, freedom]
    drive = torque @ own.T
    size = np.abs(torque).sum(axis=-1, keepdims=True)
    drive_doubt = size * (8.0 * EPSILON * np.max(np.abs(own), axis=1) + modes.shape_error)
    stiffness = inertia * (natural - w) * (natural + w) + 1j * (w * modal.dashpot + modal.loss)
    doubt = 8.0 * EPSILON * np.abs(stiffness)
    doubt = doubt + 2.0 * inertia * (natural * modes.frequency_error + EPSILON * w**2)
    weak = np.abs(stiffness) * SINGULAR <= doubt
    driven = np.abs(drive) > drive_doubt
    masked = np.any(weak & driven, axis=-1)
    stiffness = np.where(weak, 1.0, stiffness)
    part = np.where(weak, 0.0, drive / stiffness)
    angle = np.asarray(part @ modes.shape, dtype=np.complex128)
    slack = (drive_doubt + np.abs(part) * doubt) / np.abs(stiffness)
    slack = slack + np.abs(part) * (8.0 * EPSILON + modes.shape_error)
    error = np.sum(np.where(weak, 0.0, slack), axis=-1)
    angle[masked] = 0.0
    return Masked(angle, np.where(masked, np.inf, error), masked)

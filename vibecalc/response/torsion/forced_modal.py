"""Forced response by modes, for a line whose damping leaves the undamped modes uncoupled."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, SINGULAR
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.forced import Forced
from vibecalc.response.torsion.line import Line, damping_matrix, network_matrix

#: coupling between modes, as a share of their own damping, that still counts as round-off
UNCOUPLED = 1e-9


class ModalDamping(NamedTuple):
    """Dashpots (m,) in N m s/rad and loss (m,) in N m/rad of each mode, and their coupling.

    `coupling` is the largest share |d_rs| / sqrt(d_rr d_ss) of either kind that couples two modes;
    0 for proportional damping.
    """

    dashpot: FloatArray
    loss: FloatArray
    coupling: float


def modal_damping(line: Line, shape: ArrayLike) -> ModalDamping:
    """Damping of a line seen from modes of shape (m, n)."""
    modes = np.asarray(shape, dtype=float)
    loss = network_matrix(line, line.stiffness * line.loss_factor, np.zeros_like(line.inertia))
    found, coupling = [], 0.0
    for matrix in (damping_matrix(line), loss):
        between = modes @ matrix @ modes.T
        own = np.diagonal(between).copy()
        rest = np.abs(between - np.diag(own))
        # round-off of the triple product, in what is added up
        rest -= 8.0 * EPSILON * (np.abs(modes) @ np.abs(matrix) @ np.abs(modes).T)
        scale = np.sqrt(np.outer(np.abs(own), np.abs(own)))
        share = np.where(scale > 0.0, rest / np.where(scale > 0.0, scale, 1.0), 0.0)
        coupling = max(coupling, float(np.max(share, initial=0.0)))
        found.append(own)
    return ModalDamping(found[0], found[1], coupling)


def forced_modal(
    line: Line,
    natural_frequency: ArrayLike,
    shape: ArrayLike,
    modal_inertia: ArrayLike,
    frequency: ArrayLike,
    torque: ArrayLike,
    frequency_error: ArrayLike = 0.0,
) -> Forced:
    """As `forced`, as a sum over all undamped modes (m,), shapes (m, n), of one line.

    The error counts the round-off of the sum and `frequency_error` (m,) of the modes, not errors
    of their shapes. Modes left out are an error of the model that it does not count either.

    Raises
    ------
    NumericalFailure
        Damping couples the modes, or a frequency is at an undamped natural frequency that the
        torques drive (at zero: torques on a free line that do not balance).
    """
    modes, w = np.asarray(shape, dtype=float), np.asarray(frequency, dtype=float)
    inertia, natural = np.asarray(modal_inertia), np.asarray(natural_frequency)
    damping = modal_damping(line, modes)
    if damping.coupling > UNCOUPLED:
        raise NumericalFailure(
            f"modal response: damping couples the undamped modes (by {damping.coupling:.2g} of "
            "their own damping), so that a sum over modes is not the response; use elimination"
        )
    load = np.asarray(torque, dtype=np.complex128)
    drive = load @ modes.T
    drive_doubt = 4.0 * EPSILON * (np.abs(load) @ np.abs(modes).T)
    at = w[..., None]
    # (natural - w)(natural + w) keeps the digits next to a resonance
    stiffness = inertia * (natural - at) * (natural + at) + 1j * (
        at * damping.dashpot + damping.loss
    )
    doubt = 4.0 * EPSILON * np.abs(stiffness)
    doubt = doubt + 2.0 * inertia * (natural * np.asarray(frequency_error) + EPSILON * at**2)
    idle = np.abs(drive) <= drive_doubt
    weak = np.abs(stiffness) * SINGULAR <= doubt
    if np.any(weak & ~idle):
        where = np.argwhere(weak & ~idle)[0]
        met = float(np.broadcast_to(at, weak.shape)[tuple(where)])
        raise NumericalFailure(
            f"modal response: {met:.12g} rad/s is natural frequency {int(where[-1])} of the line, "
            "which the torques drive and nothing damps"
        )
    stiffness = np.where(weak, 1.0, stiffness)
    part = np.where(weak, 0.0, drive / stiffness)
    angle = part @ modes
    slack = (drive_doubt + np.abs(part) * doubt) / np.abs(stiffness) + 8.0 * EPSILON * np.abs(part)
    error = np.max(np.where(weak, 0.0, slack) @ np.abs(modes), axis=-1)
    return Forced(angle, error)

"""Root locus: how the poles move as the controller's gain grows."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.response.roll_control.evaluate import Load
from vibecalc.response.roll_control.model import Controller, ReducedModel, loop_of
from vibecalc.response.roll_control.poles import poles
from vibecalc.response.roll_control.steady import speed_feedback_for


class Locus(NamedTuple):
    """`gain` (g,) ascending as given; `pole` (g, branches) complex in 1/s with absolute errors.

    A column follows one pole from gain to gain as far as the steps allow; a picture may draw it
    as a line.
    """

    gain: np.ndarray
    pole: np.ndarray
    pole_error: np.ndarray


def root_locus(
    model: ReducedModel, controller: Controller, gains: ArrayLike, load: Load | None = None,
    target: float = 0.0, count: int = 6,
) -> Locus:  # fmt: skip
    """Poles for each of `gains` (g,); with a `load` the speed feedback keeps `target` (rad/s).

    `controller` gives the feedbacks, lag and delay (scalars); its gain is ignored. Each row holds
    two poles (one without lag), or `count` of the rightmost with a delay.
    """
    from scipy.optimize import linear_sum_assignment

    gain = np.asarray(gains, dtype=float)
    moved = controller._replace(gain=gain)
    if load is not None:
        kept = speed_feedback_for(model, gain, load.reference, load.mean, target)
        moved = moved._replace(speed_feedback=kept.value)
    found = poles(loop_of(model, moved), count)
    pole, error = found.value.copy(), found.error.copy()
    for row in range(1, len(gain)):
        away = np.abs(pole[row - 1][:, None] - pole[row][None, :])
        away = np.where(np.isfinite(away), away, 1e300)
        _, order = linear_sum_assignment(away)
        pole[row], error[row] = pole[row][order], error[row][order]
    return Locus(gain, pole, error)

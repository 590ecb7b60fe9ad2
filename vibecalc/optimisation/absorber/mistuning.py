"""What a mistuned absorber loses: the largest response with k and z2 off by a few per cent."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import WithError
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks

#: relative errors looked at unless others are given
SHARES = (0.01, 0.05, 0.10)


class Mistuning(NamedTuple):
    """Relative increase of the largest |H|, peak / peak of the tuned absorber - 1.

    `stiffness` and `damping` (..., share, 2): one ratio off, too small and too large; `corner`
    (..., share): the worst of the four with both off. Each with its absolute error. Negative where
    the absorber was not at its optimum.
    """

    share: np.ndarray
    stiffness: WithError
    damping: WithError
    corner: WithError


def mistuning(
    absorber: Absorber, excitation: str = "force", response: str = "displacement",
    shares: tuple[float, ...] = SHARES,
) -> Mistuning:  # fmt: skip
    """Loss of tuned absorbers (...) from relative errors `shares` of k and z2, of both signs.

    Raises NumericalFailure where the tuned peak is infinite or zero.
    """
    z1, m, k, z = (
        np.asarray(a)[..., None, None] for a in np.broadcast_arrays(
            *(np.asarray(part, dtype=float) for part in absorber)
        )
    )  # fmt: skip
    share = np.asarray(shares, dtype=float)
    # columns: tuned, k - +, z - +, both -- -+ +- ++
    signs_k = np.array([0, -1, 1, 0, 0, -1, -1, 1, 1])
    signs_z = np.array([0, 0, 0, -1, 1, -1, 1, -1, 1])
    off = share[:, None]
    moved = Absorber(z1, m, k * (1.0 + off * signs_k), z * (1.0 + off * signs_z))
    found = peaks(moved, excitation, response)
    tuned = found.largest[..., :1]
    if not np.all(np.isfinite(tuned) & (tuned > 0.0)):
        raise NumericalFailure(
            f"the largest {response} under {excitation!r} of the tuned absorber is not finite: no "
            "loss can be told"
        )
    with np.errstate(invalid="ignore"):
        ratio = found.largest / tuned
        doubt = found.largest_error / tuned + ratio * found.largest_error[..., :1] / tuned
    loss = ratio - 1.0
    error = np.where(np.isfinite(ratio), doubt + 4e-16, np.inf)
    worst = np.argmax(loss[..., 5:], axis=-1)[..., None]
    corner = [np.take_along_axis(a[..., 5:], worst, axis=-1)[..., 0] for a in (loss, error)]
    return Mistuning(
        share, WithError(loss[..., 1:3], error[..., 1:3]),
        WithError(loss[..., 3:5], error[..., 3:5]), WithError(*corner),
    )  # fmt: skip

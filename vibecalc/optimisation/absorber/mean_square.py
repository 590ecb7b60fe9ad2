"""Mean-square (H2) tuning: stiffness and damping that make a mean square least, batched."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.absorber.mean_square_newton import (
    Problem,
    descend,
    logarithm,
    problem,
    stiff_starts,
    undamped_optimum,
)
from vibecalc.response.absorber.mean_square import weights

#: a lower mean square than without an absorber, by at least this share, counts as one
_HELPS = 64.0 * EPSILON


class MeanSquareTuning(NamedTuple):
    """Least mean square over k >= 0 and z2 >= 0, with what it is worth; all arrays (...).

    `value` is the integral of |H|^2 over all x, as `mean_square` gives it, `alone` the same without
    an absorber (infinite without damping). `no_help`: no absorber of this mass lowers it; then k
    and z2 are zero. `locked`: the mass fastened rigidly to the primary system is better than any
    absorber; then they are infinite. `without_spring`: the optimum is on the boundary k = 0.
    `steps`: Newton steps of the whole batch. Errors are absolute.
    """

    stiffness_ratio: np.ndarray
    secondary_damping: np.ndarray
    value: np.ndarray
    alone: np.ndarray
    no_help: np.ndarray
    locked: np.ndarray
    without_spring: np.ndarray
    stiffness_error: np.ndarray
    damping_error: np.ndarray
    value_error: np.ndarray
    steps: int


def mean_square_tuning(
    primary_damping: ArrayLike,
    mass_ratio: ArrayLike,
    excitation: str = "force",
    response: str = "displacement",
    white: str = "",
) -> MeanSquareTuning:
    """H2 optimum for any primary damping and mass ratio; `white` as in `mean_square`.

    Newton's method in k / m and log z2 on the logarithm of the closed form, from the optimum of
    the undamped primary system and, on the boundary k = 0, from small and large damping; the
    lowest end is taken. Raises NumericalFailure where the response has no mean square, where no
    optimum is approached by a connected secondary, and if Newton does not converge.
    Source: S. H. Crandall and W. D. Mark (1963); G. B. Warburton (1982); T. Asami, O. Nishihara and
    A. M. Baz (2002), sec. 4.
    """
    z1, m = (
        np.array(a) for a in np.broadcast_arrays(
            np.asarray(primary_damping, dtype=float), np.asarray(mass_ratio, dtype=float)
        )
    )  # fmt: skip
    given = _problem(z1.ravel(), m.ravel(), excitation, response, white)
    parts = weights(excitation, response, white).parts
    kappa, zeta = undamped_optimum(given, on_boundary=False)
    ends = [descend(given, kappa, np.log(zeta), on_boundary=False)]
    _, thin = undamped_optimum(given, on_boundary=True)
    for factor in (1.0, 1e-3):
        zero = np.zeros_like(kappa)
        ends.append(descend(given, zero, np.log(factor * thin), on_boundary=True))
    if parts[0].startswith("motion") and parts != ("motion", ""):
        ends += [descend(given, *start, on_boundary=False) for start in stiff_starts(given)]
    levels = np.stack([np.where(end.good, end.level, np.inf) for end in ends])
    choice = np.argmin(levels, axis=0)

    def chosen(name: str) -> np.ndarray:
        every = np.stack([getattr(end, name) for end in ends])
        picked: np.ndarray = np.take_along_axis(every, choice[None], axis=0)[0]
        return picked

    best = np.min(levels, axis=0)
    alone = given.alone
    with np.errstate(divide="ignore"):
        idle = ~(best < np.log(alone) - _HELPS) & (alone <= given.locked)
        locked = ~(best < np.log(given.locked) - _HELPS) & ~idle
    scaled, depth, doubt = chosen("kappa"), chosen("depth"), chosen("doubt")
    lost = ~np.isfinite(best) & ~idle & ~locked
    if np.any(lost):
        row = int(np.flatnonzero(lost)[0])
        raise NumericalFailure(
            f"mean-square tuning of {response} under {excitation!r}: Newton's method found no "
            f"optimum for primary damping {given.z1[row]:.6g} and mass ratio {given.m[row]:.6g}"
        )
    value = np.where(idle, alone, np.where(locked, given.locked, np.exp(best)))
    still = idle | locked
    end = np.where(locked, np.inf, 0.0)

    def shaped(array: np.ndarray, at_rest: np.ndarray) -> np.ndarray:
        return np.where(still, at_rest, array).reshape(z1.shape)

    zero, spread = np.zeros_like(end), np.where(scaled == 0.0, 0.0, doubt)
    stretch = given.m * spread * np.maximum(scaled, 1.0)
    return MeanSquareTuning(
        shaped(given.m * scaled, end), shaped(np.exp(depth), end), value.reshape(z1.shape),
        alone.reshape(z1.shape), idle.reshape(z1.shape), locked.reshape(z1.shape),
        (~still & (scaled == 0.0)).reshape(z1.shape), shaped(stretch, zero),
        shaped(np.exp(depth) * doubt, zero), 80.0 * EPSILON * value.reshape(z1.shape),
        max(end.steps for end in ends),
    )  # fmt: skip


def closed_form(
    mass_ratio: ArrayLike,
    excitation: str = "force",
    response: str = "displacement",
    white: str = "",
) -> MeanSquareTuning:
    """The optimum for an undamped primary system, in closed form.

    For force and displacement k = m (2 + m) / (2 (1 + m)^2) and z2^2 = m^3 (4 + 3 m) /
    (16 (1 + m)^3), Crandall and Mark's; for the ground's acceleration and transmitted force (the
    relative displacement) k = m (2 - m) / (2 (1 + m)^2) as long as m < 2, and k = 0 beyond.
    """
    m = np.array(mass_ratio, dtype=float)
    zero = np.zeros_like(m)
    given = _problem(zero.ravel(), m.ravel(), excitation, response, white)
    kappa, z = (a.reshape(m.shape) for a in undamped_optimum(given, on_boundary=False))
    level = logarithm(given, kappa.ravel(), np.log(z.ravel())).reshape(m.shape)
    value, no = np.exp(level), np.zeros(m.shape, dtype=bool)
    return MeanSquareTuning(
        m * kappa, z, value, np.full(m.shape, np.inf), no, no, kappa == 0.0,
        8 * EPSILON * m * kappa, 8 * EPSILON * z, 80 * EPSILON * value, 0,
    )  # fmt: skip


def _problem(z1: np.ndarray, m: np.ndarray, excitation: str, response: str, white: str) -> Problem:
    chosen = weights(excitation, response, white)
    if chosen.reason and (not chosen.undamped_only or np.any(z1 > 0.0)):
        raise NumericalFailure(
            f"{response} under white noise of {excitation!r} has no mean square: {chosen.reason}"
        )
    if chosen.travel >= 0:
        raise NumericalFailure(
            "the relative motion of the secondary is least where it is locked: there is nothing to "
            "tune"
        )
    return problem(z1, m, chosen.parts)

"""Mean-square (H2) tuning: stiffness and damping that minimise a mean square, if any do."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.mean_square import (
    Form,
    Terms,
    evaluate,
    evaluate_denominator,
    numerator_form,
    weights,
)
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Damped Newton on the logarithm of a mean square, in k / m and log z2, many systems at once.
# ----------------------------------------------------------------------------

_STEPS = 80
_CLOSE = 1e-9
#: logarithm of k / m or z2 beyond which the secondary counts as free or locked
_FAR = 25.0


class MeanSquare(NamedTuple):
    """Systems (r,), their forms with weights, and what they have alone and with the mass locked."""

    z1: np.ndarray
    m: np.ndarray
    forms: tuple[Form, ...]
    factors: tuple[np.ndarray, ...]
    alone: np.ndarray
    locked: np.ndarray


class MeanSquareEnd(NamedTuple):
    """Where a descent ended: k / m, log z2, log of the mean square, error of both, convergence."""

    kappa: np.ndarray
    depth: np.ndarray
    level: np.ndarray
    uncertainty: np.ndarray
    good: np.ndarray
    steps: int


def problem(z1: np.ndarray, m: np.ndarray, parts: tuple[str, str]) -> MeanSquare:
    """Systems with the forms named by `parts` (see `weights`)."""
    names = [name for name in parts if name]
    factors = (np.ones_like(z1), 4.0 * z1 * z1)[: len(names)]
    with np.errstate(divide="ignore"):
        alone = 0.5 * np.pi / z1 * sum(factors)
        powers = [2.0 * name.startswith("ground") - 1.0 * name.endswith("rate") for name in names]
        held = (f * (1.0 + m) ** p for f, p in zip(factors, powers, strict=True))
        locked = 0.5 * np.pi / z1 * sum(held)
    forms = tuple(numerator_form(name, z1, m) for name in names)
    return MeanSquare(z1, m, forms, factors, alone, locked)


def undamped_optimum(given: MeanSquare, on_boundary: bool) -> tuple[np.ndarray, np.ndarray]:
    """k / m and z2 for z1 = 0, from the first form: z q + 4 g z^3 over m^2 z^2."""
    form = given.forms[0]
    fall = 1.0 + form.b
    k = 0.5 * (2.0 * form.a * fall - form.c) / (fall**2 + form.d)
    k = np.zeros_like(k) if on_boundary else np.maximum(k, 0.0)
    bend = ((form.a - k) - form.b * k) ** 2 + form.c * k + form.d * k * k
    return k / given.m, np.sqrt(0.25 * bend / form.g)


def logarithm(given: MeanSquare, kappa: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Logarithm of the mean square."""
    k, z = given.m * kappa, np.exp(depth)
    top = sum(
        factor * evaluate(form, k, z).value
        for form, factor in zip(given.forms, given.factors, strict=True)
    )
    value = top / evaluate_denominator(given.z1, given.m, k, z).value
    logged: np.ndarray = np.log(0.5 * np.pi * value)
    return logged


def stiff_starts(given: MeanSquare) -> list[tuple[np.ndarray, np.ndarray]]:
    """k / m and log z2 of nearly locked secondaries, along the best ratio k / z2 there, if any.

    The quadratic in that ratio is (H3) of docs/theory_absorber.md.
    """
    z1, m = given.z1, given.m
    c = z1 * z1
    with np.errstate(divide="ignore", invalid="ignore"):
        if len(given.forms) == 1:
            ratio = (1.0 - 2.0 * c) / (m * z1)
        else:
            ratio = z1 * (1.0 + m + 8.0 * c - 16.0 * c * c) / (8.0 * c * c * m)
    ratio = np.where(np.isfinite(ratio), np.clip(ratio, 0.0, 1e6), 1.0)
    return [(ratio * z, np.log(m * z)) for z in (2.0, 20.0, 200.0)]


def descend(
    given: MeanSquare, kappa: np.ndarray, depth: np.ndarray, on_boundary: bool
) -> MeanSquareEnd:
    """Newton with backtracking until every system rests, or leaves for the free or locked state."""
    kappa, depth = kappa.copy(), depth.copy()
    level = logarithm(given, kappa, depth)
    size, good = np.full(kappa.shape, np.inf), np.zeros(kappa.shape, dtype=bool)
    still = np.zeros(kappa.shape, dtype=int)
    live = np.arange(kappa.size)
    steps = 0
    while live.size and steps < _STEPS:
        steps += 1
        moved = _step(_rows(given, live), kappa[live], depth[live], level[live], on_boundary)
        before = level[live]
        kappa[live], depth[live], level[live], size[live], accepted = moved
        level_rests = np.abs(before - level[live]) <= 8.0 * EPSILON * (1.0 + np.abs(before))
        rests = (size[live] < _CLOSE) | ~accepted | (level_rests & (size[live] < 1e-5))
        still[live] = np.where(rests, still[live] + 1, 0)
        away = (np.abs(depth - np.log(given.m)) > _FAR) | (kappa > np.exp(_FAR))
        live = live[((still < 2) & ~away)[live]]
    _, bend, held, _ = _local(given, kappa, depth, on_boundary)
    least = _least_curvature(bend, held)
    with np.errstate(divide="ignore", over="ignore"):
        uncertainty = size + 40.0 * EPSILON / np.maximum(least, 1e-300)
    good = (size < 1e-5) & (least > 0.0)
    return MeanSquareEnd(kappa, depth, level, uncertainty, good, steps)


def _rows(given: MeanSquare, live: np.ndarray) -> MeanSquare:
    return MeanSquare(
        given.z1[live], given.m[live], tuple(Form(*(a[live] for a in f)) for f in given.forms),
        tuple(f[live] for f in given.factors), given.alone[live], given.locked[live],
    )  # fmt: skip


def _step(
    given: MeanSquare, kappa: np.ndarray, depth: np.ndarray, level: np.ndarray, on_boundary: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """One step of every system: the new k / m, log z2 and level, its size, and who could move."""
    slope, bend, held, wide = _local(given, kappa, depth, on_boundary)
    move = _newton(slope, bend, held)
    outwards = (kappa == 0.0) & (move[0] < 0.0) & ~held
    if np.any(outwards):
        move = _newton(slope, bend, held | outwards)
    allowed = np.where(wide, 1.0, np.maximum(0.5 * kappa, 0.05))
    with np.errstate(divide="ignore"):
        step = np.minimum(np.minimum(1.0, 2.0 / np.abs(move[1])), allowed / np.abs(move[0]))
    accepted = np.zeros(kappa.shape, dtype=bool)
    for _ in range(30):
        trial = np.where(
            wide, kappa * np.exp(step * move[0]), np.maximum(kappa + step * move[0], 0.0)
        )
        tried = depth + step * move[1]
        there = logarithm(given, trial, tried)
        fine = there <= level + 4.0 * EPSILON * (1.0 + np.abs(level))
        take = fine & ~accepted
        kappa, depth = np.where(take, trial, kappa), np.where(take, tried, depth)
        level = np.where(take, there, level)
        accepted |= fine
        if np.all(accepted):
            break
        step = np.where(accepted, step, 0.25 * step)
    size = np.maximum(np.abs(move[0]) / np.where(wide, 1.0, kappa + 1e-3), np.abs(move[1]))
    return kappa, depth, level, size, accepted


def _local(
    given: MeanSquare, kappa: np.ndarray, depth: np.ndarray, on_boundary: bool
) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...], np.ndarray, np.ndarray]:
    """Slope and curvature, where k is held at zero, and where log k is the coordinate."""
    slope, bend = _derivatives(given, kappa, depth)
    held = np.full(kappa.shape, on_boundary) | ((kappa == 0.0) & (slope[0] >= 0.0))
    wide = kappa > 1.0
    first = np.where(wide, kappa * slope[0], slope[0])
    kk = np.where(wide, kappa * kappa * bend[0] + kappa * slope[0], bend[0])
    kz = np.where(wide, kappa * bend[1], bend[1])
    return (first, slope[1]), (kk, kz, bend[2]), held, wide


def _derivatives(
    given: MeanSquare, kappa: np.ndarray, depth: np.ndarray
) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """Slope (2) and second derivatives (kk, kz, zz) of the logarithm by k / m and log z2."""
    k, z, m = given.m * kappa, np.exp(depth), given.m
    every = [evaluate(form, k, z) for form in given.forms]
    top = Terms(*(
        sum(f * part for f, part in zip(given.factors, column, strict=True))
        for column in zip(*every, strict=True)
    ))  # fmt: skip
    bottom = evaluate_denominator(given.z1, given.m, k, z)

    def logged(terms: Terms) -> tuple[np.ndarray, ...]:
        value = terms.value
        first_k, first_z = m * terms.by_k / value, z * terms.by_z / value
        return (
            first_k, first_z, m * m * terms.by_kk / value - first_k**2,
            m * z * terms.by_kz / value - first_k * first_z,
            z * z * terms.by_zz / value + first_z - first_z**2,
        )  # fmt: skip

    total = [a - b for a, b in zip(logged(top), logged(bottom), strict=True)]
    return (total[0], total[1]), (total[2], total[3], total[4])


def _newton(
    slope: tuple[np.ndarray, ...], bend: tuple[np.ndarray, ...], held: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Newton's step where the curvature is positive, with a shift elsewhere."""
    kk, zz = np.where(held, 1.0, bend[0]), bend[2]
    kz = np.where(held, 0.0, bend[1])
    first = np.where(held, 0.0, slope[0])
    least = 0.5 * (kk + zz) - np.hypot(0.5 * (kk - zz), kz)
    most = 0.5 * (kk + zz) + np.hypot(0.5 * (kk - zz), kz)
    floor = 1e-3 * np.abs(most) + 1e-14
    shift = np.where(least < floor, floor - least, 0.0)
    # a small but positive curvature is the optimum's own: Newton must see it unshifted
    shift = np.where((least > 1e-9 * np.abs(most)) & (least > 0.0), 0.0, shift)
    kk, zz = kk + shift, zz + shift
    determinant = kk * zz - kz * kz
    return (
        (-zz * first + kz * slope[1]) / determinant,
        (-kk * slope[1] + kz * first) / determinant,
    )


def _least_curvature(bend: tuple[np.ndarray, ...], held: np.ndarray) -> np.ndarray:
    kk, zz = np.where(held, np.abs(bend[2]), bend[0]), bend[2]
    kz = np.where(held, 0.0, bend[1])
    least: np.ndarray = 0.5 * (kk + zz) - np.hypot(0.5 * (kk - zz), kz)
    return least


# ----------------------------------------------------------------------------
# Mean-square (H2) tuning: stiffness and damping that make a mean square least, batched.
# ----------------------------------------------------------------------------

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
    scaled, depth, uncertainty = chosen("kappa"), chosen("depth"), chosen("uncertainty")
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

    zero, spread = np.zeros_like(end), np.where(scaled == 0.0, 0.0, uncertainty)
    stretch = given.m * spread * np.maximum(scaled, 1.0)
    return MeanSquareTuning(
        shaped(given.m * scaled, end), shaped(np.exp(depth), end), value.reshape(z1.shape),
        alone.reshape(z1.shape), idle.reshape(z1.shape), locked.reshape(z1.shape),
        (~still & (scaled == 0.0)).reshape(z1.shape), shaped(stretch, zero),
        shaped(np.exp(depth) * uncertainty, zero), 80.0 * EPSILON * value.reshape(z1.shape),
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


def _problem(
    z1: np.ndarray, m: np.ndarray, excitation: str, response: str, white: str
) -> MeanSquare:
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

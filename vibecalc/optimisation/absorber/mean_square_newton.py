"""Damped Newton on the logarithm of a mean square, in k / m and log z2, many systems at once."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.absorber.mean_square_forms import (
    Form,
    Terms,
    evaluate,
    evaluate_denominator,
    numerator_form,
)

_STEPS = 80
_CLOSE = 1e-9
#: logarithm of k / m or z2 beyond which the secondary counts as free or locked
_FAR = 25.0


class Problem(NamedTuple):
    """Systems (r,), their forms with weights, and what they have alone and with the mass locked."""

    z1: np.ndarray
    m: np.ndarray
    forms: tuple[Form, ...]
    factors: tuple[np.ndarray, ...]
    alone: np.ndarray
    locked: np.ndarray


class End(NamedTuple):
    """Where a descent ended: k / m, log z2, log of the mean square, error of both, convergence."""

    kappa: np.ndarray
    depth: np.ndarray
    level: np.ndarray
    doubt: np.ndarray
    good: np.ndarray
    steps: int


def problem(z1: np.ndarray, m: np.ndarray, parts: tuple[str, str]) -> Problem:
    """Systems with the forms named by `parts` (see `weights`)."""
    names = [name for name in parts if name]
    factors = (np.ones_like(z1), 4.0 * z1 * z1)[: len(names)]
    with np.errstate(divide="ignore"):
        alone = 0.5 * np.pi / z1 * sum(factors)
        powers = [2.0 * name.startswith("ground") - 1.0 * name.endswith("rate") for name in names]
        held = (f * (1.0 + m) ** p for f, p in zip(factors, powers, strict=True))
        locked = 0.5 * np.pi / z1 * sum(held)
    forms = tuple(numerator_form(name, z1, m) for name in names)
    return Problem(z1, m, forms, factors, alone, locked)


def undamped_optimum(given: Problem, on_boundary: bool) -> tuple[np.ndarray, np.ndarray]:
    """k / m and z2 for z1 = 0, from the first form: z q + 4 g z^3 over m^2 z^2."""
    form = given.forms[0]
    fall = 1.0 + form.b
    k = 0.5 * (2.0 * form.a * fall - form.c) / (fall**2 + form.d)
    k = np.zeros_like(k) if on_boundary else np.maximum(k, 0.0)
    bend = ((form.a - k) - form.b * k) ** 2 + form.c * k + form.d * k * k
    return k / given.m, np.sqrt(0.25 * bend / form.g)


def logarithm(given: Problem, kappa: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Logarithm of the mean square."""
    k, z = given.m * kappa, np.exp(depth)
    top = sum(
        factor * evaluate(form, k, z).value
        for form, factor in zip(given.forms, given.factors, strict=True)
    )
    value = top / evaluate_denominator(given.z1, given.m, k, z).value
    logged: np.ndarray = np.log(0.5 * np.pi * value)
    return logged


def stiff_starts(given: Problem) -> list[tuple[np.ndarray, np.ndarray]]:
    """k / m and log z2 of nearly locked secondaries, along the best ratio k / z2 there, if any.

    See `mean_square_threshold` for the quadratic in that ratio.
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


def descend(given: Problem, kappa: np.ndarray, depth: np.ndarray, on_boundary: bool) -> End:
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
        doubt = size + 40.0 * EPSILON / np.maximum(least, 1e-300)
    good = (size < 1e-5) & (least > 0.0)
    return End(kappa, depth, level, doubt, good, steps)


def _rows(given: Problem, live: np.ndarray) -> Problem:
    return Problem(
        given.z1[live], given.m[live], tuple(Form(*(a[live] for a in f)) for f in given.forms),
        tuple(f[live] for f in given.factors), given.alone[live], given.locked[live],
    )  # fmt: skip


def _step(
    given: Problem, kappa: np.ndarray, depth: np.ndarray, level: np.ndarray, on_boundary: bool
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
    given: Problem, kappa: np.ndarray, depth: np.ndarray, on_boundary: bool
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
    given: Problem, kappa: np.ndarray, depth: np.ndarray
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

"""Mean square of a response to white noise, in closed form."""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.transfer import Absorber, transfer_of
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# The mean squares of a two-mass system as quotients of sums of positive terms.
#
# Every integral of |B(ix) / D(ix)|^2 over all x (I_4 of D. E. Newland, An Introduction to Random
# Vibrations and Spectral Analysis, 2nd ed. 1984, sec. 7.5 and appendix 1, after James, Nichols and
# Phillips, 1947) was multiplied out by hand; what is subtracted there is gone. One difference is
# left, that of a tuned secondary, and it is kept so that it costs a few roundings of the whole.
# ----------------------------------------------------------------------------


class Form(NamedTuple):
    """z [(a - k - b k)^2 + c k + d k^2] + e k + f k^2 + 4 z (z + z1 k)(g z + h), k, z = z2 unknown.

    All coefficients are zero or positive. `z1` is the primary damping. Of a light secondary b is
    small: a - k is then exact near k = a, and next to it c k and d k^2 are small too.
    """

    z1: np.ndarray
    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    d: np.ndarray
    e: np.ndarray
    f: np.ndarray
    g: np.ndarray
    h: np.ndarray


class Terms(NamedTuple):
    """A form with its derivatives by k and z."""

    value: np.ndarray
    by_k: np.ndarray
    by_z: np.ndarray
    by_kk: np.ndarray
    by_kz: np.ndarray
    by_zz: np.ndarray


def numerator_form(name: str, primary_damping: np.ndarray, mass_ratio: np.ndarray) -> Form:
    """Form over N1 ("motion"), s N1, N1 + m g ("ground", all inertia forces) and s (N1 + m g)."""
    z1, m = primary_damping, mass_ratio
    whole, zero, one = 1.0 + m, np.zeros_like(m), np.ones_like(m)
    if name == "motion":
        return Form(z1, m, m, m * m, zero, zero, m * m * z1, whole, z1 * m)
    if name == "motion_rate":
        return Form(z1, m, zero, zero, m, zero, m * m * z1, one, z1 * m)
    square = whole * whole
    if name == "ground":
        return Form(
            z1, m, m * (2.0 + m), (m * whole) ** 2, zero, z1 * m**4, z1 * (m * whole) ** 2,
            whole * square, square * z1 * m,
        )  # fmt: skip
    return Form(z1, m, m, zero, square * m, zero, z1 * m * m * whole, square, z1 * m)


def evaluate(form: Form, k: np.ndarray, z: np.ndarray) -> Terms:
    """Value and derivatives up to the second."""
    z1, a, b, c, d, e, f, g, h = form
    away, fall = (a - k) - b * k, 1.0 + b
    bend = away * away + c * k + d * k * k
    bend_k = -2.0 * fall * away + c + 2.0 * d * k
    drag, side = g * z + h, z + z1 * k
    return Terms(
        z * bend + e * k + f * k * k + 4.0 * z * side * drag,
        z * bend_k + e + 2.0 * f * k + 4.0 * z * z1 * drag,
        bend + 4.0 * (side * drag + z * drag + z * side * g),
        z * (2.0 * fall * fall + 2.0 * d) + 2.0 * f,
        bend_k + 4.0 * z1 * (drag + z * g),
        8.0 * (drag + g * side + g * z),
    )


def evaluate_denominator(
    primary_damping: np.ndarray, mass_ratio: np.ndarray, k: np.ndarray, z: np.ndarray
) -> Terms:
    """Hurwitz' determinant of D over 4, m^2 z^2 + z1 times a form, with its derivatives."""
    z1, m = primary_damping, mass_ratio
    zero, square = np.zeros_like(m), m * m
    inner = evaluate(
        Form(z1, m, zero, zero, m * (2.0 + m), zero, square * z1, 1.0 + m, z1 * m), k, z
    )
    scaled = Terms(*(z1 * part for part in inner))
    return scaled._replace(
        value=scaled.value + square * z * z,
        by_z=scaled.by_z + 2.0 * square * z,
        by_zz=scaled.by_zz + 2.0 * square,
    )


# ----------------------------------------------------------------------------
# Mean square of a response to white noise, in closed form, and where there is none.
# ----------------------------------------------------------------------------

#: what of the excitation is white: by how many derivatives it differs from its amplitude
WHITE = {"displacement": 0, "velocity": 1, "acceleration": 2}
_ROUNDINGS = 40


class Weights(NamedTuple):
    """Mean square = parts[0] + 4 z1^2 parts[1], names of `numerator_form`; or the reason for none.

    An empty name stands for nothing. `travel` is the power of s left over m for the motion of
    the secondary against the primary, -1 where another motion is meant.
    """

    parts: tuple[str, str]
    reason: str
    undamped_only: bool = False
    travel: int = -1


def weights(excitation: str, response: str, white: str = "") -> Weights:
    """Which integrals make the mean square of `response`.

    `white` says what has a constant spectrum: for "base" the ground's "displacement", "velocity"
    or (default) "acceleration"; for "unbalance" what the force is the second derivative of
    ("displacement", default), or that force itself ("acceleration"). A force is white itself, and
    so is "base_acceleration", under which "deflection" is motion against the ground.
    """
    if excitation == "base_acceleration":
        # against the ground both masses feel their own inertia: N1 + m g over D
        if response == "deflection":
            return Weights(("ground", ""), "")
        return weights("base", response, "acceleration")
    transfer = transfer_of(excitation, response)
    default = {"force": "displacement", "base": "acceleration", "unbalance": "displacement"}
    chosen = white or default[excitation]
    if chosen not in WHITE or (excitation == "force" and chosen != "displacement"):
        raise NumericalFailure(f"white {white!r} says nothing for {excitation!r}")
    power = transfer.power - WHITE[chosen]
    damped = transfer.ground > 0
    slow = (
        "the slow part of the noise moves it without bound: its spectrum has no integral at zero"
        " frequency"
    )
    fast = "it follows the noise to the highest frequencies, and white noise has no mean square"
    if transfer.motion == "secondary":
        return Weights(("", ""), "the motion of the secondary itself is not among the mean squares")
    if transfer.motion == "relative":
        power += 2
        names: tuple[str, ...] = ("travel", "travel", "travel", "travel")
    else:
        stem = "motion" if transfer.motion == "primary" else "ground"
        names = (stem, f"{stem}_rate")
    if power < 0:
        return Weights(("", ""), slow)
    if power >= len(names):
        return Weights(("", ""), fast)
    only = damped and power + 1 >= len(names)
    second = "" if not damped or only else names[power + 1]
    reason = f"with damping in the primary system {fast}" if only else ""
    return Weights(
        (names[power], second), reason, only, power if transfer.motion == "relative" else -1
    )


def mean_square(
    absorber: Absorber, excitation: str = "force", response: str = "displacement", white: str = ""
) -> Bounded:
    """Integral of |H(x)|^2 over x from minus to plus infinity, and its absolute error.

    For a white force of two-sided density S (per unit of angular frequency) the mean square of
    theta1 is S w1 / K1^2 times it; in general S w1 times the square of what `transfer_of` divides
    by, and for white ground velocity or acceleration S / w1 and S / w1^3. Without an absorber the
    displacement has pi / (2 z1). See `weights` for `white`. Infinite where nothing is damped.

    Raises NumericalFailure where the response has no mean square.
    Source: integral I_4 of James, Nichols and Phillips; see `mean_square_forms`.
    """
    chosen = weights(excitation, response, white)
    arrays = [np.asarray(a, dtype=float) for a in absorber]
    z1, m, k, z = (a.copy() for a in np.broadcast_arrays(*arrays))
    if chosen.reason and (not chosen.undamped_only or np.any(z1 > 0.0)):
        kind = f" (white {white})" if white else ""
        raise NumericalFailure(
            f"{response} under white noise of {excitation!r}{kind} has no mean square: "
            f"{chosen.reason}"
        )
    locked = np.isinf(k) | np.isinf(z)
    free = (k == 0.0) & (z == 0.0)
    k_, z_ = np.where(locked | free, m, k), np.where(locked | free, m, z)
    if chosen.travel >= 0:
        value = _travel(chosen.travel, bool(chosen.parts[1]), z1, m, k_, z_)
        value = np.where(locked, 0.0, value)
        if np.any(free):
            raise NumericalFailure(f"{response}: a secondary that nothing holds has no mean square")
        return Bounded(value, _ROUNDINGS * EPSILON * value)
    total = np.zeros(z1.shape)
    bottom = evaluate_denominator(z1, m, k_, z_).value
    for name, factor in zip(chosen.parts, (np.ones_like(z1), 4.0 * z1 * z1), strict=True):
        if not name:
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            part = evaluate(numerator_form(name, z1, m), k_, z_).value / bottom
            # one mass: of all that moves together, or of the primary system alone
            mass = np.where(locked, 1.0 + m, 1.0)
            alone = mass ** (2.0 * name.startswith("ground") - 1.0 * name.endswith("rate")) / z1
            part = np.where(locked | free, alone, np.where(bottom == 0.0, np.inf, part))
            # no factor of zero may meet an infinite part
            total += np.where(factor == 0.0, 0.0, factor * part)
    value = 0.5 * np.pi * total
    with np.errstate(invalid="ignore"):
        return Bounded(value, np.where(np.isinf(value), np.inf, _ROUNDINGS * EPSILON * value))


def _travel(
    power: int, damped: bool, z1: np.ndarray, m: np.ndarray, k: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """Integral of |m s^p (1 + 2 z1 s)^q / D|^2, p = `power`, q = `damped`."""
    whole = 1.0 + m
    # halves of A1, A3, (A2 A3 - A1 A4), (A1 A2 - A0 A3), a fourth of the determinant
    a1, a3 = z + z1 * k, z * whole + z1 * m
    low = (m * m + k * whole * whole) * z + m * m * z1 * (1.0 + k) + 4.0 * z1 * z * a3
    high = z * m + z1 * k * k * whole + 4.0 * z1 * z * a1
    bottom = evaluate_denominator(z1, m, k, z).value
    with np.errstate(divide="ignore", invalid="ignore"):
        powers = (m * m * np.where(k > 0.0, low / k, np.inf), m * m * a3, m * m * a1, m * high)
        value = powers[power].copy()
        if damped:
            value += np.where(z1 > 0.0, 4.0 * z1 * z1 * powers[power + 1], 0.0)
        return 0.5 * np.pi * np.where(bottom == 0.0, np.inf, value / bottom)

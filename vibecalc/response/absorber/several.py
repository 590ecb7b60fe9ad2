"""Several absorbers on one primary system, side by side, in a row, or as any tree: response.

Seen from where it is fastened, a secondary with all that hangs on it is a mass that depends on
frequency, w = K a / (K + s^2 a) with K = k + 2 z s and a = m + the sum of w over what it carries.
Numerators and denominators are kept apart, so that an undamped absorber at its own frequency
(w infinite, the primary system at rest) needs no special case.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.response.absorber.model import transfer_of


class Several(NamedTuple):
    """n secondary systems; ratios as in `Absorber`, all referred to the primary system.

    `primary_damping` (...), the others (..., n). `parent` (n whole numbers): what each hangs on,
    0 the primary system, j the j-th secondary (counted from 1, and before it in the list).
    """

    primary_damping: ArrayLike
    mass_ratio: ArrayLike
    stiffness_ratio: ArrayLike
    secondary_damping: ArrayLike
    parent: tuple[int, ...]


def parallel(count: int) -> tuple[int, ...]:
    """Parents of `count` secondaries that all sit on the primary system."""
    return (0,) * count


def series(count: int) -> tuple[int, ...]:
    """Parents of a chain: the first on the primary system, each other on the one before it.

    With two it is the three-mass system of Baca Vasquez (2007), Fig. 5.1.
    """
    return tuple(range(count))


def checked_parents(system: Several) -> tuple[int, ...]:
    """The parents; raises NumericalFailure where they make no tree."""
    count = np.shape(system.mass_ratio)[-1]
    if len(system.parent) != count or any(not 0 <= p <= i for i, p in enumerate(system.parent)):
        raise NumericalFailure(
            f"parents {system.parent} of {count} absorbers: each must be 0 (the primary system) "
            "or the number of an absorber before it"
        )
    return system.parent


def several_amplitude(
    system: Several,
    frequency: ArrayLike,
    excitation: str = "force",
    response: str = "displacement",
    absorber: int = 1,
) -> np.ndarray:
    """Complex amplitude H(x), 0-to-peak, relative to what `transfer_of` says.

    `frequency` x broadcasts with the leading axes (...). `absorber` (from 1) is the one meant by
    "secondary_displacement" and "relative_displacement" (against what it hangs on). Infinite on
    an undamped natural frequency; infinite k or z fasten an absorber rigidly.
    """
    transfer = transfer_of(excitation, response)
    parent = checked_parents(system)
    z1, m, k, z = (np.asarray(part, dtype=float) for part in system[:4])
    x = np.asarray(frequency, dtype=float)
    s = 1j * x
    branches = _branches(parent, m, k, z, s)
    top, bottom = branches[0].inner_top, branches[0].inner_bottom
    drag = 1.0 + 2.0 * z1 * s
    below = drag * bottom + s * s * top
    above = top if transfer.motion == "ground" else bottom
    if transfer.motion in ("relative", "secondary"):
        above = _numerator(parent, absorber, transfer.motion, branches)
    above = above * transfer.sign * s**transfer.power * drag**transfer.ground
    with np.errstate(divide="ignore", invalid="ignore"):
        value = above / below
    return np.where((below == 0.0) & (above != 0.0), np.inf, value)


def path_to(parent: tuple[int, ...], absorber: int) -> list[int]:
    """Numbers of the absorbers from the primary system to `absorber`, itself included."""
    if not 1 <= absorber <= len(parent):
        raise NumericalFailure(f"absorber {absorber} of {len(parent)}: counted from 1")
    path = [absorber]
    while parent[path[0] - 1]:
        path.insert(0, parent[path[0] - 1])
    return path


class _Branch(NamedTuple):
    """A secondary with what it carries: a and w as numerators over denominators.

    Both parts of w are over `scale`. `stiff` and `inertia` are K and s^2 over s^0, s or s^2, as
    many as K holds; a locked one has K = 1 and no inertia of its own in w's denominator.
    """

    inner_top: np.ndarray
    inner_bottom: np.ndarray
    top: np.ndarray
    bottom: np.ndarray
    scale: np.ndarray
    stiff: np.ndarray
    inertia: np.ndarray


def _branches(
    parent: tuple[int, ...], m: np.ndarray, k: np.ndarray, z: np.ndarray, s: np.ndarray
) -> list[_Branch]:
    """The primary system (first, with a alone) and all secondaries."""
    shape = np.broadcast_shapes(s.shape, m.shape[:-1], k.shape[:-1], z.shape[:-1])
    one = np.ones(shape, dtype=complex)
    inner = [(one, one)] + [(m[..., i] * one, one) for i in range(len(parent))]
    found: list[_Branch] = []
    for i in reversed(range(len(parent))):
        top, bottom = inner[i + 1]
        stiff, inertia = _bond(k[..., i], z[..., i], s)
        above, below = stiff * top, stiff * bottom + inertia * top
        scale = np.maximum(np.abs(above), np.abs(below))
        above, below = above / scale, below / scale
        found.insert(0, _Branch(top, bottom, above, below, scale, stiff, inertia))
        base = inner[parent[i]]
        inner[parent[i]] = base[0] * below + above * base[1], base[1] * below
    return [_Branch(inner[0][0], inner[0][1], one, one, one, one, one), *found]


def _bond(k: np.ndarray, z: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    locked = np.isinf(k) | np.isinf(z)
    drag = 2.0 * np.where(locked, 0.0, z)
    loose, free = (k == 0.0) & ~locked, (k == 0.0) & (z == 0.0)
    stiff = np.where(loose, drag + 0.0 * s, np.where(locked, 1.0, k) + drag * s)
    inertia = np.where(free, 1.0 + 0.0 * s, np.where(loose, s, s * s))
    return stiff, np.where(locked, 0.0, inertia)


def _numerator(
    parent: tuple[int, ...], absorber: int, motion: str, branches: list[_Branch]
) -> np.ndarray:
    """Numerator of the motion of an absorber, alone or against what it hangs on.

    The denominators of w along the path cancel against the primary's numerator.
    """
    product = np.ones_like(branches[0].top)
    for number in path_to(parent, absorber):
        for other, above in enumerate(parent, start=1):
            if above == parent[number - 1] and other != number:
                product = product * branches[other].bottom
        here = branches[number]
        if number != absorber:
            product = product * here.stiff / here.scale
        elif motion == "relative":
            product = -product * here.inertia * here.inner_top / here.scale
        else:
            product = product * here.stiff * here.inner_bottom / here.scale
    return product

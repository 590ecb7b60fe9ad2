"""The balance table of a crank train, and one number for what it leaves unbalanced."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.inertia_forces import order_phasors, phasors
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.leading import side_by_side

# ----------------------------------------------------------------------------
# The balance table of a crank train: sums of sin, cos, z sin and z cos over the cylinders.
#
# Cylinders of one bank push along one line, so that numbers add. Those of several banks do not:
# their sums are vectors across the crankshaft.
# ----------------------------------------------------------------------------


def balance_table(
    orders: ArrayLike, *, crank_phase: ArrayLike, bank_angle: ArrayLike, position: ArrayLike
) -> dict[str, Bounded]:
    """Sums that say what of order n is balanced (Biezeno and Grammel, Technische Dynamik).

    Parameters
    ----------
    orders
        (n,) whole numbers.
    crank_phase, bank_angle, position
        (..., c) in rad, rad and m along the crankshaft. A cylinder counts with the angle
        n (crank_phase - bank_angle); masses are not in the table.

    Returns
    -------
    dict
        `sine`, `cosine` and both times the position in m, `position_sine` and `position_cosine`,
        (..., n, c), and `total_...` of each (..., n). A total whose magnitude is below its error
        is zero as far as the angles, as stored, can tell.
    """
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    turned = order_phasors(angle, orders)
    parts = {"sine": turned.imag, "cosine": turned.real}
    place = np.asarray(position, dtype=float)[..., None, :]
    parts |= {f"position_{name}": place * part for name, part in parts.items()}
    return parts | {f"total_{name}": part.sum() for name, part in parts.items()}


def bank_sums(
    orders: ArrayLike,
    *,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    position: ArrayLike,
    stroke: ArrayLike,
    across: ArrayLike,
) -> dict[str, Bounded]:
    """Vector sums of order n over the cylinders; arrays as in `balance_table`.

    `stroke` and `across` are (3,) unit vectors. With a = crank_phase - bank_angle and the axis
    stroke cos b - across sin b of a cylinder, a vector in the sense of rotation is
    exp(i (n a + b)) / 2, one against it exp(i (n a - b)) / 2.

    Returns
    -------
    dict
        `sum` (..., n, 3), complex, of vectors exp(i n angle) along each cylinder's axis;
        `rotating` and `counter_rotating` (..., n), the lengths of the two circular parts, the
        first of which turns with the crank, n times as fast: the end of the vector moves on an
        ellipse whose half axes are their sum and difference. Those with `position_` are weighted
        with the position along the crankshaft, in m. One cylinder alone has 1, and halves.
    """
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    turned = order_phasors(angle, orders)
    tilt = phasors(bank_angle)[..., None, :]
    found = {}
    for name, weight in (("", 1.0), ("position_", np.asarray(position, float)[..., None, :])):
        each = turned * weight
        along, aside = (each * tilt.real).sum(), -(each * tilt.imag).sum()
        found[f"{name}sum"] = along[..., None] * stroke + aside[..., None] * across
        # across points against the sense of rotation
        found[f"{name}rotating"] = 0.5 * abs(along - 1j * aside)
        found[f"{name}counter_rotating"] = 0.5 * abs(along + 1j * aside)
    return found


# ----------------------------------------------------------------------------
# One number for what a crank train leaves unbalanced.
# ----------------------------------------------------------------------------


def residual(
    loads: Bounded,
    force_weight: ArrayLike = 1.0,
    couple_weight: ArrayLike = 1.0,
    reference_length: ArrayLike = 1.0,
) -> Bounded:
    """Size (..., n) of the forces and couples (..., n, 6) of each order as one number:

    sqrt(wf^2 |F_n|^2 + wc^2 |M_n|^2 / l^2), in N, at the speed of the input, each vector with its
    three complex components.

    The norm over all orders is smooth in angles and masses except where it is zero, as a cone is
    smooth except at its tip. A search that ends in full balance had better work with its square,
    which is smooth everywhere.
    """
    of_couples = np.asarray(couple_weight, dtype=float) / np.asarray(reference_length, dtype=float)
    weights = side_by_side([force_weight] * 3 + [of_couples] * 3)
    return (loads * weights[..., None, :]).norm()

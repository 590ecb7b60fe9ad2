"""Forces of mounts over crank speed where stiffness and loss factor follow the frequency."""

import numpy as np

from vibecalc.isolation.rows import EMPTY, CoupleAt, HarmonicsAt, Jet, Readout
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import dynamics_by_order, law, response
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.spectral import SpectralSystem

# ----------------------------------------------------------------------------
# With D = sum c_i(w) B_i + iwC - w^2 M, w = n v at speed v and order n, and ' for d/dv:
#
#     D X' = F' - D' X,    D X'' = F'' - D'' X - 2 D' X'
#     Y_i = c_i S_i X + iw D_i X
# ----------------------------------------------------------------------------


def spectral_rows(
    system: SpectralSystem,
    readout: Readout,
    orders: np.ndarray,
    force: Bounded,
    couple_at: CoupleAt | None = None,
    about: np.ndarray | None = None,
    passed_on: bool = True,
) -> HarmonicsAt:
    """Rows as those of `body_rows`, one of three components for each mount of the spectrum.

    `readout.still` is that of the stiffness on which the factors of the spectrum are; of motions,
    which are not `passed_on` by the mounts, there are no factors.
    """
    order = np.asarray(orders, dtype=float)
    axis = np.zeros(force.value.shape[-1]) if about is None else about
    constant, spectrum = system.constant, system.spectrum
    _, constant_rising = law(constant.stiffness, constant.structural, constant.damping)
    rows, components, width = readout.still.shape
    still = readout.still.reshape(rows * components, width).T
    rising = readout.rising.reshape(rows * components, width).T

    def by_rows(flat: np.ndarray) -> np.ndarray:
        return flat.reshape(*flat.shape[:-1], rows, components)

    def laid_out(value: np.ndarray) -> np.ndarray:
        """(speeds, orders, rows, components) to (speeds, rows, components, orders)."""
        return np.moveaxis(value, 1, -1)

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        rate = speed[:, None] * order
        dynamic = dynamics_by_order(system.at(rate), rate)
        column = speed[:, None, None]
        load = column * column * force.value
        added = None if couple_at is None else couple_at(speed, slopes, errors)
        if added is not None:
            load = load + added.value[..., None] * axis
        load_error = column * column * force.error + 4.0 * UNIT_ROUNDOFF * np.abs(load)
        if added is not None and errors:
            load_error = load_error + added.error[..., None] * np.abs(axis)
        motion = response(dynamic, load, load_error)
        x, off = motion.value, motion.error
        factor = spectrum(rate)[..., None] if passed_on else np.ones(1)
        w, n = rate[..., None, None], order[:, None, None]
        held, dragged = by_rows(x @ still), by_rows(x @ rising)
        value = factor * held + w * dragged
        error = slope = slope_error = curvature = EMPTY
        size, drag = np.abs(still), np.abs(rising)
        spread = off + readout.uncertainty * np.abs(x)
        if errors:
            error = np.abs(factor) * by_rows(spread @ size) + w * by_rows(spread @ drag)
            error = laid_out(error)
        if slopes:
            first, second = (
                spectrum(rate, derivative)[..., None] if passed_on else np.zeros(1)
                for derivative in (1, 2)
            )
            turn = n * (
                system.slope(rate, 1)
                + constant_rising
                - 2.0 * rate[..., None, None] * constant.mass
            )
            bend = np.square(n) * (system.slope(rate, 2) - 2.0 * constant.mass)
            load_slope, load_bend = 2.0 * column * force.value, 2.0 * force.value
            if added is not None:
                load_slope = load_slope + added.slope[..., None] * axis
                load_bend = load_bend + added.curvature[..., None] * axis
            x1 = _apply(dynamic.inverse, load_slope - _apply(turn, x))
            x2 = load_bend - _apply(bend, x) - 2.0 * _apply(turn, x1)
            x2 = _apply(dynamic.inverse, x2)
            held1, dragged1 = by_rows(x1 @ still), by_rows(x1 @ rising)
            slope = factor * held1 + n * first * held + w * dragged1 + n * dragged
            curvature = (
                factor * by_rows(x2 @ still)
                + 2.0 * n * first * held1
                + np.square(n) * second * held
                + w * by_rows(x2 @ rising)
                + 2.0 * n * dragged1
            )
            slope, curvature = laid_out(slope), laid_out(curvature)
            if errors:
                lost = _apply(np.abs(turn), off + 32.0 * UNIT_ROUNDOFF * np.abs(x))
                lost = lost + _apply(dynamic.error, np.abs(x1)) + 2.0 * column * force.error
                lost = lost + 16.0 * UNIT_ROUNDOFF * np.abs(load_slope)
                if added is not None:
                    lost = lost + added.slope_error[..., None] * np.abs(axis)
                steep = _apply(np.abs(dynamic.inverse), lost)
                steep = steep + (16.0 * UNIT_ROUNDOFF + readout.uncertainty) * np.abs(x1)
                slope_error = laid_out(
                    np.abs(factor) * by_rows(steep @ size)
                    + n * np.abs(first) * by_rows(spread @ size)
                    + w * by_rows(steep @ drag)
                    + n * by_rows(spread @ drag)
                )
        return Jet(laid_out(value), error, slope, slope_error, curvature)

    return harmonics_at


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product

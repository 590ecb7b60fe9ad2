"""Cylinders that do not do their share: imbalance, misfire, lost pistons.

Each cylinder has a pressure scale (1 for a healthy one) and may misfire in one of two ways, which
the result names: "no_gas", no gauge pressure at all (a valve stuck open), or "motored", compression
and expansion without combustion (no fuel). Its masses go on moving unless it is lost.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.cylinder_torque import CrankGeometry, CylinderTorque
from vibecalc.excitation.gas_card import GasCard, fitted_card, pressure_at
from vibecalc.kinematics.dead_centres import top_dead_centre
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray

MISFIRES = ("no_gas", "motored")
PI = float(np.pi)


class CylinderGas(NamedTuple):
    """Gas torque of c cylinders, each from its own firing: harmonics (..., c, m), mean (..., c).

    Complex and 0-to-peak, N m, with absolute errors.
    """

    value: ComplexArray
    error: FloatArray
    mean: FloatArray
    mean_error: FloatArray


def cylinder_gas(
    torque: CylinderTorque,
    pressure_scale: ArrayLike,
    *,
    misfiring: ArrayLike = False,
    motored: CylinderTorque | None = None,
) -> CylinderGas:
    """Gas torque of every cylinder from that of a healthy one.

    Parameters
    ----------
    torque
        Of a healthy cylinder, gas (..., m).
    pressure_scale
        (c,) factors on the gauge pressure, zero for no gas.
    misfiring
        (c,) true for a cylinder that misfires; it has the gas torque of `motored`, times its scale,
        or without `motored` none.
    motored
        Of a cylinder without combustion, gas of the same shape.
    """
    scale = np.asarray(pressure_scale, dtype=float)
    out = np.broadcast_to(np.asarray(misfiring, dtype=bool), scale.shape)
    parts = []
    for name in ("gas", "gas_error", "mean", "mean_error"):
        healthy = np.asarray(getattr(torque, name))
        ill = np.zeros_like(healthy) if motored is None else np.asarray(getattr(motored, name))
        if name.startswith("gas"):
            each, on, by = healthy[..., None, :], out[:, None], scale[:, None]
            parts.append(np.where(on, ill[..., None, :], each) * by)
        else:
            parts.append(np.where(out, ill[..., None], healthy[..., None]) * scale)
    value, error, mean, mean_error = parts
    return CylinderGas(
        value,
        np.abs(error) + EPSILON * np.abs(value),
        mean,
        np.abs(mean_error) + EPSILON * np.abs(mean),
    )


def motored_card(
    card: GasCard, geometry: CrankGeometry, exhaust_opens: float = float(np.radians(130.0))
) -> GasCard:
    """A card without combustion, from one with it: the charge expands as it was compressed.

    From 180 degrees before firing to top dead centre the card stays as it is, then it runs back
    through the same pressures at the same places of the piston until the exhaust opens (rad,
    between 0 and pi), and passes over to the card's own pressure at 180 degrees. What has burnt
    before the top in the card given comes along, so the peak is somewhat high.

    The wrist pin at (s, e) sees the crank at equal angles on both sides of the line to it, hence
    the partner of the angle t at 2 arctan(e / s) - t.
    """
    radius, length, offset = geometry.crank_radius, geometry.rod_length, geometry.wrist_pin_offset
    top = float(top_dead_centre(radius, length, offset).angle)

    def partner(angle: FloatArray) -> FloatArray:
        place = piston_path(angle, radius, length, offset).position
        return np.asarray(2.0 * np.arctan2(offset, place) - angle)

    def pressure(angle: FloatArray) -> FloatArray:
        own = pressure_at(card, angle)
        back = pressure_at(card, partner(angle))
        share = np.clip((angle - exhaust_opens) / (PI - exhaust_opens), 0.0, 1.0)
        rise = share * share * (3.0 - 2.0 * share)
        mirrored = (1.0 - rise) * back + rise * pressure_at(card, np.asarray(PI))
        return np.where((angle > top) & (angle < PI), mirrored, own)

    first = -PI
    inside = np.mod(card.node[:-1] - first, card.cycle) + first
    back = partner(inside[inside < top])
    ends = {first, top, exhaust_opens, PI, first + card.cycle}
    before, after = inside[inside < top], inside[inside > PI]
    points = np.array(sorted({*before, *back[(back > top) & (back < PI)], *after, *ends}))
    # nodes that differ by rounding only would make pieces without width
    keep = np.concatenate([[True], np.diff(points) > 1e-9])
    keep[-1] = True
    return fitted_card(pressure, [float(v) for v in points[keep]], card.cycle)

"""Motion of the crank-side pin and of the rod angle as harmonics, for a slider-crank."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.rod_angle import rod_angle_harmonics
from vibecalc.response.impact.model import Drive

#: harmonics below this fraction of the largest acceleration cannot be seen in double precision
_NEGLIGIBLE = 2.0**-58
_HIGHEST_ORDER = 800


def slider_crank_drive(
    crank_radius: float,
    rod_length: float,
    speed: float,
    wrist_pin_offset: float = 0.0,
    *,
    highest_order: int | None = None,
    with_rod_tangent: bool = False,
) -> Drive:
    """Harmonics of Y, m, counted from the outermost place of the centred crank downwards.

    Lengths in m, `speed` in rad/s. Without `highest_order` every harmonic that double precision
    can show is kept. `with_rod_tangent` adds those of tan(rod angle), see `model.Drive`;
    `highest_order` cuts both.

    Raises NumericalFailure where the harmonics of a rod hardly longer than the crank do not end.
    """
    top = _HIGHEST_ORDER if highest_order is None else highest_order
    ratio, offset = crank_radius / rod_length, wrist_pin_offset / crank_radius
    acceleration = np.abs(motion_harmonics(ratio, top, offset, derivative=2))
    keep = np.flatnonzero(acceleration > _NEGLIGIBLE * np.max(acceleration))
    if highest_order is None and keep[-1] >= top - 1:
        raise NumericalFailure(
            f"the harmonics of the piston motion do not end before order {top}: the rod "
            f"({rod_length:.9g} m) is hardly longer than the crank ({crank_radius:.9g} m)"
        )
    displacement = -crank_radius * motion_harmonics(ratio, top, offset)
    displacement[0] += crank_radius + rod_length
    orders = np.concatenate([[0], keep]).astype(np.int64)
    drive = Drive(float(speed), orders, displacement[orders])
    if not with_rod_tangent:
        return drive
    # its harmonics fall as fast as those of the acceleration, but for a power of the order
    highest = int(orders[-1]) + 4 if highest_order is None else highest_order
    angle = rod_angle_harmonics(crank_radius, rod_length, wrist_pin_offset, highest_order=highest)
    tangent = angle.tangent.value
    size = np.abs(tangent)
    keep = np.flatnonzero(size > _NEGLIGIBLE * np.max(size)).astype(np.int64)
    return drive._replace(tangent_orders=keep, rod_tangent=tangent[keep])

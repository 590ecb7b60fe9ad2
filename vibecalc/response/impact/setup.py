"""Everything about a batch that stays the same while it runs."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.impact.model import Drive, GasForce, Train
from vibecalc.response.impact.panels import Panels, make_panels
from vibecalc.response.impact.series import REACH, DriveTable, pin_table, tangent_table
from vibecalc.response.impact.spectrum import Transform, make_transform

#: steps of one run in one revolution that count as no progress
MOST_STEPS = 200_000
#: shortest contact, as a part of a revolution
_SHORTEST_CONTACT = 1e-9


class Setup(NamedTuple):
    """Machine, crank-angle panels and tables; `rate_couple` (G, G, B) bounds all couplings."""

    train: Train
    speed: float
    panels: Panels
    pin: DriveTable
    tangent: DriveTable | None
    rate_couple: FloatArray
    transform: Transform
    pin_velocity_at_start: float


def make_setup(
    train: Train, drive: Drive, gas: GasForce, highest_order: int, subdivision: int = 1
) -> Setup:
    """Tables of a batch.

    Raises UsageError for a bore without harmonics of the rod angle or a speed that is not
    positive, NumericalFailure for contacts too stiff or damped to be followed.
    """
    if not drive.speed > 0.0:
        raise UsageError("the speed of the crank has to be positive")
    tangent, rate_couple = None, np.abs(train.couple)
    if train.bore is not None:
        if drive.rod_tangent is None:
            raise UsageError("a bore with play needs the harmonics of the rod angle")
        tangent = tangent_table(drive)
        # the bound on |tan| of the rod angle; a sum of harmonics is never above that of sizes
        rate_couple[train.bore, 0] = np.sum(np.abs(drive.rod_tangent)) / train.mass
    _refuse_hard_contacts(train, rate_couple, drive.speed)
    panels = make_panels(drive, gas, highest_order, subdivision)
    pin = pin_table(drive)
    return Setup(
        train,
        drive.speed,
        panels,
        pin,
        tangent,
        rate_couple,
        make_transform(panels, highest_order),
        float(np.sum(pin.cosine[:, 0])),
    )


def _refuse_hard_contacts(train: Train, size: FloatArray, speed: float) -> None:
    gaps = train.gaps
    own = np.einsum("ggb->gb", size)
    turn = 2.0 * np.pi / speed
    contact = np.min(np.pi / np.sqrt(own * gaps.stiffness))
    if contact < _SHORTEST_CONTACT * turn:
        raise NumericalFailure(
            f"a contact would last {contact:.3g} s, less than 1e-9 of a revolution: its stiffness "
            f"({np.max(gaps.stiffness):.3g} N/m) is too high for the masses it acts on"
        )
    damping = np.maximum(gaps.contact_damping, gaps.film_damping)
    rate = np.max(np.sum(size * damping, axis=1))
    if rate * turn > REACH * MOST_STEPS:
        raise NumericalFailure(
            f"damping of {np.max(damping):.3g} N*s/m brings the masses to rest in "
            f"{1.0 / rate:.3g} s, too fast to be followed over a revolution"
        )

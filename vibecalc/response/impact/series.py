"""Power series of the gaps over one step: between events the system is linear.

With s the fraction of the step, a gap is z = sum_k z_k s^k. The equation of motion gives z_(k+2)
from z_k and z_(k+1): the series of the matrix exponential and of the forced motion together,
which has no trouble at resonance, with damping above critical, or in the double integral of a
free flight. Steps are at most REACH over the fastest rate of the contacts, which leaves out
REACH^(DEGREE+1)/(DEGREE+1)! = 2e-17 of the motion.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.impact.contact import Law
from vibecalc.response.impact.model import Drive
from vibecalc.response.impact.panels import DEGREE
from vibecalc.response.impact.roots import in_order

#: longest step times the fastest rate of the contacts
REACH = 1.75


class DriveTable(NamedTuple):
    """Real tables (n, k): derivative k over k! is cosine . cos(n theta) + sine . sin(n theta)."""

    orders: FloatArray
    cosine: FloatArray
    sine: FloatArray


def pin_table(drive: Drive) -> DriveTable:
    """Table of the pin: column 0 its velocity Y', column 1 + k the angle series of Y''."""
    step = 1j * np.asarray(drive.orders) * drive.speed
    velocity = np.asarray(drive.displacement) * step
    return _table(drive.orders, np.vstack([velocity, *_rising(drive.orders, velocity * step)]))


def tangent_table(drive: Drive) -> DriveTable:
    """Table of tan(rod angle): column k the angle series; ValueError if the drive has none."""
    if drive.rod_tangent is None or drive.tangent_orders is None:
        raise ValueError("the drive has no harmonics of the rod angle")
    values = np.asarray(drive.rod_tangent, dtype=np.complex128)
    return _table(drive.tangent_orders, np.vstack(_rising(drive.tangent_orders, values)))


def _rising(orders: IntArray, values: np.ndarray) -> list[np.ndarray]:
    rows = [values]
    for k in range(1, DEGREE - 1):
        rows.append(rows[-1] * (1j * np.asarray(orders)) / k)
    return rows


def _table(orders: IntArray, rows: np.ndarray) -> DriveTable:
    used = np.any(rows != 0.0, axis=0)
    value = np.ascontiguousarray(rows[:, used].T)
    return DriveTable(np.asarray(orders, dtype=np.float64)[used], value.real, -value.imag)


def drive_series(table: DriveTable, angle: FloatArray) -> FloatArray:
    """The columns of a table at crank angles (A,), as an array (k, A).

    Sums run over the orders one by one, so that a run does not depend on its company in a batch.
    """
    phase = table.orders[:, None] * angle
    cosine, sine = np.cos(phase)[:, None, :], np.sin(phase)[:, None, :]
    total = np.zeros((table.cosine.shape[1], len(angle)))
    for n in range(len(table.orders)):
        total += table.cosine[n][:, None] * cosine[n]
        total += table.sine[n][:, None] * sine[n]
    return total


def fastest_rate(couple: FloatArray, law: Law) -> FloatArray:
    """Bound (A,), rad/s, on every rate of the linear system z'' = -couple (K z + D z').

    A row-sum norm: a root obeys r^2 <= d r + k, so r <= sqrt(k) + d.
    """
    size = np.abs(couple)
    stiff = np.max(np.sum(size * law.spring, axis=1), axis=0)
    damped = np.max(np.sum(size * law.damper, axis=1), axis=0)
    return np.asarray(np.sqrt(stiff) + damped)


class Step(NamedTuple):
    """Coefficients (DEGREE + 1, G, A) of the gaps, m, and (DEGREE, G, A) of the forces, N."""

    gap: FloatArray
    force: FloatArray


def motion_series(
    gap: FloatArray,
    velocity: FloatArray,
    law: Law,
    couple: FloatArray,
    push: FloatArray,
    duration: FloatArray,
    side_pull: FloatArray | None,
) -> Step:
    """Series of every gap over a step of `duration` (A,), s.

    `gap`, `velocity` (G, A) at its start; `couple` (G, G, A); `push` (DEGREE - 1, G, A) the
    series in s of what accelerates the gaps besides their forces; `side_pull` (DEGREE - 1, A)
    that of tan(rod angle) over the piston mass, if the last gap is the bore.
    """
    gaps, members = gap.shape
    square = duration * duration
    couple, push = couple * square, push * square
    if side_pull is not None:
        side_pull = side_pull * square
    rate = law.damper / duration
    z = np.empty((DEGREE + 1, gaps, members))
    force = np.empty((DEGREE, gaps, members))
    z[0], z[1] = gap, velocity * duration
    for k in range(DEGREE - 1):
        force[k] = law.spring * (z[k] if k else z[0] - law.rest) + (k + 1.0) * rate * z[k + 1]
        pull = couple[0] * force[k] if gaps == 1 else np.sum(couple * force[k], axis=1)
        z[k + 2] = (push[k] - pull) / ((k + 1.0) * (k + 2.0))
        if side_pull is not None:
            lateral = in_order(side_pull[k::-1] * force[: k + 1, 0])
            z[k + 2, -1] += lateral / ((k + 1.0) * (k + 2.0))
    last = DEGREE - 1
    force[last] = law.spring * z[last] + DEGREE * rate * z[DEGREE]
    return Step(z, force)

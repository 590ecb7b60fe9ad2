"""Statistics of an ensemble: its forces, their spectra, what they add to the shaking force."""

from typing import NamedTuple

import numpy as np

from vibecalc.impact.linkage import Drive, GapForces, GasForce, Linkage
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Statistics of an ensemble: C clearances, M members each, R revolutions of each member.
#
# Members start apart and are independent; the revolutions of one member follow from each other.
# So every standard error comes from the scatter of members, and none of them depends on the order
# in which members stand.
# ----------------------------------------------------------------------------


class Statistic(NamedTuple):
    """A statistic and its standard error, arrays of one shape, in the unit of what it is made of.

    The standard error of a quantity that is the same in all revolutions is zero.
    """

    value: FloatArray
    standard_error: FloatArray


def mean_over_runs(values: FloatArray) -> Statistic:
    """Mean (C, ...) of values (C, M, R, ...); its error from the M means of members."""
    of_member = np.mean(values, axis=2)
    return Statistic(np.mean(of_member, axis=1), standard_error(of_member))


def standard_error(of_member: FloatArray) -> FloatArray:
    """Standard error (C, ...) of a mean over members (C, M, ...), M at least 2."""
    members = of_member.shape[1]
    return np.asarray(np.std(of_member, axis=1, ddof=1) / np.sqrt(members))


def quantiles(values: FloatArray, shares: tuple[float, ...]) -> tuple[Statistic, ...]:
    """Quantiles (C, ...) of values (C, M, R, ...) over members and revolutions, one per share.

    The error of a quantile q: the share of values below q has a standard error s between members,
    and q moves by half the distance of the quantiles at share - s and share + s. Source: R. S.
    Woodruff (1952), for samples that come in clusters. Values may be infinite.
    """
    shape = values.shape
    count = shape[1] * shape[2]
    ordered = np.sort(values.reshape(shape[0], count, *shape[3:]), axis=1)
    levels = []
    for share in shares:
        middle = _at(ordered, np.full((shape[0], *shape[3:]), share))
        below = np.mean(values <= middle[:, None, None], axis=2)
        uncertainty = standard_error(below)
        low, high = (_at(ordered, np.clip(share + s * uncertainty, 0.0, 1.0)) for s in (-1.0, 1.0))
        levels.append(Statistic(middle, _half_distance(low, high)))
    return tuple(levels)


def _at(ordered: FloatArray, share: FloatArray) -> FloatArray:
    """Quantiles (C, ...) of ordered values (C, n, ...) at shares (C, ...), straight between."""
    place = share * (ordered.shape[1] - 1)
    first = np.floor(place).astype(np.int64)
    second = np.minimum(first + 1, ordered.shape[1] - 1)
    low = np.take_along_axis(ordered, first[:, None], axis=1)[:, 0]
    high = np.take_along_axis(ordered, second[:, None], axis=1)[:, 0]
    weight = place - first
    # an infinite neighbour counts only with a weight of its own
    step = np.zeros_like(low)
    np.subtract(high, low, out=step, where=np.isfinite(low) & (weight > 0.0))
    return np.asarray(low + np.multiply(weight, step, where=weight > 0.0, out=np.zeros_like(low)))


def _half_distance(low: FloatArray, high: FloatArray) -> FloatArray:
    """(high - low) / 2, zero between infinities and infinite next to one."""
    step = np.zeros_like(low)
    np.subtract(high, low, out=step, where=np.isfinite(low))
    return 0.5 * step


# ----------------------------------------------------------------------------
# Statistics of the forces, and from which order on they lead.
# ----------------------------------------------------------------------------

#: share of revolutions below the low and the high curve
LOW, HIGH = 0.05, 0.95
#: who leads an order
SHAKING, IMPACT, MOTOR = 0, 1, 2


def statistics(forces: GapForces, linkage: Linkage) -> dict[str, Statistic]:
    """Statistics of forces (G, C, M, R) by what their paths have behind `response/impact/`.

    Of single revolutions; those of spectra are of magnitudes, as magnitudes of means would be
    smaller by what revolutions differ in phase. Order 0, the mean force, is left out: it balances
    the gas and shakes nothing.
    """
    force, peak = forces.mean[0], forces.peak[0]
    size = np.abs(forces.harmonics[0, ..., 1:])
    low, high = quantiles(force, (LOW, HIGH))
    spectrum_low, spectrum_high = quantiles(size, (LOW, HIGH))
    (peak_high,) = quantiles(peak, (HIGH,))
    of_runs = {
        "mean_force": force,
        "spectrum": size,
        "average_amplitude": np.mean(size, axis=-1),
        "added_force": np.abs(added_force(linkage, forces)[..., 1:]),
        "peak_force": peak,
        "impacts": forces.contacts[0],
        "contact_share": forces.contact_time[0] * linkage.drive.speed / (2.0 * np.pi),
    }
    for place, name in enumerate(linkage.joints):
        if place:
            of_runs[f"{name}/mean_force"] = forces.mean[place]
            of_runs[f"{name}/impacts"] = forces.contacts[place]
    return {
        **{name: mean_over_runs(values) for name, values in of_runs.items()},
        "mean_force_low": low,
        "mean_force_high": high,
        "spectrum_low": spectrum_low,
        "spectrum_high": spectrum_high,
        "peak_force_high": peak_high,
    }


class Dominance(NamedTuple):
    """Who has the largest amplitude.

    `dominant_from` (C,): the lowest order from which on the impact exceeds both others at every
    higher order of the spectrum, 0 if it does not at the last one. `dominant` (C, N): 0 the
    piston's inertia force, 1 the impact, 2 the motor. The `spread` of each is half of what it
    changes between spectra two standard errors lower and as much higher.
    """

    dominant_from: IntArray
    dominant_from_spread: FloatArray
    dominant: IntArray
    dominant_spread: FloatArray


def dominance(impact: Statistic, shaking: FloatArray, motor: FloatArray) -> Dominance:
    """Compare amplitudes, N, of orders 1 to N: `impact` (C, N), `shaking` and `motor` (N,)."""
    leading = dominant(impact.value, shaking, motor)
    start = dominant_from(leading)
    uncertainty = 2.0 * impact.standard_error
    changed = [dominant(impact.value + side * uncertainty, shaking, motor) for side in (-1.0, 1.0)]
    # nowhere, as a place beyond the last order
    last = impact.value.shape[-1] + 1
    ends = [np.where(dominant_from(each) > 0, dominant_from(each), last) for each in changed]
    return Dominance(
        start,
        0.5 * np.abs(ends[1] - ends[0]),
        leading,
        0.5 * np.abs(changed[1] - changed[0]),
    )


def dominant(impact: FloatArray, shaking: FloatArray, motor: FloatArray) -> IntArray:
    """Index (C, N) of the largest; of equals the first in the order of the indices."""
    rows = np.broadcast_arrays(shaking, impact, motor)
    return np.asarray(np.argmax(np.stack(rows), axis=0).astype(np.int64))


def dominant_from(leading: IntArray) -> IntArray:
    """Lowest order (C,) from which on IMPACT leads in (C, N), 0 if it does not at the last."""
    others = leading != IMPACT
    count = leading.shape[-1]
    trailing = np.argmax(others[..., ::-1], axis=-1)
    start = np.where(np.any(others, axis=-1), count - trailing + 1, 1)
    return np.asarray(np.where(start > count, 0, start).astype(np.int64))


# ----------------------------------------------------------------------------
# What play adds to the force that shakes the body.
#
# The body feels minus the inertia force of all that moves along the cylinder: the force F of the
# joint that the crank drives, that of what the crank drives without play, and the gas on the head,
# which is equal and opposite to that on the piston. M is the mass beyond that joint: piston and
# pin, and the rod's reciprocating share if the crank pin has play. So M X'' = F + gas, and what
# play adds is F less the force M Y'' - gas that the joint would carry without play. A rod's share
# that the crank drives has its inertia force whatever the play is, and adds nothing. In F itself
# most of the lower orders is the load that is carried anyway.
# ----------------------------------------------------------------------------


def added_force(linkage: Linkage, forces: GapForces) -> ComplexArray:
    """Harmonics (C, M, R, N + 1), N, 0-to-peak, of the crank-side joint's force less `carried`."""
    found = forces.harmonics[0 if linkage.crank_pin is None else 1]
    return np.asarray(found - carried_force(linkage, found.shape[-1] - 1))


def carried_force(linkage: Linkage, highest: int) -> ComplexArray:
    """Harmonics (highest + 1,), N, of the crank-side joint's force if no joint had play."""
    mass = linkage.mass + (linkage.rod_mass or 0.0)
    pin = mass * pin_acceleration(linkage.drive, highest)
    return np.asarray(pin - gas_harmonics(linkage.gas, highest))


def pin_acceleration(drive: Drive, highest: int) -> ComplexArray:
    """Harmonics (highest + 1,) of Y'', m/s^2, positive towards the crank."""
    harmonics = np.zeros(highest + 1, dtype=np.complex128)
    orders = np.asarray(drive.orders)
    retained = orders <= highest
    values = -np.square(orders * drive.speed) * np.asarray(drive.displacement)
    harmonics[orders[retained]] = values[retained]
    return harmonics


def gas_harmonics(gas: GasForce, highest: int) -> ComplexArray:
    """Harmonics (highest + 1,), N, of a force that is straight between its angles: exact integrals.

    Integrating by parts twice leaves the slopes: pi n^2 G_n = sum slope (e^-inb - e^-ina) over
    the pieces [a, b].
    """
    harmonics = np.zeros(highest + 1, dtype=np.complex128)
    angle, force = np.asarray(gas.angle), np.asarray(gas.force)
    if not angle.size:
        return harmonics
    turn = 2.0 * np.pi
    if angle[-1] - angle[0] < turn * (1.0 - 1e-12):
        angle, force = np.append(angle, angle[0] + turn), np.append(force, force[0])
    harmonics[0] = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(angle)) / turn
    order = np.arange(1, highest + 1)
    wave = np.exp(-1j * order[:, None] * angle)
    slope = np.diff(force) / np.diff(angle)
    harmonics[1:] = (np.diff(wave, axis=1) @ slope) / (np.pi * order**2)
    return harmonics

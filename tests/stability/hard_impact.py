"""Hard cases of joints with play: contacts of a tenth of a millisecond, and chaos.

Ong (2000), chapter 5: damping ratio .00112, contact for 1.4e-4 s; two runs that start 1e-9 in
apart part company after 2 to 7 turns, so that only statistics of many runs are results.
"""

from functools import cache

import mpmath
import numpy as np
from impact_machines import CLEARANCE, INCH, MASS, compressor_drive, gas_towards, source_joint
from stability.hard_case import HardCase, Numbers, Way
from test_consistency_impact_motion import bounces

from vibecalc.impact.linkage import Drive, GasForce, Joint, Linkage, Starts, spread_starts
from vibecalc.impact.runs import distance, first_motion, parting
from vibecalc.impact.simulate import simulate
from vibecalc.impact.statistics import mean_over_runs
from vibecalc.numerics.bounded import Bounded

#: lightly damped and short of contact
JOINT = Joint(1e-3, 1e5, 6.0, 0.4, "continuous")
FORCE, START, FLIGHT, SPEED = 0.03, (5e-4, 0.0), 1.3, 3.0
COUNT = 5
APART = 1e-9 * INCH
#: mean of the force's magnitude over `ensemble(100, 40)`, N, and its standard error
LONG_RUN, LONG_RUN_ERROR = 477.172, 0.088


@cache
def true_bounces() -> Numbers:
    """In rad; the marching of the test they come from is good to a double."""
    return [mpmath.mpf(SPEED * one)
            for one in bounces(FLIGHT, JOINT, FORCE, *START, COUNT).tolist()]  # fmt: skip


def own_bounces(force: float = FORCE) -> Bounded:
    still = Drive(SPEED, np.array([0]), np.array([0.0 + 0j]))
    gas = GasForce(np.array([0.0, np.pi]), np.array([force, force]))
    found = first_motion(Linkage(still, gas, FLIGHT, JOINT), np.array([JOINT.clearance]))
    return Bounded(found.contacts[0, :COUNT], found.contacts_error[0, :COUNT])


def bounce_condition() -> float:
    """Of the last contact, by the force."""
    base, moved = own_bounces().value[-1], own_bounces(FORCE * (1.0 + 1e-7)).value[-1]
    return float(abs(moved / base - 1.0) / 1e-7)


def stepped_bounces(step: float, euler: bool) -> np.ndarray:
    """Fixed steps that run over the contacts; a contact is noticed at the end of its step."""

    def acceleration(z: float, v: float) -> float:
        if 0.0 <= z <= JOINT.clearance:
            return float((-FORCE - JOINT.film_damping * v) / FLIGHT)
        rest = JOINT.clearance if z > 0.0 else 0.0
        return float((-FORCE - JOINT.stiffness * (z - rest) - JOINT.contact_damping * v) / FLIGHT)

    z, v, inside, found, n = *START, True, [], 0
    while len(found) < COUNT and n < 400_000:
        n += 1
        if euler:
            z, v = z + step * v, v + step * acceleration(z, v)
        else:
            a1 = acceleration(z, v)
            a2 = acceleration(z + 0.5 * step * v, v + 0.5 * step * a1)
            v2, v3 = v + 0.5 * step * a1, v + 0.5 * step * a2
            a3 = acceleration(z + 0.5 * step * v2, v3)
            v4 = v + step * a3
            a4 = acceleration(z + step * v3, v4)
            z += step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v += step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        now = bool(0.0 <= z <= JOINT.clearance)
        if inside and not now:
            found.append(n * step)
        inside = now
    if len(found) < COUNT:
        raise ArithmeticError("contacts are missed")
    return SPEED * np.array(found)


def linkage() -> Linkage:
    return Linkage(compressor_drive(), gas_towards("crank"), MASS, source_joint())


def ensemble(members: int, turns: int, discard: int = 8) -> np.ndarray:
    """Mean magnitude of the force in the wrist pin, N (1, members, turns)."""
    one = linkage()
    start = spread_starts(one, np.array([CLEARANCE]), members)
    run = simulate(one, Starts(start.gap[0], start.velocity[0]), discard + turns, 2)
    return run.forces.mean[:, :, discard:]


def own_mean() -> Bounded:
    found = mean_over_runs(ensemble(40, 10))
    uncertainty = 4.0 * np.hypot(found.standard_error, LONG_RUN_ERROR)
    return Bounded(found.value.ravel(), uncertainty.ravel())


def turns_together() -> np.ndarray:
    """After how many turns pairs part that start `APART` from each other, (8,)."""
    one, count = linkage(), 8
    start = spread_starts(one, np.array([CLEARANCE]), count)
    gap = np.concatenate([start.gap[0], start.gap[0] + APART])
    velocity = np.concatenate([start.velocity[0], start.velocity[0]])
    run = simulate(one, Starts(gap, velocity), 12, 2)
    away = [run.end_gap[:count] - run.end_gap[count:],
            run.end_velocity[:count] - run.end_velocity[count:]]  # fmt: skip
    first = np.full((count, 1), APART / CLEARANCE)
    along = distance(away[0], away[1], np.asarray(CLEARANCE), np.asarray(1.0))
    return parting(np.concatenate([first, along], axis=1)).revolutions


def growth() -> float:
    """Of a distance over the turns that it takes to part, from 1e-9 in to a tenth of the play."""
    return 0.1 * CLEARANCE / APART


def cases() -> tuple[HardCase, ...]:
    return (
        HardCase(
            "five bounces of a damped mass, contact for a hundredth of the time",
            bounce_condition, true_bounces, own_bounces,
            (Way("Runge-Kutta, 1e-4 s", lambda: stepped_bounces(1e-4, False)),
             Way("Euler, 1e-4 s", lambda: stepped_bounces(1e-4, True))),
            long=True,
        ),
        HardCase(
            "mean force after 12 turns: runs 1e-9 in apart part after 2 to 7",
            growth, lambda: [mpmath.mpf(LONG_RUN)], own_mean,
            (Way("the last turn of one run", lambda: ensemble(1, 1, 11).ravel(), loose=True),),
            long=True,
        ),
    )  # fmt: skip

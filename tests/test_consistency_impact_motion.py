"""Claim: the motion with play is exact: closed forms, a second integrator and the laws of
momentum and energy agree with it to rounding. The fixed-step methods have their orders where the
motion is smooth, and approach the event-exact motion through contacts.
"""

import mpmath
import numpy as np
import pytest
from impact_machines import (
    CLEARANCE,
    DAMPING,
    INCH,
    LENGTH,
    MASS,
    RADIUS,
    ROD_MASS,
    SPEED,
    gas_towards,
    near,
    source_joint,
    source_linkage,
    states,
)
from scipy.integrate import solve_ivp

from vibecalc.impact.linkage import Drive, GasForce, Joint, Linkage
from vibecalc.impact.simulate import simulate
from vibecalc.kinematics.slider_crank import piston_motion


class Reference:
    """One machine; `joints` in the order wrist pin, crank pin, bore, None where there is none."""

    def __init__(self, radius, length, speed, gas, mass, joints, rod_mass=None):
        self.radius, self.length, self.speed = radius, length, speed
        self.gas, self.mass, self.rod_mass = gas, mass, rod_mass
        self.kinds = [k for k in range(3) if joints[k] is not None]
        self.joints = [joints[k] for k in self.kinds]
        # solve_ivp examines events from step to step only: a contact must not fit into one
        stiffest = max(float(joint.stiffness) for joint in self.joints)
        lightest = mass if rod_mass is None else mass * rod_mass / (mass + rod_mass)
        self.longest_step = 0.25 * np.sqrt(lightest / stiffest)

    def force(self, joint, side, z, v):
        if side == 0:
            return joint.film_damping * v
        rest = joint.clearance if side > 0 and joint.law == "continuous" else 0.0
        return joint.stiffness * (z - rest) + joint.contact_damping * v

    def rates(self, time, state, sides):
        angle = self.speed * time
        count = len(self.joints)
        z, v = state[:count], state[count:]
        force = {
            kind: self.force(joint, side, zk, vk)
            for kind, joint, side, zk, vk in zip(self.kinds, self.joints, sides, z, v, strict=True)
        }
        pin = -(self.speed**2) * piston_motion(angle, self.radius, self.length).acceleration
        gas = 0.0
        if len(self.gas.angle):
            gas = np.interp(angle % (2 * np.pi), self.gas.angle, self.gas.force)
        piston = (force[0] + gas) / self.mass
        if 1 in force:
            rod = (force[1] - force[0]) / self.rod_mass
            result = [rod - piston, pin - rod]
        else:
            result = [pin - piston]
        if 2 in force:
            sine = self.radius * np.sin(angle)
            tangent = sine / np.sqrt(self.length**2 - sine**2)
            result.append((force[0] * tangent - force[2]) / self.mass)
        return np.concatenate([v, result])

    def contacts(self, gap, velocity, until, tolerance=1e-12):
        """Times of the first contacts, one list for each joint, and the state at `until`, s."""
        count = len(self.joints)
        state = np.concatenate([np.atleast_1d(gap), np.atleast_1d(velocity)]).astype(float)
        sides, made = [], [[] for _ in self.joints]
        for k, joint in enumerate(self.joints):
            z, v = state[k], state[count + k]
            above = z > joint.clearance or (z == joint.clearance and v > 0)
            sides.append(1 if above else -1 if z < 0 or (z == 0 and v < 0) else 0)
            if sides[-1] and z in (0.0, joint.clearance):
                made[k].append(0.0)
        nodes = np.arange(1, int(until * self.speed / np.radians(10)) + 2) * np.radians(10)
        stops = [t for t in nodes / self.speed if t < until * (1 - 1e-12)] + [until]
        time = 0.0
        for stop in stops:
            longest = min((stop - time) / 4, self.longest_step)
            while time < stop:
                events, what = [], []
                for k, joint in enumerate(self.joints):
                    for face, way in self.faces(joint, sides[k]):
                        events.append(self.event(k, face, way))
                        what.append((k, way, face))
                answer = solve_ivp(
                    self.rates,
                    (time, stop),
                    state,
                    method="DOP853",
                    rtol=tolerance,
                    atol=1e-18,
                    events=events,
                    args=(tuple(sides),),
                    max_step=longest,
                )
                if answer.status == 1 and answer.t[-1] - time < 1e-6 * longest:
                    # a step that leaves a face and comes back finds the event it started from
                    longest /= 4
                    continue
                time, state = float(answer.t[-1]), answer.y[:, -1]
                longest = min((stop - time) / 4, self.longest_step)
                if answer.status != 1:
                    break
                hit = next(k for k, times in enumerate(answer.t_events) if len(times))
                k, way, face = what[hit]
                state[k] = face
                sides[k] += way
                if sides[k]:
                    made[k].append(time)
            time = stop
        return made, state

    @staticmethod
    def faces(joint, side):
        if side > 0:
            return [(joint.clearance, -1)]
        return [(0.0, 1)] if side < 0 else [(joint.clearance, 1), (0.0, -1)]

    @staticmethod
    def event(k, face, way):
        def crosses(time, state, sides):
            return state[k] - face

        crosses.terminal = True
        crosses.direction = way
        return crosses


TURN = 2.0 * np.pi / SPEED


def bounces(mass, joint, force, gap, velocity, count):
    """Times of the first contacts of a mass under a constant force, in 50 digits."""
    with mpmath.workdps(50):
        m, c, k, dc, df = (
            mpmath.mpf(float(v))
            for v in (mass, joint.clearance, joint.stiffness, joint.contact_damping,
                      joint.film_damping)
        )  # fmt: skip
        push, z, v = -mpmath.mpf(force) / m, mpmath.mpf(gap), mpmath.mpf(velocity)
        time, side, made = mpmath.mpf(0), 0, []
        while len(made) < count:
            if side:
                rest = c if side > 0 and joint.law == "continuous" else mpmath.mpf(0)
                level, rate = rest + push * m / k, dc / (2 * m)
                ring = mpmath.sqrt(k / m - rate**2)

                def place(t, z=z, v=v, level=level, rate=rate, ring=ring):
                    a, b = z - level, (v + rate * (z - level)) / ring
                    wave = a * mpmath.cos(ring * t) + b * mpmath.sin(ring * t)
                    return level + mpmath.exp(-rate * t) * wave

                face, horizon = (c if side > 0 else mpmath.mpf(0)), 2 * mpmath.pi / ring
            else:

                def place(t, z=z, v=v, rate=df / m):
                    final = push / rate
                    return z + final * t + (v - final) * (1 - mpmath.exp(-rate * t)) / rate

                horizon = mpmath.mpf(4)
            # scan for the first change, then bisect: no derivative, no guess
            faces = [face] if side else [mpmath.mpf(0), c]
            steps = 400
            early = horizon / steps / 1000
            last, found = early, None
            for j in range(1, steps + 1):
                now = horizon * j / steps
                for face in faces:
                    if (place(last) - face) * (place(now) - face) < 0:
                        found = face
                if found is not None:
                    break
                last = now
            t = mpmath.findroot(
                lambda x, f=found, p=place: p(x) - f, (last, now), solver="anderson", tol=1e-80
            )
            z, v, time = found, mpmath.diff(place, t), time + t
            side = 0 if side else (1 if found == c else -1)
            if side:
                made.append(time)
        return np.array([float(t) for t in made])


@pytest.mark.parametrize(
    "law", [pytest.param("continuous", marks=pytest.mark.long), "full_deflection"]
)
def test_bounces_of_a_damped_mass_against_fifty_digits(law):
    joint = Joint(1e-3, 1e5, 6.0, 0.4, law)
    force, start = 0.03, (2.5e-4, 0.012)
    truth = bounces(1.3, joint, force, *start, 4)
    still = Drive(3.0, np.array([0]), np.array([0.0 + 0j]))
    gas = GasForce(np.array([0.0, np.pi]), np.array([force, force]))
    run = simulate(Linkage(still, gas, 1.3, joint), states(start[:1], start[1:]), 1, 2)
    ours = run.first_contacts[0, 0, :4]
    np.testing.assert_allclose(ours, truth, rtol=2e-14)


SINGLE = [
    ("crank", source_joint(), None, None, 0.15),
    ("crank", source_joint("full_deflection"), None, None, 0.3),
    ("head", source_joint(film_damping=20 * DAMPING), None, None, 0.1),
    ("head", source_joint("full_deflection"), None, None, 0.1),
    ("crank", source_joint(), source_joint(film_damping=0.0), None, 0.08),
    ("head", source_joint("full_deflection"), source_joint(clearance=CLEARANCE / 3), None, 0.04),
    (
        "crank",
        source_joint(),
        source_joint(clearance=CLEARANCE / 3, film_damping=30 * DAMPING),
        source_joint(clearance=2e-3 * INCH, contact_damping=5 * DAMPING),
        0.2,
    ),
]


@pytest.mark.parametrize(
    ("sense", "joint", "crank", "wall", "until"),
    [
        row if place == 3 else pytest.param(*row, marks=pytest.mark.long)
        for place, row in enumerate(SINGLE)
    ],
)
def test_first_contacts_against_another_integrator(sense, joint, crank, wall, until):
    rod = None if crank is None else ROD_MASS
    mass = MASS - (rod or 0.0)
    gap = [1e-6] if crank is None else [1e-6, 2e-6]
    parts = {"mass": mass, "crank_pin": crank, "rod_mass": rod}
    if wall is not None:
        gap = [*gap, 0.5 * float(wall.clearance)]
        parts["bore"] = wall
    run = simulate(source_linkage(sense, joint, **parts), states([gap]), 1, 4)
    other = Reference(RADIUS, LENGTH, SPEED, gas_towards(sense), mass, (joint, crank, wall), rod)
    made, _ = other.contacts(gap, [0.0] * len(gap), until * TURN)
    compared = 0
    for found, times in zip(run.first_contacts[:, 0], made, strict=True):
        count = min(len(times), 8)
        ours = found[:count]
        # the other integrator by itself scatters by some 1e-11 turns between its tolerances
        np.testing.assert_allclose(ours, times[:count], rtol=0, atol=1e-10 * TURN)
        compared += count
    assert compared >= 4


def energy_and_momentum(revolutions, sense, law, **parts):
    start = near(3)
    columns = 1 + ("crank_pin" in parts) + ("bore" in parts)
    gaps = np.tile(start[:, None], (1, columns))
    linkage = source_linkage(sense, source_joint(law), **parts)
    run = simulate(linkage, states(gaps), revolutions, 20)
    assert np.all(run.imbalance < 1e-13)
    assert np.all(run.forces.contacts[0].sum(axis=1) > 20 * revolutions)
    # the piston's momentum over a turn: mean joint force and mean gas force
    gas = gas_towards(sense)
    mean_gas = np.trapezoid(gas.force, gas.angle) / (2 * np.pi)
    axial = run.end_velocity[..., : 1 + ("crank_pin" in parts)].sum(axis=-1)
    change = -np.diff(axial, axis=1) * MASS / TURN
    mean = run.forces.harmonics[0, :, 1:, 0].real
    np.testing.assert_allclose(mean + mean_gas, change, atol=1e-12 * run.forces.peak[0].max())


@pytest.mark.parametrize(
    ("sense", "law"),
    [("crank", "continuous"), pytest.param("head", "full_deflection", marks=pytest.mark.long)],
)
def test_energy_and_momentum_balance(sense, law):
    energy_and_momentum(2, sense, law)


@pytest.mark.long
def test_energy_and_momentum_balance_of_all_three_gaps():
    energy_and_momentum(
        2, "crank", "continuous", crank_pin=source_joint(film_damping=0.0), rod_mass=ROD_MASS,
        bore=source_joint(clearance=2e-3 * INCH),
    )  # fmt: skip


@pytest.mark.long
def test_statistics_of_a_revolution_against_dense_samples():
    samples = 1 << 13
    wide = 4 * CLEARANCE
    joint = source_joint(clearance=wide, contact_damping=DAMPING / 8, film_damping=5 * DAMPING)
    run = simulate(source_linkage(joint=joint), states(near(1)), 1, 100, samples)
    wrist, force = run.forces, run.force[0, 0]
    peak = wrist.peak[0, 0, 0]
    spectrum = np.fft.rfft(force)[:101] * 2 / samples
    spectrum[0] /= 2
    # the force jumps by the damping at contacts, so that samples have an error of one step
    coarse = 1.6e-4 * peak
    assert np.max(np.abs(wrist.harmonics[0, 0, 0] - spectrum)) < coarse
    assert abs(wrist.mean[0, 0, 0] - np.mean(np.abs(force))) < coarse
    assert peak * (1 - 1e-3) < np.max(np.abs(force)) <= peak * (1 + 1e-13)
    gap = run.gap[0, 0]
    touching = (gap < 0.0) | (gap > wide)
    assert abs(wrist.contact_time[0, 0, 0] / TURN - np.mean(touching)) < 1e-3
    assert wrist.contacts[0, 0, 0] == np.count_nonzero(touching[1:] & ~touching[:-1])
    # Parseval: what the kept orders hold cannot exceed the mean square
    kept = np.abs(wrist.harmonics[0, 0, 0]) ** 2
    assert 0.5 * np.mean(force**2) < kept[0] + 0.5 * kept[1:].sum() < np.mean(force**2)

"""A second way through the motion with play: scipy, one run, one smooth piece after the other.

The pin follows the closed form of the slider-crank instead of its harmonics, forces are written
out joint by joint, and events are those of `solve_ivp`.
"""

import numpy as np
from scipy.integrate import solve_ivp

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

"""The pitch model in many digits, from docs/theory_mounts.md, section 1; nothing of the package."""

import mpmath
from exact_parts import body_of, mounts_of, point_inertia
from exact_train import Shaking, cross, frame_of
from mpmath import mpc, mpf

from vibecalc.schema import Case


class PitchTruth:
    """One rotation about the axis across the crankshaft, through the mass centre."""

    def __init__(self, case: Case, shaking: Shaking) -> None:
        frame, body, mounts = frame_of(case), body_of(case), mounts_of(case)
        assert case.isolation is not None
        at_centre = body.inertia - point_inertia(body.mass, body.centre)
        self.inertia = frame.across @ at_centre @ frame.across
        self.place = [(m.position - body.centre) @ frame.axis for m in mounts]
        along = [(m.stiffness, m.damping, m.loss) for m in mounts]
        self.spring, self.damper, self.lag = (
            [frame.stroke @ of[i] @ frame.stroke for of in along] for i in range(3)
        )
        self.stiffness, self.damping, self.loss = (
            sum(k * x**2 for k, x in zip(values, self.place, strict=True))
            for values in (self.spring, self.damper, self.lag)
        )
        self.frequency = mpmath.sqrt(self.stiffness / self.inertia)
        given = case.isolation.lever
        # the cases of this truth give a lever unless all mounts share one distance
        self.lever = mpf(given) if given is not None else abs(self.place[0])
        self.orders = shaking.orders
        about = [
            m - cross(body.centre, f) for f, m in zip(shaking.force, shaking.couple, strict=True)
        ]
        self.couple = [m @ frame.across for m in about]
        #: per crank speed squared, of each order (3,): what turns no body that only pitches
        self.left_out = {
            "force": shaking.force,
            "couple": [m - (m @ frame.across) * frame.across for m in about],
        }
        self.weight = body.mass * mpf(case.isolation.gravity)

    def passing(self, rate: mpf) -> mpc:
        """Couple on the ground per unit angle at an excitation frequency."""
        return mpc(self.stiffness, self.loss + rate * self.damping)

    def resisting(self, rate: mpf) -> mpc:
        """Couple on the body per unit angle."""
        return self.passing(rate) - rate**2 * self.inertia

    def angle(self, speed: mpf) -> list[mpc]:
        """Pitch angle of each order."""
        return [
            speed**2 * c / self.resisting(n * speed)
            for n, c in zip(self.orders, self.couple, strict=True)
        ]

    def row(self, speed: mpf, row: int) -> list[list[mpc]]:
        """Couple over lever (row 0), or force of a mount (from row 1): [component][order]."""
        turned = [(n * speed, q) for n, q in zip(self.orders, self.angle(speed), strict=True)]
        if row == 0:
            return [[self.passing(w) * q / self.lever for w, q in turned]]
        x, k = self.place[row - 1], self.spring[row - 1]
        c, h = self.damper[row - 1], self.lag[row - 1]
        return [[-x * mpc(k, h + w * c) * q for w, q in turned]]

    def rows(self, speed: mpf) -> list[list[list[mpc]]]:
        """All rows."""
        return [self.row(speed, row) for row in range(1 + len(self.place))]

    def sag(self) -> list[mpf]:
        """Way down of each mount: heave z and turn q from force and moment balance."""
        k0 = sum(self.spring)
        k1 = sum(k * x for k, x in zip(self.spring, self.place, strict=True))
        heave = self.weight * self.stiffness / (k0 * self.stiffness - k1**2)
        tilt = -self.weight * k1 / (k0 * self.stiffness - k1**2)
        return [heave + tilt * x for x in self.place]

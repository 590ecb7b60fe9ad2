"""Hard cases of a body on springs: next to and on a resonance, stiff next to soft, underflow.

Ong (2000), chapter 4; his response is P |Y|, which hangs on the sign of every eigenvector.
"""

from collections.abc import Callable
from functools import cache

import mpmath
import numpy as np
import ong_tables as ong
from isolation_machines import Body, random_body
from stability.hard_case import HardCase, Numbers, Way, singular

from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear, dynamics, require_digits, response
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF
from vibecalc.response.energies import energy_by_order, mass_of, velocity
from vibecalc.response.modes import modes
from vibecalc.response.system import MountedBody

FORCE = np.array([1.0, -2.0, 0.5, 0.3, -0.1, 0.7])
ORDER = np.array([1])
#: the compressor's shaking, order 1 to 240, falls by 1e-155
HIGH = np.arange(2, 241, 2)


@cache
def undamped() -> Body:
    body = random_body(7)
    mounts = body.mounts._replace(damping=0.0 * body.mounts.damping)
    mounts = mounts._replace(structural=0.0 * mounts.structural)
    zero = np.zeros((6, 6))
    matrices = body.matrices._replace(
        damping=zero, structural=zero, damping_error=zero, structural_error=zero
    )
    return body._replace(mounts=mounts, matrices=matrices)


def as_stored(matrices: Linear) -> tuple[mpmath.matrix, ...]:
    parts = (matrices.mass, matrices.stiffness, matrices.damping, matrices.structural)
    return tuple(mpmath.matrix(part.tolist()) for part in parts)


def own_response(matrices: Linear, speed: float, force: np.ndarray) -> Bounded:
    """As the stage does it: look for resonances, solve, see what is left of the digits."""
    load = Bounded(force[None].astype(complex), UNIT_ROUNDOFF * np.abs(force)[None])
    body = MountedBody(matrices=matrices, shapes=modes(matrices))
    body.checked(ORDER, speed, print, load)
    system = dynamics(matrices, ORDER * speed)
    motion = response(system, load.value, load.error)
    require_digits(matrices, system, load, motion, ORDER, speed)
    return Bounded(motion.value[0], motion.error[0])


def by_solve(matrices: Linear, speed: float, force: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.solve(matrices.stiffness - speed**2 * matrices.mass, force))


def by_modes(matrices: Linear, speed: float, force: np.ndarray, signs: bool = True) -> np.ndarray:
    """Modal sum; without signs the source's P |Y|."""
    from scipy.linalg import eigh

    square, shape = eigh(matrices.stiffness, matrices.mass)
    swing = (shape.T @ force) / (square - speed**2)
    return np.asarray(shape @ swing if signs else np.abs(shape @ np.abs(swing)))


@cache
def assembled() -> tuple[mpmath.matrix, mpmath.matrix]:
    """Mass as stored, and stiffness of the mounts added up, in long arithmetic."""
    body = undamped()
    total = mpmath.zeros(6)
    for place, block in zip(body.mounts.position, body.mounts.stiffness, strict=True):
        x, y, z = map(mpmath.mpf, place.tolist())
        # displacement of a place: t + r x p
        seen = mpmath.matrix([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]])
        total += seen.T * mpmath.matrix(block.tolist()) * seen
    return mpmath.matrix(body.mass_matrix.tolist()), total


def exact_motion(speed: mpmath.mpf) -> list[mpmath.mpf]:
    mass, stiffness = assembled()
    return list(mpmath.lu_solve(stiffness - speed**2 * mass, mpmath.matrix(FORCE.tolist())))


#: third natural frequency of `undamped()` in rad/s; roundings by which speeds near it differ
NATURAL, STEPS = 173.8644474014703, 3.0 * np.arange(12)


def speeds_nearby(away: float) -> list[float]:
    """Speeds (12,): what one of them loses is luck of the last bits, the worst of many is not."""
    return [float(speed) for speed in NATURAL * (1.0 + away) * (1.0 + STEPS * EPSILON)]


@cache
def truth_of(away: float) -> list[mpmath.mpf]:
    with mpmath.workdps(60):
        return [one for speed in speeds_nearby(away) for one in exact_motion(mpmath.mpf(speed))]


def condition_nearby(away: float) -> float:
    """Of the largest component, by a change of the speed, whose square all stiffness meets."""
    with mpmath.workdps(60):
        speed = mpmath.mpf(speeds_nearby(away)[0])
        here, there = (exact_motion(w) for w in (speed, speed * (1 + mpmath.mpf("1e-20"))))
        most = max(range(6), key=lambda i: abs(here[i]))
        return float(abs((there[most] - here[most]) / here[most]) / 1e-20)


def nearby(away: float) -> HardCase:
    matrices, speeds = undamped().matrices, speeds_nearby(away)

    def own() -> Bounded:
        found = [own_response(matrices, speed, FORCE) for speed in speeds]
        return Bounded(*(np.ravel(part) for part in zip(*found, strict=True)))

    def each(motion: Callable[..., np.ndarray], **how: bool) -> Callable[[], list[np.ndarray]]:
        return lambda: [motion(matrices, speed, FORCE, **how) for speed in speeds]

    return HardCase(
        f"an order {away:g} next to an undamped natural frequency",
        lambda: condition_nearby(away), lambda: truth_of(away), own,
        (Way("numpy.linalg.solve", each(by_solve), loose=True),
         Way("sum of modes from scipy.linalg.eigh", each(by_modes), loose=True),
         Way("P |Y|, as published", each(by_modes, signs=False))),
    )  # fmt: skip


def diagonal() -> Linear:
    """Six freedoms apart from each other; 2 x 100 rad/s is a natural frequency to the last bit."""
    mass, zero = np.diag([2.0, 2.0, 2.0, 0.5, 0.5, 0.5]), np.zeros((6, 6))
    natural = np.array([200.0, 310.0, 420.0, 530.0, 640.0, 750.0])
    return Linear(mass, mass * natural**2, zero, zero, zero, zero, zero, zero)


def on_it() -> HardCase:
    matrices = diagonal()
    return HardCase(
        "an order on an undamped natural frequency", singular, None,
        lambda: own_response(matrices, 200.0, FORCE),
        (Way("sum of modes from scipy.linalg.eigh", lambda: by_modes(matrices, 200.0, FORCE)),
         Way("numpy.linalg.solve, 1 rounding off",
             lambda: by_solve(matrices, 200.0 * (1 + 2**-52), FORCE))),
    )  # fmt: skip


class Motion:
    """The compressor's motion under its piston, orders 2 to 240, taken as exact."""

    def __init__(self) -> None:
        self.matrices = ong.si_matrices()
        swing = -motion_harmonics(ong.RADIUS / ong.LENGTH, int(HIGH[-1]), derivative=2)[HIGH]
        arm = np.array([0.0, 1.0, 0.0, ong.LEVER_A * ong.INCH, 0.0, 0.0])
        force = swing[:, None] * arm
        self.rate = HIGH * ong.SPEED
        self.value = response(dynamics(self.matrices, self.rate), force, 0.0 * np.abs(force)).value


@cache
def motion() -> Motion:
    return Motion()


def own_energy() -> Bounded:
    one = motion()
    state = velocity(Bounded(one.value, np.zeros(one.value.shape)), one.rate)
    return energy_by_order(mass_of(one.matrices), state).mean


def plain_energy() -> np.ndarray:
    one = motion()
    state = one.rate[:, None] * one.value
    return np.asarray([0.25 * (v.conj() @ one.matrices.mass @ v).real for v in state])


@cache
def true_energy() -> Numbers:
    one = motion()
    with mpmath.workdps(40):
        mass = mpmath.matrix(one.matrices.mass.tolist())
        found = []
        for n, row in zip(HIGH.tolist(), one.value, strict=True):
            v = mpmath.matrix([mpmath.mpc(complex(x)) * n * mpmath.mpf(ong.SPEED) for x in row])
            found.append((v.H * mass * v)[0].real / 4)
        # below the smallest double there is none
        return [x if x > 1e-323 else mpmath.mpf(0) for x in found]


def stiff_matrices() -> Linear:
    """One skewed direction 1e10 times as stiff as the others."""
    body = undamped()
    along = np.array([1.0, 2.0, -1.0, 0.3, 0.2, -0.5])
    extra = 1e10 * float(np.max(body.matrices.stiffness)) * np.outer(along, along)
    stiffness = body.matrices.stiffness + 0.5 * (extra + extra.T)
    rounding = UNIT_ROUNDOFF * np.abs(stiffness)
    return body.matrices._replace(stiffness=stiffness, stiffness_error=rounding)


def true_frequencies(matrices: Linear) -> list[mpmath.mpf]:
    with mpmath.workdps(60):
        mass, stiffness = as_stored(matrices)[:2]
        inverse = mpmath.inverse(mpmath.cholesky(mass))
        square = mpmath.eigsy(inverse * stiffness * inverse.T, eigvals_only=True)
        return [mpmath.sqrt(one) for one in square]


def own_frequencies(matrices: Linear) -> Bounded:
    return modes(matrices).bounded_frequency


def by_eigh(matrices: Linear) -> np.ndarray:
    from scipy.linalg import eigh

    return np.sqrt(np.maximum(eigh(matrices.stiffness, matrices.mass, eigvals_only=True), 0.0))


def by_eig(matrices: Linear) -> np.ndarray:
    square = np.linalg.eigvals(np.linalg.solve(matrices.mass, matrices.stiffness))
    return np.sqrt(np.maximum(np.sort(square.real), 0.0))


def entry_condition(matrices: Linear) -> float:
    """Of the worst frequency, by the entries of the matrices: sum |v| |dK| |v| / 2 w^2."""
    found = modes(matrices)
    size = np.abs(found.shape)
    stiff = np.sum(size * (np.abs(matrices.stiffness) @ size), axis=0)
    heavy = np.sum(size * (np.abs(matrices.mass) @ size), axis=0)
    return float(np.max(0.5 * (stiff / found.eigenvalue + heavy)))


def modes_case(name: str, matrices: Linear) -> HardCase:
    return HardCase(
        name, lambda: entry_condition(matrices),
        lambda: true_frequencies(matrices), lambda: own_frequencies(matrices),
        (Way("scipy.linalg.eigh(K, M)", lambda: by_eigh(matrices), loose=True),
         Way("eigenvalues of M^-1 K", lambda: by_eig(matrices), loose=True)),
    )  # fmt: skip


def cases() -> tuple[HardCase, ...]:
    return (
        nearby(1e-7),
        nearby(1e-9),
        on_it(),
        HardCase(
            "energies of orders 2 to 240, to 1e-320 and below", lambda: 2.0,
            true_energy, own_energy,
            (Way("v* M v / 4 in plain floats", plain_energy),),
        ),
        modes_case("a mount 1e10 times as stiff along one skewed direction", stiff_matrices()),
    )  # fmt: skip

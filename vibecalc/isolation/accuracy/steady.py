"""Accuracy of the largest force of a support over the cycle at operating speed."""

import numpy as np

from vibecalc.core.accuracy.topic import Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import about_point, as_loads
from vibecalc.isolation.adapters.common import LARGEST, isolation_of
from vibecalc.isolation.model import pitch_parts
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.matrices import Matrices
from vibecalc.parts.matrices import assemble, displacement_at
from vibecalc.response.accuracy.forced import (
    Mounted,
    by_shooting,
    from_rest,
    read,
    solved,
    solved_exactly,
)
from vibecalc.response.forced import dynamics, response

# ----------------------------------------------------------------------------
# The body of `[isolation]` as plain arrays, read at one of its supports.
# ----------------------------------------------------------------------------


def support_of(scene: Scene, mount: int) -> Mounted:
    """What shakes the body, and the force of one support on the ground, for either model.

    Loads are those of all orders that the excitation has handed on, guard orders included.
    """
    forcing: Forcing = scene.handed_on["forcing"]
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    if isolation_of(scene).model == "pitch":
        train = scene.case.machine.crank_train
        parts = pitch_parts(body, mounts, train.axis, train.stroke)
        couple = about_point(forcing.per_speed_squared, parts.centre).couple @ parts.across
        square = np.square(parts.position)
        stiffness, damping, structural = (
            np.array([[square @ part]])
            for part in (parts.stiffness, parts.damping, parts.structural)
        )
        lever = -parts.position[mount]
        spring = parts.stiffness[mount] + 1j * parts.structural[mount]
        return Mounted(
            np.array([[parts.inertia]]),
            stiffness,
            damping,
            structural,
            couple[:, None],
            forcing.orders,
            np.array([[spring * lever]]),
            np.array([[parts.damping[mount] * lever]]),
        )
    matrices = assemble(
        body.mass_matrix, mounts.position, mounts.stiffness, mounts.damping, mounts.structural
    )
    there = displacement_at(mounts.position[mount])
    load = as_loads(forcing.per_speed_squared)
    # what is zero to rounding would drive what it does not
    value = np.where(np.abs(load.value) > load.error, load.value, 0.0)
    return Mounted(
        matrices.mass,
        matrices.stiffness,
        matrices.damping,
        matrices.structural,
        value,
        forcing.orders,
        (mounts.stiffness[mount] + 1j * mounts.structural[mount]) @ there,
        mounts.damping[mount] @ there,
    )


# ----------------------------------------------------------------------------
# Topics of the isolation: the largest force of a support over the cycle at operating speed.
# ----------------------------------------------------------------------------

STEPS = (16.0, 32.0, 64.0, 128.0, 256.0)
TURNS = (4.0, 16.0, 64.0, 256.0)
RTOL = 1e-8
#: of the sum of all loads, what stands clear of rounding
SEEN = 1e-16


def isolation_steady_topics(scene: Scene) -> list[Topic]:
    """The peak at the support that has the largest one; none where nothing shakes."""
    peaks = scene.record[LARGEST].values
    which = int(np.argmax(peaks))
    body = support_of(scene, which)
    if not peaks[which] > 0.0 or not np.any(body.load):
        return []
    forcing: Forcing = scene.handed_on["forcing"]
    name = scene.parts.mounts.names[which] if scene.parts.mounts else ""
    return [_topic(body, forcing.retained, scene.case.machine.speed, name)]


def peak_of(body: Mounted, amplitudes: np.ndarray, speed: float) -> float:
    """Largest length of what is read over the cycle."""
    harmonics = read(body, amplitudes, speed)
    return float(vector_cycle_peak(harmonics, body.orders).value)


def _topic(body: Mounted, kept: int, speed: float, name: str) -> Topic:
    everything, guards = len(body.orders), len(body.orders) - kept
    zero = np.zeros(body.mass.shape)
    matrices = Matrices(*body[:4], zero, zero, zero, zero)

    def harmonic(count: float) -> Answer:
        part = body.first(int(count))
        load = speed * speed * part.load
        found = response(dynamics(matrices, part.orders * speed), load, 0.0 * np.abs(load))
        return Answer(np.array([peak_of(part, found.value, speed)]), count + guards)

    def looped(count: float) -> Answer:
        part = body.first(int(count))
        return Answer(np.array([peak_of(part, solved(part, speed), speed)]), count)

    def shooting(steps: float) -> Answer:
        part = body.first(kept)
        amplitudes, work = by_shooting(part, speed, int(steps))
        return Answer(np.array([peak_of(part, amplitudes, speed)]), work)

    def marched(turns: float) -> Answer:
        part = body.first(kept)
        amplitudes, work = from_rest(part, speed, int(turns), RTOL)
        return Answer(np.array([peak_of(part, amplitudes, speed)]), work)

    counts = tuple(
        float(x) for x in sorted({1, 2, 4, 6, 8, 12, 16, 24, 40, kept}) if x <= everything
    )
    solvers = [
        Solver(
            "orders at once",
            "dynamic stiffness of N orders inverted together, with guard orders for the error",
            "orders",
            counts,
            harmonic,
            default=float(kept),
            theory="geometric",
            citation="Harris and Piersol (2002), ch. 3",
        ),
        Solver(
            "loop of solutions",
            "numpy.linalg.solve for one order after the other",
            "orders",
            counts,
            looped,
            theory="geometric",
        ),
    ]
    if body.lasts:
        solvers += [
            Solver(
                "RK4 shooting",
                "classical Runge-Kutta over one turn, the start that repeats itself solved for",
                "steps per turn",
                STEPS,
                shooting,
                theory="order 4",
            ),
            Solver(
                "DOP853 from rest",
                f"scipy from rest at rtol {RTOL:g}, the last of N turns read",
                "turns",
                TURNS,
                marched,
                theory="as the free motion dies away",
            ),
        ]
    # a method without an error estimate needs no more orders than are kept, nor those at rounding
    least = min(_least_orders(body), kept)
    return Topic(
        stage="isolation",
        name="largest support force",
        words=f"peak over the cycle of the force of support {name!r} at {speed:.6g} rad/s",
        quantity=LARGEST,
        unit="N",
        work="solutions of, or products with, the system's matrices",
        reference=lambda: _reference(body, speed),
        solvers=tuple(solvers),
        default_extra=float(np.ceil(10.0 * (kept + guards) / least) / 10.0),
        default_why=f"{guards} guard orders are solved for the error estimate, since a resonance "
        "may raise what is left out, and orders without a load or below rounding with the others",
    )


def _least_orders(body: Mounted) -> int:
    """Orders after which all further loads together are below rounding."""
    size = np.abs(body.load).sum(axis=1)
    rest = np.cumsum(size[::-1])[::-1]
    return max(int(np.sum(rest > SEEN * rest[0])) // 2, 1)


def _reference(body: Mounted, speed: float) -> Reference:
    exact = peak_of(body, solved_exactly(body, speed), speed)
    other = peak_of(body, solved(body, speed), speed)
    agreement = abs(other / exact - 1.0)
    return Reference(
        np.array([exact]),
        agreement,
        f"{len(body.orders)} orders solved in 34 digits (mpmath), agrees with numpy.linalg.solve "
        f"to {agreement:.1e}",
    )

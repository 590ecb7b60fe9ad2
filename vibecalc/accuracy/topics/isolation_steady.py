"""Topics of the isolation: the largest force of a support over the cycle at operating speed."""

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.mounted import (
    Mounted,
    by_shooting,
    from_rest,
    read,
    solved,
    solved_exactly,
)
from vibecalc.accuracy.yardsticks.mounted_isolation import support_of
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.excitation import Forcing
from vibecalc.pipeline.stages.isolation_common import LARGEST
from vibecalc.response.direct import dynamics, response
from vibecalc.response.matrices import Matrices

STEPS = (16.0, 32.0, 64.0, 128.0, 256.0)
TURNS = (4.0, 16.0, 64.0, 256.0)
RTOL = 1e-8
#: of the sum of all loads, what stands clear of rounding
SEEN = 1e-16


def topics(scene: Scene) -> list[Topic]:
    """The peak at the support that has the largest one; none where nothing shakes."""
    peaks = scene.record[LARGEST].values
    which = int(np.argmax(peaks))
    body = support_of(scene, which)
    if not peaks[which] > 0.0 or not np.any(body.load):
        return []
    forcing: Forcing = scene.handed_on["forcing"]
    name = scene.parts.mounts.names[which] if scene.parts.mounts else ""
    return [_topic(body, forcing.kept, scene.case.machine.speed, name)]


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
    ladders = [
        Ladder(
            "orders at once",
            "dynamic stiffness of N orders inverted together, with guard orders for the error",
            "orders",
            counts,
            harmonic,
            default=float(kept),
            theory="geometric",
            citation="Harris and Piersol (2002), ch. 3",
        ),
        Ladder(
            "loop of solutions",
            "numpy.linalg.solve for one order after the other",
            "orders",
            counts,
            looped,
            theory="geometric",
        ),
    ]
    if body.lasts:
        ladders += [
            Ladder(
                "RK4 shooting",
                "classical Runge-Kutta over one turn, the start that repeats itself solved for",
                "steps per turn",
                STEPS,
                shooting,
                theory="order 4",
            ),
            Ladder(
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
        ladders=tuple(ladders),
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

"""What the orders left out are worth: half ranges of an engine's sections from all orders."""

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.fourier_samples import samples_of_harmonics, transform_work
from vibecalc.accuracy.yardsticks.shaft_cycles import (
    half_ranges_of_samples,
    is_even,
    on_freedoms,
    station_torque,
    steady_by_steps,
)
from vibecalc.accuracy.yardsticks.shaft_lines import dense_angles
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.curves import stiffness_of
from vibecalc.pipeline.stages.torsion.drive import build_drive
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.forced import forced_masked
from vibecalc.response.torsion.synthesis import synthesis

#: orders of the trusted answer, in steps of the cycle
MANY = 800
SAMPLES = (32.0, 64.0, 128.0, 256.0, 512.0, 1024.0)
STEPS = (144.0, 288.0, 720.0, 1440.0, 2880.0)
#: samples of the second way to the trusted answer, and of a highest value without synthesis
FINEST = 1 << 15


def orders_left_out(scene: Scene, setup: Setup) -> list[Topic]:
    """None where cylinders misfire or differ, and where no dashpots or stiffnesses are at hand."""
    line = setup.model.at(setup.speed)
    if not is_even(scene, setup) or setup.model.modal is not None or not line.inertia.all():
        return []
    if np.any(setup.model.speed_stiffness):
        return []
    step = float(setup.drive.order[0])
    taken, n = len(setup.drive.order), len(line.inertia)
    kept = sorted({6.0, 12.0, 24.0, float(taken), 48.0, 96.0, 192.0})
    known: dict[int, tuple[FloatArray, ComplexArray]] = {}

    def loads(count: int) -> tuple[FloatArray, ComplexArray]:
        """Orders (m,) and torques (m, n), the first of what is known once."""
        if MANY not in known:
            drive = build_drive(scene.case, setup.shaft, orders=(step * MANY, step))
            own = drive.torque(np.array([setup.speed]))[0]
            known[MANY] = drive.order, on_freedoms(setup, own, drive)
        order, torque = known[MANY]
        return order[:count], torque[:count]

    def summed(order: FloatArray, torque: ComplexArray) -> FloatArray:
        w = setup.speed * order
        angle = forced_masked(line, w, torque, estimate=False).angle
        twist = angle[:, line.first] - angle[:, line.second]
        return synthesis(order, (stiffness_of(line, w) * twist).T).half_range

    def orders(count: float) -> Answer:
        return Answer(summed(*loads(int(count))), _work(n, int(count)))

    def sampled(number: float) -> Answer:
        order, torque = _of_samples(setup, int(number), step)
        return Answer(summed(order, torque), _work(n, len(order)))

    def marched(number: float) -> Answer:
        found = steady_by_steps(
            line, station_torque(setup, setup.speed), setup.speed, setup.drive.firing.cycle,
            int(number),
        )  # fmt: skip
        return Answer(half_ranges_of_samples(found.torque.T), found.work)

    def reference() -> Reference:
        many = summed(*loads(MANY))
        order, torque = _of_samples(setup, FINEST, step)
        order, torque = order[: 2 * MANY], torque[: 2 * MANY]
        w = setup.speed * order
        angle = dense_angles(line, w, torque)
        rows = stiffness_of(line, w) * (angle[:, line.first] - angle[:, line.second])
        values = samples_of_harmonics(rows.T, np.arange(1, len(order) + 1), FINEST)
        other = half_ranges_of_samples(values)
        away = float(np.max(np.abs(many - other)) / np.max(np.abs(many)))
        return Reference(
            many, away, f"{MANY} orders by quadrature, held against {2 * MANY} orders of "
            f"{FINEST} samples, solved as full matrices",
        )  # fmt: skip

    ladders = (
        Ladder(
            "orders kept", "of exact harmonics", "orders", tuple(kept), orders,
            default=float(taken),
        ),
        Ladder(
            "samples", "Fourier transform of the torques at even angles, all its orders", "angles",
            SAMPLES, sampled, theory="order 2",
        ),
        Ladder(
            "steps in time", "RK4 over a cycle and the state that comes back", "steps", STEPS,
            marched, theory="order 3 to 4, but for the corners of the card",
        ),
    )  # fmt: skip
    return [
        Topic(
            "torsion", "orders left out",
            "half range of the torque of all sections from all orders of the cylinders, whose "
            "torques are given",
            "response/torsion/torque_half_range", "N*m", "complex multiplications", reference,
            ladders,
            default_extra=4.0,
            default_why="the case asks for so many orders, whatever its card is like",
        )
    ]  # fmt: skip


def _of_samples(setup: Setup, count: int, step: float) -> tuple[FloatArray, ComplexArray]:
    """Orders (m,) and torques (m, n) below half of the samples."""
    cycle = setup.drive.firing.cycle
    values = station_torque(setup, setup.speed)(cycle * np.arange(count) / count)
    torque = np.fft.rfft(values, axis=0)[1 : count // 2] * (2.0 / count)
    return np.asarray(step * np.arange(1, count // 2)), torque


def _work(n: int, orders: int) -> float:
    """Elimination at each order and the sum over the cycle in each of about n sections."""
    return 6.0 * n * orders + n * (transform_work(8 * orders) + 32.0 * orders)

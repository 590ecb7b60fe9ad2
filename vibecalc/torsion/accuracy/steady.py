"""Accuracy of torques at the operating speed: by order, over a cycle, orders left out."""

import numpy as np

from vibecalc.core.accuracy.other_integrators import (
    harmonics_of_samples,
    samples_of_harmonics,
    transform_work,
)
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import _panels, gas_harmonics
from vibecalc.excitation.gas_tables import GasCard
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, ComplexArray, FloatArray
from vibecalc.torsion.accuracy.by_other_means import (
    cylinder_gas,
    dense_angles,
    exact_angles,
    exact_highest,
    fejer_rule,
    half_ranges_of_samples,
    is_even,
    modal_angles,
    on_freedoms,
    pole_angles,
    quadrature_harmonics,
    station_torque,
    steady_by_steps,
    through_three,
    transfer_angles,
)
from vibecalc.torsion.adapters.setup import Setup, build_drive, build_setup
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, complex_stiffness
from vibecalc.torsion.synthesis import DEGREE, cycle_of, synthesis

# ----------------------------------------------------------------------------
# Torques in all sections of a shaft line at its speed: elimination, matrices, modes, poles.
# ----------------------------------------------------------------------------

#: lines longer than this are taken with their first orders only
ORDERS_OF_LONG, LONG = 12, 16


def torsion_forced_topics(scene: Scene) -> list[Topic]:
    """None where damping is given by mode: the equations of motion then have no matrix for it."""
    setup = build_setup(scene.case)
    if by_modes_refused(setup):
        return []
    line = setup.model.at(setup.speed)
    n = len(line.inertia)
    w, torque = orders_and_torque(setup, ORDERS_OF_LONG if n > LONG else None)
    m = len(w)
    if not line.inertia.all():
        solvers = _by_matrices(setup, line, w, torque)
    else:
        solvers = (*_by_matrices(setup, line, w, torque), *_by_modes(setup, line, w, torque))
    if setup.model.modal is not None:
        extra, why = 5.0, "the case asks for a sum over modes"
    elif setup.model.method == "dense":
        extra, why = 6.0 + n**2 / 6.0, "the case asks for full matrices with pivoting"
    else:
        extra, why = 3.0, "no loss of digits in long, stiff lines; an error bound at each order"
    where = f"torques of all sections at {m} orders and {setup.speed:.6g} rad/s"
    return [
        Topic(
            "torsion", "torques by order", where, "response/torsion/torque", "N*m",
            "complex multiplications",
            lambda: Reference(
                section_torques(line, w, exact_angles(line, w, torque)), UNIT_ROUNDOFF,
                "the equations of motion in 40 digits",
            ),
            solvers,
            default_extra=extra,
            default_why=why,
        )
    ]  # fmt: skip


def by_modes_refused(setup: Setup) -> bool:
    """Whether damping is given by mode, for which no matrix is at hand."""
    damping = setup.torsion.damping_model
    return damping is not None and damping.kind == "modal"


def orders_and_torque(setup: Setup, count: int | None = None) -> tuple[FloatArray, ComplexArray]:
    """Frequencies (m,) in rad/s and torques (m, n) on all freedoms at the operating speed."""
    drive = setup.drive
    own = drive.torque(np.array([setup.speed]))[0][:count]
    return setup.speed * drive.order[:count], on_freedoms(setup, own)


def section_torques(line: Line, w: FloatArray, angle: ComplexArray) -> ComplexArray:
    """Torques (m, e) of the elements from angles (m, n)."""
    return np.asarray(complex_stiffness(line, w) * (angle[:, line.first] - angle[:, line.second]))


def _by_matrices(
    setup: Setup, line: Line, w: FloatArray, torque: ComplexArray
) -> tuple[Solver, ...]:
    n, m = len(line.inertia), len(w)
    method = setup.model.method if setup.model.modal is None else "modal"

    def of(angle: ComplexArray, work: float) -> Answer:
        return Answer(section_torques(line, w, angle), work * m)

    def kernel(dense: bool, estimate: bool, work: float) -> Answer:
        found = forced_masked(line, w, torque, dense=dense, estimate=estimate)
        return of(found.angle, work)

    return (
        Solver(
            "elimination", "along the line, with its error bound", "", NOTHING_TO_SET,
            lambda _: kernel(False, True, 10.0 * n),
            default=1.0 if method == "elimination" else None,
        ),
        Solver(
            "elimination alone", "the same without the bound", "", NOTHING_TO_SET,
            lambda _: kernel(False, False, 6.0 * n),
        ),
        Solver(
            "inverse", "full matrix with pivoting, one step of refinement, error bound", "",
            NOTHING_TO_SET, lambda _: kernel(True, True, n**3 + 5.0 * n**2),
            default=1.0 if method == "dense" else None,
        ),
        Solver(
            "full matrix", "numpy.linalg.solve at each order", "", NOTHING_TO_SET,
            lambda _: of(dense_angles(line, w, torque), n**3 / 3.0 + n**2),
        ),
        Solver(
            "transfer matrices", "2 x 2, from one end of a row to the other", "", NOTHING_TO_SET,
            lambda _: of(transfer_angles(line, w, torque), 4.0 * n),
            citation="Pestel and Leckie 1963",
        ),
    )  # fmt: skip


def _by_modes(setup: Setup, line: Line, w: FloatArray, torque: ComplexArray) -> tuple[Solver, ...]:
    n, m, modes = len(line.inertia), len(w), setup.modes
    count = len(modes.frequency)
    kept = np.unique(np.linspace(min(2, count), count, min(count, 7)).astype(int))

    def summed(number: float) -> Answer:
        angle = modal_angles(line, modes, int(number), w, torque)
        # the modes themselves in real multiplications, four to a complex one
        return Answer(section_torques(line, w, angle), 2.5 * n**3 + m * number * (2.0 * n + 1.0))

    def poles(_: float) -> Answer:
        angle = pole_angles(line, w, torque)
        return Answer(section_torques(line, w, angle), 12.5 * (2 * n) ** 3 / 4.0 + m * 4.0 * n**2)

    return (
        Solver(
            "sum over modes", "undamped modes; what damping couples them by is left out",
            "modes", tuple(float(one) for one in kept), summed,
            default=None if setup.model.modal is None else float(count),
        ),
        Solver("state matrix", "eigenvalues and vectors with dashpots", "", NOTHING_TO_SET,
                   poles),
    )  # fmt: skip


# ----------------------------------------------------------------------------
# Over a cycle of an engine: harmonics of a cylinder, sums of orders, and orders left out.
# ----------------------------------------------------------------------------

POINTS = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
#: angles of a cycle: whole degrees, as cards are printed, and powers of two
DEGREES = (72.0, 144.0, 360.0, 720.0, 1440.0, 2880.0, 7200.0)
ANGLES = (64.0, 256.0, 1024.0, 4096.0, 16384.0, 65536.0)
#: cells about a maximum that a sum of orders examines, on average
CELLS = 2.0


def torsion_cycle_topics(scene: Scene) -> list[Topic]:
    """Harmonics of the gas torque where there is one, half ranges of all sections."""

    setup = build_setup(scene.case)
    gas = setup.drive.healthy(setup.speed).gas
    found = [_cylinder(setup)] if np.any(gas) else []
    found.append(_half_ranges(setup))
    return found + orders_left_out(scene, setup)


def _cylinder(setup: Setup) -> Topic:
    drive, order, cycle = setup.drive, setup.drive.order, setup.drive.firing.cycle
    torque = cylinder_gas(drive, setup.speed)
    first = min(float(card.node[0]) for card in drive.cards)
    nodes = np.concatenate([first + np.mod(card.node - first, cycle) for card in drive.cards])
    border = np.append(np.unique(np.round(nodes, 13)), first + cycle)
    border = border[np.append(np.diff(border) > 1e-12, True)]

    def kernel(_: float) -> Answer:
        share = drive.weights(np.asarray(setup.speed))
        each = [gas_harmonics(card, drive.geometry, order)[0].value for card in drive.cards]
        return Answer(share @ np.array(each), float(sum(map(_evaluations, drive.cards))))

    def _evaluations(card: GasCard) -> int:
        width = _panels(card, drive.geometry, float(order[-1]))[1]
        degree = card.coefficient.shape[1] - 1
        points = np.ceil(15.0 + 0.34 * order[-1] * width.max() + 0.5 * degree)
        return len(width) * int(points)

    def panels(points: float) -> Answer:
        rule = gauss_rule(int(points))
        found, count = quadrature_harmonics(
            torque, border, cycle, order, (rule.nodes, rule.weights)
        )
        return Answer(found, float(count))

    def sampled(count: float) -> Answer:
        values = torque(np.asarray(cycle * np.arange(int(count)) / count))
        place = np.rint(order * cycle / (2.0 * np.pi)).astype(int)
        return Answer(harmonics_of_samples(values, int(place[-1]))[place], count)

    def reference() -> Reference:
        found = quadrature_harmonics(torque, border, cycle, order, fejer_rule(48))[0]
        rule = gauss_rule(24)
        other = quadrature_harmonics(torque, border, cycle, order, (rule.nodes, rule.weights))[0]
        return Reference(
            found, apart(found, other), "Fejer's rule of 48 points on each piece of the card, "
            "held against Gauss' of 24",
        )  # fmt: skip

    straight = all(card.coefficient.shape[1] == 2 for card in drive.cards)
    theory = "order 2" if straight else ""
    solvers = (
        Solver(
            "bounded panels", "Gauss points enough for a proof", "", NOTHING_TO_SET, kernel,
            default=1.0, citation="Trefethen 2013, theorem 19.3",
        ),
        Solver(
            "Gauss", "on each piece of the card", "points in a piece", POINTS, panels,
            theory="geometric",
        ),
        Solver(
            "samples", "Fourier transform of the torque at even angles", "angles", DEGREES, sampled,
            theory=theory,
        ),
        Solver(
            "samples, powers of two", "the same next to the points of the card", "angles", ANGLES,
            sampled, theory=theory,
        ),
    )  # fmt: skip
    return Topic(
        "torsion", "gas torque of a cylinder",
        f"harmonics of the gas torque at {len(order)} orders", "response/torsion/excitation/gas",
        "N*m", "angles at which pressure and piston speed are evaluated", reference, solvers,
        default_extra=4.0,
        default_why="points enough for any card and order, by a bound; once for all speeds",
    )  # fmt: skip


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference over the largest magnitude."""
    return float(np.max(np.abs(one - other)) / np.max(np.abs(one)))


def _half_ranges(setup: Setup) -> Topic:
    line = setup.model.at(setup.speed)
    w, load = orders_and_torque(setup)
    found = forced_masked(line, w, load)
    rows = section_torques(line, w, found.angle).T
    order = setup.drive.order
    turns = setup.drive.firing.cycle / (2.0 * np.pi)
    place = np.rint(order * turns).astype(int)
    whole = synthesis(order, rows)
    worst = int(np.argmax(whole.half_range))
    count, e = len(order), len(rows)

    def kernel(_: float) -> Answer:
        seen = synthesis(order, rows)
        cells = 2.0 * CELLS * (count + 0.5 * count * (DEGREE + 1))
        work = transform_work(cycle_of(tuple(place.tolist())).samples) + cells
        return Answer(seen.half_range, e * work, float(seen.highest_angle[worst]))

    def grid(number: float) -> Answer:
        values = samples_of_harmonics(rows, place, int(number))
        at = float(np.argmax(values[worst])) * 2.0 * np.pi * turns / number
        half = 0.5 * (values.max(axis=1) - values.min(axis=1))
        return Answer(half, e * transform_work(int(number)), at)

    def parabola(number: float) -> Answer:
        values = samples_of_harmonics(rows, place, int(number))
        high, at = through_three(values)
        low, _ = through_three(-values)
        step = 2.0 * np.pi * turns / number
        return Answer(0.5 * (high + low), e * transform_work(int(number)), float(at[worst] * step))

    def reference() -> Reference:
        high, at = exact_highest(rows, place)
        low, _ = exact_highest(-rows, place)
        return Reference(
            0.5 * (high + low), 2.0**-53,
            "Newton's method on the slope in 30 digits, from the best of 32768 samples",
            float(at[worst] * turns),
        )  # fmt: skip

    solvers = (
        Solver(
            "cells", "samples, then Taylor polynomials where the maximum may be", "",
            NOTHING_TO_SET, kernel, default=1.0,
        ),
        Solver("grid", "the best of even angles", "angles", ANGLES, grid, theory="order 2"),
        Solver(
            "grid with parabola", "through the best angle and its neighbours", "angles", ANGLES,
            parabola, theory="order 3",
        ),
        Solver(
            "sum of magnitudes", "all orders at their highest together", "", NOTHING_TO_SET,
            lambda _: Answer(np.abs(rows).sum(axis=1), float(e * count)),
        ),
    )  # fmt: skip
    return Topic(
        "torsion", "half ranges over the cycle",
        f"half range of the torque of all {e} sections from {count} orders at "
        f"{setup.speed:.6g} rad/s",
        "response/torsion/torque_half_range", "N*m", "complex multiplications", reference,
        solvers,
        position=f"crank angle of the highest torque of section {worst + 1} [rad]",
    )  # fmt: skip


# ----------------------------------------------------------------------------
# What the orders left out are worth: half ranges of an engine's sections from all orders.
# ----------------------------------------------------------------------------

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
        return synthesis(order, (complex_stiffness(line, w) * twist).T).half_range

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
        rows = complex_stiffness(line, w) * (angle[:, line.first] - angle[:, line.second])
        values = samples_of_harmonics(rows.T, np.arange(1, len(order) + 1), FINEST)
        other = half_ranges_of_samples(values)
        away = float(np.max(np.abs(many - other)) / np.max(np.abs(many)))
        return Reference(
            many, away, f"{MANY} orders by quadrature, held against {2 * MANY} orders of "
            f"{FINEST} samples, solved as full matrices",
        )  # fmt: skip

    solvers = (
        Solver(
            "orders kept", "of exact harmonics", "orders", tuple(kept), orders,
            default=float(taken),
        ),
        Solver(
            "samples", "Fourier transform of the torques at even angles, all its orders", "angles",
            SAMPLES, sampled, theory="order 2",
        ),
        Solver(
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
            solvers,
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

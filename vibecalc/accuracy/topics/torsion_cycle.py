"""Over a cycle of an engine: harmonics of a cylinder, sums of orders, and orders left out."""

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.topics.torsion_forced import orders_and_torque, section_torques
from vibecalc.accuracy.yardsticks.fourier_samples import (
    harmonics_of_samples,
    samples_of_harmonics,
    transform_work,
)
from vibecalc.accuracy.yardsticks.shaft_cycles import (
    cylinder_gas,
    exact_highest,
    fejer_rule,
    quadrature_harmonics,
    through_three,
)
from vibecalc.excitation.cylinder_torque import _panels, gas_harmonics
from vibecalc.excitation.gas_card import GasCard
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup, build_setup
from vibecalc.response.torsion.forced import forced_masked
from vibecalc.response.torsion.synthesis import synthesis
from vibecalc.response.torsion.synthesis_cells import DEGREE, cycle_of

POINTS = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
#: angles of a cycle: whole degrees, as cards are printed, and powers of two
DEGREES = (72.0, 144.0, 360.0, 720.0, 1440.0, 2880.0, 7200.0)
ANGLES = (64.0, 256.0, 1024.0, 4096.0, 16384.0, 65536.0)
#: cells about a maximum that a sum of orders looks at, on average
CELLS = 2.0


def topics(scene: Scene) -> list[Topic]:
    """Harmonics of the gas torque where there is one, half ranges of all sections."""
    from vibecalc.accuracy.topics.torsion_cycle_orders import orders_left_out

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
    ladders = (
        Ladder(
            "bounded panels", "Gauss points enough for a proof", "", NOTHING_TO_SET, kernel,
            default=1.0, citation="Trefethen 2013, theorem 19.3",
        ),
        Ladder(
            "Gauss", "on each piece of the card", "points in a piece", POINTS, panels,
            theory="geometric",
        ),
        Ladder(
            "samples", "Fourier transform of the torque at even angles", "angles", DEGREES, sampled,
            theory=theory,
        ),
        Ladder(
            "samples, powers of two", "the same beside the points of the card", "angles", ANGLES,
            sampled, theory=theory,
        ),
    )  # fmt: skip
    return Topic(
        "torsion", "gas torque of a cylinder",
        f"harmonics of the gas torque at {len(order)} orders", "response/torsion/excitation/gas",
        "N*m", "angles at which pressure and piston speed are evaluated", reference, ladders,
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

    ladders = (
        Ladder(
            "cells", "samples, then Taylor polynomials where the maximum may be", "",
            NOTHING_TO_SET, kernel, default=1.0,
        ),
        Ladder("grid", "the best of even angles", "angles", ANGLES, grid, theory="order 2"),
        Ladder(
            "grid with parabola", "through the best angle and its neighbours", "angles", ANGLES,
            parabola, theory="order 3",
        ),
        Ladder(
            "sum of magnitudes", "all orders at their highest together", "", NOTHING_TO_SET,
            lambda _: Answer(np.abs(rows).sum(axis=1), float(e * count)),
        ),
    )  # fmt: skip
    return Topic(
        "torsion", "half ranges over the cycle",
        f"half range of the torque of all {e} sections from {count} orders at "
        f"{setup.speed:.6g} rad/s",
        "response/torsion/torque_half_range", "N*m", "complex multiplications", reference, ladders,
        position=f"crank angle of the highest torque of section {worst + 1} [rad]",
    )  # fmt: skip

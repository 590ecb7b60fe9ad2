"""Hard cases of shaft lines: long rows, uneven stiffness, rigid modes, resonances.

Baca Vasquez (2007), chapter 4, and the rows that the 2 x 2 transfer matrix of Holzer does not
survive: uniform, alternating 1 and 1e6, graded 1 to 1e6, two halves joined by 1e-6.
"""

from functools import cache
from typing import Any

import numpy as np
from exact_shaft_line import exact_angles
from mpmath import mp, mpf
from stability.hard_case import HardCase, Numbers, Way, singular
from torsion_lines import engine, exact_count, hard_chain, star

from vibecalc.numerics.bounded import Bounded
from vibecalc.torsion.forced import forced
from vibecalc.torsion.line import Line, dynamic_stiffness, stiffness_matrix
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.modes_of_tree import riccati_frequencies

COUNT = 200
#: modes that are examined: the lowest elastic, the middle, the highest
LOOKED = (1, COUNT // 2, COUNT - 1)


@cache
def line_of(name: str) -> Line:
    return hard_chain(name, COUNT)


def true_frequency(line: Line, number: int, near: float) -> mpf:
    """Bisection on 40-digit counts from a bracket that the counts themselves hold."""
    with mp.workdps(40):
        low, high = (mpf(near) * (1 + sign * mpf("2e-14")) for sign in (-1, 1))
        assert exact_count(line, low) <= number < exact_count(line, high)
        for _ in range(18):
            middle = (low + high) / 2
            low, high = (low, middle) if exact_count(line, middle) > number else (middle, high)
        return (low + high) / 2


@cache
def truth_of(name: str) -> Numbers:
    line = line_of(name)
    if name == "uniform":
        with mp.workdps(40):
            return [2 * mp.sin(mp.pi * k / (2 * COUNT)) for k in LOOKED]
    found = natural_modes(line).frequency
    return [true_frequency(line, k, float(found[k])) for k in LOOKED]


@cache
def own_modes(name: str) -> Bounded:
    found = natural_modes(line_of(name))
    place = list(LOOKED)
    return Bounded(found.frequency[place], found.frequency_error[place])


def energy_condition(name: str) -> float:
    """Half the shares of the strain energy plus half those of the kinetic: by all k and J."""
    line, found = line_of(name), natural_modes(line_of(name))
    shape = found.shape[list(LOOKED)]
    strain = (shape[:, line.first] - shape[:, line.second]) ** 2 @ line.stiffness
    kinetic = found.frequency[list(LOOKED)] ** 2 * (shape**2 @ line.inertia)
    return float(np.max(0.5 * strain / kinetic + 0.5))


def symmetric(line: Line) -> np.ndarray:
    root = np.sqrt(line.inertia)
    return np.asarray(stiffness_matrix(line) / np.outer(root, root))


def by_eigh(name: str) -> np.ndarray:
    square = np.linalg.eigvalsh(symmetric(line_of(name)))
    return np.sqrt(np.maximum(square, 0.0))[list(LOOKED)]


def by_eig(name: str) -> np.ndarray:
    line = line_of(name)
    square = np.linalg.eigvals(stiffness_matrix(line) / line.inertia[:, None])
    return np.sqrt(np.maximum(np.sort(square.real), 0.0))[list(LOOKED)]


def residual(line: Line, square: Any) -> Any:
    """Torque left at the end of a row by the 2 x 2 transfer matrix (Holzer), in plain floats."""
    angle, torque = 1.0, 0.0
    for inertia, stiffness in zip(line.inertia.tolist(), [*line.stiffness.tolist(), 1.0],
                                  strict=True):  # fmt: skip
        torque -= square * inertia * angle
        angle += torque / stiffness
    return torque


def by_transfer(name: str) -> np.ndarray:
    """Bisection of the sign of that torque, between the middles to the modes next to it."""
    line, found = line_of(name), natural_modes(line_of(name)).frequency
    result = []
    for k in LOOKED:
        before = 0.5 * float(found[k - 1] + found[k])
        after = 0.5 * float(found[k] + found[k + 1]) if k + 1 < COUNT else 1.01 * float(found[k])
        ends = residual(line, before**2), residual(line, after**2)
        if not np.all(np.isfinite(ends)):
            raise OverflowError("the transfer matrix overflows")
        if ends[0] * ends[1] > 0.0:
            raise ArithmeticError("the root is missed: no change of sign")
        low, high = before, after
        for _ in range(60):
            middle = 0.5 * (low + high)
            same = residual(line, middle**2) * ends[0] > 0.0
            low, high = (middle, high) if same else (low, middle)
        result.append(low)
    return np.array(result)


def by_scan(name: str) -> np.ndarray:
    """The same torque at 2000 even steps of frequency; all changes of its sign have to be there."""
    line = line_of(name)
    w = np.linspace(0.0, 1.01 * float(natural_modes(line).frequency[-1]), 2001)[1:]
    left = residual(line, np.asarray(w * w))
    if not np.all(np.isfinite(left)):
        raise OverflowError("the transfer matrix overflows")
    changes = np.flatnonzero(np.sign(left[1:]) != np.sign(left[:-1]))
    if len(changes) != COUNT - 1:
        raise ArithmeticError(f"{COUNT - 1 - len(changes)} roots are missed")
    found = 0.5 * (w[changes] + w[changes + 1])
    return np.asarray(found[[k - 1 for k in LOOKED]])


def row(name: str, words: str) -> HardCase:
    return HardCase(
        words, lambda: energy_condition(name), lambda: truth_of(name),
        lambda: own_modes(name),
        (Way("numpy.linalg.eigvalsh", lambda: by_eigh(name), loose=True),
         Way("eigenvalues of J^-1 K", lambda: by_eig(name), loose=True),
         Way("Holzer's 2 x 2 transfer, each root in a given bracket",
             lambda: by_transfer(name), loose=True),
         Way("Holzer's 2 x 2 transfer, 2000 steps", lambda: by_scan(name)),
         Way("Riccati form with count and bisection",
             lambda: riccati_frequencies(line_of(name))[list(LOOKED)])),
    )  # fmt: skip


def rigid() -> HardCase:
    line = line_of("graded_stiffness")
    lowest = float(natural_modes(line).frequency[1])
    return HardCase(
        "the rigid mode of a graded row, against its lowest elastic one",
        lambda: 0.0, lambda: [mpf(0)],
        lambda: Bounded(natural_modes(line).frequency[:1], np.zeros(1)),
        (Way("numpy.linalg.eigvalsh", lambda: np.sqrt(np.abs(
            np.linalg.eigvalsh(symmetric(line))[:1])), loose=True),
         Way("eigenvalues of J^-1 K", lambda: np.sqrt(np.min(np.abs(np.linalg.eigvals(
             stiffness_matrix(line) / line.inertia[:, None])), keepdims=True)), loose=True)),
        scale=lowest,
    )  # fmt: skip


def twins() -> HardCase:
    line = star(3, 4, 1e-12)

    def truth() -> Numbers:
        return [true_frequency(line, k, float(natural_modes(line).frequency[k])) for k in (1, 2, 3)]

    def own() -> Bounded:
        found = natural_modes(line)
        return Bounded(found.frequency[1:4], found.frequency_error[1:4])

    return HardCase(
        "a hub with three branches that differ by 1e-12", lambda: 1.0, truth, own,
        (Way("numpy.linalg.eigvalsh",
             lambda: np.sqrt(np.linalg.eigvalsh(symmetric(line))[1:4]), loose=True),),
    )  # fmt: skip


def torque_of(line: Line) -> np.ndarray:
    torque = np.zeros(len(line.inertia), dtype=complex)
    torque[0], torque[len(torque) // 2] = 100.0, 30.0j
    return torque


def own_forced(line: Line, w: float) -> Bounded:
    found = forced(line, w, torque_of(line))
    return Bounded(found.angle, np.full(found.angle.shape, float(found.error)))


def by_dense(line: Line, w: float) -> np.ndarray:
    return np.asarray(np.linalg.solve(dynamic_stiffness(line, np.asarray(w)), torque_of(line)))


def by_transfer_matrix(line: Line, w: float) -> np.ndarray:
    """Both unknowns at the free ends from the product of transfer matrices (row, no branches)."""
    torque, n = torque_of(line), len(line.inertia)
    element = [*(line.stiffness + 1j * w * line.damping).tolist(), 1.0]
    paths = []
    for start, load in ((1.0, 0.0), (0.0, 1.0)):
        angle, carried, path = complex(start), 0j, []
        for i in range(n):
            path.append(angle)
            carried += (1j * w * line.absolute_damping[i] - w * w * line.inertia[i]) * angle
            carried -= load * torque[i]
            angle += carried / element[i]
        paths.append((np.array(path), carried))
    (free, own_end), (driven, end) = paths
    return np.asarray(driven - end / own_end * free)


def by_modal_sum(line: Line, w: float) -> np.ndarray:
    """Undamped modes of eigh, damping of each mode alone."""
    root = np.sqrt(line.inertia)
    square, vector = np.linalg.eigh(symmetric(line))
    shape = vector / root[:, None]
    twist = shape[line.first] - shape[line.second]
    loss = twist.T**2 @ line.damping + shape.T**2 @ line.absolute_damping
    return np.asarray(shape @ ((shape.T @ torque_of(line)) / (square - w * w + 1j * w * loss)))


def answer_case(name: str, line: Line, w: float) -> HardCase:
    @cache
    def truth() -> Numbers:
        with mp.workdps(40):
            return list(exact_angles(line, w, torque_of(line)))

    def scale() -> float:
        return float(np.max(np.abs(forced(line, w, torque_of(line)).angle)))

    def condition_now() -> float:
        """By the frequency alone, which meets every inertia twice: of the largest angle."""
        with mp.workdps(40):
            moved = exact_angles(line, w * (1 + 2e-12), torque_of(line))
        base = np.array([complex(one) for one in truth()])
        return float(np.max(np.abs(moved - base)) / np.max(np.abs(base)) / 2e-12)

    return HardCase(
        name, condition_now, truth, lambda: own_forced(line, w),
        (Way("numpy.linalg.solve", lambda: by_dense(line, w), loose=True),
         Way("2 x 2 transfer matrices", lambda: by_transfer_matrix(line, w), loose=True),
         Way("sum of modes from eigh", lambda: by_modal_sum(line, w), loose=True)),
        scale=scale(),
    )  # fmt: skip


def damped_engine() -> Line:
    line = engine(damper=True)
    return line._replace(damping=np.array([1.2e3, *[20.0] * 6]))


def on_it() -> HardCase:
    line = engine()
    w = float(natural_modes(line).frequency[1])
    return HardCase(
        "the published engine on its first natural frequency, undamped",
        singular, None, lambda: own_forced(line, w),
        (Way("numpy.linalg.solve", lambda: by_dense(line, w)),
         Way("2 x 2 transfer matrices", lambda: by_transfer_matrix(line, w))),
    )  # fmt: skip


def cases() -> tuple[HardCase, ...]:
    nearby = float(natural_modes(engine()).frequency[1]) * (1.0 + 1e-7)
    alternating = line_of("alternating")._replace(damping=np.full(COUNT - 1, 1e-3))
    return (
        row("uniform", "200 equal inertias"),
        row("alternating", "200 inertias, stiffness 1 and 1e6 in turn"),
        row("graded", "200 inertias and stiffnesses graded 1 to 1e6"),
        row("graded_stiffness", "200 equal inertias, stiffness graded 1 to 1e6"),
        row("weak_link", "two rows of 100 joined by 1e-6"),
        rigid(),
        twins(),
        answer_case("forced: 1e-7 next to a resonance of the engine, undamped", engine(), nearby),
        answer_case("forced: the engine with its damper", damped_engine(), 110.0),
        answer_case("forced: 200 inertias, stiffness 1 and 1e6 in turn, at 1000 rad/s",
                    alternating, 1000.0),
        on_it(),
    )  # fmt: skip

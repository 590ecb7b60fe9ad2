"""Natural frequencies and shapes of a shaft line: the mode count, factors, eigenvalues, Holzer."""

from collections.abc import Callable

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.shaft_lines import as_shown, exact_modes
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup, build_setup
from vibecalc.response.torsion.bisection import highest
from vibecalc.response.torsion.count import Tree, modes_below, rooted
from vibecalc.response.torsion.graph import pieces
from vibecalc.response.torsion.holzer import holzer_table
from vibecalc.response.torsion.line import Line, stiffness_matrix
from vibecalc.response.torsion.modes import natural_modes

#: longer lines take more than their share of time in long arithmetic
MOST_FREEDOMS = 24
HALVINGS = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0)
SCANNED = (100.0, 300.0, 1000.0, 3000.0, 10_000.0, 30_000.0)
PRINTED = (3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0)


def topics(scene: Scene) -> list[Topic]:
    """Frequencies and shapes; none for stations without inertia, loops and very long lines."""
    setup = build_setup(scene.case)
    line = setup.model.at(setup.speed)
    parts = pieces(line)
    if len(line.inertia) > MOST_FREEDOMS or not line.inertia.all():
        return []
    if len(parts) > 1 or not parts[0].is_tree:
        return []
    return [_frequencies(setup, line), _shapes(setup, line)]


def _frequencies(setup: Setup, line: Line) -> Topic:
    n, tree = len(line.inertia), rooted(pieces(line)[0])
    row = _is_row(line)
    exact = exact_once(line)
    ladders = (
        Ladder(
            "factor" if row else "factor and mode counts",
            "qd algorithm, bidiagonal factor" if row else "singular values, then halved in",
            "", NOTHING_TO_SET, lambda _: Answer(natural_modes(line).frequency, _work(line, row)),
            default=1.0, citation="Fernando and Parlett 1994",
        ),
        Ladder(
            "mode counts", "Riccati transfer, sign counts, brackets halved", "halvings", HALVINGS,
            lambda count: _halved(tree, int(count)), theory="0.301 digits per halving",
            citation="Horner and Pilkey 1978",
        ),
        Ladder(
            "symmetric form", "eigenvalues of J^-1/2 K J^-1/2", "", NOTHING_TO_SET,
            lambda _: Answer(_symmetric(line)[0], 2.0 / 3.0 * n**3 + 12.0 * n**2),
        ),
        Ladder(
            "eigenvalues of K / J", "a matrix that is not symmetric", "", NOTHING_TO_SET,
            lambda _: Answer(_plain(line)[0], 5.0 * n**3),
        ),
        Ladder(
            "state matrix", "eigenvalues of twice as many unknowns", "", NOTHING_TO_SET,
            lambda _: Answer(_of_state(line), 40.0 * n**3),
        ),
        Ladder(
            "Holzer scan", "signs of the residual torque, a straight line between two",
            "frequencies", SCANNED, lambda count: _scanned(line, tree, int(count)),
            theory="order 2", citation="Holzer 1921",
        ),
    )  # fmt: skip
    return Topic(
        "torsion", "natural frequencies", "all natural frequencies of the line, undamped",
        "response/torsion/modes/natural_frequency", "rad/s", "multiplications",
        lambda: Reference(
            exact()[0], UNIT_ROUNDOFF, "eigenvalues of the symmetric form in 40 digits"
        ),
        ladders,
        default_extra=1.0 if row else 8.0,
        default_why="" if row else "each mode to its own last digits, soft ones of stiff lines too",
    )  # fmt: skip


def _shapes(setup: Setup, line: Line) -> Topic:
    n = len(line.inertia)
    natural = setup.modes.frequency
    row = _is_row(line)
    exact = exact_once(line)
    ladders = (
        Ladder(
            "factor" if row else "recurrences", "singular vectors" if row else
            "recurrences of the branches from the station of most energy", "", NOTHING_TO_SET,
            lambda _: Answer(natural_modes(line).shape, _work(line, row) + 6.0 * n**3),
            default=1.0,
        ),
        Ladder(
            "symmetric form", "eigenvectors of J^-1/2 K J^-1/2", "", NOTHING_TO_SET,
            lambda _: Answer(_symmetric(line)[1], 4.5 * n**3),
        ),
        Ladder(
            "eigenvectors of K / J", "a matrix that is not symmetric", "", NOTHING_TO_SET,
            lambda _: Answer(_plain(line)[1], 12.5 * n**3),
        ),
        Ladder(
            "Holzer table", "of frequencies with so many digits, as tables are printed", "digits",
            PRINTED, lambda digits: _tabled(line, natural, int(digits)),
            theory="1 digit per digit", citation="Holzer 1921",
        ),
    )  # fmt: skip
    return Topic(
        "torsion", "mode shapes", "angles of all stations in all modes, the largest 1",
        "response/torsion/modes/shape", "", "multiplications",
        lambda: Reference(
            exact()[1], UNIT_ROUNDOFF, "eigenvectors of the symmetric form in 40 digits"
        ),
        ladders,
        default_extra=4.0,
        default_why="shapes of soft modes of stiff lines to all digits, with an error bound",
    )  # fmt: skip


def exact_once(line: Line) -> Callable[[], tuple[FloatArray, FloatArray]]:
    """Modes in long arithmetic, computed when first asked for."""
    kept: list[tuple[FloatArray, FloatArray]] = []

    def modes() -> tuple[FloatArray, FloatArray]:
        if not kept:
            kept.append(exact_modes(line))
        return kept[0]

    return modes


def _is_row(line: Line) -> bool:
    return all(len(others) <= 2 for others in pieces(line)[0].spring.values())


def _work(line: Line, row: bool) -> float:
    """Singular values of a square; of a tree the counts that halve its brackets as well."""
    n = len(line.inertia)
    whole = 4.0 / 3.0 * n**3 + 12.0 * n**2
    if row:
        return whole
    natural = natural_modes(line).frequency
    elastic = natural[natural > 0.0]
    wide = 4.0 * n * EPSILON * natural[-1]
    return whole + 3.0 * n * float(np.sum(2.0 + np.maximum(np.log2(wide / (EPSILON * elastic)), 0)))


def _halved(tree: Tree, halvings: int) -> Answer:
    n = len(tree.inertia)
    top, rigid = highest(tree), 0 if np.any(tree.ground) else 1
    wanted = np.arange(rigid, n)
    low, high = np.zeros(len(wanted)), np.full(len(wanted), top)
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        under = modes_below(tree, middle) > wanted
        low, high = np.where(under, low, middle), np.where(under, middle, high)
    found = np.concatenate([np.zeros(rigid), 0.5 * (low + high)])
    return Answer(found, 3.0 * n * len(wanted) * halvings)


def _symmetric(line: Line) -> tuple[FloatArray, FloatArray]:
    root = np.sqrt(line.inertia)
    square, vector = np.linalg.eigh(stiffness_matrix(line) / root / root[:, None])
    return np.sqrt(np.abs(square)), as_shown(vector.T / root)


def _plain(line: Line) -> tuple[FloatArray, FloatArray]:
    square, vector = np.linalg.eig(stiffness_matrix(line) / line.inertia[:, None])
    order = np.argsort(np.abs(square), kind="stable")
    return np.sqrt(np.abs(square[order])), as_shown(vector.T[order].real)


def _of_state(line: Line) -> FloatArray:
    n = len(line.inertia)
    lower = -stiffness_matrix(line) / line.inertia[:, None]
    matrix = np.block([[np.zeros((n, n)), np.eye(n)], [lower, np.zeros((n, n))]])
    return np.asarray(np.sort(np.abs(np.linalg.eigvals(matrix)))[::2])


def _scanned(line: Line, tree: Tree, count: int) -> Answer:
    n, rigid = len(line.inertia), 0 if np.any(line.ground_stiffness) else 1
    places = np.linspace(0.0, highest(tree), count + 1)[1:]
    residual = holzer_table(line, places).residual
    change = np.flatnonzero(residual[1:] * residual[:-1] < 0.0)
    if len(change) != n - rigid:
        raise NumericalFailure(
            f"{count} frequencies show {len(change)} changes of sign for {n - rigid} elastic modes"
        )
    left, right = residual[change], residual[change + 1]
    found = places[change] + (places[1] - places[0]) * left / (left - right)
    return Answer(np.concatenate([np.zeros(rigid), found]), 3.0 * n * count)


def _tabled(line: Line, natural: FloatArray, digits: int) -> Answer:
    """Holzer's table of each frequency, rounded to some digits."""
    rounded = np.array([float(f"{one:.{digits - 1}e}") for one in natural])
    table = holzer_table(line, rounded)
    shape = np.empty_like(table.angle)
    shape[:, table.rows.freedom] = table.angle
    return Answer(as_shown(shape), 3.0 * len(natural) ** 2)

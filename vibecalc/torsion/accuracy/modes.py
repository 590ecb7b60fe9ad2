"""Accuracy of natural frequencies and shapes, and of the modal twist made of them."""

from collections.abc import Callable

import numpy as np

from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF, ComplexArray, FloatArray
from vibecalc.torsion.accuracy.by_other_means import as_shown, exact_modes
from vibecalc.torsion.accuracy.steady import orders_and_torque
from vibecalc.torsion.adapters.setup import Setup, build_setup
from vibecalc.torsion.as_published import modal_excitation, twist_on_criticals
from vibecalc.torsion.holzer import holzer_table
from vibecalc.torsion.line import Line, connected_parts, stiffness_matrix
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.modes_of_tree import Tree, highest, modes_below, rooted

# ----------------------------------------------------------------------------
# Natural frequencies and shapes of a shaft line: the mode count, factors, eigenvalues, Holzer.
# ----------------------------------------------------------------------------

#: longer lines take more than their share of time in long arithmetic
MOST_FREEDOMS = 24
HALVINGS = (5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 50.0)
SCANNED = (100.0, 300.0, 1000.0, 3000.0, 10_000.0, 30_000.0)
PRINTED = (3.0, 4.0, 6.0, 8.0, 10.0, 12.0, 14.0)


def torsion_modes_topics(scene: Scene) -> list[Topic]:
    """Frequencies and shapes; none for stations without inertia, loops and very long lines."""
    setup = build_setup(scene.case)
    line = setup.model.at(setup.speed)
    parts = connected_parts(line)
    if len(line.inertia) > MOST_FREEDOMS or not line.inertia.all():
        return []
    if len(parts) > 1 or not parts[0].is_tree:
        return []
    return [_frequencies(setup, line), _shapes(setup, line)]


def _frequencies(setup: Setup, line: Line) -> Topic:
    n, tree = len(line.inertia), rooted(connected_parts(line)[0])
    row = _is_row(line)
    exact = exact_once(line)
    solvers = (
        Solver(
            "factor" if row else "factor and mode counts",
            "qd algorithm, bidiagonal factor" if row else "singular values, then halved in",
            "", NOTHING_TO_SET, lambda _: Answer(natural_modes(line).frequency, _work(line, row)),
            default=1.0, citation="Fernando and Parlett 1994",
        ),
        Solver(
            "mode counts", "Riccati transfer, sign counts, brackets halved", "halvings", HALVINGS,
            lambda count: _halved(tree, int(count)), theory="0.301 digits per halving",
            citation="Horner and Pilkey 1978",
        ),
        Solver(
            "symmetric form", "eigenvalues of J^-1/2 K J^-1/2", "", NOTHING_TO_SET,
            lambda _: Answer(_symmetric(line)[0], 2.0 / 3.0 * n**3 + 12.0 * n**2),
        ),
        Solver(
            "eigenvalues of K / J", "a matrix that is not symmetric", "", NOTHING_TO_SET,
            lambda _: Answer(_plain(line)[0], 5.0 * n**3),
        ),
        Solver(
            "state matrix", "eigenvalues of twice as many unknowns", "", NOTHING_TO_SET,
            lambda _: Answer(_of_state(line), 40.0 * n**3),
        ),
        Solver(
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
        solvers,
        default_extra=1.0 if row else 8.0,
        default_why="" if row else "each mode to its own last digits, soft ones of stiff lines too",
    )  # fmt: skip


def _shapes(setup: Setup, line: Line) -> Topic:
    n = len(line.inertia)
    natural = setup.modes.frequency
    row = _is_row(line)
    exact = exact_once(line)
    solvers = (
        Solver(
            "factor" if row else "recurrences", "singular vectors" if row else
            "recurrences of the branches from the station of most energy", "", NOTHING_TO_SET,
            lambda _: Answer(natural_modes(line).shape, _work(line, row) + 6.0 * n**3),
            default=1.0,
        ),
        Solver(
            "symmetric form", "eigenvectors of J^-1/2 K J^-1/2", "", NOTHING_TO_SET,
            lambda _: Answer(_symmetric(line)[1], 4.5 * n**3),
        ),
        Solver(
            "eigenvectors of K / J", "a matrix that is not symmetric", "", NOTHING_TO_SET,
            lambda _: Answer(_plain(line)[1], 12.5 * n**3),
        ),
        Solver(
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
        solvers,
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
    return all(len(others) <= 2 for others in connected_parts(line)[0].spring.values())


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


# ----------------------------------------------------------------------------
# The modal twist as published: complex factors, the source's real form, orders left out.
# ----------------------------------------------------------------------------

KEPT = (3.0, 6.0, 12.0, 18.0, 24.0)


def torsion_modal_route_topics(scene: Scene) -> list[Topic]:
    """The twist of each mode on its critical speeds; nothing without damping or eq. 4.19."""
    setup = build_setup(scene.case)
    options = setup.torsion.as_published
    if options is None or not setup.model.line.inertia.all():
        return []
    ratio = None if options.magnifier == "empirical" else options.damping_ratio
    if options.magnifier == "undamped":
        return []
    line, order = setup.model.line, setup.drive.order
    _, torque = orders_and_torque(setup)
    elastic = np.flatnonzero(setup.modes.frequency > 0.0)[: options.modes]
    first = _first_freedom(setup)
    exact = exact_once(line)
    m, q, n = len(elastic), len(order), len(line.inertia)

    def scaled(shape: FloatArray) -> FloatArray:
        return np.asarray(shape[elastic] / shape[elastic, first][:, None])

    def kernel(count: float) -> Answer:
        kept = slice(0, int(count))
        found = modal_excitation(
            scaled(setup.modes.shape), setup.modes.frequency[elastic], line.inertia, torque[kept]
        )
        zeta = None if ratio is None else np.full(m, ratio)
        sums = twist_on_criticals(found, order[kept], zeta).value[..., -1]
        whole = np.zeros((m, q))
        whole[:, kept] = sums
        return Answer(whole, count * (m * n + 2.0 * m * count))

    def dense(_: float) -> Answer:
        frequency, shape = _of_symmetric(line)
        value = _twist(scaled(shape), frequency[elastic], line, torque, order, ratio)
        return Answer(value, 4.5 * n**3 / 4.0 + q * (m * n + 2.0 * m * q))

    def single_angle(_: float) -> Answer:
        """Phases by an arc tangent of one argument, which takes a half turn for none."""
        frequency, shape = setup.modes.frequency[elastic], scaled(setup.modes.shape)
        value = _twist(shape, frequency, line, torque, order, ratio, half_turn_lost=True)
        return Answer(value, q * (m * n + 2.0 * m * q))

    def reference() -> Reference:
        frequency, shape = exact()
        value = _exact_twist(scaled(shape), frequency[elastic], line, torque, order, ratio)
        return Reference(
            value, 16.0 * UNIT_ROUNDOFF,
            "modes of the symmetric form in 40 digits, rounded, then eqs. 4.20 and 4.28 in 30",
        )  # fmt: skip

    settings = tuple(sorted({*(one for one in KEPT if one < q), float(q)}))
    solvers = (
        Solver(
            "complex factors", "all orders to the highest, each with its phase", "orders", settings,
            kernel, default=float(q), citation="Baca Vasquez 2007, equations 4.17 to 4.29",
        ),
        Solver(
            "modes of the symmetric form", "the same with numpy.linalg.eigh", "", NOTHING_TO_SET,
            dense,
        ),
        Solver(
            "one-argument arc tangent", "phases as the source takes them: a half turn is lost", "",
            NOTHING_TO_SET, single_angle, citation="Baca Vasquez 2007, equation 4.18",
        ),
    )  # fmt: skip
    return [
        Topic(
            "modal route as published", "twist on critical speeds",
            f"modal twist of {m} modes at crank angle zero on the critical speeds of {q} orders",
            "response/torsion/as_published/twist_at_critical", "rad", "complex multiplications",
            reference, solvers,
        )
    ]  # fmt: skip


def _first_freedom(setup: Setup) -> int:
    """Where shapes are 1: at the first station, or the ring that stands in front of it."""
    first = int(setup.shaft.freedom[0])
    return next((one.ring for one in setup.shaft.dampers if one.carrier == first), first)


def _of_symmetric(line: Line) -> tuple[FloatArray, FloatArray]:
    root = np.sqrt(line.inertia)
    square, vector = np.linalg.eigh(stiffness_matrix(line) / root / root[:, None])
    return np.sqrt(np.abs(square)), vector.T / root


def _twist(
    shape: FloatArray, frequency: FloatArray, line: Line, torque: ComplexArray, order: FloatArray,
    ratio: float | None, half_turn_lost: bool = False,
) -> FloatArray:  # fmt: skip
    """Sum of all orders at crank angle zero on each critical speed, (m, q)."""
    total = shape @ torque.T
    static = total / ((shape**2 @ line.inertia) * frequency**2)[:, None]
    r = order / order[:, None]
    below = (1.0 - r) * (1.0 + r) + 2j * (ratio or 0.0) * r
    resonant = np.eye(len(order), dtype=bool)
    factor = 1.0 / np.where(resonant & (ratio is None), 1.0, below)
    term = factor * static[:, None, :]
    if ratio is None:
        size = np.abs(static)
        bump = 3.8 / np.where(size > 0.0, size, 1.0) ** 0.25 * static
        term = np.where(resonant, bump[:, None, :], term)
    if half_turn_lost:
        with np.errstate(divide="ignore", invalid="ignore"):
            angle = np.arctan(term.imag / term.real)
        term = np.abs(term) * np.exp(1j * np.where(np.isfinite(angle), angle, 0.0))
    return np.asarray(term.real.sum(axis=-1))


def _exact_twist(
    shape: FloatArray, frequency: FloatArray, line: Line, torque: ComplexArray, order: FloatArray,
    ratio: float | None,
) -> FloatArray:  # fmt: skip
    """The same in long arithmetic."""
    import mpmath

    value = np.zeros((len(shape), len(order)))
    with mpmath.workdps(30):
        orders = [mpmath.mpf(one) for one in order.tolist()]
        for c, (own, w) in enumerate(zip(shape.tolist(), frequency.tolist(), strict=True)):
            inertia = sum(
                mpmath.mpf(a) ** 2 * mpmath.mpf(j)
                for a, j in zip(own, line.inertia.tolist(), strict=True)
            )
            static = [
                sum(mpmath.mpf(a) * mpmath.mpc(complex(t)) for a, t in zip(own, row, strict=True))
                / (inertia * mpmath.mpf(w) ** 2)
                for row in torque
            ]
            for k, met in enumerate(orders):
                total = mpmath.mpf(0)
                for j, (one, q) in enumerate(zip(static, orders, strict=True)):
                    r = q / met
                    if ratio is None and j == k:
                        size = abs(one)
                        part = one * mpmath.mpf("3.8") / mpmath.root(size, 4) if size else one
                    else:
                        part = one / (1 - r * r + 2j * mpmath.mpf(ratio or 0.0) * r)
                    total += part.real
                value[c, k] = float(total)
    return value

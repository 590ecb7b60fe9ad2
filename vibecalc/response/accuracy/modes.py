"""Accuracy of the modes: natural frequencies of the body, each to its own size."""

import numpy as np

from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.matrices import Matrices
from vibecalc.response.adapters.response import linear_system
from vibecalc.response.modes import modes, refined_shapes

# ----------------------------------------------------------------------------
# Topics of the response: natural frequencies of the body, each to its own size.
# ----------------------------------------------------------------------------

DIGITS = 40
#: multiplications over n^3 (Golub and Van Loan, Matrix Computations, 4th ed. 2013)
CHOLESKY, TWO_SOLVES, EIGH_VECTORS, EIGH_VALUES = 1.0 / 6.0, 1.0, 4.5, 2.0 / 3.0
QR_VALUES, QZ_VALUES, SOLVE, FACTOR = 5.0, 15.0, 4.0 / 3.0, 1.0 / 3.0
#: a step of refinement, and the quotients that end them: products of three matrices each
REFINEMENT, QUOTIENTS = 5.0, 4.0
#: all of a method that gives the frequencies and nothing else
VALUES_ALONE = CHOLESKY + TWO_SOLVES + EIGH_VALUES
JACOBI_SWEEP = 3.0
SCANS = (16.0, 64.0, 256.0, 1024.0, 4096.0)


def response_modes_topics(scene: Scene) -> list[Topic]:
    """The frequencies of all modes that something holds, over their true values."""
    system = linear_system(scene)
    shapes = system.shapes
    held = shapes.eigenvalue > shapes.eigenvalue_error
    if not np.all(held):
        return []  # the frequency of a mode that nothing holds is zero, and has no own size
    return [_topic(system.matrices, shapes.natural_frequency)]


def _topic(matrices: Matrices, scale: np.ndarray) -> Topic:
    mass, stiffness, size = matrices.mass, matrices.stiffness, len(scale)
    cube = float(size**3)

    def shown(eigenvalues: np.ndarray, work: float) -> Answer:
        values = np.sort(np.asarray(eigenvalues).real)
        if np.any(values <= 0.0):
            raise NumericalFailure("a squared natural frequency came out negative")
        return Answer(np.sqrt(values) / scale, cube * work)

    def refined(_: float) -> Answer:
        found = modes(matrices)
        work = _full(refined_shapes(matrices)[1])
        return Answer(found.natural_frequency / scale, cube * work)

    def reduced(_: float) -> Answer:
        values = np.linalg.eigvalsh(_symmetric(mass, stiffness))
        return shown(values, VALUES_ALONE)

    def generalised(_: float) -> Answer:
        from scipy.linalg import eigh

        values = eigh(stiffness, mass, eigvals_only=True)
        return shown(values, VALUES_ALONE)

    def unsymmetric(_: float) -> Answer:
        values = np.linalg.eigvals(np.linalg.solve(mass, stiffness))
        return shown(values, SOLVE + QR_VALUES)

    def pencil(_: float) -> Answer:
        from scipy.linalg import eigvals

        return shown(eigvals(stiffness, mass), QZ_VALUES)

    def rotated(sweeps: float) -> Answer:
        values = _jacobi(_symmetric(mass, stiffness), int(sweeps))
        return shown(values, CHOLESKY + TWO_SOLVES + JACOBI_SWEEP * sweeps)

    def scanned(points: float) -> Answer:
        found = _scan(mass, stiffness, 0.5 * scale[0], 2.0 * scale[-1], int(points))
        return shown(found**2, FACTOR * points)

    solvers = (
        Solver(
            "Cholesky, eigh, refined",
            "reduced by the factors of the scaled mass, a step of refinement on the pencil or two",
            "",
            NOTHING_TO_SET,
            refined,
            default=1.0,
            citation="Ogita and Aishima (2018), algorithm 1",
        ),
        Solver(
            "Cholesky, eigvalsh",
            "reduced by the factors of the mass, numpy.linalg.eigvalsh",
            "",
            NOTHING_TO_SET,
            reduced,
        ),
        Solver("scipy eigh", "generalised symmetric problem", "", NOTHING_TO_SET, generalised),
        Solver(
            "numpy eigvals",
            "QR algorithm on the inverse mass times the stiffness",
            "",
            NOTHING_TO_SET,
            unsymmetric,
            citation="Ong (2000), appendix",
        ),
        Solver("scipy eigvals", "QZ algorithm on the pencil", "", NOTHING_TO_SET, pencil),
        Solver(
            "Jacobi rotations",
            "cyclic sweeps over the reduced matrix",
            "sweeps",
            (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
            rotated,
            theory="quadratic from sweep to sweep",
        ),
        Solver(
            "scan of the determinant",
            "signs of the determinant at N frequencies, evenly spaced on a logarithmic axis, and "
            "straight lines between",
            "frequencies",
            SCANS,
            scanned,
            theory="order 2",
        ),
    )
    return Topic(
        stage="response",
        name="natural frequencies",
        words=f"{size} undamped natural frequencies, each over its true value",
        quantity="response/modes/natural_frequency",
        unit="",
        work="multiplications",
        reference=lambda: _reference(matrices, scale),
        solvers=solvers,
        default_extra=_full(refined_shapes(matrices)[1]) / VALUES_ALONE,
        default_why="it gives the shapes too, the factors keep the digits of low modes next to "
        "stiff ones, and the quotients an error for each",
    )


def _full(steps: int) -> float:
    """Multiplications over n^3 for frequencies, shapes and errors, with so many refinements."""
    return CHOLESKY + TWO_SOLVES + EIGH_VECTORS + steps * REFINEMENT + QUOTIENTS


def _symmetric(mass: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    lower = np.linalg.cholesky(mass)
    reduced = np.linalg.solve(lower, np.linalg.solve(lower, stiffness).T)
    return np.asarray(0.5 * (reduced + reduced.T))


def _jacobi(matrix: np.ndarray, sweeps: int) -> np.ndarray:
    """Diagonal after some cyclic sweeps of rotations that each make one pair zero."""
    turned = matrix.copy()
    size = len(matrix)
    for _ in range(sweeps):
        for p in range(size - 1):
            for q in range(p + 1, size):
                if turned[p, q] == 0.0:
                    continue
                lean = (turned[q, q] - turned[p, p]) / (2.0 * turned[p, q])
                tangent = np.copysign(1.0, lean) / (abs(lean) + np.hypot(1.0, lean))
                cosine = 1.0 / np.hypot(1.0, tangent)
                pair = np.array([[cosine, tangent * cosine], [-tangent * cosine, cosine]])
                turned[:, [p, q]] = turned[:, [p, q]] @ pair
                turned[[p, q]] = pair.T @ turned[[p, q]]
    return np.diagonal(turned)


def _scan(
    mass: np.ndarray, stiffness: np.ndarray, low: float, high: float, points: int
) -> np.ndarray:
    """Frequencies at which the determinant changes its sign, by straight lines.

    Raises NumericalFailure where the grid does not tell as many as there are modes.
    """
    rate = np.geomspace(low, high, points)
    scaled = 1.0 / np.sqrt(np.diagonal(mass))
    system = (stiffness - np.square(rate)[:, None, None] * mass) * np.outer(scaled, scaled)
    value = np.linalg.det(system / np.square(rate)[:, None, None])
    at = np.flatnonzero(value[:-1] * value[1:] < 0.0)
    if len(at) != len(mass):
        raise NumericalFailure(
            f"{points} frequencies show {len(at)} changes of sign, not {len(mass)}"
        )
    share = value[at] / (value[at] - value[at + 1])
    return np.asarray(rate[at] + share * (rate[at + 1] - rate[at]))


def _reference(matrices: Matrices, scale: np.ndarray) -> Reference:
    """Eigenvalues in 40 digits; the determinant there changes its sign about every one of them."""
    import mpmath

    with mpmath.workdps(DIGITS):
        mass, stiffness = (mpmath.matrix(part.tolist()) for part in matrices[:2])
        inverse = mpmath.inverse(mpmath.cholesky(mass))
        reduced = inverse * stiffness * inverse.T
        reduced = (reduced + reduced.T) / 2
        found = sorted(mpmath.eigsy(reduced, eigvals_only=True))
        values = np.array(
            [float(mpmath.sqrt(x) / mpmath.mpf(s)) for x, s in zip(found, scale, strict=True)]
        )
        margin = mpmath.mpf(10) ** -25
        apart = max(float(margin) if _brackets(mass, stiffness, x, margin) else 1.0 for x in found)
    return Reference(
        values,
        apart,
        f"eigenvalues in {DIGITS} digits (mpmath); the determinant of the pencil changes its "
        "sign within 1e-25 of each",
    )


def _brackets(mass: object, stiffness: object, eigenvalue: object, margin: object) -> bool:
    """Whether the determinant has opposite signs a margin below and above an eigenvalue."""
    import mpmath

    below, above = (
        mpmath.det(stiffness - eigenvalue * (1 + side * margin) * mass)  # type: ignore[operator]
        for side in (-1, 1)
    )
    return bool(below * above < 0)

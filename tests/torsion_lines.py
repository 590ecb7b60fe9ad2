"""Shaft lines for tests: the published engine, hard rows, branches; mode counts in mpmath."""

import mpmath
import numpy as np

from vibecalc.torsion.line import Line, chain

ENGINE_INERTIA = [18.64] * 6 + [2655.0]
ENGINE_STIFFNESS = [22.82e6] * 5 + [19.21e6]
HARD = ("uniform", "alternating", "graded", "graded_stiffness", "weak_link", "two_pieces", "held")


def engine(damper: bool = False) -> Line:
    """The seven inertias of the published engine; with its damper's ring in front, eight."""
    inertia, stiffness = list(ENGINE_INERTIA), list(ENGINE_STIFFNESS)
    if damper:
        inertia, stiffness = [27.5126, *inertia], [5.9712e5, *stiffness]
    return chain(np.array(inertia), np.array(stiffness))


def hard_chain(name: str, count: int) -> Line:
    """One of the `HARD` rows of `count` inertias."""
    inertia, stiffness, ground = np.ones(count), np.ones(count - 1), np.zeros(count)
    if name == "alternating":
        stiffness[1::2] = 1e6
    if name in ("graded", "graded_stiffness"):
        stiffness = np.geomspace(1.0, 1e6, count - 1)
    if name == "graded":
        inertia = np.geomspace(1.0, 1e6, count)
    if name == "weak_link":
        stiffness[count // 2 - 1] = 1e-6
    if name == "two_pieces":
        stiffness[count // 2 - 1] = 0.0
    if name == "held":
        ground[[0, count // 3, count - 1]] = 5.0, 1e-3, 5.0
    return chain(inertia, stiffness)._replace(ground_stiffness=ground)


def network(
    inertia: list[float],
    elements: list[tuple[int, int, float]],
    ground: list[float] | None = None,
    damping: list[float] | None = None,
    absolute: list[float] | None = None,
) -> Line:
    """Any line from (first, second, stiffness) of each element."""
    first, second, stiffness = (np.array(part) for part in zip(*elements, strict=True))
    none, free = np.zeros(len(inertia)), np.zeros(len(elements))
    return Line(
        np.array(inertia, dtype=float),
        none if absolute is None else np.array(absolute, dtype=float),
        none if ground is None else np.array(ground, dtype=float),
        first,
        second,
        stiffness.astype(float),
        free if damping is None else np.array(damping, dtype=float),
        free,
    )


def ring_on(line: Line, freedom: int, values: tuple[float, float, float, float]) -> Line:
    """The line with a ring of inertia, stiffness, damping and loss factor on one freedom."""
    inertia, stiffness, damping, loss = values
    n = len(line.inertia)
    return Line(
        np.append(line.inertia, inertia),
        np.append(line.absolute_damping, 0.0),
        np.append(line.ground_stiffness, 0.0),
        np.append(line.first, freedom),
        np.append(line.second, n),
        np.append(line.stiffness, stiffness),
        np.append(line.damping, damping),
        np.append(line.loss_factor, loss),
    )


def star(branches: int, length: int, spread: float) -> Line:
    """Equal branches on a hub, but for a relative difference of their stiffnesses."""
    inertia, elements = [3.0], []
    for branch in range(branches):
        before = 0
        for place in range(length):
            inertia.append(1.0 + 0.1 * place)
            stiffness = (2.0 + place) * (1.0 + spread * branch)
            elements.append((before, len(inertia) - 1, stiffness))
            before = len(inertia) - 1
    return network(inertia, elements)


def exact_count(line: Line, frequency: mpmath.mpf) -> int:
    """Modes below a frequency, in 40 digits: Gauss elimination from the leaves, numbered so that
    each station's parent has a lower number."""
    with mpmath.workdps(40):
        square = mpmath.mpf(frequency) ** 2
        pivot = [
            mpmath.mpf(float(g)) - square * mpmath.mpf(float(j))
            for g, j in zip(line.ground_stiffness, line.inertia, strict=True)
        ]
        up = {int(b): (int(a), float(k)) for a, b, k in zip(
            line.first, line.second, line.stiffness, strict=True)}  # fmt: skip
        below = 0
        for station in range(len(pivot) - 1, -1, -1):
            if station in up and up[station][1] != 0.0:
                parent, stiffness = up[station]
                whole = pivot[station] + stiffness
                below += whole < 0
                pivot[parent] += stiffness - mpmath.mpf(stiffness) ** 2 / whole
            else:
                below += pivot[station] < 0
        return int(below)


def assert_every_mode(line: Line, frequency: np.ndarray, error: np.ndarray) -> None:
    """Each mode lies within its error: the 40-digit count passes its number there."""
    for number, (w, e) in enumerate(zip(frequency.tolist(), error.tolist(), strict=True)):
        if w > 0.0:
            low, high = mpmath.mpf(w) - mpmath.mpf(e), mpmath.mpf(w) + mpmath.mpf(e)
            assert exact_count(line, low) <= number < exact_count(line, high), number

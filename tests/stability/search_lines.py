"""Contests on shaft lines and on periodic solutions."""

import mpmath
import numpy as np
from periodic_problems import halved, random_kinked, random_smooth
from stability.search import Contest
from stability.search_machines import between, worst
from torsion_lines import network

from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.multipliers import product_multipliers
from vibecalc.numerics.periodic.other_methods import march_turns
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.roll.running import point_levels
from vibecalc.torsion.forced import forced_masked
from vibecalc.torsion.line import Line, chain
from vibecalc.torsion.modes import natural_modes
from vibecalc.torsion.modes_of_tree import riccati_frequencies


def drawn_line(point: np.ndarray) -> Line:
    """A row or a tree of 2 to 60 stations, spreads of inertia and stiffness to 1e12, some held."""
    random = np.random.default_rng(int(point[0] * 1e5))
    count = 2 + int(between(point[1], 1.0, 58.0))
    inertia = 10.0 ** random.uniform(0.0, 12.0 * point[2] + 1e-9, count)
    stiffness = 10.0 ** random.uniform(0.0, 12.0 * point[3] + 1e-9, count - 1)
    if random.random() < 0.2:
        # equal ones make modes meet
        inertia, stiffness = np.ones(count), np.full(count - 1, stiffness[0])
    ground = np.zeros(count)
    if random.random() < 0.3:
        ground[random.integers(count)] = 10.0 ** random.uniform(-12.0, 12.0)
    if point[4] < 0.5:
        return chain(inertia, stiffness)._replace(ground_stiffness=ground)
    elements = [(int(random.integers(k)), k, float(stiffness[k - 1])) for k in range(1, count)]
    return network(inertia.tolist(), elements, ground.tolist())


def line_modes(point: np.ndarray) -> float:
    """Singular values or secular equations against Riccati with count and bisection."""
    line = drawn_line(point)
    found = natural_modes(line)
    other = riccati_frequencies(line)
    return worst(found.frequency - other, found.frequency_error + 1e-15 * other)


def line_forced(point: np.ndarray) -> float:
    """Elimination along the line against dense solves with pivoting, near a resonance."""
    line = drawn_line(point)
    random = np.random.default_rng(int(point[5] * 1e5))
    natural = natural_modes(line).frequency
    away = between(point[6], 1e-11, 3.0)
    w = abs(
        float(natural[random.integers(len(natural))]) * (1.0 + away * random.choice([-1.0, 1.0]))
    )
    lowest = float(np.min(natural[natural > 0.0], initial=1e6))
    loss = 0.0 if random.random() < 0.3 else 10.0 ** random.uniform(-14.0, 0.0)
    line = line._replace(
        damping=loss * line.stiffness / max(w, lowest) * random.random(len(line.stiffness)),
        absolute_damping=loss * line.inertia * w * random.random(len(line.inertia)),
    )
    torque = random.normal(size=len(line.inertia)) + 1j * random.normal(size=len(line.inertia))
    torque *= random.random(len(torque)) < 0.5
    here = forced_masked(line, w, torque)
    there = forced_masked(line, w, torque, dense=True)
    if here.masked or there.masked:
        # masking is loud; one that answers where the other masks has to say how little it knows
        return 0.0
    apart = float(np.max(np.abs(here.angle - there.angle)))
    return apart / (float(here.error) + float(there.error) + 1e-320)


def periodic(point: np.ndarray) -> float:
    """Two numbers of points, as a running state takes them, against many on quarter panels."""
    random = np.random.default_rng(int(point[0] * 1e6))
    problem = (random_kinked if point[1] < 0.5 else random_smooth)(random)
    levels = point_levels(1.0)
    place = int(point[2] * (len(levels) - 1.01))
    check = solve_periodic(problem, levels[place], [0.0])
    found = solve_periodic(problem, levels[place + 1], check)
    fine = problem._replace(edges=halved(halved(problem.edges)))
    truth = solve_periodic(fine, 14, [0.3], tolerance=1e-15)
    if not (check.converged.all() and found.converged.all() and truth.converged.all()):
        return 0.0
    x = np.linspace(0.0, 2.0 * np.pi, 401)
    fewer, more, exact = (evaluate(one, x) for one in (check, found, truth))
    rounding = 1e-13 * np.max(np.abs(exact))
    return float(np.max(np.abs(more - exact)) / (np.max(np.abs(more - fewer)) + rounding))


def marched(point: np.ndarray) -> float:
    """Collocation against a march turn after turn to the same smooth solution."""
    random = np.random.default_rng(int(point[0] * 1e6))
    problem = random_smooth(random)
    fine = problem._replace(edges=halved(halved(problem.edges)))
    points = 6 + int(point[1] * 5.99)
    found, check = (solve_periodic(problem, one, [0.0]) for one in (points, points + 1))
    march = march_turns(fine.rhs, fine.edges, np.array([5.0]), points=12, tolerance=1e-13)
    if not (found.converged.all() and march.converged[0]):
        return 0.0
    # the start of the last turn is where the turn before has ended
    end = float(found.left[0, 0, 0])
    off = abs(end - march.path[0, -1])
    apart = abs(end - float(check.left[0, 0, 0]))
    # a step of the march ends its Newton iteration where the next would be below 1e-13
    left = 1e-13 * float(np.max(np.abs(march.path))) + float(march.change[0])
    return float(off / (2.0 * apart + left))


def multipliers(point: np.ndarray) -> float:
    """Eigenvalues of a product of panels against the product and its eigenvalues in long form."""
    random = np.random.default_rng(int(point[0] * 1e6))
    panels, states = 2 + int(point[1] * 40), 1 + int(point[2] * 2.99)
    spread = 3.0 * point[3]
    transfer = random.normal(size=(1, panels, states, states))
    transfer *= 10.0 ** random.uniform(-spread, spread, (1, panels, states, 1))
    found = product_multipliers(transfer)
    with mpmath.workdps(600):
        whole = mpmath.eye(states)
        for one in transfer[0]:
            whole = mpmath.matrix(one.tolist()) * whole
        exact = mpmath.eig(whole, left=False, right=False)
        exact = sorted(exact, key=lambda v: -abs(v))
        return max(
            min(float(abs(mpmath.mpc(complex(value)) - one) / (mpmath.mpf(float(error)) + 1e-300))
                for one in exact)
            for value, error in zip(found.value[0], found.error[0], strict=True)
        )  # fmt: skip


LINES = (
    Contest("line modes", "bidiagonal or secular against bisection", 5, line_modes),
    Contest("line forced", "elimination against dense", 7, line_forced),
    Contest("periodic", "two numbers of Gauss points against many", 3, periodic),
    Contest("periodic march", "collocation against a march", 2, marched),
    Contest("multipliers", "product of panels against long arithmetic", 4, multipliers),
)

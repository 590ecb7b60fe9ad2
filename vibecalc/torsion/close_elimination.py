"""Elimination along a tree with the error that its roundings make by the line's own compliances."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.torsion.elimination import LineSolution, at_root, balanced
from vibecalc.torsion.tree_plan import Branches, Plan, Stations

# ----------------------------------------------------------------------------
# The running bound of `eliminate` takes every rounding by its size. Next to a resonance of an
# eliminated part of the line the angle of its parent is almost nothing, so that the ratio of both
# angles is uncertain; the ratio one station further is uncertain as well, and in their product both
# cancel. The running bound adds them up, half wave by half wave.
#
# Here the roundings at a station are an error of its stiffness and of the torque on it, and what
# these do to the angles are the compliances G of the whole line, whatever is large on the way:
#
#     |error of x_i| <= sum of |G_im| w_m over all m + what is lost in x_i itself,
#     w_m = error of the stiffness at m |x_m| + error of the torque at m.
#
# With r = 1 / (k + g) and t = k r of a branch, G between a child and its parent p is t G_p, and of
# the child itself r + t^2 G_p. So the sum over m takes a sweep from the leaves, W = w + sum of
# |t| W, and one from the root, E = |t| E_p + W (|G| - |t^2 G_p|).
# ----------------------------------------------------------------------------

ZERO: ComplexArray = np.zeros((), dtype=np.complex128)


def eliminate_closely(
    plan: Plan, frequency: FloatArray, torque: list[ComplexArray | None], angle: ComplexArray
) -> LineSolution:
    """As `eliminate` with its estimate, at four times the cost, with the sharper bound.

    It is infinite where a pivot vanishes. It stays large where torques act on a part of the line
    that is next to a resonance of its own: what they do there cancels, and another root is needed.
    """
    tree, unit, n, count = plan.tree, plan.unit, len(plan.station), len(frequency)
    branches, stations = Branches(plan, frequency), Stations(plan, frequency)
    inverse, turn = np.empty((2, n, count), dtype=np.complex128)
    # what rounding makes of the stiffness of stations and branches, and of the torque
    uncertain, lost = np.empty((n, count)), np.zeros(angle.shape)
    between, load, ground = [0.0] * n, list(torque), [ZERO] * n
    for i in range(n):
        np.multiply(stations.uncertainty(i), unit, out=uncertain[i])
    singular = np.zeros(count, dtype=bool)
    for i in tree.order:
        p, acting, attached = tree.parent[i], load[i], ground[i] + stations.dynamic_stiffness(i)
        ground[i] = ZERO
        if p < 0:
            inverse[i], free = at_root(attached)
            if acting is not None and np.any(free):
                singular |= free & ~balanced(acting, torque)
            angle[i] = 0.0 if acting is None else inverse[i] * acting
            continue
        element, _, largest = branches.element(i)
        # what an element is formed with: its damping, and others side by side
        formed = np.max(np.abs(element.imag)) if np.iscomplexobj(element) else 0.0
        between[i] = EPSILON * float(formed + (largest if len(tree.elements[i]) > 1 else 0.0))
        r = np.reciprocal(attached + element, out=inverse[i], casting="same_kind")
        t = np.multiply(r, element, out=turn[i])
        passed = attached * t
        ground[p] = ground[p] + passed
        uncertain[p] += unit * np.abs(passed)
        angle[i] = 0.0
        if acting is not None:
            np.multiply(r, acting, out=angle[i])
            moved = element * angle[i]
            above = load[p]
            load[p] = moved if above is None else above + moved
            lost[p] += unit * np.abs(moved)
    error = np.empty(lost.shape)
    for i in reversed(tree.order):
        p, x = tree.parent[i], angle[i]
        size = np.abs(x)
        if p >= 0:
            far = turn[i] * angle[p]
            size += np.abs(far)
            x += far
            if between[i]:
                twisted = np.abs(x - angle[p])
                twisted *= between[i]
                lost[i] += twisted
                lost[p] += twisted
        np.multiply(size, unit, out=error[i])
        lost[i] += uncertain[i] * np.abs(x)
    gathered, ratio = lost, uncertain
    for i in tree.order:
        p = tree.parent[i]
        if p >= 0:
            np.abs(turn[i], out=ratio[i])
            gathered[p] += ratio[i] * gathered[i]
    compliance = inverse
    for i in reversed(tree.order):
        p, own = tree.parent[i], np.abs(compliance[i])
        if p >= 0:
            shared = np.multiply(turn[i], turn[i], out=turn[i])
            shared *= compliance[p]
            compliance[i] += shared
            own = np.abs(compliance[i])
            own -= np.abs(shared)
            error[i] += ratio[i] * error[p]
        error[i] += own * gathered[i]
    worst = np.max(error, axis=0)
    worst[:, singular] = np.inf
    worst[np.isnan(worst)] = np.inf
    return LineSolution(angle, worst, np.zeros(count, dtype=bool), np.max(np.abs(angle), axis=0))

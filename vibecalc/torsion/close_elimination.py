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
    upwards = [(i, tree.parent[i]) for i in tree.order if tree.parent[i] >= 0]
    compliance, turn = np.zeros((2, n, count), dtype=np.complex128)
    # roundings of the stiffness of stations and branches, and of the torque
    uncertain, lost = np.empty((n, count)), np.zeros(angle.shape)
    between, load, ground = np.zeros((n, 1, 1)), list(torque), [ZERO] * n
    for i in range(n):
        uncertain[i] = stations.uncertainty(i)
    singular = np.zeros(count, dtype=bool)
    angle[...] = 0.0
    for i in tree.order:
        p, acting, attached = tree.parent[i], load[i], ground[i] + stations.dynamic_stiffness(i)
        ground[i] = ZERO
        if p < 0:
            compliance[i], free = at_root(attached)
            if acting is not None:
                singular |= free & ~balanced(acting, torque)
                np.multiply(compliance[i], acting, out=angle[i])
            continue
        element, _, largest = branches.element(i)
        # what an element is formed with: its damping, and others side by side
        if np.iscomplexobj(element):
            between[i] = np.max(np.abs(element.imag))
        if len(tree.elements[i]) > 1:
            between[i] += largest
        r = np.add(attached, element, out=compliance[i])
        np.reciprocal(r, out=r)
        attached *= np.multiply(r, element, out=turn[i])
        uncertain[p] += np.abs(attached)
        ground[p] = ground[p] + attached
        if acting is not None:
            np.multiply(r, acting, out=angle[i])
            moved, above = element * angle[i], load[p]
            load[p] = moved if above is None else above + moved
            lost[p] += np.abs(moved)
    error = np.abs(angle)
    for i, p in reversed(upwards):
        far = turn[i] * angle[p]
        error[i] += np.abs(far)
        angle[i] += far
    size = np.abs(angle)
    largest_angle = np.max(size, axis=0)
    size *= uncertain[:, None]
    lost += size
    np.abs(turn, out=uncertain)
    if np.any(between):
        parent = np.arange(n)
        parent[[i for i, _ in upwards]] = [p for _, p in upwards]
        np.abs(angle - angle[parent], out=size)
        size *= (EPSILON / unit) * between
        lost += size
        for i, p in upwards:
            lost[p] += size[i]
    ratio = uncertain
    for i, p in upwards:
        lost[p] += ratio[i] * lost[i]
    np.square(turn, out=turn)
    for i, p in reversed(upwards):
        turn[i] *= compliance[p]
        compliance[i] += turn[i]
    own = np.abs(compliance)
    own -= np.abs(turn)
    lost *= own[:, None]
    error += lost
    for i, p in reversed(upwards):
        error[i] += ratio[i] * error[p]
    worst = unit * np.max(error, axis=0)
    worst[:, singular] = np.inf
    worst[np.isnan(worst)] = np.inf
    return LineSolution(angle, worst, np.zeros(count, dtype=bool), largest_angle)

"""Adapter: mass, centre and moments of inertia of a body of parts."""

import numpy as np

from vibecalc.body.results import NAMES, OfParts
from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.body import DIRECTIONS


def run_body(scene: Scene) -> None:
    """Emit what the parts add up to; axes of equal moments may point anywhere."""
    body = scene.parts.body
    if body is None or body.inertia_error is None or body.centre_error is None:
        raise ValueError("the body has no parts")
    axes = {"direction": DIRECTIONS, "principal": np.arange(1, 4), **NAMES}
    inertia, error = body.inertia, body.inertia_error
    rows, columns = np.triu_indices(3, 1)
    moments, vectors = np.linalg.eigh(inertia)
    off = np.linalg.norm(error) + 8.0 * EPSILON * moments[-1]
    largest = np.argmax(np.abs(vectors), axis=0)
    vectors = vectors * np.sign(vectors[largest, range(3)])
    gap = float(np.diff(moments).min())
    turned = min(2.0 * off / gap, 2.0) if gap > 0.0 else 2.0
    found = OfParts(
        mass=rounded(body.mass, 8),
        centre=Bounded(body.centre, body.centre_error),
        moments=Bounded(np.diagonal(inertia), np.diagonal(error)),
        products=Bounded(-inertia[rows, columns], error[rows, columns]),
        principal_moments=Bounded(moments, off),
        principal_axes=Bounded(vectors.T, np.asarray(turned)),
    )
    scene.emit_all(found, axes)
    scene.cite(
        "theorem of parallel axes about the common mass centre",
        "mass, centre and inertia of the body",
        "Goldstein, Classical Mechanics, ch. 5",
    )

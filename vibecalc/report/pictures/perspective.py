"""A box and arrows in perspective, as points of the page: enough to show how a body moves."""

import numpy as np

_HALF = np.array([0.62, 0.62, 0.5])
_TURN, _LIFT = np.radians(-62.0), np.radians(24.0)
_DISTANCE = 7.0

#: corners of the box by number, joined along its edges
EDGES = tuple((first, first | bit) for first in range(8) for bit in (1, 2, 4) if not first & bit)
#: names and ends of the three axes
TRIAD = tuple(zip("xyz", np.diag([1.55, 1.4, 1.35]), strict=True))


def project(point: np.ndarray) -> np.ndarray:
    """Place (2,) on the page of a point (3,); z goes up, nearer things are larger."""
    turned = np.array(
        [
            np.cos(_TURN) * point[0] - np.sin(_TURN) * point[1],
            np.sin(_TURN) * point[0] + np.cos(_TURN) * point[1],
            point[2],
        ]
    )
    away = np.cos(_LIFT) * turned[1] - np.sin(_LIFT) * turned[2]
    height = np.sin(_LIFT) * turned[1] + np.cos(_LIFT) * turned[2]
    return np.asarray(np.array([turned[0], height]) * _DISTANCE / (_DISTANCE + away))


def corners(moved: np.ndarray | None = None, turned: np.ndarray | None = None) -> np.ndarray:
    """The eight corners (8, 3), moved along and turned about vectors (3,), angles in rad."""
    signs = np.array([[(number >> bit & 1) * 2 - 1 for bit in range(3)] for number in range(8)])
    points = signs * _HALF
    if turned is not None:
        points = rotate(points, turned)
    return np.asarray(points if moved is None else points + moved)


def rotate(points: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Points (n, 3) turned right-handed about a vector by its length (Rodrigues' formula)."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return points
    unit = vector / angle
    along = np.outer(points @ unit, unit)
    across = np.cross(np.broadcast_to(unit, points.shape), points)
    turned = points * np.cos(angle) + across * np.sin(angle) + along * (1.0 - np.cos(angle))
    return np.asarray(turned)


def arc_about(vector: np.ndarray, radius: float) -> np.ndarray:
    """Three quarters of a circle (n, 3) about the outer part of a vector, right-handed."""
    unit = vector / np.linalg.norm(vector)
    aside = np.eye(3)[int(np.argmin(np.abs(unit)))]
    first = np.cross(unit, aside)
    first /= np.linalg.norm(first)
    second = np.cross(unit, first)
    angle = np.linspace(0.0, 1.5 * np.pi, 46)
    circle = np.outer(np.cos(angle), first) + np.outer(np.sin(angle), second)
    return np.asarray(0.72 * vector + radius * circle)

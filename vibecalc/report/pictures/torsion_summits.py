"""Maxima of the curves of a shaft line: points that the curves go through, and their names."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.numbers import rpm
from vibecalc.report.pictures.canvas import COLOURS
from vibecalc.report.sections.torsion_terms import TORSION, names, order_text, place_of, vector
from vibecalc.results.record import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: of the width of the axes, the least distance of two names
_APART = 0.024
#: of the range, how near to its ends a maximum is at one
_AT_END = 1e-6


class Points(NamedTuple):
    """Maxima of a section: speed in rad/s, height in SI, mode and order (0: none)."""

    speed: np.ndarray
    height: np.ndarray
    mode: np.ndarray
    order: np.ndarray


def top_of(record: Record, section: str, load: str = "torque_half_range", root: str = "") -> Points:
    """The highest of a section at any speed, as far as it is known and has an end."""
    parts = [_entry(record, f"{root}largest/{name}", section)
             for name in ("speed", load, "mode", "half_order")]  # fmt: skip
    known = bool(parts[0].size and parts[1].size and np.isfinite(parts[1]).all())
    speed, height, mode, order = (
        (one if one.size else np.zeros(1)) if known else np.zeros(0) for one in parts
    )
    return Points(speed, height, mode, order)


def points_of(record: Record, section: str) -> Points:
    """All maxima of the torque of a section that are told, by rising speed."""
    found = [vector(record, f"summit/{name}", "summit")
             for name in ("speed", "torque_half_range", "mode", "half_order")]  # fmt: skip
    held = vector(record, "summit/section", "summit")
    top = top_of(record, section)
    listed = names(record, "speeds/torque_half_range", "section")
    if held is None or section not in listed or any(one is None for one in found):
        return top
    speed, height, mode, order = (np.asarray(one, dtype=float) for one in found)
    own = (held == listed.index(section) + 1) & np.isfinite(height)
    # the highest is a maximum between the ends of the range, or at one of them
    new = not np.any(np.isclose(speed[own], top.speed, rtol=1e-6)) if top.speed.size else False
    more = top if new else Points(*(np.zeros(0),) * 4)
    joined = [
        np.concatenate([one[own], other])
        for one, other in zip((speed, height, mode, order), more, strict=True)
    ]
    rising = np.argsort(joined[0], kind="stable")
    return Points(*(one[rising] for one in joined))


def through(
    speed: np.ndarray, curve: np.ndarray, points: Points, factor: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """A curve over speeds (rad/s) with the points in it; gaps where it is infinite."""
    fresh = ~np.isin(points.speed, speed)
    x = np.concatenate([speed, points.speed[fresh]])
    y = np.concatenate([curve, factor * points.height[fresh]])
    rising = np.argsort(x, kind="stable")
    return x[rising], np.where(np.isfinite(y), y, np.nan)[rising]


def name(axes: "Axes", points: Points, factor: float, ends: tuple[float, float]) -> None:
    """Dots, and above the axes the mode / order of each with a line to it; `ends` in rpm."""
    if not points.speed.size:
        return
    at, height = rpm(1.0) * points.speed, factor * points.height
    axes.plot(at, height, "o", color=COLOURS[0], ms=5, zorder=6,
              label="maximum, with mode / order")  # fmt: skip
    for x, y, place, mode, order in zip(
        at, height, spread(at, ends), points.mode, points.order, strict=True
    ):
        axes.annotate(
            _words(float(x), float(mode), float(order), ends), (x, y), xytext=(place, 1.012),
            textcoords=axes.get_xaxis_transform(), rotation=90, ha="center", va="bottom",
            fontsize=8, color=COLOURS[0], annotation_clip=False,
            arrowprops={"arrowstyle": "-", "linewidth": 0.6, "linestyle": ":", "shrinkA": 0.0,
                        "shrinkB": 3.0, "relpos": (0.5, 0.0), "color": COLOURS[0]},
        )  # fmt: skip


def spread(at: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Places near `at` (ascending) within the ends that leave room for a name each."""
    room = _APART * (ends[1] - ends[0])
    room = min(room, (ends[1] - ends[0]) / max(len(at) - 1, 1))
    places = at.copy()
    for _ in range(200):
        close = np.diff(places) < room * (1.0 - 1e-6)
        if not close.any():
            break
        push = 0.5 * np.maximum(room - np.diff(places), 0.0)
        places[:-1] -= push
        places[1:] += push
        places = np.clip(places, *ends)
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + room)
    if places[-1] > ends[1]:
        places[-1] = ends[1]
        for i in range(len(places) - 2, -1, -1):
            places[i] = min(places[i], places[i + 1] - room)
    return places


def _words(at: float, mode: float, order: float, ends: tuple[float, float]) -> str:
    """`2 / 3`, or why there is none."""
    if mode and order:
        return f"{int(mode)} / {order_text(order)}"
    near = _AT_END * (ends[1] - ends[0])
    return "end" if at - ends[0] <= near or ends[1] - at <= near else "several"


def _entry(record: Record, path: str, section: str) -> np.ndarray:
    """One entry of a quantity by section as an array of one, empty if it is not there."""
    quantity = having(record, TORSION + path, "section")
    place = place_of(quantity, section)
    if quantity is None or place is None:
        return np.zeros(0)
    return np.asarray(quantity.values, dtype=float)[place : place + 1]

"""Adapter: how far the modes of a shaft line are from its orders.

What a rule asks of that (`hardware/shaft_rules.py`) is told where the case names the rule.
"""

import numpy as np

from vibecalc.excitation.order_sums import major_orders
from vibecalc.hardware.shaft_limits import separation
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup

CLASSES = ("major", "other")


def beyond(setup: Setup, highest_speed: float) -> BoolArray:
    """Modes (m,) that no order of the case is near, or that none makes resonate.

    That is rigid modes, those damped so strongly that no response peaks near them, and those above
    the highest order. Above it is where the next order, which the case leaves out, would be nearer.
    """
    natural, order = setup.natural(), setup.drive.order
    step = order[-1] - order[-2] if len(order) > 1 else order[-1]
    above = natural.frequency > (order[-1] + 0.5 * step) * highest_speed
    return np.asarray(natural.silent | above)


def emit_separation(scene: Scene, setup: Setup, where: str, low: float, high: float) -> None:
    """Margins (mode, class) from speeds `low` to `high` in rad/s.

    Infinite, with order 0 and kept, for modes `beyond` and for a class without orders.
    """
    rule, firing = setup.torsion.separation, setup.drive.firing
    modes, order = setup.natural(), setup.drive.order
    found = separation(modes.frequency, order, low, high, rule or "api_618")
    blank, major = beyond(setup, high), major_orders(firing.angle, order, firing.bank)
    shape = (len(modes.frequency), len(CLASSES))
    margin, nearest, kept = np.full(shape, np.inf), np.zeros(shape), np.ones(shape, dtype=np.int64)
    error = np.zeros(shape)
    doubt: FloatArray = modes.frequency_error[:, None] / (order * (low if low > 0.0 else high))
    for column, chosen in enumerate((major, ~major)):
        places = np.flatnonzero(chosen)
        if not len(places):
            continue
        own = found.margin[:, places]
        best = np.argmin(own, axis=1)
        row = np.arange(len(own))
        margin[:, column] = np.where(blank, np.inf, own[row, best])
        nearest[:, column] = np.where(blank, 0.0, order[places][best])
        kept[:, column] = np.where(blank, True, np.all(found.kept[:, places], axis=1))
        rounding = 8.0 * EPSILON * (1.0 + np.abs(own[row, best]))
        error[:, column] = doubt[:, places][row, best] + rounding
    axes = {"mode": np.arange(1, shape[0] + 1), "order_class": CLASSES}
    place = f"{ROOT}/separation/{where}"
    scene.emit(f"{place}/margin", margin, np.where(np.isfinite(margin), error, 0.0), axes)
    scene.emit(f"{place}/half_order", nearest, 0.0, axes)
    if rule is not None:
        scene.emit(f"{place}/kept", kept, 0.0, axes)

"""Adapter: forces of the crank train to weights that leave the least of them."""

from functools import partial

import numpy as np

from vibecalc.balance.model import orders_that_count, sought_weights
from vibecalc.balance.results import After, Before, Left, Shaking, WeightsFound
from vibecalc.balance.weights import (
    Places,
    Solution,
    across_of,
    counting,
    least_residual,
    longest,
    residual,
)
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import DIRECTIONS, Forcing, length_over_cycle, norm_with_tail
from vibecalc.excitation.crank_forces import rotating_part
from vibecalc.excitation.inertia_forces import at_speed, couples_of, forces_of, with_terms
from vibecalc.numerics.bounded import Bounded, Summed, concatenate, rounded, stack
from vibecalc.parts.crank_train import RotatingMasses


def run_balance(scene: Scene) -> None:
    """Emit the weights, and forces, couples and residuals by order without and with them."""
    forcing: Forcing = scene.handed_on["forcing"]
    given, train = scene.case.balance, scene.parts.crank_train
    assert given is not None
    weights = given.force_weight, given.couple_weight, given.roll_weight
    counts = counting(weights, given.reference_length, train.axis)
    sought, orders = sought_weights(given, scene.case.machine.crank_train), orders_that_count(given)
    ratio, before = sought.places.speed_ratio, forcing.per_speed_squared
    rows = [np.flatnonzero(np.abs(ratio) == order) for order in orders]
    places = [Places(*(part[which] for part in sought.places)) for which in rows]
    solved = [
        least_residual(before[order - 1], those, train, counts)
        for order, those in zip(orders, places, strict=True)
    ]
    for order, one in zip(orders, solved, strict=True):
        if not np.any(one.unbalance.value) and one.left.value > one.left.error:
            scene.warn(
                f"[balance]: no weight reduces order {order}, so that all of its weights are zero"
            )
    back = np.argsort(np.concatenate(rows))
    unbalance = concatenate([one.unbalance for one in solved])[back]
    phase = concatenate([one.phase for one in solved])[back]
    share = np.concatenate([one.share for one in solved])[back]
    position = sought.places.start + share[:, None] * (sought.places.end - sought.places.start)
    known, bounded = np.isfinite(sought.radius), np.isfinite(sought.places.largest)
    found = WeightsFound(
        unbalance=unbalance,
        phase=phase,
        position=rounded(position, 8),
        speed_ratio=ratio.astype(float),
        mass=unbalance[known] / sought.radius[known] if known.any() else None,
        utilisation=unbalance[bounded] / sought.places.largest[bounded] if bounded.any() else None,
    )
    scene.emit_all(found, {**sought.axes, "direction": DIRECTIONS})
    turning = RotatingMasses(
        names=sought.names, unbalance=unbalance, speed_ratio=ratio, phase=phase, position=position
    )
    pull = rotating_part(train, turning, len(forcing.order))
    _emit_shaking(scene, Before, before, forcing, counts)
    _emit_shaking(scene, After, before + pull, forcing, counts)
    _emit_totals(scene, residual(before[np.array(orders) - 1], counts), solved, orders)
    scene.cite(
        "linear least squares with each weight within its bound",
        "weights that leave the least force and couple",
        "Boyd and Vandenberghe, Convex Optimization, 2004, ch. 5 and 11; docs/theory_balance.md",
    )


def _emit_shaking(
    scene: Scene, group: type[Shaking], loads: Bounded, forcing: Forcing, counts: np.ndarray
) -> None:
    """What is left by order, and of all orders together; weights turn at none that is left out."""
    used, axis = forcing.retained, scene.parts.crank_train.axis
    axes = {"order": forcing.order[:used], "direction": DIRECTIONS}
    driven = at_speed(loads, scene.case.machine.speed)
    force, couple, every = forces_of(driven), couples_of(driven), residual(driven, counts)
    found = group(
        force=with_terms(longest(force[:used])),
        couple=with_terms(longest(couple[:used] @ across_of(axis))),
        roll_couple=with_terms(abs(couple[:used] @ axis)),
        residual=with_terms(every[:used]),
        all_orders=norm_with_tail(every, forcing),
        force_peak=partial(length_over_cycle, force.T, forcing),
        couple_peak=partial(length_over_cycle, couple.T, forcing),
    )
    scene.emit_all(found, axes)
    if group is After:
        scene.emit_all(Left(with_terms(force[:used]), with_terms(couple[:used])), axes)


def _emit_totals(
    scene: Scene, before: Bounded, solved: list[Solution], orders: tuple[int, ...]
) -> None:
    """Residuals of the orders that count; the gap to what weights can leave at least."""
    square = scene.case.machine.speed**2
    total = (square * before).norm()
    left = (square * stack([one.left for one in solved])).norm()
    least = square * np.linalg.norm([one.lower_bound for one in solved])
    results = Left(
        residual_before=with_terms(total),
        residual=with_terms(left),
        gap=Summed(max(0.0, float(left.value - least)), 2.0 * left.error, float(total.value)),
        free_directions=np.array([float(one.free_directions) for one in solved]),
    )
    scene.emit_all(results, {"balanced_order": np.array(orders)})

"""Adapter: forces of the crank train to weights that leave the least of them."""

import numpy as np

from vibecalc.balance.model import Sought, orders_that_count, sought_weights
from vibecalc.balance.results import After, Before, Left, Shaking, WeightsFound
from vibecalc.balance.weights import (
    Frame,
    Measure,
    Places,
    Solution,
    least_residual,
    longest,
    parted,
    residual,
)
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import (
    DIRECTIONS,
    Forcing,
    couples_of,
    forces_of,
    length_over_cycle,
)
from vibecalc.excitation.crank_forces import TurningWeights, turning_forces
from vibecalc.excitation.inertia_forces import Excitation, add, at_speed, size_of_terms, with_terms
from vibecalc.numerics.bounded import Bounded, Summed, concatenate, rounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.parts.crank_train import CrankTrain


def run_balance(scene: Scene) -> None:
    """Emit the weights, and forces, couples and residuals by order without and with them."""
    forcing: Forcing = scene.handed_on["forcing"]
    given, train = scene.case.balance, scene.parts.crank_train
    if given is None or train is None:
        raise ValueError("[balance] needs a crank train")
    kept = Excitation._make(part[: forcing.retained] for part in forcing.per_speed_squared)
    measure = Measure(
        given.force_weight,
        given.couple_weight,
        given.roll_weight,
        given.reference_length,
        train.axis,
    )
    sought, counting = (
        sought_weights(given, scene.case.machine.crank_train),
        orders_that_count(given),
    )
    solved = {order: _solve(order, kept, sought, train, measure) for order in counting}
    _tell(scene, solved)
    after = _emit_weights(scene, sought, solved, train, kept)
    _emit_orders(scene, kept, after, measure, forcing.order[: forcing.retained])
    _emit_totals(scene, kept, measure, solved)
    for group, one in ((Before, kept), (After, after)):
        _emit_all_orders(scene, group, one, forcing, measure)
    scene.cite(
        "linear least squares with each weight within its bound",
        "weights that leave the least force and couple",
        "Boyd and Vandenberghe, Convex Optimization, 2004, ch. 5 and 11; docs/theory_balance.md",
    )


def _at(order: int, sought: list[Sought]) -> list[int]:
    return [i for i, one in enumerate(sought) if abs(one.speed_ratio) == order]


def _solve(
    order: int, kept: Excitation, sought: list[Sought], train: CrankTrain, measure: Measure
) -> Solution:
    mine = [sought[i] for i in _at(order, sought)]
    places = Places(
        speed_ratio=np.array([one.speed_ratio for one in mine]),
        start=np.array([one.start for one in mine]),
        end=np.array([one.end for one in mine]),
        phase=np.array([one.phase for one in mine]),
        largest=np.array([one.largest for one in mine]),
    )
    of_order = Excitation._make(part[order - 1] for part in kept)
    error = float(residual(of_order, measure).error)
    frame = Frame(train.origin, train.stroke, train.across)
    return least_residual(of_order.force, of_order.couple, error, places, frame, measure)


def _tell(scene: Scene, solved: dict[int, Solution]) -> None:
    """Say where weights do not help."""
    for order, one in solved.items():
        if not np.any(one.unbalance.value) and one.value > one.error:
            scene.warn(
                f"[balance]: no weight lessens what there is of order {order}, so that all of its "
                "weights are zero"
            )


def _emit_weights(
    scene: Scene,
    sought: list[Sought],
    solved: dict[int, Solution],
    train: CrankTrain,
    kept: Excitation,
) -> Excitation:
    """Emit what was found, in the order of the case; gives forces and couples with the weights."""
    places = np.concatenate([_at(order, sought) for order in solved])
    back = np.argsort(places)
    unbalance = concatenate([one.unbalance for one in solved.values()])[back]
    phase = concatenate([one.phase for one in solved.values()])[back]
    share = np.concatenate([one.share for one in solved.values()])[back]
    names = [one.name for one in sought]
    start, end = (np.array([getattr(one, name) for one in sought]) for name in ("start", "end"))
    position = start + share[:, None] * (end - start)
    ratio, radius, largest = (
        np.array([getattr(one, name) for one in sought])
        for name in ("speed_ratio", "radius", "largest")
    )
    known, bounded = np.flatnonzero(~np.isnan(radius)), np.flatnonzero(np.isfinite(largest))
    found = WeightsFound(
        unbalance=unbalance,
        phase=phase,
        position=rounded(position, 8),
        speed_ratio=ratio.astype(float),
        mass=unbalance[known] / radius[known] if known.size else None,
        use=unbalance[bounded] / largest[bounded] if bounded.size else None,
    )
    axes = {
        "weight": names,
        "direction": DIRECTIONS,
        "balance_radius": [names[i] for i in known],
        "balance_bound": [names[i] for i in bounded],
    }
    scene.emit_all(found, axes)
    return add(kept, *_pulls(train, unbalance, ratio, phase.value, position, len(kept.force)))


def _pulls(
    train: CrankTrain,
    unbalance: Bounded,
    ratio: np.ndarray,
    phase: np.ndarray,
    position: np.ndarray,
    highest: int,
) -> list[Excitation]:
    """Forces and couples of the weights, and zeros that are off by what the weights are off by."""
    found, off = (
        turning_forces(
            train, TurningWeights(size, ratio, phase, position), train.origin[None, :], highest
        )
        for size in unbalance
    )
    # the errors of a pull are three roundings of it or more
    none, errors = np.zeros_like(off.force), [off.force_error, off.couple_error]
    return [found, Excitation(none, none, *(one / EPSILON for one in errors))]


def _emit_orders(
    scene: Scene, kept: Excitation, after: Excitation, measure: Measure, orders: np.ndarray
) -> None:
    speed = scene.case.machine.speed
    axes = {"order": orders, "direction": DIRECTIONS}
    terms: dict[str, float] = {}
    for group, one in ((Before, kept), (After, after)):
        driven = at_speed(one, speed)
        force, couple = forces_of(driven), couples_of(driven)
        across, about = parted(driven.couple, measure.axis)
        found = {
            "force": longest(force),
            "couple": longest(Bounded(across, 3.0 * driven.couple_error)),
            "roll_couple": abs(Bounded(about, driven.couple_error @ np.abs(measure.axis))),
            "residual": residual(driven, measure),
        }
        for name, value in found.items():
            terms[name] = max(terms.get(name, 0.0), size_of_terms(value.error))
        sums = {
            name: Summed(value.value, value.error, terms[name]) for name, value in found.items()
        }
        scene.emit_all(group(**sums), axes)
        if group is After:
            scene.emit_all(Left(with_terms(force), with_terms(couple)), axes)


def _emit_all_orders(
    scene: Scene, group: type[Shaking], kept: Excitation, forcing: Forcing, measure: Measure
) -> None:
    """Residual, force and couple of all orders together; weights turn at none that is left out."""
    beyond = (part[forcing.retained :] for part in forcing.per_speed_squared)
    whole = Excitation._make(
        np.concatenate([one, rest]) for one, rest in zip(kept, beyond, strict=True)
    )
    driven = at_speed(whole, scene.case.machine.speed)
    every = residual(driven, measure)
    left, dropped = every[: forcing.retained].norm(), forcing.tail * every.value[forcing.retained :]
    error = left.error + np.linalg.norm(dropped)
    found = group(
        all_orders=with_terms(Bounded(left.value, error), left.error),
        force_peak=lambda: length_over_cycle(forces_of(driven).T, forcing),
        couple_peak=lambda: length_over_cycle(couples_of(driven).T, forcing),
    )
    scene.emit_all(found)


def _emit_totals(
    scene: Scene, kept: Excitation, measure: Measure, solved: dict[int, Solution]
) -> None:
    """Residuals of the orders that count; the gap to what weights can leave at least."""
    square = scene.case.machine.speed**2
    orders = list(solved)
    found = Bounded(
        square * np.array([solved[order].value for order in orders]),
        square * np.array([solved[order].error for order in orders]),
    )
    before = residual(Excitation._make(part[np.array(orders) - 1] for part in kept), measure)
    total = (square * before).norm()
    least = np.linalg.norm(square * np.array([one.lower_bound for one in solved.values()]))
    left = found.norm()
    results = Left(
        residual_before=with_terms(total),
        residual=with_terms(left),
        gap=Summed(max(0.0, float(left.value - least)), 2.0 * left.error, float(total.value)),
        free_directions=np.array([float(one.free_directions) for one in solved.values()]),
    )
    scene.emit_all(results, {"balanced_order": np.array(orders)})

"""Adapter: what the mounts keep from the ground, by order, overall and over frequency."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.inertia_forces import with_terms
from vibecalc.isolation.efficiency import (
    OverCycle,
    by_order,
    efficiency,
    is_more,
    is_swamped,
    own_part,
    peak,
    rms,
)
from vibecalc.isolation.on_mounts import OnMounts, frequency_grid, of_each
from vibecalc.isolation.results import ByDirection, OfCouples, OfForces, OfVector
from vibecalc.numerics.bounded import Bounded, bounded, concatenate
from vibecalc.numerics.rounding import ComplexArray
from vibecalc.parts.body import COORDINATES, cross_matrix
from vibecalc.response.adapters.loads import BodyLoads, steady_motion


class Ground(NamedTuple):
    """What reaches the ground through a foundation that moves: loads (m, 6) at the speed.

    `passing` gives loads there over loads on the machine (frequencies, 6, 6) at rad/s, with
    something to see about the `natural` frequencies.
    """

    load: Bounded
    passing: Callable[[np.ndarray], Bounded]
    natural: np.ndarray


def run_efficiency(scene: Scene) -> None:
    """Emit loads held still and on the ground, their ratios, and these over frequency."""
    system: OnMounts = scene.handed_on["on_mounts"]
    loads: BodyLoads = scene.handed_on["loads"]
    given: Ground | None = scene.handed_on.get("ground")
    frequency = loads.order * scene.case.machine.speed
    if given is None:
        motion = steady_motion(scene, system, system.felt(loads.load), loads.order)
        ground, natural = system.ground_load(motion, frequency), system.shapes.natural_frequency
        given = Ground(ground, system.transmissibility, natural)
    scene.cite(
        "isolation efficiency: 1 - transmissibility of forces and couples on the ground",
        "isolation of the ground",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 30",
    )
    # loads about the mass centre; that of pitch is about it
    body, freedoms, centre = scene.parts.body, system.freedoms, np.eye(6)
    if body is not None and len(freedoms) > 1:
        centre[3:, :3] = -cross_matrix(body.centre)
    centre = centre[np.ix_(freedoms, freedoms)]
    held, ground = system.felt(loads.load) @ centre.T, given.load @ centre.T
    # unit loads at the mass centre are such about the reference point with the couple they have
    back = np.linalg.inv(centre)
    through = centre @ given.passing(frequency) @ back
    directions = []
    for group, chosen in ((OfForces, freedoms < 3), (OfCouples, freedoms >= 3)):
        if np.any(chosen):
            names = [COORDINATES[place] for place in freedoms[chosen]]
            both = held[:, chosen], ground[:, chosen]
            own = own_part(both[0], through, chosen)
            directions.append(_emit_vector(scene, group, *both, own, names, loads))
    grid = frequency_grid(given.natural, highest=float(frequency[loads.retained - 1]))
    curve = of_each(centre @ given.passing(grid) @ back)
    axes = {
        "coordinate": [COORDINATES[place] for place in freedoms],
        "frequency": grid / (2.0 * np.pi),
    }
    scene.emit_all(ByDirection(concatenate(directions), curve), axes)


def has_share(
    scene: Scene, words: str, unit: str, held: OverCycle, ground: OverCycle, own: OverCycle
) -> bool:
    """Whether there is something to isolate that the load on the ground may be compared with.

    Of root mean squares. Where the `own` part of what arrives is next to nothing there is not: a
    warning says so.
    """
    none, nothing = (not one.value.value > 4.0 * one.rounding for one in (held, ground))
    if none and nothing:
        return False
    if none or is_swamped(held.value, ground.value, own.value.value):
        values = 0.0 if none else float(held.value.value), float(ground.value.value)
        acts, arrives = (f"{one:.4g} {unit}" for one in values)
        scene.warn(
            f"no isolation efficiency of the {words}: the rigidly mounted machine passes on "
            f"{acts} r.m.s., and the {arrives} r.m.s. on the ground come from its other loads"
        )
        return False
    return True


def _emit_vector(
    scene: Scene,
    group: type[OfVector],
    held: Bounded,
    ground: Bounded,
    own: ComplexArray,
    names: list[str],
    loads: BodyLoads,
) -> Bounded:
    """Emit results of forces or couples; the efficiency of the r.m.s. by direction."""
    used, tail = loads.retained, loads.tail
    results: dict[str, Any] = {
        "held": with_terms(held[:used]),
        "ground": with_terms(ground[:used]),
        "by_order": by_order(held[:used], ground[:used], own[:used]),
    }
    acting, arrived = (rms(one, used, tail) for one in (held, ground))
    alone = rms(bounded(own), used, tail)
    totals = acting.norm(), arrived.norm()
    unit = group.WORDS["unit"].replace("*", " ")
    shares = has_share(scene, group.WORDS["what"], unit, *totals, alone.norm())
    peaks = (peak(one, loads.order, used, tail) for one in (held, ground))
    for name, (first, second) in {"rms": totals, "peak": peaks}.items():
        results[f"held_{name}"] = with_terms(first.value, first.rounding)
        results[f"ground_{name}"] = with_terms(second.value, second.rounding)
        if not shares or not first.value.value > 4.0 * first.rounding:
            continue
        ratio = second.value / first.value
        results[name] = 1.0 - ratio
        if second.value.value > 4.0 * second.rounding:
            level = -20.0 * np.log10(ratio.value)
            results[f"{name}_level"] = Bounded(level, 8.7 * ratio.error / ratio.value)
    axes = {
        "order": loads.order[:used].astype(float),
        "coordinate": names,
        "component": [*names, "resultant"],
    }
    scene.emit_all(group(**results), axes)
    acts, arrives = (is_more(*one, one.norm().value) for one in (acting, arrived))
    acts &= ~is_swamped(acting.value, arrived.value, alone.value.value)
    return efficiency(acting.value, arrived.value, acts, arrives)

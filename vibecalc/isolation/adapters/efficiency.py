"""Adapter: what the mounts keep from the ground, by order, overall and over frequency."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.inertia_forces import with_terms
from vibecalc.isolation.adapters.loads import BodyLoads, steady_motion
from vibecalc.isolation.efficiency import Overall, by_order, efficiency, is_more, overall, rms
from vibecalc.isolation.efficiency_results import ByDirection, OfCouples, OfForces, OfVector
from vibecalc.isolation.on_mounts import OnMounts, frequency_grid, of_each
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.parts.body import COORDINATES, cross_matrix


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
    felt = system.felt(loads.load)
    frequency = loads.order * scene.case.machine.speed
    if given is None:
        motion = steady_motion(scene, system, loads.load, loads.order)
        ground, natural = system.ground_load(motion, frequency), system.shapes.natural_frequency
        given = Ground(ground, system.transmissibility, natural)
    scene.cite(
        "isolation efficiency: 1 - transmissibility of forces and couples on the ground",
        "isolation of the ground",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 30",
    )
    centre = _to_centre(scene, system)
    held, ground = felt @ centre.T, given.load @ centre.T
    for group, first, second, names in _vectors(system, held, ground):
        _emit_vector(scene, group, first, second, names, loads)
    _emit_rms(scene, system, held, ground, loads)
    _emit_curve(scene, system, given, centre, float(frequency[loads.retained - 1]))


def _to_centre(scene: Scene, system: OnMounts) -> np.ndarray:
    """Matrix (f, f) that takes loads about the reference point to those about the mass centre."""
    body, matrix = scene.parts.body, np.eye(6)
    if body is not None and len(system.freedoms) > 1:  # that of pitch is about the centre
        matrix[3:, :3] = -cross_matrix(body.centre)
    return np.asarray(matrix[np.ix_(system.freedoms, system.freedoms)])


def _vectors(
    system: OnMounts, held: Bounded, ground: Bounded
) -> Iterator[tuple[type[OfVector], Bounded, Bounded, list[str]]]:
    """Forces and couples, as far as the model has them: results, both, names of components."""
    for group, chosen in ((OfForces, system.freedoms < 3), (OfCouples, system.freedoms >= 3)):
        if np.any(chosen):
            names = [COORDINATES[place] for place in system.freedoms[chosen]]
            yield group, held[:, chosen], ground[:, chosen], names


def _emit_vector(
    scene: Scene,
    group: type[OfVector],
    held: Bounded,
    ground: Bounded,
    names: list[str],
    loads: BodyLoads,
) -> None:
    used = loads.retained
    results: dict[str, Any] = {
        "held": with_terms(held[:used]),
        "ground": with_terms(ground[:used]),
        "by_order": by_order(held[:used], ground[:used]),
    }
    both = [overall(one, loads.order, used, loads.tail) for one in (held, ground)]
    for place, name in enumerate(Overall._fields):
        first, second = (one[place] for one in both)
        results[f"held_{name}"] = with_terms(first.value, first.rounding)
        results[f"ground_{name}"] = with_terms(second.value, second.rounding)
        # where nothing acts there is nothing to isolate
        if not first.value.value > 4.0 * first.rounding:
            continue
        ratio = second.value / first.value
        results[name] = 1.0 - ratio
        if second.value.value > 4.0 * second.rounding:
            level = -20.0 * np.log10(ratio.value)
            results[f"{name}_level"] = Bounded(level, 8.7 * ratio.error / ratio.value)
    axes = {
        "half_order": loads.order[:used].astype(float),
        "coordinate": names,
        "component": [*names, "resultant"],
    }
    scene.emit_all(group(**results), axes)


def _emit_rms(
    scene: Scene, system: OnMounts, held: Bounded, ground: Bounded, loads: BodyLoads
) -> None:
    """Efficiency of the root of the mean square, by direction."""
    first, second = (rms(one, loads.retained, loads.tail) for one in (held, ground))
    parts = []
    for chosen in (system.freedoms < 3, system.freedoms >= 3):
        if np.any(chosen):
            acting, arrived = first.some(chosen), second.some(chosen)
            acts, arrives = (is_more(*one, one.norm().value) for one in (acting, arrived))
            parts.append(efficiency(acting.value, arrived.value, acts, arrives))
    names = [COORDINATES[place] for place in system.freedoms]
    scene.emit_all(ByDirection(concatenate(parts)), {"coordinate": names})


def _emit_curve(
    scene: Scene, system: OnMounts, given: Ground, centre: np.ndarray, highest: float
) -> None:
    """Of a load of one size at all frequencies, in the direction in which it acts."""
    grid = frequency_grid(given.natural, highest=highest)
    # unit loads at the mass centre are such about the reference point with the couple they have
    found = centre @ given.passing(grid) @ np.linalg.inv(centre)
    axes = {
        "coordinate": [COORDINATES[place] for place in system.freedoms],
        "frequency": grid / (2.0 * np.pi),
    }
    scene.emit_all(ByDirection(transmissibility=of_each(found)), axes)

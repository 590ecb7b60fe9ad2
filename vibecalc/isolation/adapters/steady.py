"""What all that acts on a body does at its mounts at the operating speed."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import MotionByOrder, length_over_cycle, peak_with_tail
from vibecalc.excitation.inertia_forces import size_of_terms
from vibecalc.isolation.adapters.common import (
    EXCURSION,
    LARGEST,
    LOADS,
    VERTICAL,
    emit_support_motion,
    emit_with_constant,
    isolation_of,
)
from vibecalc.isolation.adapters.loads import BodyLoads
from vibecalc.isolation.at_mounts import AtMounts
from vibecalc.isolation.results import CAUSES, TORQUE_REACTION_ROOT
from vibecalc.numerics import bounded
from vibecalc.numerics.bounded import Bounded
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.mounts import Mounts


class Moved(NamedTuple):
    """Complex amplitudes at the orders (m,): of the reference point and at the mounts.

    `motion` (..., m, 6); `at_mounts` of the body there, `deflection` of the mounts and `force` on
    what they stand on (..., mounts, d, m) in the `directions` (d,) that the model has.
    """

    motion: Bounded
    at_mounts: Bounded
    deflection: Bounded
    force: Bounded
    directions: tuple[int, ...] = (0, 1, 2)


class AtRest(NamedTuple):
    """Sag and load (..., mounts) by the weight, and what the mean torque adds."""

    sag: Bounded
    load: Bounded
    mean: AtMounts


def emit_steady(
    scene: Scene,
    mounts: Mounts,
    loads: BodyLoads,
    at_rest: AtRest,
    moved: Moved,
    solve: Callable[[Bounded], Moved],
) -> None:
    """Emit motion, forces and loads of the supports, `moved` by all that acts.

    `solve` takes loads (..., m, 6) of which a part has to be told apart.
    """
    scene.handed_on["motion_by_order"] = MotionByOrder(
        loads.order, loads.retained, loads.tail, moved.motion
    )
    if isolation_of(scene).model != "pitch":
        _emit_motion(scene, loads, moved.motion)
    names = [DIRECTIONS[place] for place in moved.directions]
    emit_support_motion(scene, loads, mounts.names, names, moved.at_mounts, moved.force)
    axes = {"mount": mounts.names}
    if scene.wants(LARGEST):
        largest = length_over_cycle(moved.force, loads)
        scene.emit(LARGEST, largest.value, largest.error, axes, terms=largest.terms)
    if scene.wants(VERTICAL, EXCURSION, *LOADS):
        _emit_upright(scene, mounts, loads, at_rest, moved)
    if mounts.rest is not None:
        from vibecalc.isolation.adapters.mounts import emit_travel

        emit_travel(scene, mounts, moved.deflection, at_rest.mean.displacement, loads)
    if loads.torque is not None:
        _emit_torque(scene, mounts, loads, at_rest, moved)
        _emit_by_cause(scene, mounts, loads, loads.torque, solve)


def _emit_motion(scene: Scene, loads: BodyLoads, motion: Bounded) -> None:
    used = loads.retained
    axes = {"order": loads.order[:used], "direction": DIRECTIONS}
    for name, part in (("translation", slice(0, 3)), ("rotation", slice(3, 6))):
        scene.emit(
            f"isolation/body/{name}_harmonics",
            motion[..., :used, part],
            axes=axes,
            terms=size_of_terms(motion.error[..., :used, part]),
        )


def _emit_upright(
    scene: Scene, mounts: Mounts, loads: BodyLoads, at_rest: AtRest, moved: Moved
) -> None:
    """Vertical motion of the body; deflection and load of the mounts with what is constant."""
    up = np.eye(3)["xyz".index(isolation_of(scene).up)]
    still = [_along(one[..., None], up)[..., 0] for one in at_rest.mean]
    up = up[list(moved.directions)]
    highest = peak_with_tail(_along(moved.at_mounts, up), loads)
    axes = {"mount": mounts.names}
    scene.emit(VERTICAL, highest.value, highest.error, axes, terms=highest.terms)
    raised, lifted = still
    down, load = (-_along(one, up) for one in (moved.deflection, moved.force))
    given = (down, load, at_rest.sag - raised, at_rest.load - lifted, loads)
    emit_with_constant(scene, mounts.names, *given)


def _along(vector: Bounded, direction: np.ndarray) -> Bounded:
    """Component (..., mounts, orders) of vectors (..., mounts, 3, orders)."""
    return Bounded(
        np.einsum("...dn,d->...n", vector.value, direction),
        np.einsum("...dn,d->...n", vector.error, np.abs(direction)),
    )


def _emit_torque(
    scene: Scene, mounts: Mounts, loads: BodyLoads, at_rest: AtRest, moved: Moved
) -> None:
    """Couple of the cylinders, the roll under all loads, and the force by the mean torque."""
    assert loads.torque is not None
    scene.cite(
        "torque reaction of the cylinders with the shaking of the crank train, order by order",
        f"{scene.case.machine.kind} on its mounts",
        "docs/theory_torsion_mounts.md",
    )
    about = np.concatenate([np.zeros(3), scene.parts.crank_train.axis])
    axes = {"half_order": loads.order[: loads.retained]}
    couple = loads.torque[: loads.retained] @ about
    scene.emit(f"{TORQUE_REACTION_ROOT}/couple", couple, axes=axes)
    scene.emit(f"{TORQUE_REACTION_ROOT}/mean_couple", loads.mean @ about)
    if scene.wants(f"{TORQUE_REACTION_ROOT}/roll_peak"):
        roll = peak_with_tail(moved.motion @ about, loads)
        scene.emit(f"{TORQUE_REACTION_ROOT}/roll_peak", roll.value, roll.error)
    force = at_rest.mean.force + np.zeros((len(mounts.names), 3))
    axes_of = {"mount": mounts.names, "direction": DIRECTIONS}
    scene.emit("isolation/support_force/mean", force, axes=axes_of)


def _emit_by_cause(
    scene: Scene,
    mounts: Mounts,
    loads: BodyLoads,
    torque: Bounded,
    solve: Callable[[Bounded], Moved],
) -> None:
    """Largest force over the cycle of each support by each cause alone."""
    if not scene.wants(CAUSES):
        return
    parts = {"torque of the cylinders": torque, "shaking": loads.load - torque}
    peaks = [length_over_cycle(solve(part).force, loads) for part in parts.values()]
    found = bounded.stack([Bounded(peak.value, peak.error) for peak in peaks])
    scene.emit(CAUSES, found, axes={"mount": mounts.names, "cause": list(parts)})

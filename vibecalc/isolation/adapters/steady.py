"""What all that acts on a body does at its mounts at the operating speed."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import MotionByOrder, kept, length_over_cycle, peak_with_tail
from vibecalc.excitation.inertia_forces import with_terms
from vibecalc.isolation.adapters.common import Extremes, extremes, isolation_of
from vibecalc.isolation.at_mounts import AtMounts, displacement
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.results import BodyMotion, SupportDisplacement, SupportForce, TorqueReaction
from vibecalc.numerics import bounded
from vibecalc.numerics.bounded import Bounded, Summed, maximum
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mounts import Mounts
from vibecalc.response.adapters.loads import BodyLoads


class Moved(NamedTuple):
    """Complex amplitudes at the orders (m,): of the reference point and at the mounts.

    `motion` (..., m, 6); `at_mounts` of the body there, `deflection` of the mounts and `force` on
    what they stand on (..., mounts, d, m) in the `directions` (d,) that the model has. `alike`
    are some of the mounts, and which of these feels the force of each mount, up to its sign.
    """

    motion: Bounded
    at_mounts: Bounded
    deflection: Bounded
    force: Bounded
    directions: tuple[int, ...]
    alike: tuple[np.ndarray, np.ndarray]


def moved_by(system: OnMounts, motion: Bounded, frequency: np.ndarray) -> Moved:
    """What a motion (..., m, f) of a system at frequencies (..., m) is for the machine on it."""
    deflection, reference = system.at_mounts(motion), system.moved(motion)
    at_mounts = deflection
    if motion.shape[-1] > system.resting.reach.shape[-1]:
        # what the mounts stand on moves too, in the other coordinates
        at_mounts = displacement(displacement_at(system.mounts.position), reference)
    force = system.force(deflection, frequency)
    return Moved(reference, at_mounts, deflection, force, system.directions, system.alike())


class AtRest(NamedTuple):
    """Sag and load (..., mounts) by the weight, and what the mean torque adds."""

    sag: Bounded
    load: Bounded
    mean: AtMounts


#: loads (..., m, 6) on the body to what they do
Solve: TypeAlias = Callable[[Bounded], Moved]


def emit_steady(scene: Scene, mounts: Mounts, moved: Moved, solve: Solve) -> None:
    """Emit motion, forces and loads of the supports, `moved` by all that acts.

    `solve` takes loads of which a part has to be told apart.
    """
    loads: BodyLoads = scene.handed_on["loads"]
    at_rest: AtRest = scene.handed_on["at_rest"]
    scene.handed_on["motion_by_order"] = MotionByOrder(
        loads.order, loads.retained, loads.tail, moved.motion
    )
    axes = {
        "mount": mounts.names,
        "order": loads.order[: loads.retained],
        "direction": [DIRECTIONS[place] for place in moved.directions],
    }
    if isolation_of(scene).model != "pitch":
        motion = moved.motion[..., : loads.retained, :]
        move, turn = (with_terms(motion[..., part]) for part in (slice(3), slice(3, None)))
        scene.emit_all(BodyMotion(move, turn), axes)
    up = np.eye(3)["xyz".index(isolation_of(scene).up)]
    few = up[list(moved.directions)]

    def upright(constant: Bounded, moved_by: Bounded, alternating: Bounded) -> Extremes:
        """Of what is constant, without what the mean raises, and what alternates: downwards."""
        still = constant - _along(moved_by[..., None], up)[..., 0]
        return extremes(still, -_along(alternating, few), loads)

    def largest_deflection() -> Bounded:
        both = upright(at_rest.sag, at_rest.mean.displacement, moved.deflection)
        return maximum(abs(both.highest), abs(both.lowest))

    on_supports = partial(upright, at_rest.load, at_rest.mean.force, moved.force)
    displacement = SupportDisplacement(
        steady_harmonics=kept(moved.at_mounts, loads),
        vertical_peak=lambda: peak_with_tail(_along(moved.at_mounts, few), loads),
        total=largest_deflection,
    )
    scene.emit_all(displacement, axes)
    force = SupportForce(
        steady_harmonics=kept(moved.force, loads),
        steady_peak=lambda: _largest(moved, loads),
        largest_load=lambda: on_supports().highest,
        minimum_load=lambda: on_supports().lowest,
    )
    scene.emit_all(force, axes)
    if mounts.rest is not None:
        from vibecalc.isolation.adapters.mounts import emit_travel

        emit_travel(scene, mounts, moved.deflection, at_rest.mean.displacement, loads)
    if loads.torque is not None:
        _emit_torque(scene, loads, loads.torque, moved, solve)
        constant = at_rest.mean.force + np.zeros((len(mounts.names), 3))
        scene.emit_all(SupportForce(mean=constant), axes)


def _largest(moved: Moved, loads: BodyLoads) -> Summed:
    """Largest force of each mount over the cycle, of mounts that are alike once."""
    first, which = moved.alike
    peak = length_over_cycle(moved.force[..., first, :, :], loads)
    return peak._replace(value=peak.value[..., which], error=peak.error[..., which])


def _along(vector: Bounded, direction: np.ndarray) -> Bounded:
    """Component (..., mounts, orders) of vectors (..., mounts, 3, orders)."""
    return (vector * direction[:, None]).sum(-2)


def _emit_torque(
    scene: Scene, loads: BodyLoads, torque: Bounded, moved: Moved, solve: Solve
) -> None:
    """Couple of the cylinders, the roll under all loads, and forces of supports by each cause."""
    scene.cite(
        "torque reaction of the cylinders with the shaking of the crank train, order by order",
        f"{scene.case.machine.kind} on its mounts",
        "docs/theory_mounts.md",
    )
    about = np.concatenate([np.zeros(3), scene.parts.crank_train.axis])
    found = TorqueReaction(
        couple=torque[: loads.retained] @ about,
        mean_couple=loads.mean @ about,
        roll_peak=lambda: peak_with_tail(moved.motion @ about, loads),
    )
    scene.emit_all(found, {"order": loads.order[: loads.retained]})
    parts = {"torque of the cylinders": torque, "shaking": loads.load - torque}

    def alone() -> Bounded:
        peaks = [length_over_cycle(solve(part).force, loads) for part in parts.values()]
        return bounded.stack([Bounded(peak.value, peak.error) for peak in peaks])

    names = scene.parts.mounts.names if scene.parts.mounts else ()
    scene.emit_all(SupportForce(by_cause=alone), {"mount": names, "cause": list(parts)})

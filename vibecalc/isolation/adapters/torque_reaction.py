"""Adapter: a machine on its mounts under the torque of its cylinders, steady or running up."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import as_loads, at_speed
from vibecalc.isolation.adapters.common import (
    KeptRows,
    RunUpSection,
    RunUpSetup,
    isolation_of,
)
from vibecalc.isolation.adapters.loads import steady_motion
from vibecalc.isolation.adapters.rigid_body import MountedBody, of_body, static_of
from vibecalc.isolation.adapters.torque_couple import (
    Couples,
    Passing,
    TorqueLaw,
    couples_of,
    line_passing,
    torque_law,
    total_torque,
)
from vibecalc.isolation.on_mounts import OnMounts, on_mounts
from vibecalc.isolation.results import TORQUE_REACTION_ROOT
from vibecalc.isolation.rigid_body import (
    all_six,
    displacement,
    held,
    mount_force,
)
from vibecalc.isolation.rows import CoupleAt, HarmonicsAt, Readout, with_left_out
from vibecalc.isolation.torque_reaction import (
    TAIL,
    couple_by_differences,
    couple_on_body,
    extreme_loads,
    linear_couple,
    nearest_driven,
    torque_left_out,
    vector_peak,
    with_shaking,
)
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.matrices import Matrices
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.parts.body import DIRECTIONS, RigidBody, dofs_of_model
from vibecalc.parts.firing import TURN, cycle_angle, shakes_with_torque
from vibecalc.parts.matrices import mounted
from vibecalc.parts.mounts import Mounts
from vibecalc.response.forced import MotionByOrder, dynamics, response
from vibecalc.response.modes import Modes
from vibecalc.response.resonances import Resonances, idle_warnings

# ----------------------------------------------------------------------------
# Adapter: a machine on its mounts under the torque of its cylinders, with what shakes it.
# ----------------------------------------------------------------------------

#: an order that drives a mode is worth a word within this share of its natural frequency
CLOSE = 0.1


class Driven(NamedTuple):
    """A body on its mounts with all that drives it.

    `shaking` (n, 6) of the orders 1 .. n, `loads` (m, f) with the couples of the torque.
    """

    system: OnMounts
    couples: Couples
    shaking: Bounded
    loads: Bounded


def driven_body(scene: Scene) -> Driven:
    """The machine of a case under the torque of its cylinders with what shakes it, at its speed."""
    forcing: Forcing = scene.handed_on["forcing"]
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    freedoms = dofs_of_model(isolation_of(scene).model, scene.case.machine.crank_train.axis)
    couples = couples_of(scene, forcing.retained)
    shaking = as_loads(at_speed(forcing.per_speed_squared, scene.case.machine.speed))
    axis = scene.parts.crank_train.axis
    loads = _of(with_shaking(couples.added, couples.order, axis, shaking), freedoms)
    return Driven(on_mounts(body, mounts, freedoms), couples, shaking, loads)


def motion_with_torque(scene: Scene) -> MotionByOrder:
    """Motion of the body by all that drives it, for those who read it at other places."""
    system, couples, _, loads = driven_body(scene)
    few, _ = steady_motion(scene, system, loads, couples.order)
    return MotionByOrder(couples.order, couples.retained, TAIL, _six(few, system.freedoms))


def run_torque_reaction(scene: Scene) -> None:
    """Emit couple, motion, forces and loads of the supports, and how near orders come to modes."""
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None:
        raise ValueError("isolation needs a body and mounts")
    options, speed = isolation_of(scene), scene.case.machine.speed
    axis = scene.parts.crank_train.axis
    system, couples, shaking, loads = driven_body(scene)
    freedoms, shapes = system.freedoms, system.shapes
    whole = held(system.whole, freedoms)
    scene.cite(
        "torque reaction of the cylinders with the shaking of the crank train, order by order",
        f"{scene.case.machine.kind} on its mounts",
        "docs/theory_torsion_mounts.md",
    )
    used, order = couples.retained, couples.order
    scene.emit(
        f"{TORQUE_REACTION_ROOT}/couple",
        couples.total.value[:used],
        couples.total.error[:used],
        {"half_order": order[:used]},
    )
    scene.emit(f"{TORQUE_REACTION_ROOT}/mean_couple", couples.mean.value, couples.mean.error)

    few, resonances = steady_motion(scene, system, loads, order)
    motion = _six(few, freedoms)
    _emit_nearest(scene, shapes, resonances, loads, couples)
    _emit_motion(scene, motion, axis, couples)
    at_mounts = displacement(motion, mounts.position)
    force = system.force(at_mounts, order * speed)
    alone = with_shaking(couples.total, order, axis, Bounded(shaking.value[:0], shaking.error[:0]))
    torque_motion, _ = steady_motion(scene, system, _of(alone, freedoms), order)
    at_mounts_by_torque = displacement(_six(torque_motion, freedoms), mounts.position)
    of_torque = system.force(at_mounts_by_torque, order * speed)
    by_mount = {"mount": mounts.names}
    scene.emit(
        f"{TORQUE_REACTION_ROOT}/support_force",
        force.value[..., :used],
        force.error[..., :used],
        {**by_mount, "direction": DIRECTIONS, "half_order": order[:used]},
    )
    for name, harmonics in (("peak", force), ("of_torque", of_torque)):
        peak = vector_peak(harmonics, order, used)
        scene.emit(f"{TORQUE_REACTION_ROOT}/support_force_{name}", peak.value, peak.error, by_mount)
    mean = _mean_force(held(_against_rest(system, body), freedoms), mounts, couples.mean, axis)
    scene.emit(
        f"{TORQUE_REACTION_ROOT}/mean_support_force",
        mean.value,
        mean.error,
        {**by_mount, "direction": DIRECTIONS},
    )
    up = np.eye(3)["xyz".index(options.up)]
    static = static_of(scene, whole, body, mounts)
    share = static.share - mean.value @ up
    share_error = static.share_error + mean.error @ up + UNIT_ROUNDOFF * np.abs(share)
    downwards = Bounded(
        -np.einsum("mdn,d->mn", force.value, up), np.einsum("mdn,d->mn", force.error, up)
    )
    if mounts.rest is not None:
        from vibecalc.isolation.adapters.mounts import emit_travel

        emit_travel(scene, mounts, at_mounts, order, used)
    load = extreme_loads(downwards, order, used, Bounded(share, share_error))
    scene.emit(f"{TORQUE_REACTION_ROOT}/largest_load", load.highest, load.error, by_mount)
    scene.emit(f"{TORQUE_REACTION_ROOT}/minimum_load", load.lowest, load.error, by_mount)


def _of(loads: Bounded, freedoms: np.ndarray) -> Bounded:
    return Bounded(loads.value[:, freedoms], loads.error[:, freedoms])


def _six(motion: Bounded, freedoms: np.ndarray) -> Bounded:
    return Bounded(all_six(motion.value, freedoms), all_six(motion.error, freedoms))


def _against_rest(system: OnMounts, body: RigidBody) -> Matrices:
    """All six motions, with the stiffness of the mounts against loads that stay."""
    mounts = system.mounts
    if mounts.static is None:
        return system.whole
    return mounted(body, replace(mounts, stiffness=mounts.static))


def _mean_force(matrices: Matrices, mounts: Mounts, couple: Bounded, axis: np.ndarray) -> Bounded:
    """Force (mounts, 3) of each support on the ground under a constant couple about `axis`."""
    none = np.zeros((6, 6))
    still = matrices._replace(structural=none, structural_error=none)
    load = np.concatenate([np.zeros(3), float(couple.value) * axis])[None]
    uncertainty = np.concatenate([np.zeros(3), float(couple.error) * np.abs(axis)])[None]
    motion = response(dynamics(still, np.zeros(1)), load.astype(complex), uncertainty)
    force = mount_force(
        displacement(motion, mounts.position),
        np.zeros(1),
        mounts.stiffness if mounts.static is None else mounts.static,
        np.zeros_like(mounts.damping),
        np.zeros_like(mounts.structural),
    )
    return Bounded(force.value[..., 0].real, force.error[..., 0])


def _emit_motion(scene: Scene, motion: Bounded, axis: np.ndarray, couples: Couples) -> None:
    used = couples.retained
    axes = {"half_order": couples.order[:used], "direction": DIRECTIONS}
    for name, part in (("translation", slice(0, 3)), ("rotation", slice(3, 6))):
        scene.emit(
            f"{TORQUE_REACTION_ROOT}/{name}",
            motion.value[:used, part],
            motion.error[:used, part],
            axes,
        )
    roll = Bounded(motion.value[:, 3:] @ axis, motion.error[:, 3:] @ np.abs(axis))
    peak = cycle_peak(roll.value[:used], np.rint(2.0 * couples.order[:used]).astype(np.int64))
    scene.emit(
        f"{TORQUE_REACTION_ROOT}/roll_peak", peak.value, peak.error + torque_left_out(roll, used)
    )


def _emit_nearest(
    scene: Scene, shapes: Modes, resonances: Resonances, loads: Bounded, couples: Couples
) -> None:
    """The nearest order of each mode, and a warning for those that nearly meet."""
    speed, used = scene.case.machine.speed, couples.retained
    listed = Bounded(loads.value[:used], loads.error[:used])
    nearest = nearest_driven(shapes, listed, couples.order[:used], speed)
    axes = {"mode": np.arange(1, len(nearest.order) + 1)}
    scene.emit(f"{TORQUE_REACTION_ROOT}/nearest_order", nearest.order, 0.0, axes)
    scene.emit(f"{TORQUE_REACTION_ROOT}/margin", nearest.margin, nearest.margin_error, axes)
    for mode in np.flatnonzero(np.abs(nearest.margin) < CLOSE):
        scene.warn(
            f"order {nearest.order[mode]:g} of the torque reaction and the shaking is within "
            f"{CLOSE:.0%} of mode {mode + 1} of the body on its mounts, "
            f"{resonances.frequency[mode]:.6g} rad/s (damping ratio "
            f"{resonances.damping_ratio[mode]:.2g})"
        )


# ----------------------------------------------------------------------------
# The run-up of a machine whose cylinders turn its body, too: all orders of shaking and torque.
#
# Between two gas cards the torque is linear in the speed, so each such part of the range is a
# run-up of its own.
# ----------------------------------------------------------------------------

#: damping ratio from which a resonance of a shaft line is looked for
_NARROW = 1e-3


def torque_sections(scene: Scene, start: float, stop: float) -> tuple[RunUpSection, ...]:
    """The range from `start` to `stop`, cut at the speeds of the gas cards within it."""
    forcing: Forcing = scene.handed_on["forcing"]
    law = torque_law(scene, forcing.retained)
    within = law.speeds[(law.speeds > start) & (law.speeds < stop)]
    passing = None if shakes_with_torque(scene.case) else line_passing(scene)
    return tuple(
        RunUpSection(_setup(scene, law, passing, low, high), low, high)
        for low, high in pairwise([start, *within.tolist(), stop])
    )


def _setup(
    scene: Scene, law: TorqueLaw, passing: Passing | None, low: float, high: float
) -> RunUpSetup:
    """Rows and resonances between two speeds."""
    on_them: MountedBody = scene.handed_on["mounted"]
    forcing: Forcing = scene.handed_on["forcing"]
    line_frequency = np.zeros(0) if passing is None else _line_frequencies(scene, high)
    axis, ends = scene.parts.crank_train.axis, np.array([low, high])
    none = Bounded(np.zeros(len(law.order)), np.zeros(len(law.order)))
    whole = Bounded(*as_loads(forcing.per_speed_squared))
    shaking = with_shaking(none, law.order, axis, whole)
    about = np.concatenate([np.zeros(3), axis])[on_them.freedoms]

    def of_orders(part: slice) -> tuple[Callable[[Readout, bool], HarmonicsAt], Resonances]:
        force = Bounded(*(each[part][:, on_them.freedoms] for each in shaking))
        couple = _couple(law, passing, ends, part)
        at_ends = couple(ends, errors=True)
        forces = [force, *_about(Bounded(at_ends.value, at_ends.error), about)]
        resonances = _met(on_them.system, forces)

        def rows(readout: Readout, passed_on: bool) -> HarmonicsAt:
            given = (readout, law.order[part], force, resonances, couple, about, passed_on)
            return on_them.system.rows(*given)

        return rows, _with_poles(on_them.system, resonances, forces)

    kept, resonances = of_orders(slice(law.retained))
    others, _ = of_orders(slice(law.retained, None))
    beyond = law.order[law.retained :]

    def rows(readout: Readout, passed_on: bool = False) -> KeptRows:
        return KeptRows(kept(readout, passed_on), others(readout, passed_on), TAIL, beyond)

    travel = on_them.system.travel()
    step, order = TURN / cycle_angle(scene.case.machine), law.order[: law.retained]
    return RunUpSetup(
        rows=with_left_out(*rows(on_them.readout, True)[:3]),
        harmonics=np.arange(1, law.retained + 1),
        step=step,
        resonances=resonances._replace(
            frequency=resonances.frequency / step,
            moved_frequency=np.concatenate([resonances.moved_frequency, line_frequency]) / step,
            moved_ratio=np.concatenate(
                [resonances.moved_ratio, np.full(len(line_frequency), _NARROW)]
            ),
        ),
        shows=on_them.shows,
        row_of=np.arange(on_them.shows.shape[1]),
        lever_rows=0,
        idle=lambda first, last: idle_warnings(resonances, order, first, last),
        of_body=of_body(rows, on_them.freedoms, on_them.shapes),
        travel=None if travel is None else with_left_out(*rows(travel)[:3]),
    )


def _line_frequencies(scene: Scene, speed: float) -> np.ndarray:
    """Natural frequencies of the shaft line above zero, rad/s, where its torque has resonances."""
    from vibecalc.torsion.model import build_shaft_line
    from vibecalc.torsion.modes import natural_modes

    frequency = natural_modes(build_shaft_line(scene.case).at(speed)).frequency
    return frequency[frequency > 0.0]


def _couple(law: TorqueLaw, passing: Passing | None, ends: np.ndarray, part: slice) -> CoupleAt:
    """Couple of the orders `part` that the shaking lacks, as a function of the speed."""
    if passing is None:
        low, high = (couple_on_body(law.gas_at(end), share=law.share) for end in ends)
        return linear_couple(ends, *(Bounded(c.value[part], c.error[part]) for c in (low, high)))
    order = law.order[part]

    def by_the_line(speed: np.ndarray) -> Bounded:
        torque = total_torque(law, speed)
        torque = Bounded(torque.value[..., part], torque.error[..., part])
        return couple_on_body(torque, passing(order, speed))

    return couple_by_differences(by_the_line, *ends.tolist())


def _about(couple: Bounded, axis: np.ndarray) -> list[Bounded]:
    """Loads (orders, f) of the couples (speeds, orders) about an axis (f,), speed by speed."""
    return [
        Bounded(value[:, None] * axis, error[:, None] * np.abs(axis))
        for value, error in zip(couple.value, couple.error, strict=True)
    ]


def _met(system: OnMounts, forces: list[Bounded]) -> Resonances:
    """Resonances of which an order is idle that none of the forces (orders, f) gives a force."""
    found = [system.resonances(force) for force in forces]
    return found[0]._replace(idle=np.all([one.idle for one in found], axis=0))


def _with_poles(system: OnMounts, resonances: Resonances, forces: list[Bounded]) -> Resonances:
    found = [system.with_poles(resonances, force) for force in forces]
    return found[0]._replace(idle=np.all([one.idle for one in found], axis=0))

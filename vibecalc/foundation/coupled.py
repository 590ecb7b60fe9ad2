"""Adapter: loads of the machine onto machine and foundation, and what a rigid one would get."""

from collections.abc import Callable
from functools import partial

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.inertia_forces import with_terms
from vibecalc.foundation.coupled_results import (
    BelowMounts,
    CoupledModes,
    FoundationMotion,
    OnGround,
    OnRigid,
)
from vibecalc.foundation.impedance import CoupledMotion, FlexibleFoundation, on_flexible_foundation
from vibecalc.foundation.model import flexible_foundation, on_body
from vibecalc.isolation.adapters.efficiency import Ground
from vibecalc.isolation.adapters.loads import BodyLoads, steady_motion
from vibecalc.isolation.adapters.steady import Moved, emit_steady
from vibecalc.isolation.at_mounts import displacement
from vibecalc.isolation.efficiency import efficiency, is_more, rms
from vibecalc.isolation.on_mounts import OnMounts, frequency_grid
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.parts.body import COORDINATES, DIRECTIONS, RigidBody
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mount_needs import foundation_kind
from vibecalc.parts.mounts import Mounts

_TURN = 2.0 * np.pi
#: share of the loads' r.m.s. that may be at orders beyond the tables of a foundation
_OUTSIDE = 0.01


def run_coupled(scene: Scene) -> None:
    """Emit modes, motion of both, loads on the ground and on a rigid foundation, their ratios."""
    given, body, mounts = scene.case.foundation, scene.parts.body, scene.parts.mounts
    if given is None or body is None or mounts is None:
        raise ValueError("[foundation] needs a body and mounts")
    loads: BodyLoads = scene.handed_on["loads"]
    frequency = loads.order * scene.case.machine.speed
    still: OnMounts = scene.handed_on["on_mounts"]
    alone_moves, _ = steady_motion(scene, still, still.felt(loads.load), loads.order)
    rigid = still.ground_load(alone_moves, frequency)
    natural = still.shapes.natural_frequency
    solve: Callable[[Bounded], CoupledMotion]
    passing: Callable[[np.ndarray], Bounded]
    if foundation_kind(scene.case) == "body":
        system = on_body(given, body, mounts)
        solve = partial(_on_body, scene, system, loads.order)
        passing = system.transmissibility
        scene.handed_on["on_foundation"] = system
        _emit_modes(scene, system)
        natural = np.concatenate([natural, system.shapes.natural_frequency])
        words = "two rigid bodies, 12 x 12 complex dynamic stiffness"
    else:
        flexible = flexible_foundation(given, mounts.names)
        _inside(scene, flexible, loads, frequency)
        solve = partial(on_flexible_foundation, body, mounts, flexible, frequency)
        passing = partial(_through, body, mounts, flexible)
        words = "mounts in series with the dynamic stiffness of their feet"
    grid = frequency_grid(natural, highest=float(frequency[loads.retained - 1]))
    source = "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3 and 10"
    scene.cite(words, "motion of machine and foundation", source)
    found, at_rest = solve(loads.load), scene.handed_on["at_rest"]

    def moved(load: Bounded) -> Moved:
        return _at_mounts(solve(load), mounts)

    emit_steady(scene, mounts, loads, at_rest, _at_mounts(found, mounts), moved)
    _emit_motion(scene, found, loads, frequency)
    _emit_loads(scene, found.ground, rigid, loads)
    scene.handed_on["ground"] = Ground(found.ground, passing, natural)
    axes = {"coordinate": COORDINATES, "foundation_frequency": grid / _TURN}

    def alone(through: Callable[[np.ndarray], Bounded]) -> Bounded:
        """Of each coordinate, of a load along itself."""
        size = abs(through(grid))
        return reshaped(size, lambda one: np.diagonal(one, axis1=-2, axis2=-1).T)

    scene.emit_all(OnGround(transmissibility=lambda: alone(passing)), axes)
    scene.emit_all(OnRigid(transmissibility=lambda: alone(still.transmissibility)), axes)


def _at_mounts(found: CoupledMotion, mounts: Mounts) -> Moved:
    """The same as of a body on mounts."""
    at_mounts = displacement(displacement_at(mounts.position), found.machine)
    foot, force = (
        reshaped(one, lambda part: np.moveaxis(part, 0, -1)) for one in (found.foot, found.force)
    )
    return Moved(found.machine, at_mounts, at_mounts - foot, force)


def _on_body(scene: Scene, system: OnMounts, order: np.ndarray, load: Bounded) -> CoupledMotion:
    """Motion of two rigid bodies, read as that of a machine on a flexible foundation."""
    frequency = order * scene.case.machine.speed
    motion, _ = steady_motion(scene, system, system.felt(load), order)
    deflection = system.at_mounts(motion)
    force = system.force(deflection, frequency)
    force = reshaped(force, lambda part: np.moveaxis(part, -1, 0))
    lower = Bounded(motion.value[:, None, 6:, None], motion.error[:, None, 6:, None])
    foot = (-system.stretch[..., 6:].astype(complex) @ lower)[..., 0]
    rate = frequency[:, None, None]
    power = (foot * (1j * rate) * Bounded(np.conj(force.value), force.error)).real
    return CoupledMotion(
        motion[:, :6], motion[:, 6:], force, foot,
        system.ground_load(motion, frequency), power.sum(-1).sum(-1) * 0.5,
    )  # fmt: skip


def _emit_modes(scene: Scene, system: OnMounts) -> None:
    shapes = system.shapes
    axes = {"coupled_mode": np.arange(1, len(shapes.natural_frequency) + 1)}
    found = CoupledModes(
        natural_frequency=Bounded(shapes.natural_frequency, shapes.natural_frequency_error),
        damping_ratio=system.damping_ratio(),
        machine_share=system.energy_fraction()[..., :6].sum(-1),
    )
    scene.emit_all(found, axes)


def _inside(
    scene: Scene, foundation: FlexibleFoundation, loads: BodyLoads, frequency: np.ndarray
) -> None:
    """Say which orders are beyond the tables; refuse where these matter."""
    curves = [*foundation.feet.values(), *foundation.plate.values()]
    low = max(float(one.frequency[0]) for one in curves)
    high = min(float(one.frequency[-1]) for one in curves)
    out = (frequency < low) | (frequency > high)
    if low == high or not np.any(out[: loads.retained]):
        return  # one row holds at all frequencies
    size = np.abs(loads.load.value[: loads.retained])
    whole, beyond = (
        np.linalg.norm(part, axis=0) for part in (size, size * out[: loads.retained, None])
    )
    share = float(np.max(beyond / np.where(whole > 0.0, whole, 1.0)))
    first = float(loads.order[int(np.argmax(out))])
    words = (
        f"order {first:g} at {frequency[int(np.argmax(out))] / _TURN:.6g} Hz lies beyond the "
        f"tables of the foundation, {low / _TURN:.6g} to {high / _TURN:.6g} Hz"
    )
    if share > _OUTSIDE:
        raise NumericalFailure(
            f"{words}: {share:.1%} of the r.m.s. of a load on the machine is at such orders; give "
            "the tables more rows"
        )
    scene.warn(f"{words}: their first or last row holds there, for loads of {share:.1e} of all")


def _through(
    body: RigidBody, mounts: Mounts, foundation: FlexibleFoundation, frequency: np.ndarray
) -> Bounded:
    """Load on the ground by unit loads, (frequencies, 6, 6)."""
    unit = np.broadcast_to(np.eye(6, dtype=complex), (len(frequency), 6, 6))
    load = Bounded(unit, np.zeros(unit.shape))
    found = on_flexible_foundation(body, mounts, foundation, frequency, load)
    return reshaped(found.ground, lambda one: np.swapaxes(one, -1, -2))


def _emit_motion(
    scene: Scene, found: CoupledMotion, loads: BodyLoads, frequency: np.ndarray
) -> None:
    used = loads.retained
    mounts = scene.parts.mounts
    axes = {
        "half_order": loads.order[:used].astype(float),
        "direction": DIRECTIONS,
        "mount": mounts.names if mounts is not None else (),
    }
    if np.any(found.plate.value != 0.0) or foundation_kind(scene.case) == "body":
        plate = found.plate[:used]
        scene.emit_all(FoundationMotion(plate[:, :3], plate[:, 3:]), axes)
    speed = found.foot * (1j * frequency[:, None, None])
    below = BelowMounts(
        foot=reshaped(found.foot[:used], lambda one: np.moveaxis(one, 0, -1)),
        foot_velocity_rms=rms(speed, used, loads.tail).norm().value,
        power=found.power[:used],
    )
    scene.emit_all(below, axes)


def _emit_loads(scene: Scene, ground: Bounded, rigid: Bounded, loads: BodyLoads) -> None:
    used = loads.retained
    axes = {"half_order": loads.order[:used].astype(float), "direction": DIRECTIONS}
    for what, part in (("force", slice(0, 3)), ("couple", slice(3, 6))):
        held = loads.load[:, part]
        acting = rms(held, used, loads.tail).norm()
        size = held[:used].norm()
        acts = is_more(size, size.error, size.max(0))
        for group, load in ((OnGround, ground[:, part]), (OnRigid, rigid[:, part])):
            total, arrived = rms(load, used, loads.tail).norm(), load[:used].norm()
            arrives = is_more(arrived, arrived.error, arrived.max(0))
            found = {
                what: with_terms(load[:used]),
                f"{what}_rms": with_terms(total.value, total.rounding),
                f"{what}_by_order": efficiency(size, arrived, acts, arrives),
            }
            if acting.value.value > 4.0 * acting.rounding:
                found[f"{what}_efficiency"] = 1.0 - total.value / acting.value
            scene.emit_all(group(**found), axes)

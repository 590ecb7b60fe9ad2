"""Adapter: loads of the machine onto machine and foundation, and what a rigid one would get."""

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
from vibecalc.foundation.model import flexible_foundation, on_body
from vibecalc.foundation.systems import FlexibleFoundation, OnTables, on_tables
from vibecalc.isolation.adapters.efficiency import Ground
from vibecalc.isolation.adapters.loads import BodyLoads, steady_motion
from vibecalc.isolation.adapters.steady import Moved, emit_steady
from vibecalc.isolation.at_mounts import displacement
from vibecalc.isolation.efficiency import efficiency, is_more, rms
from vibecalc.isolation.on_mounts import OnMounts, frequency_grid, of_each
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.parts.body import COORDINATES, DIRECTIONS
from vibecalc.parts.matrices import displacement_at
from vibecalc.parts.mount_needs import foundation_kind

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
    system: OnMounts
    if foundation_kind(scene.case) == "body":
        system = on_body(given, body, mounts)
        scene.handed_on["on_foundation"] = system
        _emit_modes(scene, system)
        words = "two rigid bodies, 12 x 12 complex dynamic stiffness"
    else:
        flexible = flexible_foundation(given, mounts.names)
        _inside(scene, flexible, loads, frequency)
        system = on_tables(body, mounts, flexible)
        words = "mounts in series with the dynamic stiffness of their feet"
    source = "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3 and 10"
    scene.cite(words, "motion of machine and foundation", source)

    def moved(motion: Bounded) -> Moved:
        deflection = system.at_mounts(motion)
        at_mounts = displacement(displacement_at(mounts.position), motion[:, :6])
        return Moved(motion[:, :6], at_mounts, deflection, system.force(deflection, frequency))

    still: OnMounts = scene.handed_on["on_mounts"]
    motion, alone = (steady_motion(scene, one, loads.load, loads.order) for one in (system, still))
    found = moved(motion)

    def solve(load: Bounded) -> Moved:
        return moved(steady_motion(scene, system, load, loads.order))

    emit_steady(scene, mounts, found, solve)
    _emit_motion(scene, system, motion, found.force, loads, frequency)
    ground = system.ground_load(motion, frequency)
    _emit_loads(scene, ground, still.ground_load(alone, frequency), loads)
    natural = np.concatenate([still.shapes.natural_frequency, system.shapes.natural_frequency])
    scene.handed_on["ground"] = Ground(ground, system.transmissibility, natural)
    grid = frequency_grid(natural, highest=float(frequency[loads.retained - 1]))
    axes = {"coordinate": COORDINATES, "foundation_frequency": grid / _TURN}

    for group, one in ((OnGround, system), (OnRigid, still)):
        scene.emit_all(group(transmissibility=partial(_curves, one, grid)), axes)


def _curves(system: OnMounts, frequency: np.ndarray) -> Bounded:
    return of_each(system.transmissibility(frequency))


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


def _emit_motion(
    scene: Scene,
    system: OnMounts,
    motion: Bounded,
    force: Bounded,
    loads: BodyLoads,
    frequency: np.ndarray,
) -> None:
    """Emit what the foundation does by a motion (m, f) and forces (mounts, 3, m) of the mounts."""
    used = loads.retained
    axes = {
        "half_order": loads.order[:used].astype(float),
        "direction": DIRECTIONS,
        "mount": system.mounts.names,
    }
    kept = list(system.plate if isinstance(system, OnTables) else range(6))
    plate = motion[:used, 6 : 6 + len(kept)] @ np.eye(6)[kept]
    if kept:
        scene.emit_all(FoundationMotion(plate[:, :3], plate[:, 3:]), axes)
    foot = displacement(-system.stretch[..., 6:], motion[:, 6:])
    speed = foot * (1j * frequency)
    power = (speed * Bounded(np.conj(force.value), force.error)).real.sum((0, 1)) * 0.5
    by_order = reshaped(speed, lambda one: np.moveaxis(one, -1, 0))
    below = BelowMounts(
        foot=foot[..., :used],
        foot_velocity_rms=rms(by_order, used, loads.tail).norm().value,
        power=power[:used],
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

"""Adapter: loads of the machine onto machine and foundation, and what a rigid one would get."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.inertia_forces import size_of_terms
from vibecalc.foundation.coupled_results import COUPLED
from vibecalc.foundation.impedance import CoupledMotion, FlexibleFoundation, on_flexible_foundation
from vibecalc.foundation.model import flexible_foundation, stand_on_body
from vibecalc.foundation.stage import kind_of
from vibecalc.isolation.adapters.loads import BodyLoads, body_loads, steady_motion
from vibecalc.isolation.efficiency import efficiency, is_more, rms
from vibecalc.isolation.on_base import (
    Stand,
    alone,
    frequency_grid,
    ground_load,
    transmissibility,
)
from vibecalc.isolation.on_mounts import OnMounts, on_mounts
from vibecalc.numerics import bounded
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.matrices import Matrices
from vibecalc.parts.body import COORDINATES, DIRECTIONS, RigidBody
from vibecalc.parts.mounts import Mounts
from vibecalc.response.forced import MotionByOrder
from vibecalc.response.modal_damping import damped_basis, damping_ratio, energy_fraction
from vibecalc.response.modes import Modes, modes

_TURN = 2.0 * np.pi
#: share of the loads' r.m.s. that may be at orders beyond the tables of a foundation
_OUTSIDE = 0.01


def run_coupled(scene: Scene) -> None:
    """Emit modes, motion of both, loads on the ground and on a rigid foundation, their ratios."""
    given, body, mounts = scene.case.foundation, scene.parts.body, scene.parts.mounts
    if given is None or body is None or mounts is None:
        raise ValueError("[foundation] needs a body and mounts")
    loads = body_loads(scene)
    frequency = loads.order * scene.case.machine.speed
    still = on_mounts(body, mounts, np.arange(6))
    motion, _ = steady_motion(scene, still, loads.load, loads.order)
    rigid = ground_load(alone(still.matrices), motion, frequency)
    natural = still.shapes.natural_frequency
    if kind_of(scene.case) == "body":
        stand = stand_on_body(given, body, mounts)
        matrices = stand.system.matrices
        both = damped_basis(matrices, modes(matrices))
        together = OnMounts(mounts, np.arange(12), matrices, matrices, both)
        found = _on_body(scene, stand, together, loads, frequency)
        _emit_modes(scene, matrices, both)
        natural = np.concatenate([natural, both.natural_frequency])
        grid = frequency_grid(natural, highest=float(frequency[loads.retained - 1]))
        passing = transmissibility(stand.system, grid)
        words = "two rigid bodies, 12 x 12 complex dynamic stiffness"
    else:
        flexible = flexible_foundation(given, mounts.names)
        _inside(scene, flexible, loads, frequency)
        found = on_flexible_foundation(body, mounts, flexible, frequency, loads.load)
        grid = frequency_grid(natural, highest=float(frequency[loads.retained - 1]))
        passing = _through(body, mounts, flexible, grid)
        words = "mounts in series with the dynamic stiffness of their feet"
    source = "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3 and 10"
    scene.cite(words, "motion of machine and foundation", source)
    scene.handed_on["motion_on_foundation"] = MotionByOrder(
        loads.order, loads.retained, loads.tail, found.machine
    )
    _emit_motion(scene, found, loads, frequency)
    _emit_loads(scene, found.ground, rigid, loads)
    at_rest = transmissibility(alone(still.matrices), grid)
    axes = {"coordinate": COORDINATES, "foundation_frequency": grid / _TURN}
    for name, part in (("ground", passing), ("rigid", at_rest)):
        diagonal = reshaped(abs(part), lambda one: np.diagonal(one, axis1=-2, axis2=-1).T)
        scene.emit(f"{COUPLED}/{name}/transmissibility", diagonal, axes=axes)


def _on_body(
    scene: Scene, stand: Stand, system: OnMounts, loads: BodyLoads, frequency: np.ndarray
) -> CoupledMotion:
    """Motion of two rigid bodies, read as that of a machine on a flexible foundation."""
    none = np.zeros(loads.load.shape)
    load = bounded.concatenate([loads.load, Bounded(none.astype(complex), none)])
    motion, _ = steady_motion(scene, system, load, loads.order)
    column = Bounded(motion.value[:, None, :, None], motion.error[:, None, :, None])
    deflection = np.asarray(stand.stretch, dtype=complex) @ column
    force = (stand.passing(frequency) @ deflection)[..., 0]
    lower = Bounded(column.value[..., 6:, :], column.error[..., 6:, :])
    foot = (-stand.stretch[..., 6:].astype(complex) @ lower)[..., 0]
    rate = frequency[:, None, None]
    power = (foot * (1j * rate) * Bounded(np.conj(force.value), force.error)).real
    return CoupledMotion(
        motion[:, :6], motion[:, 6:], force, foot,
        ground_load(stand.system, motion, frequency), power.sum(-1).sum(-1) * 0.5,
    )  # fmt: skip


def _emit_modes(scene: Scene, matrices: Matrices, shapes: Modes) -> None:
    axes = {"coupled_mode": np.arange(1, len(shapes.natural_frequency) + 1)}
    frequency = Bounded(shapes.natural_frequency, shapes.natural_frequency_error)
    scene.emit(f"{COUPLED}/modes/natural_frequency", frequency, axes=axes)
    scene.emit(f"{COUPLED}/modes/damping_ratio", damping_ratio(matrices, shapes), axes=axes)
    share = energy_fraction(matrices, shapes)[..., :6].sum(-1)
    scene.emit(f"{COUPLED}/modes/machine_share", share, axes=axes)


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
    axes = {"half_order": loads.order[:used], "direction": DIRECTIONS}
    for name, part in (("machine", found.machine), ("body", found.plate)):
        if name == "machine" or np.any(part.value != 0.0) or kind_of(scene.case) == "body":
            scene.emit(f"{COUPLED}/{name}/translation", part[:used, :3], axes=axes)
            scene.emit(f"{COUPLED}/{name}/rotation", part[:used, 3:], axes=axes)
    mounts = scene.parts.mounts
    names = mounts.names if mounts is not None else ()
    axes = {**axes, "mount": names}
    for name, part in (("foot", found.foot), ("mount_force", found.force)):
        moved = reshaped(part[:used], lambda one: np.moveaxis(one, 0, -1))
        scene.emit(f"{COUPLED}/{name}", moved, axes=axes)
    speed = found.foot * (1j * frequency[:, None, None])
    velocity = rms(speed, used, loads.tail).norm().value
    scene.emit(f"{COUPLED}/foot_velocity_rms", velocity, axes=axes)
    scene.emit(f"{COUPLED}/power", found.power[:used], axes=axes)


def _emit_loads(scene: Scene, ground: Bounded, rigid: Bounded, loads: BodyLoads) -> None:
    used = loads.retained
    axes = {"half_order": loads.order[:used], "direction": DIRECTIONS}
    for what, part in (("force", slice(0, 3)), ("couple", slice(3, 6))):
        held = loads.load[:, part]
        acting = rms(held, used, loads.tail).norm()
        size = held[:used].norm()
        acts = is_more(size, size.error, size.max(0))
        for name, load in (("ground", ground[:, part]), ("rigid", rigid[:, part])):
            path = f"{COUPLED}/{name}/{what}"
            scene.emit(path, load[:used], axes=axes, terms=size_of_terms(load.error[:used]))
            total, arrived = rms(load, used, loads.tail).norm(), load[:used].norm()
            scene.emit(f"{path}_rms", total.value, terms=size_of_terms(total.rounding))
            arrives = is_more(arrived, arrived.error, arrived.max(0))
            share = efficiency(size, arrived, acts, arrives)
            scene.emit(f"{path}_by_order", share, axes=axes)
            if acting.value.value > 4.0 * acting.rounding:
                scene.emit(f"{path}_efficiency", 1.0 - total.value / acting.value)

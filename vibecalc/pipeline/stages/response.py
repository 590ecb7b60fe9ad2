"""Adapter: the body on its suspension at operating speed."""

import numpy as np

from vibecalc.excitation.adapter import DIRECTIONS, Forcing
from vibecalc.excitation.inertia_forces import as_loads, at_speed, size_of_terms
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.rounding import DATA_ROUNDINGS, EPSILON, WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.linear_system import (
    COORDINATES,
    LinearSystem,
    forcing_of,
    linear_system,
    ratios_of,
    undriven_at_operating_point,
)
from vibecalc.response.assurance import modal_assurance
from vibecalc.response.direct import Undriven, dynamics, response
from vibecalc.response.energies import (
    energies_over_cycle,
    energy_by_order,
    mass_of,
    stiffness_of,
    velocity,
)
from vibecalc.response.energy import energy_fraction
from vibecalc.response.matrices import Matrices
from vibecalc.response.modal import modal_response
from vibecalc.response.trust import require_digits

PARTS = (slice(0, 3), slice(3, 6))
METHODS = {
    "modal": (
        "superposition of modes",
        "Thomson and Dahleh, Theory of Vibration with Applications, 5th ed. 1998, ch. 6",
    ),
    "direct": (
        "6 x 6 complex dynamic stiffness",
        "Harris and Piersol, Shock and Vibration Handbook, 5th ed. 2002, ch. 3",
    ),
}


def run(scene: Scene) -> None:
    """Emit modes, motion, forces on the ground and, where asked for, energies."""
    forcing = forcing_of(scene)
    system = linear_system(scene)
    matrices = system.matrices
    options = scene.case.response
    if options is None:
        raise ValueError("the case has no [response]")
    name, citation = METHODS[options.method]
    scene.cite(name, "motion of the body", citation)

    speed = scene.case.machine.speed
    undriven = undriven_at_operating_point(
        scene, system, as_loads(forcing.per_speed_squared), forcing.orders
    )
    _emit_modes(scene, system, forcing)
    driven = as_loads(at_speed(forcing.per_speed_squared, speed))
    frequency = forcing.orders * speed
    motion = _motion(options.method, system, frequency, driven, undriven, forcing, speed)
    _emit_motion(scene, forcing, motion)
    ground = _ground(matrices, frequency, driven, motion)
    _emit_ground(scene, forcing, ground)
    if options.energies:
        _emit_energies(scene, forcing, matrices, motion, frequency)


def _motion(
    method: str,
    system: LinearSystem,
    frequency: np.ndarray,
    driven: WithError,
    undriven: Undriven,
    forcing: Forcing,
    speed: float,
) -> WithError:
    matrices = system.matrices
    if method == "modal":
        shape = system.shapes.shape
        return modal_response(matrices, shape, frequency, driven.value, driven.error)
    stiffness = dynamics(matrices, frequency, undriven)
    motion = response(stiffness, driven.value, driven.error)
    require_digits(matrices, stiffness, driven, motion, forcing.orders, speed)
    return motion


def _emit_modes(scene: Scene, system: LinearSystem, forcing: Forcing) -> None:
    matrices, shapes = system
    numbers = np.arange(1, 7)
    axes = {"mode": numbers, "coordinate": COORDINATES, "other_mode": numbers}
    frequency, doubt = shapes.natural_frequency, shapes.natural_frequency_error
    scene.emit("response/modes/natural_frequency", frequency, doubt, axes)
    if np.all(shapes.eigenvalue > shapes.eigenvalue_error):
        ratio = ratios_of(scene, system)
        scene.emit("response/modes/damping_ratio", ratio.value, ratio.error, axes)
        _emit_nearest(scene, forcing, frequency, doubt, axes)
    share = energy_fraction(matrices, shapes)
    scene.emit("response/modes/shape", shapes.shape.T, shapes.shape_error, axes)
    scene.emit("response/modes/energy_fraction", share.value, share.error, axes)
    # weighed by the diagonal alone: under the whole mass matrix the modes of one machine are
    # orthogonal by definition, while this says which look alike
    diagonal = np.diag(np.diagonal(matrices.mass))
    own = WithError(shapes.shape, shapes.shape_error)
    alike = modal_assurance(own, own, WithError(diagonal, DATA_ROUNDINGS * EPSILON * diagonal))
    # a mode is like itself, whatever rounding has done to it
    np.fill_diagonal(alike.value, 1.0)
    np.fill_diagonal(alike.error, 0.0)
    scene.emit("response/modes/assurance", alike.value, alike.error, axes)


def _emit_nearest(
    scene: Scene,
    forcing: Forcing,
    frequency: np.ndarray,
    doubt: np.ndarray,
    axes: dict[str, object],
) -> None:
    """The excited order next to each mode: how far the machine stays away from resonance."""
    load = as_loads(forcing.per_speed_squared)
    driven = np.any(np.abs(load.value) > 4.0 * load.error, axis=-1)
    orders = forcing.orders[: forcing.kept][driven[: forcing.kept]]
    if not orders.size:
        return
    met = orders * scene.case.machine.speed / frequency[:, None]
    nearest = np.argmin(np.abs(np.log(met)), axis=1)
    ratio = met[np.arange(6), nearest]
    scene.emit("response/modes/nearest_order", orders[nearest], 0.0, axes)
    error = ratio * (doubt / frequency + 4.0 * EPSILON)
    scene.emit("response/modes/distance", ratio - 1.0, error, axes)


def _emit_motion(scene: Scene, forcing: Forcing, motion: WithError) -> None:
    for name, part in zip(("translation", "rotation"), PARTS, strict=True):
        _emit_with_peak(scene, f"response/{name}", "_harmonics", forcing, _pick(motion, part))


def _emit_ground(scene: Scene, forcing: Forcing, ground: WithError) -> None:
    for name, part in zip(("force", "couple"), PARTS, strict=True):
        _emit_with_peak(scene, f"response/ground_{name}", "", forcing, _pick(ground, part))


def _ground(
    matrices: Matrices, frequency: np.ndarray, driven: WithError, motion: WithError
) -> WithError:
    """Force and couple (orders, 6) of the suspension on the ground.

    (K + iH + iwC) X, or what is left of the load when the body is moved, F + w^2 M X: the former is
    the better one above the natural frequencies, the latter below, where the errors of K X and of F
    are nearly the same. A mode that is left out of an order is in the first alone.
    """
    rate = frequency[:, None, None]
    held = matrices.stiffness + 1j * (matrices.structural + rate * matrices.damping)
    doubt = matrices.stiffness_error + matrices.structural_error + rate * matrices.damping_error
    first = _times(WithError(held, doubt), motion)
    squared = np.square(rate)
    moved = _times(WithError(squared * matrices.mass, squared * matrices.mass_error), motion)
    second = moved.error + driven.error + EPSILON * (np.abs(driven.value) + np.abs(moved.value))
    better = second < first.error
    return WithError(
        np.where(better, driven.value + moved.value, first.value),
        np.where(better, second, first.error),
    )


def _times(matrix: WithError, motion: WithError) -> WithError:
    """A matrix (orders, 6, 6) of each order times its motion (orders, 6)."""
    size = np.abs(matrix.value)
    value = (matrix.value @ motion.value[..., None])[..., 0]
    doubt = matrix.error + 10.0 * EPSILON * size
    error = doubt @ np.abs(motion.value)[..., None] + size @ motion.error[..., None]
    return WithError(value, error[..., 0])


def _pick(whole: WithError, part: slice) -> WithError:
    return WithError(whole.value[..., part], whole.error[..., part])


def _emit_with_peak(
    scene: Scene, stem: str, suffix: str, forcing: Forcing, rows: WithError
) -> None:
    kept, orders = forcing.kept, forcing.orders[: forcing.kept]
    axes = {"order": orders, "direction": DIRECTIONS}
    rounding = rows.error[:kept]
    scene.emit(f"{stem}{suffix}", rows.value[:kept], rounding, axes, terms=size_of_terms(rounding))
    if not scene.wants(f"{stem}_peak"):
        return
    peak = cycle_peak(rows.value[:kept].T, orders)
    rounding = peak.error + rounding.sum(0)
    error = rounding + forcing.tail * np.abs(rows.value[kept:]).sum(0)
    scene.emit(f"{stem}_peak", peak.value, error, axes, terms=size_of_terms(rounding))


def _emit_energies(
    scene: Scene,
    forcing: Forcing,
    matrices: Matrices,
    motion: WithError,
    frequency: np.ndarray,
) -> None:
    scene.cite(
        "energy of harmonic motion, phasors added before squares",
        "kinetic and potential energy, mean and peak",
        "docs/theory.md",
    )
    kept, speed = forcing.kept, scene.case.machine.speed
    axes = {"order": forcing.orders[:kept]}
    whole = energies_over_cycle(matrices, motion, forcing.orders, speed, kept, forcing.tail)
    pairs = (
        ("kinetic", mass_of(matrices), velocity(motion, frequency), whole.kinetic),
        ("potential", stiffness_of(matrices), motion, whole.potential),
    )
    for name, weight, state, total in pairs:
        stem = f"response/{name}_energy"
        each = energy_by_order(weight, state)
        scene.emit(f"{stem}/mean_by_order", each.mean[:kept], each.mean_error[:kept], axes)
        scene.emit(f"{stem}/peak_by_order", each.peak[:kept], each.peak_error[:kept], axes)
        scene.emit(f"{stem}/mean", total.mean, total.mean_error)
        scene.emit(f"{stem}/peak", total.peak, total.peak_error)

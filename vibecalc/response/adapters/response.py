"""Adapter: the body on its suspension, at operating speed and over a range of speeds."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import (
    DIRECTIONS,
    Forcing,
    MotionByOrder,
    few_orders,
    peak_with_tail,
)
from vibecalc.excitation.inertia_forces import at_speed, with_terms
from vibecalc.numerics.bounded import Bounded, Summed, reshaped, where
from vibecalc.numerics.leading import leave_alone
from vibecalc.numerics.linear import (
    Linear,
    UndrivenModes,
    bounded_parts,
    dynamics,
    dynamics_by_order,
    require_digits,
    response,
)
from vibecalc.numerics.rounding import DATA_ROUNDINGS, EPSILON
from vibecalc.parts.body import COORDINATES
from vibecalc.parts.matrices import build_system, displacement_at
from vibecalc.parts.mount_state import mounts_of
from vibecalc.response.energies import (
    energies_over_cycle,
    energy_by_order,
    mass_of,
    mean_over_cycle,
    square_root,
    stiffness_of,
    velocity,
)
from vibecalc.response.forced import modal_response
from vibecalc.response.modal_damping import (
    body_resonances,
    damped_basis,
    damping_ratio,
    energy_fraction,
    idle_modes,
    modal_damping,
)
from vibecalc.response.modes import Modes, modal_assurance, modes
from vibecalc.response.resonances import (
    MaskedSpeeds,
    Resonances,
    check_operating_point,
    energy_speeds,
    idle_warnings,
    left_out,
    masked_speeds,
    outside,
)
from vibecalc.response.results import (
    Energy,
    KineticEnergy,
    LeftOut,
    ModesOfBody,
    MotionOfBody,
    OverSpeed,
    PotentialEnergy,
)
from vibecalc.response.spectral import (
    OwnMode,
    SpectralSystem,
    joined,
    own_damping_ratio,
    own_energy_fraction,
    own_modes,
    own_resonances,
    spectral_system,
)

if TYPE_CHECKING:
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# The body on its suspension as a linear system that several stages of the response share.
# ----------------------------------------------------------------------------


class LinearSystem(NamedTuple):
    """Matrices with all damping in them, and modes in a basis that the damping leaves apart.

    Where the stiffness of mounts follows the frequency, `spectral` has the matrices at all of
    them and `own` each mode at its own.
    """

    matrices: Linear
    shapes: Modes
    spectral: SpectralSystem | None = None
    own: tuple[OwnMode, ...] = ()


def linear_system(scene: Scene) -> LinearSystem:
    """The system of the case, built once per run."""
    system: LinearSystem = scene.once("linear_system", _build)
    return system


def _build(case: "Case") -> LinearSystem:
    machine = case.machine
    matrices = build_system(case)
    mounts = mounts_of(case)
    if mounts is not None and mounts.spectrum is not None:
        spectral = spectral_system(matrices.free(), mounts, displacement_at(mounts.position))
        own = tuple(own_modes(spectral))
        return LinearSystem(matrices, joined(own), spectral, own)
    shapes = modes(matrices)
    ratio = None if machine.mounts is None else machine.mounts.modal_damping
    if ratio:
        added = modal_damping(matrices, shapes, np.full(6, ratio))
        matrices = matrices._replace(
            damping=matrices.damping + added.value,
            damping_error=matrices.damping_error + added.error,
        )
    return LinearSystem(matrices, damped_basis(matrices, shapes))


def ratios_of(scene: Scene, system: LinearSystem) -> Bounded:
    """Damping ratio (modes,) of each mode, what the case gives as a ratio counting exactly.

    Modal damping is that, and a loss factor of the whole stiffness is twice that. Raises
    NumericalFailure for a mode that nothing holds.
    """
    if system.own:
        return own_damping_ratio(system.own)
    machine = scene.case.machine
    mounts = machine.mounts
    system_without = build_system(scene.case)
    given = 0.0 if mounts is None else mounts.modal_damping or 0.0
    if mounts is not None and mounts.stiffness_matrix is not None:
        given += 0.5 * (mounts.loss_factor or 0.0)
        system_without = system_without._replace(
            structural=np.zeros((6, 6)), structural_error=np.zeros((6, 6))
        )
    ratios = damping_ratio(system_without, system.shapes)
    value = ratios.value + given
    return Bounded(value, ratios.error + EPSILON * np.abs(value))


def undriven_at_operating_point(
    scene: Scene,
    system: LinearSystem,
    load: Bounded,
    orders: np.ndarray,
    known: Resonances | None = None,
) -> UndrivenModes:
    """Modes that an order meets without driving them; NumericalFailure where it drives one.

    `load` (orders, 6) may have any scale; `known` are the resonances under another one.
    """
    held = system.shapes.eigenvalue > system.shapes.eigenvalue_error
    if known is None or system.own or not np.all(held):
        resonances = resonances_of(system, load)
    else:
        resonances = known._replace(idle=idle_modes(system.shapes, load))
    for warning in check_operating_point(resonances, orders, scene.case.machine.speed):
        scene.warn(warning)
    pairs = left_out(resonances)
    if system.own:
        pairs = np.zeros_like(pairs)
    return UndrivenModes(pairs, system.shapes.shape, system.shapes.eigenvalue)


def resonances_of(system: LinearSystem, load: Bounded) -> Resonances:
    """Where orders with these loads (..., orders, 6) meet the modes.

    A mode that nothing holds has no resonance: it stands at infinity, where no order meets it.
    """
    matrices, shapes = system.matrices, system.shapes
    if system.own:
        return own_resonances(system.own, load)
    held = shapes.eigenvalue > shapes.eigenvalue_error
    if held.ndim > 1:
        leave_alone(~np.all(held, axis=-1))
    if np.all(held):
        return body_resonances(matrices, shapes, load)
    found = body_resonances(matrices, Modes(*(part[..., held] for part in shapes)), load)
    frequency, ratio, width = np.full(6, np.inf), np.zeros(6), np.zeros(6)
    idle = np.ones(load.shape, dtype=bool)
    frequency[held], ratio[held], width[held] = found[:3]
    idle[..., held] = found.idle
    return Resonances(frequency, ratio, width, idle)


def forcing_of(scene: Scene) -> Forcing:
    """What the excitation has handed on."""
    forcing: Forcing = scene.handed_on["forcing"]
    return forcing


# ----------------------------------------------------------------------------
# Adapter: the body on its suspension at operating speed.
# ----------------------------------------------------------------------------

GROUND = paths_of(
    MotionOfBody, "ground_force", "ground_couple", "ground_force_peak", "ground_couple_peak"
)
NEAREST = paths_of(ModesOfBody, "nearest_order", "distance")
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


def run_response(scene: Scene) -> None:
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
    undriven = undriven_at_operating_point(scene, system, forcing.per_speed_squared, forcing.order)
    _emit_modes(scene, system, forcing)
    driven = at_speed(forcing.per_speed_squared, speed)
    frequency = forcing.order * np.asarray(speed)[..., None]
    motion = _motion(options.method, system, frequency, driven, undriven, forcing, speed)
    scene.handed_on["motion_by_order"] = MotionByOrder(
        forcing.order, forcing.retained, forcing.tail, motion
    )
    _emit_motion(scene, forcing, motion)
    if scene.wants(*GROUND):
        _emit_ground(scene, forcing, _ground(system, frequency, driven, motion))
    if options.energies:
        _emit_energies(scene, forcing, matrices, motion, frequency)


def _motion(
    method: str,
    system: LinearSystem,
    frequency: np.ndarray,
    driven: Bounded,
    undriven: UndrivenModes,
    forcing: Forcing,
    speed: float,
) -> Bounded:
    matrices = system.matrices
    if method == "modal":
        shape = system.shapes.shape
        return modal_response(matrices, shape, frequency, driven.value, driven.error)
    if system.spectral is None:
        stiffness = dynamics(matrices, frequency, undriven)
    else:
        stiffness = dynamics_by_order(system.spectral.at(frequency), frequency)
    motion = response(stiffness, driven.value, driven.error)
    require_digits(matrices, stiffness, driven, motion, forcing.order, speed)
    return motion


def _emit_modes(scene: Scene, system: LinearSystem, forcing: Forcing) -> None:
    matrices, shapes, own = system.matrices, system.shapes, system.own
    numbers = np.arange(1, 7)
    axes = {"mode": numbers, "coordinate": COORDINATES, "other_mode": numbers}
    frequency = Bounded(shapes.natural_frequency, shapes.natural_frequency_error)
    held = np.all(shapes.eigenvalue > shapes.eigenvalue_error)
    found = ModesOfBody(
        natural_frequency=frequency,
        damping_ratio=ratios_of(scene, system) if held else None,
        shape=Bounded(shapes.shape.mT, shapes.shape_error.mT),
        energy_fraction=(
            own_energy_fraction(own, 3) if own else energy_fraction(matrices, shapes, 3)
        ),
        assurance=lambda: _assurance(system),
    )
    scene.emit_all(found, axes)
    if held and scene.wants(*NEAREST):
        _emit_nearest(scene, forcing, frequency, axes)


def _assurance(system: LinearSystem) -> Bounded:
    """Which modes look alike.

    Weighed by the diagonal alone: under the whole mass matrix the modes of one machine are
    orthogonal by definition.
    """
    diagonal = np.diag(np.diagonal(system.matrices.mass))
    vectors = Bounded(system.shapes.shape, system.shapes.shape_error)
    alike = modal_assurance(
        vectors, vectors, Bounded(diagonal, DATA_ROUNDINGS * EPSILON * diagonal)
    )
    # a mode is like itself, whatever rounding has done to it
    np.fill_diagonal(alike.value, 1.0)
    np.fill_diagonal(alike.error, 0.0)
    return alike


def _emit_nearest(
    scene: Scene,
    forcing: Forcing,
    frequency: Bounded,
    axes: dict[str, object],
) -> None:
    """The excited order next to each mode: how far the machine stays away from resonance."""
    load = forcing.per_speed_squared
    driven = np.any(np.abs(load.value) > 4.0 * load.error, axis=-1)
    orders = forcing.order[: forcing.retained][driven[: forcing.retained]]
    if not orders.size:
        return
    met = orders * scene.case.machine.speed / frequency.value[:, None]
    nearest = np.argmin(np.abs(np.log(met)), axis=1)
    ratio = met[np.arange(6), nearest]
    error = ratio * (frequency.error / frequency.value + 4.0 * EPSILON)
    found = ModesOfBody(nearest_order=orders[nearest], distance=Bounded(ratio - 1.0, error))
    scene.emit_all(found, axes)


def _emit_motion(scene: Scene, forcing: Forcing, motion: Bounded) -> None:
    move, turn = motion[..., :3], motion[..., 3:]
    found = MotionOfBody(
        translation_harmonics=_by_order(move, forcing),
        rotation_harmonics=_by_order(turn, forcing),
        translation_peak=lambda: _peak(move, forcing),
        rotation_peak=lambda: _peak(turn, forcing),
    )
    scene.emit_all(found, _axes(forcing))


def _emit_ground(scene: Scene, forcing: Forcing, ground: Bounded) -> None:
    force, couple = ground[..., :3], ground[..., 3:]
    found = MotionOfBody(
        ground_force=_by_order(force, forcing),
        ground_couple=_by_order(couple, forcing),
        ground_force_peak=lambda: _peak(force, forcing),
        ground_couple_peak=lambda: _peak(couple, forcing),
    )
    scene.emit_all(found, _axes(forcing))


def _axes(forcing: Forcing) -> dict[str, object]:
    return {"order": forcing.order[: forcing.retained], "direction": DIRECTIONS}


def _by_order(rows: Bounded, forcing: Forcing) -> Summed:
    return with_terms(rows[..., : forcing.retained, :])


def _peak(rows: Bounded, forcing: Forcing) -> Summed:
    return peak_with_tail(reshaped(rows, np.matrix_transpose), forcing)


def _ground(
    system: LinearSystem, frequency: np.ndarray, driven: Bounded, motion: Bounded
) -> Bounded:
    """Force and couple (..., orders, 6) of the suspension on the ground.

    (K + iH + iwC) X, or what is left of the load when the body is moved, F + w^2 M X: the former is
    the better one above the natural frequencies, the latter below, where the errors of K X and of F
    are nearly the same. A mode that is left out of an order is in the first alone.
    """
    rate = frequency[..., None]
    if system.spectral is not None:
        mass, stiffness, damping, structural = bounded_parts(system.spectral.at(frequency))
        rate, motion, driven = rate[..., None], motion[..., None, :], driven[..., None, :]
    else:
        mass, stiffness, damping, structural = bounded_parts(system.matrices)
    # the matrices are symmetric, so that rows times them are what they make of columns
    held = motion @ stiffness + 1j * (motion @ structural + rate * (motion @ damping))
    moved = driven + np.square(rate) * (motion @ mass)
    better = where(moved.error < held.error, moved, held)
    return better if system.spectral is None else better[..., 0, :]


def _emit_energies(
    scene: Scene,
    forcing: Forcing,
    matrices: Linear,
    motion: Bounded,
    frequency: np.ndarray,
) -> None:
    scene.cite(
        "energy of harmonic motion, phasors added before squares",
        "kinetic and potential energy, mean and peak",
        "docs/theory.md",
    )
    used = forcing.retained
    axes = {"order": forcing.order[:used]}
    kinds: tuple[tuple[type[Energy], Bounded, Bounded], ...] = (
        (KineticEnergy, mass_of(matrices), velocity(motion, frequency)),
        (PotentialEnergy, stiffness_of(matrices), motion),
    )
    for group, weight, state in kinds:
        if scene.wants(*paths_of(group, "mean_by_order", "peak_by_order")):
            each = energy_by_order(weight, state)
            by_order = group(
                mean_by_order=Bounded(each.mean, each.mean_error)[..., :used],
                peak_by_order=Bounded(each.peak, each.peak_error)[..., :used],
            )
            scene.emit_all(by_order, axes)
    sought = [kind for kind in kinds if scene.wants(*paths_of(kind[0], "peak"))]
    found = energies_over_cycle(
        [(weight, state) for _, weight, state in sought], forcing.order, used, forcing.tail
    )
    for (group, _, _), total in zip(sought, found, strict=True):
        mean, peak = Bounded(total.mean, total.mean_error), Bounded(total.peak, total.peak_error)
        scene.emit_all(group(mean=mean, peak=peak))
    for group, weight, state in kinds:
        if scene.wants(*paths_of(group, "mean")) and not scene.wants(*paths_of(group, "peak")):
            square_root(weight)  # which refuses an energy without a lower bound
            scene.emit_all(group(mean=mean_over_cycle(weight, state, used, forcing.tail)))


# ----------------------------------------------------------------------------
# Adapter: energies of the body over a range of crank speeds.
# ----------------------------------------------------------------------------

#: a curve gets points around the resonances of an order that moves a mode by this share at least
#: of what the strongest order does
WORTH_POINTS = 1e-10


def run_speeds(scene: Scene) -> None:
    """Emit mean energies at each speed, and the intervals left out around resonances."""
    options = scene.case.response
    if options is None or options.run_up is None:
        raise ValueError("the case has no run-up in [response]")
    forcing, system = forcing_of(scene), linear_system(scene)
    first, last = options.run_up.start, options.run_up.stop
    used, orders = forcing.retained, forcing.order[: forcing.retained]
    load = forcing.per_speed_squared
    resonances = resonances_of(system, Bounded(load.value[:used], load.error[:used]))
    masked = masked_speeds(resonances, orders, first, last)
    for warning in idle_warnings(resonances, orders, first, last):
        scene.warn(warning)
    shown = _worth_points(system, resonances, load.value[:used], orders)
    speed = _with_ends(energy_speeds(shown, orders, masked, first, last), masked, first, last)
    axes = {"speed": speed, "masked": np.arange(1, len(masked.centre) + 1)}
    scene.emit_all(OverSpeed(*_energies(system, resonances, forcing, load, speed)), axes)
    off = masked.centre_error
    low, centre, high = (Bounded(one, off) for one in (masked.low, masked.centre, masked.high))
    scene.emit_all(LeftOut(low, centre, high, masked.order, masked.mode), axes)


def _worth_points(
    system: LinearSystem, resonances: Resonances, load: np.ndarray, orders: np.ndarray
) -> Resonances:
    """The resonances without those of orders too weak to be seen."""
    moved = np.abs(load @ system.shapes.shape) / np.square(orders)[:, None]
    return resonances._replace(idle=resonances.idle | (moved < WORTH_POINTS * np.max(moved)))


def _with_ends(speed: np.ndarray, masked: MaskedSpeeds, first: float, last: float) -> np.ndarray:
    """The speeds, and all ends of the masked intervals, however narrow these are."""
    ends = np.concatenate([masked.low, masked.high])
    ends = ends[(ends >= first) & (ends <= last) & outside(masked, ends)]
    every = np.sort(np.concatenate([speed, ends]))
    distinct: np.ndarray = every[np.concatenate([[True], np.diff(every) > 0.0])]
    return distinct


def _energies(
    system: LinearSystem,
    resonances: Resonances,
    forcing: Forcing,
    load: Bounded,
    speed: np.ndarray,
) -> list[Bounded]:
    """Mean kinetic and potential energy (speeds,), errors counting the dropped orders by a few.

    At rest nothing moves, held or not.
    """
    matrices, used = system.matrices, forcing.retained
    few, few_tail = few_orders(forcing)
    chosen = np.concatenate([np.arange(used), few])
    count = len(few)
    idle = np.pad(left_out(resonances), ((0, count), (0, 0)))
    undriven = UndrivenModes(idle, system.shapes.shape, system.shapes.eigenvalue)
    turning = speed > 0.0
    frequency = speed[turning][:, None] * forcing.order[chosen]
    square = np.square(speed[turning])[:, None, None]
    stiffness = dynamics(matrices, frequency, undriven)
    motion = response(stiffness, square * load.value[chosen], square * load.error[chosen])
    found = []
    for weight, state in (
        (mass_of(matrices), velocity(motion, frequency)),
        (stiffness_of(matrices), motion),
    ):
        value, error = np.zeros(speed.shape), np.zeros(speed.shape)
        value[turning], error[turning] = mean_over_cycle(weight, state, used, few_tail)
        found.append(Bounded(value, error))
    return found

"""Adapter: the body on its suspension, at operating speed and over a range of speeds."""

from collections.abc import Callable
from functools import cache

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import DIRECTIONS, Forcing, MotionByOrder, peak_with_tail
from vibecalc.excitation.inertia_forces import with_terms
from vibecalc.numerics.bounded import Bounded, Summed, concatenate, reshaped, stack, where
from vibecalc.numerics.linear import bounded_parts, response
from vibecalc.numerics.rounding import DATA_ROUNDINGS, EPSILON
from vibecalc.parts.body import COORDINATES
from vibecalc.parts.matrices import build_system, displacement_at
from vibecalc.parts.mount_state import mounts_of
from vibecalc.response.adapters.loads import (
    BodyLoads,
    LoadsOverSpeed,
    body_loads,
    loads_over_speed,
    steady_motion,
)
from vibecalc.response.energies import (
    energy_by_order,
    mass_of,
    mean_over_cycle,
    peak_over_cycle,
    square_root,
    stiffness_of,
    velocity,
)
from vibecalc.response.modal_damping import with_modal_damping
from vibecalc.response.modes import modal_assurance
from vibecalc.response.resonances import energy_speeds, idle_warnings, masked_speeds
from vibecalc.response.results import (
    Energy,
    KineticEnergy,
    LeftOut,
    ModesOfBody,
    MotionOfBody,
    OverSpeed,
    PotentialEnergy,
)
from vibecalc.response.system import MountedBody, modes_on_mounts
from vibecalc.schema import Case


def mounted_body(scene: Scene) -> MountedBody:
    """The body of the case on its suspension, built once per run."""
    system: MountedBody = scene.once("mounted_body", _build)
    return system


def _build(case: Case) -> MountedBody:
    matrices, mounts = build_system(case), mounts_of(case)
    stretch = np.zeros(0) if mounts is None else displacement_at(mounts.position)
    shapes, spectral = modes_on_mounts(matrices, mounts, stretch)
    given = case.machine.mounts
    if given is not None and given.modal_damping:
        matrices = with_modal_damping(matrices, shapes, given.modal_damping)
    return MountedBody(matrices=matrices, shapes=shapes, spectral=spectral)


def forcing_of(scene: Scene) -> Forcing:
    """What the excitation has handed on."""
    forcing: Forcing = scene.handed_on["forcing"]
    return forcing


# ----------------------------------------------------------------------------
# Adapter: the body on its suspension at operating speed.
# ----------------------------------------------------------------------------

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
    loads, system, options = body_loads(scene, "response"), mounted_body(scene), scene.case.response
    if options is None:
        raise ValueError("the case has no [response]")
    name, citation = METHODS[options.method]
    scene.cite(name, "motion of the body", citation)
    if loads.torque is not None:
        scene.cite(
            "torque reaction of the cylinders with the shaking of the crank train, order by order",
            "motion of the body",
            "docs/theory_mounts.md",
        )
    order = loads.order
    frequency = order * np.asarray(scene.case.machine.speed)[..., None]
    motion = steady_motion(scene, system, loads.load, order, options.method == "modal")
    _emit_modes(scene, system, loads)
    scene.handed_on["motion_by_order"] = MotionByOrder(order, loads.retained, loads.tail, motion)
    ground = cache(lambda: _ground(system, frequency, loads.load, motion))
    _emit_motion(scene, loads, motion, ground)
    if options.energies:
        scene.cite(
            "energy of harmonic motion, phasors added before squares",
            "kinetic and potential energy, mean and peak",
            "docs/theory_mounts.md",
        )
        moving = velocity(motion, frequency)
        _emit_energy(scene, KineticEnergy, mass_of(system.matrices), moving, loads)
        _emit_energy(scene, PotentialEnergy, stiffness_of(system.matrices), motion, loads)


def _emit_modes(scene: Scene, system: MountedBody, loads: BodyLoads) -> None:
    shapes, numbers = system.shapes, np.arange(1, 7)
    held = np.all(shapes.held)
    found = ModesOfBody(
        natural_frequency=shapes.bounded_frequency,
        damping_ratio=system.damping_ratio() if held else None,
        shape=reshaped(shapes.bounded_shape, np.matrix_transpose),
        energy_fraction=system.energy_fraction,
        assurance=lambda: _assurance(system),
    )
    axes = {"mode": numbers, "coordinate": COORDINATES, "other_mode": numbers}
    scene.emit_all(found, axes)
    if not held or not scene.wants(*paths_of(ModesOfBody, "nearest_order", "distance")):
        return
    load, speed = loads.load[: loads.retained], scene.case.machine.speed
    driven = np.any(np.abs(load.value) > 4.0 * load.error, axis=-1)
    orders = loads.order[: loads.retained][driven]
    if len(orders):
        met = orders * speed / shapes.natural_frequency[:, None]
        nearest = orders[np.argmin(np.abs(np.log(met)), axis=1)]
        distance = nearest * speed / shapes.bounded_frequency - 1.0
        scene.emit_all(ModesOfBody(nearest_order=nearest, distance=distance), axes)


def _assurance(system: MountedBody) -> Bounded:
    """Which modes look alike, weighed by the diagonal of the mass matrix alone."""
    diagonal = np.diagonal(system.matrices.mass)
    weight = Bounded(diagonal, DATA_ROUNDINGS * EPSILON * diagonal)
    alike = modal_assurance(system.shapes.bounded_shape, weight)
    # a mode is like itself, whatever rounding has done to it
    np.fill_diagonal(alike.value, 1.0)
    np.fill_diagonal(alike.error, 0.0)
    return alike


def _emit_motion(
    scene: Scene, loads: BodyLoads, motion: Bounded, ground: Callable[[], Bounded]
) -> None:
    """Motion (..., orders, 6) of the body, and the load on the ground where that is wanted."""
    move, turn = slice(None, 3), slice(3, None)

    def by_order(rows: Bounded) -> Summed:
        return with_terms(rows[..., : loads.retained, :])

    def peak(rows: Bounded) -> Summed:
        return peak_with_tail(reshaped(rows, np.matrix_transpose), loads)

    found = MotionOfBody(
        translation_harmonics=by_order(motion[..., move]),
        rotation_harmonics=by_order(motion[..., turn]),
        translation_peak=lambda: peak(motion[..., move]),
        rotation_peak=lambda: peak(motion[..., turn]),
        ground_force=lambda: by_order(ground()[..., move]),
        ground_couple=lambda: by_order(ground()[..., turn]),
        ground_force_peak=lambda: peak(ground()[..., move]),
        ground_couple_peak=lambda: peak(ground()[..., turn]),
    )
    axes = {"order": loads.order[: loads.retained], "direction": DIRECTIONS}
    scene.emit_all(found, axes)


def _ground(
    system: MountedBody, frequency: np.ndarray, driven: Bounded, motion: Bounded
) -> Bounded:
    """Force and couple (..., orders, 6) of the suspension on the ground.

    (K + iH + iwC) X, or what is left of the load when the body is moved, F + w^2 M X: the former is
    the better one above the natural frequencies, the latter below, where the errors of K X and of F
    are nearly the same. A mode that is left out of an order is in the first alone.
    """
    held = (system.at(frequency).passing(frequency) @ motion[..., None])[..., 0]
    # the mass matrix is symmetric, so that rows times it are what it makes of columns
    moved = driven + np.square(frequency)[..., None] * (motion @ bounded_parts(system.matrices)[0])
    return where(moved.error < held.error, moved, held)


def _emit_energy(
    scene: Scene, group: type[Energy], weight: Bounded, state: Bounded, loads: BodyLoads
) -> None:
    """Energies of velocities or displacements (..., orders, 6), the peaks where they are wanted."""
    order, used, tail = loads.order, loads.retained, loads.tail
    each = cache(lambda: energy_by_order(weight, state[..., :used, :]))
    square_root(weight)  # which refuses an energy without a lower bound
    found = group(
        mean_by_order=lambda: each().mean,
        peak_by_order=lambda: each().peak,
        mean=lambda: mean_over_cycle(weight, state, used, tail),
        peak=lambda: peak_over_cycle(weight, state, order, used, tail),
    )
    scene.emit_all(found, {"order": order[:used]})


# ----------------------------------------------------------------------------
# Adapter: energies of the body over a range of crank speeds.
# ----------------------------------------------------------------------------

#: a curve gets points around the resonances of an order that moves a mode by this share at least
#: of what the strongest order does
WORTH_POINTS = 1e-10
#: orders times modes that get points at most, the strongest first
MOST_SHOWN = 100
#: speeds times orders that are solved at once
MOST_AT_ONCE = 20_000


def _weak(loads: LoadsOverSpeed, system: MountedBody, natural: np.ndarray) -> np.ndarray:
    """Which of the kept orders move a mode too little (orders, modes) to be worth points."""
    order, shape = loads.order[: loads.retained, None], system.shapes.shape
    shaken, *couples = (np.abs(load.value @ shape) for load in loads.some(slice(loads.retained)))
    moved = shaken / np.square(order) + sum(couples, np.zeros(1)) / np.square(natural)
    strong = np.sort(moved, axis=None)[-MOST_SHOWN:]
    return np.asarray(moved < max(WORTH_POINTS * strong[-1], strong[0]))


def run_speeds(scene: Scene) -> None:
    """Emit mean energies at each speed, and the intervals left out around resonances.

    Errors count the dropped orders by a few of them.
    """
    options = scene.case.response
    if options is None or options.run_up is None:
        raise ValueError("the case has no run-up in [response]")
    first, last = options.run_up.start, options.run_up.stop
    system, loads = mounted_body(scene), loads_over_speed(scene, "response", first, last)
    every, used, tail = loads.order, loads.retained, loads.tail
    met, orders = system.resonances(*loads.some()), every[:used]
    resonances = met._replace(idle=met.idle[:used])
    masked = masked_speeds(resonances, orders, first, last)
    for warning in idle_warnings(resonances, orders, first, last):
        scene.warn(warning)
    shown = resonances._replace(idle=resonances.idle | _weak(loads, system, met.frequency))
    shown = shown.beside(loads.line, np.zeros(loads.line.shape))
    speed = energy_speeds(shown, orders, masked, first, last, loads.speeds)

    def energies(speed: np.ndarray) -> Bounded:
        # at rest nothing moves, held or not
        turning = speed > 0.0
        at = np.where(turning, speed, last)
        frequency, load = at[:, None] * every, loads.at(at)
        motion = response(system.dynamics(frequency, met), load.value, load.error)
        return stack(
            [
                mean_over_cycle(weight, state, used, tail) * turning
                for weight, state in (
                    (mass_of(system.matrices), velocity(motion, frequency)),
                    (stiffness_of(system.matrices), motion),
                )
            ],
            axis=0,
        )

    parts = np.array_split(speed, -(-len(speed) * len(every) // MOST_AT_ONCE))
    energy = concatenate([energies(part) for part in parts])
    axes = {"speed": speed, "resonance_skipped": np.arange(1, len(masked.centre) + 1)}
    scene.emit_all(OverSpeed(energy[0], energy[1]), axes)
    low, centre, high = (Bounded(one, masked.centre_error) for one in masked[:3])
    scene.emit_all(LeftOut(low, centre, high, masked.order, masked.mode), axes)

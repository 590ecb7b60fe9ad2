"""The body on its suspension as a linear system that several stages of the response share."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.excitation.adapter import Forcing
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.parts.matrices import build_system
from vibecalc.pipeline.scene import Scene
from vibecalc.response.damped_basis import damped_basis
from vibecalc.response.direct import Undriven
from vibecalc.response.energy import damping_ratio
from vibecalc.response.matrices import Matrices
from vibecalc.response.modal_damping import modal_damping
from vibecalc.response.modal_resonance import body_resonances
from vibecalc.response.modes import Modes, modes
from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import check_operating_point, left_out

if TYPE_CHECKING:
    from vibecalc.case.schema import Case

COORDINATES = ("x", "y", "z", "rx", "ry", "rz")


class LinearSystem(NamedTuple):
    """Matrices with all damping in them, and modes in a basis that the damping leaves apart."""

    matrices: Matrices
    shapes: Modes


def linear_system(scene: Scene) -> LinearSystem:
    """The system of the case, built once per run."""
    found: LinearSystem = scene.once("linear_system", _build)
    return found


def _build(case: "Case") -> LinearSystem:
    machine = case.machine
    matrices = build_system(machine)
    shapes = modes(matrices)
    ratio = None if machine.mounts is None else machine.mounts.modal_damping
    if ratio:
        added = modal_damping(matrices, shapes, np.full(6, ratio))
        matrices = matrices._replace(
            damping=matrices.damping + added.value,
            damping_error=matrices.damping_error + added.error,
        )
    return LinearSystem(matrices, damped_basis(matrices, shapes))


def ratios_of(scene: Scene, system: LinearSystem) -> WithError:
    """Damping ratio (modes,) of each mode, what the case gives as a ratio counting exactly.

    Modal damping is that, and a loss factor of the whole stiffness is twice that. Raises
    NumericalFailure for a mode that nothing holds.
    """
    machine = scene.case.machine
    mounts = machine.mounts
    rest = build_system(machine)
    given = 0.0 if mounts is None else mounts.modal_damping or 0.0
    if mounts is not None and mounts.stiffness_matrix is not None:
        given += 0.5 * (mounts.loss_factor or 0.0)
        rest = rest._replace(structural=np.zeros((6, 6)), structural_error=np.zeros((6, 6)))
    found = damping_ratio(rest, system.shapes)
    value = found.value + given
    return WithError(value, found.error + EPSILON * np.abs(value))


def undriven_at_operating_point(
    scene: Scene, system: LinearSystem, load: WithError, orders: np.ndarray
) -> Undriven:
    """Modes that an order meets without driving them; NumericalFailure where it drives one.

    `load` (orders, 6) may have any scale.
    """
    resonances = resonances_of(system, load)
    for warning in check_operating_point(resonances, orders, scene.case.machine.speed):
        scene.warn(warning)
    return Undriven(left_out(resonances), system.shapes.shape, system.shapes.eigenvalue)


def resonances_of(system: LinearSystem, load: WithError) -> Resonances:
    """Where orders with these loads (orders, 6) meet the modes.

    A mode that nothing holds has no resonance: it stands at infinity, where no order meets it.
    """
    matrices, shapes = system
    held = shapes.eigenvalue > shapes.eigenvalue_error
    if np.all(held):
        return body_resonances(matrices, shapes, load)
    found = body_resonances(matrices, Modes(*(part[..., held] for part in shapes)), load)
    frequency, ratio, width = np.full(6, np.inf), np.zeros(6), np.zeros(6)
    idle = np.ones((len(load.value), 6), dtype=bool)
    frequency[held], ratio[held], width[held] = found[:3]
    idle[:, held] = found.idle
    return Resonances(frequency, ratio, width, idle)


def forcing_of(scene: Scene) -> Forcing:
    """What the excitation has handed on."""
    forcing: Forcing = scene.handed_on["forcing"]
    return forcing

"""Natural frequencies and damping of a shaft line, shapes, Holzer tables, Campbell diagram."""

from functools import partial

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.adapters.setup import Setup, line_modes, undamped_modes
from vibecalc.torsion.asked import has_damped_rings, has_holzer, has_loops
from vibecalc.torsion.damped_modes import LineModes, poles_of_modes
from vibecalc.torsion.holzer import (
    Angles,
    ShapeUncertainty,
    angle_uncertainty,
    holzer_rows,
    holzer_table,
    measured,
    shape_uncertainty,
    uncertainty_of,
)
from vibecalc.torsion.line import Line, hand_over, lines_of
from vibecalc.torsion.modes_of_tree import riccati_frequencies
from vibecalc.torsion.results import ROOT

# ----------------------------------------------------------------------------
# Adapter: natural frequencies and damping of a shaft line, shapes, Holzer tables.
# ----------------------------------------------------------------------------

PLACE = f"{ROOT}/modes"
TRANSFER = f"{PLACE}/transfer_matrix_frequency"


def emit_modes(scene: Scene, setup: Setup) -> None:
    """The modes at the operating speed: of the line as it vibrates, and undamped where they differ.

    Where a damper makes them differ, Holzer's tables and the second way are of the undamped ones.
    """
    undamped, natural = setup.modes, setup.natural()
    shaft, line = setup.shaft, setup.model.at(setup.speed)
    if natural.failure:
        scene.warn(
            f"damped modes not found: {natural.failure}. Natural frequencies, critical speeds and "
            "margins are those of the undamped line with free damper rings"
        )
    if np.any(natural.together):
        numbers = ", ".join(str(one + 1) for one in np.flatnonzero(natural.together))
        scene.warn(
            f"modes {numbers} have equal natural frequencies, as with identical branches: "
            "frequencies and damping ratios are valid, mode shapes are not unique"
        )
    axes = {
        "mode": np.arange(1, len(natural.frequency) + 1),
        "station": shaft.station_names,
        "section": shaft.section_names,
        "damper": tuple(one.name for one in shaft.dampers),
    }
    ring = [one.ring for one in shaft.dampers]
    uncertainty = natural_uncertainty(setup)
    scene.emit(f"{PLACE}/natural_frequency", natural.frequency, natural.frequency_error, axes)
    scene.emit(f"{PLACE}/frequency_error", natural.frequency_error, 0.0, axes)
    angle = natural.shape if natural.damped else undamped.shape
    shape = Bounded(angle, angle_uncertainty(uncertainty))
    for name, freedom, turned in (
        ("shape", shaft.freedom, shaft.station_ratio),
        ("ring_shape", np.array(ring, dtype=np.int64), shaft.freedom_ratio[ring]),
    ):
        if len(freedom):
            turned_shape = shape[:, freedom] * rounded(turned, 2.0)
            scene.emit(f"{PLACE}/{name}", turned_shape, axes=axes)
    inertia = np.abs(angle) ** 2 @ line.inertia if natural.damped else undamped.modal_inertia
    moved = uncertainty_of(uncertainty, 2.0 * (angle.conj() * line.inertia)[:, None, :])[:, 0]
    scene.emit(f"{PLACE}/modal_inertia", inertia, moved + 8.0 * EPSILON * inertia, axes)
    own = setup.model.at(setup.speed, natural.frequency)
    share = _strain(own, angle, natural.frequency > 0.0, uncertainty)
    scene.emit(f"{PLACE}/strain_energy_share", share, axes=axes)
    _emit_ratios(scene, setup, natural)
    undamped_axes = {"mode": np.arange(1, len(undamped.frequency) + 1)}
    if natural.damped or has_damped_rings(scene.case):
        error = undamped.frequency_error
        scene.emit(f"{PLACE}/undamped_frequency", undamped.frequency, error, undamped_axes)
    if not has_loops(scene.case) and scene.wants(TRANSFER):
        other = _by_transfer(setup)
        error = undamped.frequency_error + 4.0 * EPSILON * other
        scene.emit(TRANSFER, other, error, undamped_axes)
    emit_holzer(scene, setup, line, _undamped_uncertainty(setup) if natural.damped else uncertainty)
    scene.cite(
        "qd algorithm and twisted factorisation of the shaft line; mode counts for branches",
        "natural frequencies and mode shapes to full precision",
        "Parlett, The Symmetric Eigenvalue Problem, 1998; Fernando and Parlett, Numer. Math. 67, "
        "1994",
    )
    scene.cite(
        "Riccati transfer matrix with mode count and bisection",
        "independent check of natural frequencies",
        "Horner and Pilkey, J. Mech. Design 100, 1978; Wittrick and Williams, QJMAM 24, 1971",
    )


def natural_uncertainty(setup: Setup) -> ShapeUncertainty:
    """Errors of the shapes of the line as it vibrates at the operating speed."""
    natural = setup.natural()
    if not natural.damped:
        return _undamped_uncertainty(setup)
    line = setup.model.at(setup.speed, natural.frequency)
    return shape_uncertainty(line, natural, setup.model.stations)


def _undamped_uncertainty(setup: Setup) -> ShapeUncertainty:
    return shape_uncertainty(setup.model.at(setup.speed, setup.modes.frequency), setup.modes)


def _by_transfer(setup: Setup) -> FloatArray:
    """Undamped natural frequencies (m,) a second way, each of the line at its own frequency."""
    line = setup.model.at(setup.speed, setup.modes.frequency)
    if line.stiffness.ndim == 1:
        return riccati_frequencies(line, setup.modes.frequency)
    return np.array([riccati_frequencies(one)[i] for i, one in enumerate(lines_of(line))])


def _emit_ratios(scene: Scene, setup: Setup, natural: LineModes) -> None:
    """The damping ratio of each mode: of its pole, or as the case gives it."""
    path = f"{PLACE}/damping_ratio"
    if not scene.wants(path):
        return
    ratio, size, off = natural.damping_ratio, natural.frequency, natural.frequency_error
    if not natural.damped:
        off = np.zeros_like(size)
    if not natural.damped and setup.model.modal is None and np.any(ratio):
        model, speed = setup.model, setup.speed
        try:
            found = poles_of_modes(model.at(speed), setup.modes, partial(model.at, speed))
        except NumericalFailure as failure:
            scene.warn(f"no damping ratios: {failure}")
            return
        size, off = np.abs(found.pole), found.error
        ratio = np.divide(-found.pole.real, size, out=np.zeros_like(size), where=size > 0.0)
    # an error of a pole turns it by that over its size at most
    turned = np.where(size > 0.0, off / np.where(size > 0.0, size, 1.0), 0.0)
    axes = {"mode": np.arange(1, len(ratio) + 1)}
    scene.emit(path, ratio, turned + 8.0 * EPSILON * np.abs(ratio), axes, terms=1.0)


#: weights (modes, elements, freedoms) of strain energies that are held at once
_WEIGHTS = 1 << 18


def _strain(
    line: Line, shape: FloatArray | ComplexArray, moves: BoolArray, uncertainty: ShapeUncertainty
) -> Bounded:
    """Share (m, e) of each element in the strain energy, 0 in a rigid mode."""
    twist = shape[:, line.first] - shape[:, line.second]
    energy = line.stiffness * np.abs(twist) ** 2
    total = energy.sum(axis=1) + np.abs(shape) ** 2 @ line.ground_stiffness
    moving = moves & (total > 0.0)
    safe = np.where(moving, total, 1.0)[:, None]
    share = np.where(moving[:, None], energy / safe, 0.0)
    # d share = (d energy - share d total) / total
    torque = 2.0 * line.stiffness * twist.conj() / safe
    whole = 2.0 * line.ground_stiffness * shape.conj() / safe
    hand_over(whole.T, line, -torque.T)
    # the length of the weights of all angles, where no more than a bound of these is known
    along = torque.conj() * (whole[:, line.first] - whole[:, line.second])
    square = 2.0 * np.abs(torque) ** 2 - 2.0 * share * along.real
    square += share**2 * np.sum(np.abs(whole) ** 2, axis=1, keepdims=True)
    off = uncertainty.bound[:, None] * np.sqrt(np.maximum(square, 0.0))
    if uncertainty.moved.shape[-1]:
        ends = np.eye(shape.shape[1])[line.first] - np.eye(shape.shape[1])[line.second]
        together = max(1, _WEIGHTS // ends.size)
        for start in range(0, len(share), together):
            some = slice(start, start + together)
            weight = torque[some, :, None] * ends - share[some, :, None] * whole[some, None, :]
            off[some] = uncertainty_of(uncertainty.of(some), weight)
    off = off + 8.0 * EPSILON * share
    return Bounded(share, np.where(moving[:, None], off, 0.0))


# ----------------------------------------------------------------------------
# Adapter: Holzer tables of a shaft line at its natural frequencies, branch by branch.
# ----------------------------------------------------------------------------

PLACES = tuple(
    f"{ROOT}/modes/holzer_{name}" for name in ("angle", "inertia_torque", "torque", "residual")
)
#: a first row that moves less than this of the largest angle is no measure for the others
_STILL = 1e-6
#: times the largest difference of two ways to the torques of a mode
MANY = 4.0


def emit_holzer(scene: Scene, setup: Setup, line: Line, uncertainty: ShapeUncertainty) -> None:
    """Angles and torques of each mode from its shape, what the recurrence leaves at the end.

    The recurrence loses digits in a row where a mode fades, the shapes keep them.
    """
    if not has_holzer(scene.case) or not scene.wants(*PLACES):
        return
    modes = setup.modes
    own = setup.model.at(setup.speed, modes.frequency)
    rows = holzer_rows(own)
    axes = {
        "mode": np.arange(1, len(modes.frequency) + 1),
        "freedom": tuple(setup.shaft.freedom_names[place] for place in rows.freedom),
    }
    shape = modes.shape[:, rows.freedom]
    first = shape[:, :1]
    size = np.abs(shape).max(axis=1, keepdims=True, initial=0.0)
    still = np.abs(first) <= np.maximum(_STILL * size, 4.0 * modes.shape_error[:, None])
    unit = np.where(still, 1.0, first)
    angle = shape / unit
    common = modes.shape_error[:, None] / np.abs(unit)  # of the first row
    turned = Bounded(angle, common * np.hypot(1.0, angle))
    ground = line.ground_stiffness[rows.freedom]
    inertia_w2 = modes.frequency[:, None] ** 2 * line.inertia[rows.freedom]
    inertial = rounded(inertia_w2, 16.0) * turned
    total, total_error = inertial - ground * turned
    for row, below in enumerate(rows.below[:-1]):
        total[:, below] += total[:, row]
        # without a common sign
        total_error[:, below] = np.hypot(total_error[:, below], total_error[:, row])
    # where the torques of the shafts agree with those of the inertias they are better than that
    twist = angle[:, :-1] - angle[:, rows.below[:-1]]
    apart = np.abs(total[:, :-1] - rows.stiffness * twist).max(axis=1, keepdims=True, initial=0.0)
    closing = MANY * apart + (8.0 * EPSILON + common) * np.abs(total)
    total_error = np.where(np.any(ground), total_error, np.minimum(total_error, closing))
    errors = [turned.error, inertial.error, total_error]
    if uncertainty.moved.shape[-1]:
        table = Angles(line, rows, unit, still, angle, inertia_w2)
        errors = [
            np.minimum(*both) for both in zip(errors, measured(table, uncertainty), strict=True)
        ]
    try:
        left = holzer_table(own, modes.frequency).sum_torque[:, -1]
    except NumericalFailure:  # a branch that swings alone: what the shapes leave
        left = total[:, -1]
    for path, value, error in zip(PLACES, (angle, inertial.value, total), errors, strict=False):
        scene.emit(path, value, error, axes)
    # at a natural frequency nothing is left
    scene.emit(PLACES[3], left, np.abs(left) + errors[2][:, -1], axes)
    scene.cite(
        "Holzer's table at the natural frequencies",
        "angles and torques of each mode",
        "Holzer, Die Berechnung der Drehschwingungen, 1921",
    )


# ----------------------------------------------------------------------------
# Adapter: natural frequencies of a shaft line against the speed, where pendulums change them.
# ----------------------------------------------------------------------------

PATH = f"{ROOT}/campbell/natural_frequency"
#: speeds at most; the curves are smooth
MOST = 101


def emit_campbell(scene: Scene, setup: Setup, speed: FloatArray) -> None:
    """Modes at some of the speeds (s,), both ends included, if the case asks for them."""
    follows = np.any(setup.model.speed_stiffness) or setup.model.couplings is not None
    if not setup.torsion.campbell or not follows:
        return
    if not scene.wants(PATH):
        return
    chosen = np.unique(np.linspace(0, len(speed) - 1, min(MOST, len(speed))).round().astype(int))
    at = speed[chosen]
    found = [
        line_modes(setup.torsion, setup.model, undamped_modes(setup.model, one), one)
        for one in at.tolist()
    ]
    frequency = np.array([one.frequency for one in found]).T
    error = np.array([one.frequency_error for one in found]).T
    axes = {"mode": np.arange(1, len(frequency) + 1), "speed": at}
    scene.emit(PATH, frequency, error, axes)

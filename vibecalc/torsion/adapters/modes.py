"""Natural frequencies and damping of a shaft line, shapes, Holzer tables, Campbell diagram."""

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import rounded
from vibecalc.numerics.errors import copies, spread
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray
from vibecalc.torsion.adapters.setup import Setup, line_modes, undamped_modes, vibrating_modes
from vibecalc.torsion.asked import has_damped_rings, has_holzer, has_loops
from vibecalc.torsion.damped_modes import LineModes, poles_of_modes
from vibecalc.torsion.line import Line, lines_of
from vibecalc.torsion.modes import Modes
from vibecalc.torsion.modes_of_tree import holzer_rows, holzer_table, riccati_frequencies
from vibecalc.torsion.results import ROOT

# ----------------------------------------------------------------------------
# Adapter: natural frequencies and damping of a shaft line, shapes, Holzer tables.
# ----------------------------------------------------------------------------

PLACE = f"{ROOT}/modes"
TRANSFER = f"{PLACE}/transfer_matrix_frequency"
#: results of the shapes
SHAPES = tuple(
    f"{PLACE}/{name}" for name in ("shape", "ring_shape", "modal_inertia", "strain_energy_share")
)
#: freedoms of a line whose modes take so long that fewer copies have to do, and how many
LONG, FEW = 100, 2


class ModeCopies:
    """Modes of a line at its operating speed, and of copies of it moved by their last bits.

    What follows from its shapes is as uncertain as it moves with these.
    """

    def __init__(self, setup: Setup) -> None:
        self.setup = setup

    @cached_property
    def undamped(self) -> list[Modes]:
        """Of the line without damping, rings free."""
        return [self.setup.modes, *(undamped_modes(one, self.setup.speed) for one in self._models)]

    @cached_property
    def natural(self) -> list[Modes] | list[LineModes]:
        """Of the line as it vibrates: real where they are the undamped ones."""
        natural = self.setup.natural()
        if not natural.damped:
            return self.undamped
        swings = natural.frequency > 0.0
        near = natural.pole[swings], natural.shape[swings].T
        return [natural, *(vibrating_modes(one, self.setup.speed, near) for one in self._models)]

    @cached_property
    def _models(self) -> list[Any]:
        model = self.setup.model
        moved = copies(model.line, model.speed_stiffness)[1:]
        if model.line.inertia.shape[-1] > LONG:
            moved = moved[:FEW]
        return [model._replace(line=line, speed_stiffness=added) for line, added in moved]

    def of(self, function: Callable[[Any], Any]) -> Any:
        """What a function gives of the modes of the line as it vibrates, with its errors."""
        return spread([function(one) for one in self.natural])


def emit_modes(scene: Scene, setup: Setup, moved: ModeCopies) -> None:
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
    scene.emit(f"{PLACE}/natural_frequency", natural.frequency, natural.frequency_error, axes)
    scene.emit(f"{PLACE}/frequency_error", natural.frequency_error, 0.0, axes)
    if scene.wants(*SHAPES):
        _emit_shapes(scene, setup, moved, axes)
    _emit_ratios(scene, setup, natural)
    undamped_axes = {"mode": np.arange(1, len(undamped.frequency) + 1)}
    if natural.damped or has_damped_rings(scene.case):
        error = undamped.frequency_error
        scene.emit(f"{PLACE}/undamped_frequency", undamped.frequency, error, undamped_axes)
    if not has_loops(scene.case) and scene.wants(TRANSFER):
        other = _by_transfer(setup)
        error = undamped.frequency_error + 4.0 * EPSILON * other
        scene.emit(TRANSFER, other, error, undamped_axes)
    emit_holzer(scene, setup, line, moved)
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


def _emit_shapes(scene: Scene, setup: Setup, moved: ModeCopies, axes: dict[str, Any]) -> None:
    """Angles of stations and rings, inertias and strain energies of the line as it vibrates."""
    shaft, frequency = setup.shaft, setup.natural().frequency
    ring = [one.ring for one in shaft.dampers]
    shape = moved.of(lambda one: one.shape)
    for path, freedom, turned in (
        (SHAPES[0], shaft.freedom, shaft.station_ratio),
        (SHAPES[1], np.array(ring, dtype=np.int64), shaft.freedom_ratio[ring]),
    ):
        if len(freedom):
            scene.emit(path, shape[:, freedom] * rounded(turned, 2.0), axes=axes)
    line, moving = setup.model.at(setup.speed, frequency), frequency > 0.0
    inertia = moved.of(lambda one: np.abs(one.shape) ** 2 @ line.inertia)
    scene.emit(SHAPES[2], inertia, axes=axes)
    scene.emit(SHAPES[3], moved.of(lambda one: _strain(line, one.shape, moving)), axes=axes)


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


def _strain(line: Line, shape: FloatArray | ComplexArray, moves: BoolArray) -> FloatArray:
    """Share (m, e) of each element in the strain energy, 0 in a rigid mode."""
    twist = shape[:, line.first] - shape[:, line.second]
    energy = line.stiffness * np.abs(twist) ** 2
    total = energy.sum(axis=1) + np.abs(shape) ** 2 @ line.ground_stiffness
    moving = moves & (total > 0.0)
    return np.where(moving[:, None], energy / np.where(moving, total, 1.0)[:, None], 0.0)


# ----------------------------------------------------------------------------
# Adapter: Holzer tables of a shaft line at its natural frequencies, branch by branch.
# ----------------------------------------------------------------------------

PLACES = tuple(
    f"{ROOT}/modes/holzer_{name}" for name in ("angle", "inertia_torque", "torque", "residual")
)
#: a first row that moves less than this of the largest angle is no measure for the others
_STILL = 1e-6


def emit_holzer(scene: Scene, setup: Setup, line: Line, moved: ModeCopies) -> None:
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
    shape = np.abs(modes.shape[:, rows.freedom])
    size = shape.max(axis=1, keepdims=True, initial=0.0)
    still = shape[:, :1] <= np.maximum(_STILL * size, 4.0 * modes.shape_error[:, None])
    inertia, ground = line.inertia[rows.freedom], line.ground_stiffness[rows.freedom]

    def table(one: Modes) -> tuple[FloatArray, ...]:
        """Angles, torques of the inertias and their sums (m, r)."""
        shape = one.shape[:, rows.freedom]
        angle = shape / np.where(still, 1.0, shape[:, :1])
        inertial = one.frequency[:, None] ** 2 * inertia * angle
        total = inertial - ground * angle
        for row, below in enumerate(rows.below[:-1]):
            total[:, below] += total[:, row]
        return angle, inertial, total

    found = spread([table(one) for one in moved.undamped])
    total = found[-1]
    try:
        left = holzer_table(own, modes.frequency).sum_torque[:, -1]
    except NumericalFailure:  # a branch that swings alone: what the shapes leave
        left = total.value[:, -1]
    for path, value in zip(PLACES, found, strict=False):
        scene.emit(path, value, axes=axes)
    # at a natural frequency nothing is left
    scene.emit(PLACES[3], left, np.abs(left) + total.error[:, -1], axes)
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

"""The modal route of the source, one mode at a time, named for what it is."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.adapters.setup import Setup, build_setup, line_speeds, placed
from vibecalc.torsion.as_published import (
    ModalExcitation,
    caughey_series,
    modal_excitation,
    modal_twist,
    series_damping,
    twist_on_criticals,
)
from vibecalc.torsion.study_results import PUBLISHED
from vibecalc.torsion.tables import AsPublished

# ----------------------------------------------------------------------------
# Adapter: the modal route of the source, one mode at a time, named for what it is.
# ----------------------------------------------------------------------------

#: a first freedom that moves less than this share of the largest is a node of the mode
_NODE = 1e-9


def run_torsion_as_published(scene: Scene) -> None:
    """Emit everything for [response.torsion.as_published]."""
    setup = build_setup(scene.case)
    options = setup.torsion.as_published
    if options is None:
        raise ValueError("the case has no [response.torsion.as_published]")
    place, shape = _shapes(setup, options)
    frequency, uncertainty = setup.modes.frequency[place], setup.modes.frequency_error[place]
    number = place + 1
    modes = {"elastic_mode": number}
    scene.emit(f"{PUBLISHED}natural_frequency", frequency, uncertainty, modes)
    _emit_rayleigh(scene, setup, options, frequency, number)
    excitation = modal_excitation(shape, frequency, setup.model.line.inertia, _torque(setup))
    order = setup.drive.order
    _emit_intensity(scene, excitation, number, order)
    ratio = 0.0 if options.magnifier == "empirical" else options.damping_ratio
    zeta = np.full(len(place), 0.0 if options.magnifier == "undamped" else ratio)
    if setup.torsion.speeds is not None:
        speeds = line_speeds(setup.torsion.speeds)
        twist = modal_twist(excitation, Bounded(frequency, uncertainty), order, speeds, zeta)
        axes = {"elastic_mode": number, "speed": speeds}
        scene.emit(f"{PUBLISHED}twist", twist.real, axes=axes)
        scene.emit(f"{PUBLISHED}twist_magnitude", abs(twist), axes=axes)
    if options.magnifier != "undamped":
        damped = None if options.magnifier == "empirical" else zeta
        _emit_criticals(scene, excitation, number, order, damped)
    scene.cite(
        "modal route of the source: modal twist at crank angle zero, shapes with 1 at the first "
        "freedom; it is no twist of a shaft",
        "numbers as published",
        "Baca Vasquez (2007), equations 4.17 to 4.20 and 4.27 to 4.29; docs/theory_torsion.md",
    )


def _shapes(setup: Setup, options: AsPublished) -> tuple[np.ndarray, Bounded]:
    """Places of the elastic modes asked for, shapes with 1 at the first freedom."""
    modes, shaft = setup.modes, setup.shaft
    elastic = np.flatnonzero(modes.frequency > 0.0)[: options.modes]
    if elastic.size == 0:
        raise NumericalFailure("the shaft line has no elastic mode")
    # a ring that hangs on the first station stands in front of it
    first = int(shaft.freedom[0])
    first = next((one.ring for one in shaft.dampers if one.carrier == first), first)
    angle = Bounded(modes.shape[elastic], modes.shape_error[elastic, None])
    base = angle[:, first]
    node = np.abs(base.value) < _NODE
    if np.any(node):
        raise NumericalFailure(
            f"as published, mode {elastic[node][0] + 1} is to have the angle 1 at the first "
            "freedom of the line, which stands still in it"
        )
    return elastic, angle / base[:, None]


def _torque(setup: Setup) -> Bounded:
    """Torque (m, n) of the operating speed on all freedoms, referred."""
    drive = setup.drive
    on = placed(drive.freedom, setup.model.line.inertia.size)
    return drive.torque(np.array([setup.speed]))[0] @ on


def _emit_rayleigh(
    scene: Scene, setup: Setup, options: AsPublished, frequency: FloatArray, number: np.ndarray
) -> None:
    """The series through the ratio of the case at the two lowest elastic modes."""
    elastic = setup.modes.frequency[setup.modes.frequency > 0.0][:2]
    series = caughey_series(elastic, np.full(len(elastic), options.damping_ratio))
    alpha = np.append(series.alpha, 0.0)[:2]
    error = np.append(series.error, 0.0)[:2]
    scene.emit(f"{PUBLISHED}rayleigh_inertia", alpha[0], error[0])
    scene.emit(f"{PUBLISHED}rayleigh_stiffness", alpha[1], error[1])
    ratio = series_damping(series, frequency)
    axes = {"elastic_mode": number}
    scene.emit(f"{PUBLISHED}rayleigh_damping_ratio", ratio, axes=axes)


def _emit_intensity(
    scene: Scene, excitation: ModalExcitation, number: np.ndarray, order: FloatArray
) -> None:
    axes = {"elastic_mode": number, "half_order": order}
    scene.emit(f"{PUBLISHED}intensity", excitation.vector_sum, axes=axes)
    scene.emit(f"{PUBLISHED}static_twist", excitation.deflection, axes=axes)
    largest = order[np.argmax(np.abs(excitation.vector_sum.value), axis=1)]
    scene.emit(f"{PUBLISHED}largest_intensity_order", largest, 0.0, {"elastic_mode": number})


def _emit_criticals(
    scene: Scene, excitation: ModalExcitation, number: np.ndarray, order: FloatArray,
    zeta: FloatArray | None,
) -> None:  # fmt: skip
    twist = twist_on_criticals(excitation, order, zeta)[..., -1]
    axes = {"elastic_mode": number, "half_order": order}
    scene.emit(f"{PUBLISHED}twist_at_critical", twist, axes=axes)
    best = np.argmax(np.abs(twist.value), axis=1)
    largest, modes = abs(twist)[np.arange(len(number)), best], {"elastic_mode": number}
    scene.emit(f"{PUBLISHED}largest_twist", largest, axes=modes)
    scene.emit(f"{PUBLISHED}largest_twist_order", order[best], 0.0, modes)

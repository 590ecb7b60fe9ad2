"""The modal route of the source, one mode at a time, named for what it is."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray
from vibecalc.torsion.adapters.setup import Setup, build_setup
from vibecalc.torsion.as_published import (
    ModalExcitation,
    caughey_series,
    modal_excitation,
    modal_twist,
    series_damping,
    twist_on_criticals,
)
from vibecalc.torsion.results import PUBLISHED
from vibecalc.torsion.tables import AsPublished, LineSpeeds

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
    place, shape, shape_error = _shapes(setup, options)
    frequency, uncertainty = setup.modes.frequency[place], setup.modes.frequency_error[place]
    number = place + 1
    modes = {"elastic_mode": number}
    scene.emit(f"{PUBLISHED}natural_frequency", frequency, uncertainty, modes)
    _emit_rayleigh(scene, setup, options, frequency, number)
    torque, error = _torque(setup)
    excitation = modal_excitation(shape, frequency, setup.model.line.inertia, torque, error)
    excitation = _with_shape_error(excitation, shape_error, torque)
    order = setup.drive.order
    _emit_intensity(scene, excitation, number, order)
    ratio = 0.0 if options.magnifier == "empirical" else options.damping_ratio
    zeta = np.full(len(place), 0.0 if options.magnifier == "undamped" else ratio)
    if setup.torsion.speeds is not None:
        _emit_twist(
            scene, setup.torsion.speeds, excitation, (frequency, uncertainty, number, order), zeta
        )
    if options.magnifier != "undamped":
        damped = None if options.magnifier == "empirical" else zeta
        _emit_criticals(scene, excitation, number, order, damped)
    scene.cite(
        "modal route of the source: modal twist at crank angle zero, shapes with 1 at the first "
        "freedom; it is no twist of a shaft",
        "numbers as published",
        "Baca Vasquez (2007), equations 4.17 to 4.20 and 4.27 to 4.29; docs/theory_torsion.md",
    )


def line_speeds(asked: LineSpeeds) -> FloatArray:
    """Speeds of a range in rad/s."""
    make = np.geomspace if asked.spacing == "logarithmic" else np.linspace
    return np.asarray(make(asked.start, asked.stop, asked.points))


def _shapes(setup: Setup, options: AsPublished) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """Places of the elastic modes asked for, shapes with 1 at the first freedom, their errors."""
    modes, shaft = setup.modes, setup.shaft
    elastic = np.flatnonzero(modes.frequency > 0.0)[: options.modes]
    if elastic.size == 0:
        raise NumericalFailure("the shaft line has no elastic mode")
    # a ring that hangs on the first station stands in front of it
    first = int(shaft.freedom[0])
    first = next((one.ring for one in shaft.dampers if one.carrier == first), first)
    base = modes.shape[elastic, first][:, None]
    node = np.abs(base[:, 0]) < _NODE
    if np.any(node):
        raise NumericalFailure(
            f"as published, mode {elastic[node][0] + 1} is to have the angle 1 at the first "
            "freedom of the line, which stands still in it"
        )
    shape = modes.shape[elastic] / base
    uncertainty = modes.shape_error[elastic] / np.abs(base[:, 0])
    return elastic, shape, uncertainty * (1.0 + np.max(np.abs(shape), axis=1))


def _torque(setup: Setup) -> tuple[np.ndarray, FloatArray]:
    """Torque (m, n) of the operating speed on all freedoms, referred, and its error."""
    drive, speed = setup.drive, np.array([setup.speed])
    shape = (len(drive.order), setup.model.line.inertia.size)
    torque, error = np.zeros(shape, dtype=complex), np.zeros(shape)
    torque[:, drive.freedom], error[:, drive.freedom] = drive.torque(speed)[0]
    return torque, error


def _with_shape_error(
    excitation: ModalExcitation, shape_error: FloatArray, torque: np.ndarray
) -> ModalExcitation:
    """The same with what the errors of the shapes add."""
    added = shape_error[:, None] * np.abs(torque).sum(axis=1)
    share = np.abs(excitation.deflection).max(axis=1, keepdims=True)
    stiffness = np.abs(excitation.vector_sum).max(axis=1, keepdims=True) / np.where(
        share > 0.0, share, 1.0
    )
    # modal inertia is quadratic in the shape
    deflected = 2.0 * shape_error[:, None] * np.abs(excitation.deflection)
    turned = added / np.where(stiffness > 0.0, stiffness, 1.0)
    return excitation._replace(
        vector_sum_error=excitation.vector_sum_error + added,
        deflection_error=excitation.deflection_error + turned + deflected,
    )


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
    scene.emit(f"{PUBLISHED}rayleigh_damping_ratio", ratio.value, ratio.error, axes)


def _emit_intensity(
    scene: Scene, excitation: ModalExcitation, number: np.ndarray, order: FloatArray
) -> None:
    axes = {"elastic_mode": number, "half_order": order}
    scene.emit(f"{PUBLISHED}intensity", excitation.vector_sum, excitation.vector_sum_error, axes)
    scene.emit(f"{PUBLISHED}static_twist", excitation.deflection, excitation.deflection_error, axes)
    largest = order[np.argmax(np.abs(excitation.vector_sum), axis=1)]
    scene.emit(f"{PUBLISHED}largest_intensity_order", largest, 0.0, {"elastic_mode": number})


def _emit_twist(
    scene: Scene, asked: LineSpeeds, excitation: ModalExcitation,
    of_modes: tuple[FloatArray, FloatArray, np.ndarray, FloatArray], zeta: FloatArray,
) -> None:  # fmt: skip
    frequency, uncertainty, number, order = of_modes
    speeds = line_speeds(asked)
    twist = modal_twist(excitation, frequency, order, speeds, zeta)
    # a frequency that is off by so much moves the resonance
    moved = modal_twist(excitation, frequency + uncertainty, order, speeds, zeta)
    error = twist.error + 2.0 * np.abs(moved.magnitude - twist.magnitude)
    error = error + 8.0 * EPSILON * twist.magnitude
    axes = {"elastic_mode": number, "speed": speeds}
    scene.emit(f"{PUBLISHED}twist", twist.at_zero, error, axes)
    scene.emit(f"{PUBLISHED}twist_magnitude", twist.magnitude, error, axes)


def _emit_criticals(
    scene: Scene, excitation: ModalExcitation, number: np.ndarray, order: FloatArray,
    zeta: FloatArray | None,
) -> None:  # fmt: skip
    sums = twist_on_criticals(excitation, order, zeta)
    value, error = sums.value[..., -1], sums.error[..., -1]
    axes = {"elastic_mode": number, "half_order": order}
    scene.emit(f"{PUBLISHED}twist_at_critical", value, error, axes)
    best = np.argmax(np.abs(value), axis=1)
    row = np.arange(len(number))
    modes = {"elastic_mode": number}
    scene.emit(f"{PUBLISHED}largest_twist", np.abs(value)[row, best], error[row, best], modes)
    scene.emit(f"{PUBLISHED}largest_twist_order", order[best], 0.0, modes)

"""A shaft line at its operating speed: vibration by orders, their sums, orders left out."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray
from vibecalc.torsion.adapters.critical import beyond, emit_critical, emit_separation
from vibecalc.torsion.adapters.curves import (
    OrderSolution,
    actual_per_referred,
    by_freedom,
    data_uncertainty,
    gear_torques,
    gear_uncertainties,
    rounding_uncertainty,
    solved,
    station_means,
    steady_gears,
    steady_uncertainties,
    summed,
)
from vibecalc.torsion.adapters.excitation import emit_excitation
from vibecalc.torsion.adapters.modes import emit_modes
from vibecalc.torsion.adapters.setup import Setup, build_drive, build_setup
from vibecalc.torsion.adapters.variants import emit_healthy
from vibecalc.torsion.line import Line, complex_stiffness
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.section_loads import heat, mesh_torque, steady_shares
from vibecalc.torsion.synthesis import synthesis

# ----------------------------------------------------------------------------
# Adapter: a shaft line and its engine to modes, excitation, vibration at operating speed.
# ----------------------------------------------------------------------------


def run_torsion(scene: Scene) -> None:
    """Emit what holds at the operating speed, and hand the line on to its other stages.

    Raises NumericalFailure where an order meets a natural frequency that nothing damps.
    """
    setup = build_setup(scene.case)
    scene.handed_on["torsion"] = setup[1:]
    emit_modes(scene, setup)
    emit_excitation(scene, setup)
    emit_steady(scene, setup)
    emit_critical(scene, setup)
    if setup.torsion.misfire:
        emit_healthy(scene, setup)


def setup_of(scene: Scene) -> Setup:
    """What this stage has left for those after it."""
    response = scene.case.response
    assert response is not None and response.torsion is not None
    # with the table as this case has it: the line may be one that another case has left
    return Setup(response.torsion, *scene.handed_on["torsion"])


# ----------------------------------------------------------------------------
# Adapter: vibration of a shaft line at the operating speed, all orders and their sums.
# ----------------------------------------------------------------------------

#: an order below this share of the lowest elastic mode is lost next to the rigid motion
SLOW = 0.1


class _Uncertainty:
    """Absolute errors at one speed by order (m, ...): of the data, and rounding."""

    def __init__(self, setup: Setup, state: OrderSolution, line: Line) -> None:
        at = np.array([setup.speed])
        angle, twist = data_uncertainty(setup, at)
        rounded_angle, rounded_twist = rounding_uncertainty(setup, at, state)
        self.angle = (angle + rounded_angle)[0]
        self.twist = (twist + rounded_twist)[0]
        size = np.abs(complex_stiffness(line, state.frequency[0]))
        self.torque = size * self.twist + 4.0 * EPSILON * np.abs(state.torque[0])


def emit_steady(scene: Scene, setup: Setup) -> None:
    """Angles, twists, torques and stresses by order, their half ranges, heat, gears, margins."""
    state = operating(setup)
    shaft, order = setup.shaft, setup.drive.order
    line = setup.model.at(setup.speed)
    uncertainty = _Uncertainty(setup, state, line)
    axes: dict[str, object] = {
        "station": shaft.station_names,
        "section": shaft.section_names,
        "half_order": order,
        "damper": tuple(one.name for one in shaft.dampers),
        "gear": tuple(one.name for one in shaft.gears),
    }
    station_ratio = shaft.station_ratio
    angle = (state.angle[0][:, shaft.freedom] * station_ratio).T
    angle_uncertainty = (uncertainty.angle[:, shaft.freedom] * np.abs(station_ratio)).T
    scene.emit(f"{ROOT}/angle", angle, angle_uncertainty, axes)
    total = summed(order, angle, angle_uncertainty)
    scene.emit(f"{ROOT}/angle_half_range", total.half_range, total.error, axes)
    scene.emit(f"{ROOT}/angle_peak", total.peak, total.error, axes)
    ratio = shaft.section_ratio
    twist, twist_uncertainty = (state.twist[0] * ratio).T, (uncertainty.twist * np.abs(ratio)).T
    scene.emit(f"{ROOT}/twist", twist, twist_uncertainty, axes)
    turned = summed(order, twist, twist_uncertainty)
    scene.emit(f"{ROOT}/twist_half_range", turned.half_range, turned.error, axes)
    scene.emit(f"{ROOT}/twist_peak", turned.peak, turned.error, axes)
    dampers = [one.element for one in shaft.dampers]
    if dampers:
        travel = turned.peak[dampers], turned.error[dampers]
        scene.emit(f"{ROOT}/damper/travel", *travel, axes)
    _torques(scene, setup, state, uncertainty, axes)
    _heat(scene, setup, state, uncertainty, line, axes)
    if shaft.gears:
        _gears(scene, setup, state, uncertainty, axes)
    _margins(scene, setup)
    if scene.wanted is None:  # a study of many points needs no sentences
        warn_of_orders(scene, setup)
    scene.cite(
        "elimination along the line at every order, sums over the cycle with phase",
        "forced vibration, half ranges",
        "Nestorides (ed.), A Handbook on Torsional Vibration, BICERA 1958; Pestel and Leckie, "
        "Matrix Methods in Elastomechanics, 1963",
    )


def operating(setup: Setup) -> OrderSolution:
    """All orders at the operating speed.

    Raises NumericalFailure naming mode and order where nothing damps what an order excites.
    """
    state = solved(setup.model, setup.drive, np.array([setup.speed]), estimate=True)
    met = np.flatnonzero(state.masked[0])
    if len(met):
        order, w = setup.drive.order[met[0]], float(state.frequency[0, met[0]])
        every = setup.natural().frequency
        mode = nearest_mode(every, np.array([w]))[0]
        natural = float(every[mode - 1]) if mode else 0.0
        rpm = setup.speed * 30.0 / np.pi
        if every[0] == 0.0 and not w >= SLOW * natural > 0.0:
            lowest = f", {natural:.9g} rad/s" if mode else ""
            raise NumericalFailure(
                f"order {order:g} at {setup.speed:.9g} rad/s ({rpm:.6g} rpm) is so slow that the "
                "shaft line turns as one rigid body (mode 1, 0 rad/s): the twists of its shafts "
                "are lost in the rounding of its angles. Take a speed that is not so far below "
                f"the lowest elastic mode{lowest}"
            )
        raise NumericalFailure(
            f"order {order:g} at {setup.speed:.9g} rad/s ({rpm:.6g} rpm) is on the undamped "
            f"natural frequency of mode {mode} of the shaft line, {natural:.9g} rad/s: its "
            "response has no bound there. Give shafts, stations or a damper some damping, or "
            "move the speed"
        )
    return state


def nearest_mode(natural: FloatArray, frequency: FloatArray) -> np.ndarray:
    """Number, from 1, of the elastic mode nearest in ratio to frequencies (k,); 0 for none."""
    elastic = np.flatnonzero(natural > 0.0)
    if not len(elastic):
        return np.zeros(len(frequency), dtype=np.int64)
    away = np.abs(np.log(frequency[:, None] / natural[elastic]))
    return np.asarray(elastic[np.argmin(away, axis=1)] + 1)


def _torques(
    scene: Scene,
    setup: Setup,
    state: OrderSolution,
    uncertainty: _Uncertainty,
    axes: dict[str, object],
) -> None:
    shaft, order = setup.shaft, setup.drive.order
    ratio = shaft.section_ratio
    torque = (state.torque[0] / ratio).T
    torque_uncertainty = (uncertainty.torque / np.abs(ratio)).T
    scene.emit(f"{ROOT}/torque", torque, torque_uncertainty, axes)
    total = summed(order, torque, torque_uncertainty)
    mean, mean_error = _mean_sections(setup)
    mean, mean_error = mean / ratio, mean_error / np.abs(ratio)
    peak = np.maximum(np.abs(mean + total.highest), np.abs(mean + total.lowest))
    scene.emit(f"{ROOT}/torque_half_range", total.half_range, total.error, axes)
    if setup.torsion.limits:
        from vibecalc.torsion.adapters.limits import emit_operating_use

        emit_operating_use(scene, setup, total.half_range, total.error)
    scene.emit(f"{ROOT}/torque_peak", peak, total.error + mean_error, axes)
    scene.emit(f"{ROOT}/torque_bound", total.upper_bound, total.error, axes)
    scene.emit(f"{ROOT}/torque_mean", mean, mean_error, axes)
    with_stress = np.flatnonzero(shaft.section_modulus)
    if not len(with_stress):
        return
    modulus = shaft.section_modulus[with_stress]
    names = {**axes, "section": tuple(shaft.section_names[e] for e in with_stress)}
    stress = torque[with_stress] / modulus[:, None]
    off = torque_uncertainty[with_stress] / modulus[:, None] + 4.0 * EPSILON * np.abs(stress)
    scene.emit(f"{ROOT}/stress", stress, off, names)
    half = total.half_range[with_stress] / modulus
    off = total.error[with_stress] / modulus + 4.0 * EPSILON * half
    scene.emit(f"{ROOT}/stress_half_range", half, off, names)


def _mean_sections(setup: Setup) -> tuple[FloatArray, FloatArray]:
    """Referred mean torques (e,) of the sections at the operating speed, and their errors."""
    shares = steady_shares(setup.model.at(setup.speed))
    at = np.array([setup.speed])
    mean, error = station_means(setup.shaft, setup.drive, at, setup.speed)
    value = shares @ by_freedom(setup.shaft, mean)[0]
    return value, np.max(np.abs(shares), axis=1) * error[0]


def _heat(
    scene: Scene,
    setup: Setup,
    state: OrderSolution,
    uncertainty: _Uncertainty,
    line: Line,
    axes: dict[str, object],
) -> None:
    shaft = setup.shaft
    w = state.frequency[0]
    by_order = heat(line, w, state.angle[0])
    element = by_order.element.sum(axis=0)
    share = w[:, None] * complex_stiffness(line, w).imag * uncertainty.twist
    error = np.sum(share * (np.abs(state.twist[0]) + uncertainty.twist), axis=0)
    error = np.abs(error) + 16.0 * EPSILON * np.abs(element)
    moved = uncertainty.angle * (np.abs(state.angle[0]) + uncertainty.angle)
    ground_error = np.sum(w[:, None] ** 2 * line.absolute_damping * moved, axis=0)
    ground = by_order.ground.sum(axis=0)
    ground_error = np.abs(ground_error) + 16.0 * EPSILON * np.abs(ground)
    at_station, station_error = np.zeros((2, len(shaft.station_names)))
    damping = shaft.station_values[1]
    total = line.absolute_damping[shaft.freedom]
    some = total != 0.0  # two damping ratios may ask for less than none
    share = np.divide(damping, total, out=np.zeros_like(total), where=some)
    at_station[some] = ground[shaft.freedom][some] * share[some]
    station_error[some] = np.abs(ground_error[shaft.freedom] * share)[some]
    for one in shaft.dampers:  # a damping model may brake rings, too
        at_station[one.station] += ground[one.ring]
        station_error[one.station] += abs(ground_error[one.ring])
    scene.emit(f"{ROOT}/section_heat", element, error, axes)
    scene.emit(f"{ROOT}/station_heat", at_station, station_error, axes)
    if setup.torsion.damping_model is not None and setup.torsion.damping_model.kind == "modal":
        _heat_of_modes(scene, setup, state, uncertainty)
    if shaft.dampers:
        dampers = [one.element for one in shaft.dampers]
        scene.emit(f"{ROOT}/damper/heat", element[dampers], error[dampers], axes)


def _heat_of_modes(
    scene: Scene, setup: Setup, state: OrderSolution, uncertainty: _Uncertainty
) -> None:
    """Mean power (m,) of ratios by mode, w^2 c |coordinate|^2 / 2: it has no place in the line."""
    modal, w = setup.model.modal, state.frequency[0]
    assert modal is not None
    modes, inertia = setup.modes, setup.model.line.inertia
    lever = (modes.shape * inertia / modes.modal_inertia[:, None]).T
    coordinate = np.abs(state.angle[0] @ lever)
    off = uncertainty.angle @ np.abs(lever) + (np.abs(state.angle[0]) @ inertia)[:, None] * (
        (modes.shape_error + 8.0 * EPSILON) / modes.modal_inertia
    )
    factor = 0.5 * w[:, None] * (w[:, None] * modal.dashpot + modal.loss)
    value = np.sum(factor * coordinate**2, axis=0)
    error = np.sum(factor * off * (2.0 * coordinate + off), axis=0) + 16.0 * EPSILON * value
    axes = {"mode": np.arange(1, len(value) + 1)}
    scene.emit(f"{ROOT}/modal_heat", value, error, axes)
    if np.any(value > 0.0):
        scene.warn(
            "damping ratios by mode take the place of the dampings of shafts, stations and "
            f"dampers: their heat, {value.sum():.4g} W in all modes together, has no place in the "
            "line, and sections, stations and dampers have none"
        )


def _gears(
    scene: Scene,
    setup: Setup,
    state: OrderSolution,
    uncertainty: _Uncertainty,
    axes: dict[str, object],
) -> None:
    shaft, drive, at = setup.shaft, setup.drive, np.array([setup.speed])
    scale = actual_per_referred(shaft)
    w = state.frequency[0]
    of_line = (shaft, drive, setup.model, w)
    torque = gear_torques(*of_line, state.angle[0], state.torque[0], state.load[0]) * scale
    known = drive.torque_error(at)[0]
    off = (
        gear_uncertainties(*of_line, uncertainty.angle, uncertainty.torque, known).T
        * np.abs(scale)[:, None]
    )
    shares = steady_shares(setup.model.at(setup.speed))
    mean, _ = station_means(shaft, drive, at, setup.speed)
    sections = by_freedom(shaft, mean) @ shares.T
    steady = (steady_gears(shaft, sections, mean) * scale)[0]
    mesh = mesh_torque(steady, drive.order, torque.T, off)
    steady_error = steady_uncertainties(shaft, drive, at, mean, shares)[0] * np.abs(scale)
    scene.emit(f"{ROOT}/gear/mean_torque", steady, steady_error, axes)
    scene.emit(f"{ROOT}/gear/alternating_torque", mesh.half_range, mesh.error, axes)
    both = -mesh.largest, mesh.least
    # an unloaded gear rests on neither flank: the lower one of both counts
    unloaded = np.abs(steady) <= steady_error
    least = np.where(unloaded, np.minimum(*both), np.where(steady < 0.0, *both))
    scene.emit(f"{ROOT}/gear/minimum_torque", least, mesh.error + steady_error, axes)
    scene.emit(f"{ROOT}/gear/hammers", mesh.hammer.astype(np.int64), 0.0, axes)
    for name, unsure in zip(axes["gear"], mesh.uncertain, strict=True):  # type: ignore[call-overload]
        if unsure:
            scene.warn(f"gear {name!r}: its least torque is zero to within the error")


def _margins(scene: Scene, setup: Setup) -> None:
    """Nearest order to each mode, and how far it is as a share of the order's frequency.

    Order 0, infinitely far, for the modes that are `beyond` all orders.
    """
    natural, order = setup.natural().frequency, setup.drive.order
    excited = setup.speed * order
    distance = natural[:, None] / excited - 1.0
    nearest = np.argmin(np.abs(distance), axis=1)
    axes = {"mode": np.arange(1, len(natural) + 1)}
    blank = beyond(setup, setup.speed)
    value = np.where(blank, np.inf, np.abs(distance[np.arange(len(natural)), nearest]))
    error = setup.natural().frequency_error / excited[nearest] + 4.0 * EPSILON
    scene.emit(f"{ROOT}/margin/nearest_order", np.where(blank, 0.0, order[nearest]), 0.0, axes)
    scene.emit(f"{ROOT}/margin/distance", value, np.where(blank, 0.0, error), axes)
    emit_separation(scene, setup, "operating", setup.speed, setup.speed)


# ----------------------------------------------------------------------------
# Adapter: what the orders that a case leaves out would add to the torques of its shafts.
# ----------------------------------------------------------------------------

#: a share of the half range that is worth a sentence
NOTICEABLE = 0.01


def warn_of_orders(scene: Scene, setup: Setup) -> None:
    """Look at the operating speed at twice as many orders, by the smallest step of the cycle."""
    used = setup.drive.order
    base = 2.0 * np.pi / setup.drive.firing.cycle
    drive = build_drive(scene.case, setup.shaft, orders=(2.0 * float(used[-1]), float(base)))
    state = solved(setup.model, drive, np.array([setup.speed]))
    order, torque = drive.order, state.torque[0].T / setup.shaft.section_ratio[:, None]
    known = np.min(np.abs(order[:, None] - used), axis=1) < 0.25 * base
    half = synthesis(order[known], torque[:, known]).half_range
    noticeable = half > NOTICEABLE * half.max(initial=0.0)
    if not np.any(noticeable):
        return
    safe = np.where(noticeable, half, np.inf)

    def tell(chosen: BoolArray, what: str) -> None:
        met = order[chosen & state.masked[0]]
        if len(met):
            scene.warn(
                f"{what} are left out; order {met[0]:g} of them is on an undamped natural "
                "frequency at the operating speed, where its response has no bound"
            )
            return
        added = synthesis(order[chosen], torque[:, chosen]).half_range
        most = int(np.argmax(added / safe))
        if added[most] > NOTICEABLE * safe[most]:
            scene.warn(
                f"{what} are left out and in no error estimate: at the operating speed they have "
                f"{100.0 * added[most] / half[most]:.3g} % of the half range of the orders of the "
                f"case in '{setup.shaft.section_names[most]}'"
            )

    between = ~known & (order < used[-1])
    if np.any(between):
        step = float(used[0])
        half_orders = "half orders" if step == 1.0 and base < 1.0 else "orders between"
        tell(between, f"the {half_orders}, since the step of the orders is {step:g},")
    tell(order > used[-1] + 0.25 * base, f"the orders above {used[-1]:g}, up to {order[-1]:g},")

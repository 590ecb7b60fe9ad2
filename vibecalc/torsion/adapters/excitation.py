"""Pressure and torques of a cylinder, orders, vector sums of the engine."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import (
    bank_factor,
    gas_torque_at,
    inertia_torque_at,
    major_orders,
    order_ranks,
    phase_sums,
    phasor,
)
from vibecalc.excitation.gas_tables import pressure_at
from vibecalc.kinematics.slider_crank import stroke
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray, IntArray
from vibecalc.torsion.adapters.modes import natural_uncertainty
from vibecalc.torsion.adapters.setup import Setup, placed
from vibecalc.torsion.holzer import ShapeUncertainty, uncertainty_of
from vibecalc.torsion.results import ROOT

PLACE = f"{ROOT}/excitation"
CURVES = tuple(
    f"{PLACE}/{name}"
    for name in ("pressure", "gas_torque", "inertia_torque", "total_torque", "engine_torque")
)
#: a mode that moves the cylinders by less than this of its largest angle has no vector sums
STILL = 1e-5
#: Pa; a mean indicated pressure beyond it gets a sentence
HIGHEST_MEAN = 8e6
#: crank angles of a turn, less one
STEPS = 360


def emit_excitation(scene: Scene, setup: Setup) -> None:
    """What one cylinder and all of them do at the operating speed."""
    drive, speed = setup.drive, setup.speed
    if not drive.firing.names:
        _stations(scene, setup)
        _intensity(scene, setup)
        return
    if scene.wants(*CURVES):
        _over_the_cycle(scene, setup)
    one = drive.healthy(speed)
    axes = {"order": drive.order, "cylinder": drive.firing.names}
    gas, inertia = one.gas, rounded(speed**2, 4.0) * one.inertia
    scene.emit(f"{PLACE}/gas", gas, axes=axes)
    scene.emit(f"{PLACE}/inertia", inertia, axes=axes)
    scene.emit(f"{PLACE}/total", gas + inertia, axes=axes)
    volume = drive.geometry.piston_area * drive.geometry.crank_radius
    if volume > 0.0:
        pressure = (gas + inertia) * rounded(1.0 / volume, 4.0)
        scene.emit(f"{PLACE}/tangential_pressure", pressure, axes=axes)
    _means(scene, setup, one.mean)
    scene.emit(
        f"{PLACE}/firing_angle", drive.firing.angle, 8.0 * EPSILON * drive.firing.cycle, axes
    )
    _stations(scene, setup)
    _sums(scene, setup)
    scene.cite(
        "Gauss quadrature of the pressure card with the exact slider-crank, inertia by its series",
        "torque harmonics of a cylinder at half orders",
        "Ker Wilson, Practical Solution of Torsional Vibration Problems, vol. 2, 3rd ed. 1963",
    )


def _means(scene: Scene, setup: Setup, mean: Bounded) -> None:
    drive, at, geometry = setup.drive, np.array([setup.speed]), setup.drive.geometry
    torque = drive.mean_torque(at).sum()[0]
    scene.emit(f"{PLACE}/mean_torque", torque)
    scene.emit(f"{PLACE}/power", setup.speed * torque)
    swept = geometry.piston_area * float(stroke(*geometry[:2], geometry.wrist_pin_offset))
    if swept > 0.0:
        pressure = rounded(drive.firing.cycle / swept, 16.0) * mean
        scene.emit(f"{PLACE}/mean_indicated_pressure", pressure)
        if abs(pressure.value) > HIGHEST_MEAN:
            scene.warn(
                f"the mean indicated pressure is {1e-5 * pressure.value:.3g} bar, above the 40 "
                "bar of engines: are the gas pressures in Pa (write '60 bar' for bar)?"
            )


def _over_the_cycle(scene: Scene, setup: Setup) -> None:
    """Pressure and torques at each degree of the cycle.

    A table of tangential effort has no pressure; its torque is that of the orders of the case.
    """
    drive, geometry = setup.drive, setup.drive.geometry
    turns = round(drive.firing.cycle / (2.0 * np.pi))
    angle = np.linspace(0.0, drive.firing.cycle, STEPS * turns + 1)
    inertia = setup.speed**2 * inertia_torque_at(
        geometry, drive.reciprocating_mass, drive.rod_inertia, angle
    )
    axes = {"crank_angle": angle}
    # an angle of the cycle is right to a rounding, and so is its sine
    rounding, step = EPSILON * drive.firing.cycle, angle[1] - angle[0]

    def uncertainty(value: FloatArray) -> float:
        steepest = float(np.max(np.abs(np.diff(value)))) / step
        return float(8.0 * EPSILON * np.max(np.abs(value)) + rounding * steepest)

    errors, values = {}, {}
    if drive.cards:
        share = drive.weights(np.asarray(setup.speed))
        pressure = share @ np.array([pressure_at(card, angle) for card in drive.cards])
        gas = share @ np.array([gas_torque_at(card, geometry, angle) for card in drive.cards])
        off = share @ np.array([card.error.max() for card in drive.cards])
        lever = geometry.piston_area * geometry.crank_radius
        values["pressure"], errors["pressure"] = pressure, uncertainty(pressure) + off
        off_gas = lever * off
    else:
        one = drive.healthy(setup.speed)
        turned = np.exp(1j * angle[:, None] * drive.order)
        gas = one.mean.value + np.real(turned @ one.gas.value)
        off_gas = float(one.mean.error + one.gas.error.sum())
    values |= {"gas_torque": gas, "inertia_torque": inertia, "total_torque": gas + inertia}
    errors |= {
        "gas_torque": uncertainty(gas) + off_gas,
        "inertia_torque": 2.0 * uncertainty(inertia),
    }
    errors["total_torque"] = errors["gas_torque"] + errors["inertia_torque"]
    for name, value in values.items():
        scene.emit(f"{PLACE}/{name}", value, errors[name], axes)
    # of all cylinders, as far as the orders of the case go
    at = np.array([setup.speed])
    of_engine = drive._replace(given=())
    torque = of_engine.torque(at)[0].sum()
    mean = drive.mean_torque(at).sum()[0]
    # a rounded angle turns each order, all of them by as much
    turned = EPSILON * drive.firing.cycle * (np.abs(torque.value) @ drive.order)
    wave = np.real(np.exp(1j * angle[:, None] * drive.order) @ torque.value)
    engine = mean + Bounded(wave, turned + torque.error.sum())
    scene.emit(f"{PLACE}/engine_torque", engine, axes=axes)


def _stations(scene: Scene, setup: Setup) -> None:
    drive, shaft, at = setup.drive, setup.shaft, np.array([setup.speed])
    torque = drive.torque(at)[0] / shaft.station_ratio[drive.station]
    by_station = np.zeros((len(shaft.station_names), len(drive.order)), dtype=np.complex128)
    by_station[drive.station] = torque.value.T
    axes = {"station": shaft.station_names, "order": drive.order}
    scene.emit(f"{PLACE}/station_torque", by_station, np.max(torque.error, initial=0.0), axes)


def _sums(scene: Scene, setup: Setup) -> None:
    drive, modes = setup.drive, setup.natural()
    axes = {"mode": np.arange(1, len(modes.frequency) + 1), "order": drive.order}
    every = modes.shape if modes.damped else modes.shape.real
    shape = every[:, setup.shaft.cylinder_freedom]
    sums = phase_sums(shape, drive.firing.angle, drive.order)
    whole = np.abs(shape).sum(axis=1, keepdims=True)
    still = (whole < STILL) | ~drive.fires
    whole = np.where(still, 1.0, whole)
    value = np.where(still, 0.0, sums.value / whole)
    moved, freedom = natural_uncertainty(setup), setup.shaft.cylinder_freedom
    turned: ComplexArray = np.asarray(phasor(drive.order, drive.firing.angle)[None])
    length = np.abs(shape)
    towards = (shape / np.where(length > 0.0, length, 1.0)).conj()[:, None, :]
    share: ComplexArray = np.asarray(value[..., None] * towards, dtype=np.complex128)
    if modes.damped:  # their lengths move by a part only of what their angles do
        uncertainty = sums.error + _on_freedoms(moved, turned, freedom)
        uncertainty = uncertainty + _on_freedoms(moved, share, freedom)
    else:
        # what grows all cylinders alike leaves the share that is left of their sum
        uncertainty = sums.error + _on_freedoms(moved, turned - share, freedom)
    uncertainty = np.where(still, 0.0, uncertainty / whole)
    scene.emit(f"{PLACE}/vector_sum", value, uncertainty, axes)
    scene.emit(f"{PLACE}/rank", order_ranks(value, uncertainty), 0.0, axes)
    _intensity(scene, setup)
    angles = drive.firing.angle, drive.order, drive.firing.bank
    major = drive.fires & major_orders(*angles)
    scene.emit(f"{PLACE}/major", major.astype(np.int64), 0.0, axes)
    if np.ptp(drive.firing.bank) > 0.0:
        scene.emit(f"{PLACE}/bank_factor", *bank_factor(*angles), axes)


def _intensity(scene: Scene, setup: Setup) -> None:
    """Torque of each order on each mode."""
    drive, modes = setup.drive, setup.natural()
    axes = {"mode": np.arange(1, len(modes.frequency) + 1), "order": drive.order}
    every = modes.shape if modes.damped else modes.shape.real
    torque = drive.torque(np.array([setup.speed]))[0]
    intensity = every[:, drive.freedom] @ torque.T
    off = _on_freedoms(natural_uncertainty(setup), torque.value, drive.freedom)
    scene.emit(f"{PLACE}/intensity", intensity.value, intensity.error + off, axes)


def _on_freedoms(
    uncertainty: ShapeUncertainty, weight: ComplexArray, freedom: IntArray
) -> FloatArray:
    """Errors (m, q) of sums of the angles of cylinders, with weights (..., q, c)."""
    place = placed(freedom, uncertainty.moved.shape[1] - 1)
    return uncertainty_of(uncertainty, weight @ place)

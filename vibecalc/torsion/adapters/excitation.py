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
)
from vibecalc.excitation.gas_tables import pressure_at
from vibecalc.kinematics.slider_crank import stroke
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.torsion.adapters.modes import ModeCopies
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.damped_modes import LineModes
from vibecalc.torsion.modes import Modes
from vibecalc.torsion.results import ROOT

PLACE = f"{ROOT}/excitation"
CURVES = tuple(
    f"{PLACE}/{name}"
    for name in ("pressure", "gas_torque", "inertia_torque", "total_torque", "engine_torque")
)
SUMS = (f"{PLACE}/vector_sum", f"{PLACE}/rank")
#: a mode that moves the cylinders by less than this of its largest angle has no vector sums
STILL = 1e-5
#: Pa; a mean indicated pressure beyond it gets a sentence
HIGHEST_MEAN = 8e6
#: crank angles of a turn, less one
STEPS = 360


def emit_excitation(scene: Scene, setup: Setup, moved: ModeCopies) -> None:
    """What one cylinder and all of them do at the operating speed."""
    drive, speed = setup.drive, setup.speed
    if not drive.firing.names:
        _stations(scene, setup)
        _intensity(scene, setup, moved)
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
    _sums(scene, setup, moved)
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


def _sums(scene: Scene, setup: Setup, moved: ModeCopies) -> None:
    drive, freedom = setup.drive, setup.shaft.cylinder_freedom
    axes = {"mode": np.arange(1, len(setup.natural().frequency) + 1), "order": drive.order}
    if scene.wants(*SUMS):
        still = np.abs(setup.natural().shape[:, freedom]).sum(axis=1, keepdims=True) < STILL
        still = still | ~drive.fires

        def summed(one: Modes | LineModes) -> tuple[ComplexArray, FloatArray]:
            """Sums over those of all in phase, and what rounds these (m, q)."""
            shape = one.shape[:, freedom]
            sums = phase_sums(shape, drive.firing.angle, drive.order)
            whole = np.where(still, np.inf, np.abs(shape).sum(axis=1, keepdims=True))
            return np.asarray(sums.value / whole), np.asarray(sums.error / whole)

        value, rounding = moved.of(summed)
        uncertainty = value.error + rounding.value
        scene.emit(SUMS[0], value.value, uncertainty, axes)
        scene.emit(SUMS[1], order_ranks(value.value, uncertainty), 0.0, axes)
    _intensity(scene, setup, moved)
    angles = drive.firing.angle, drive.order, drive.firing.bank
    major = drive.fires & major_orders(*angles)
    scene.emit(f"{PLACE}/major", major.astype(np.int64), 0.0, axes)
    if np.ptp(drive.firing.bank) > 0.0:
        scene.emit(f"{PLACE}/bank_factor", *bank_factor(*angles), axes)


def _intensity(scene: Scene, setup: Setup, moved: ModeCopies) -> None:
    """Torque of each order on each mode."""
    path, drive = f"{PLACE}/intensity", setup.drive
    if not scene.wants(path):
        return
    axes = {"mode": np.arange(1, len(setup.natural().frequency) + 1), "order": drive.order}
    torque = drive.torque(np.array([setup.speed]))[0]
    intensity = moved.of(lambda one: one.shape[:, drive.freedom] @ torque.value.T)
    off = np.abs(setup.natural().shape[:, drive.freedom]) @ torque.errors.T
    scene.emit(path, intensity.value, intensity.error + off, axes)

"""Adapter: play in the joints of one cylinder to statistics of its impacts."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.axial_force import axial_force
from vibecalc.impact.linkage import GapForces
from vibecalc.impact.model import Joints, joints_of
from vibecalc.impact.runs import (
    ROUNDINGS,
    Ensemble,
    Study,
    first_motion,
    parting,
    run_ensemble,
    run_fixed_steps,
)
from vibecalc.impact.statistics import (
    Statistic,
    dominance,
    mean_over_runs,
    quantiles,
    standard_error,
    statistics,
)
from vibecalc.kinematics.harmonics import harmonics_with_error
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray

if TYPE_CHECKING:
    from vibecalc.response.tables import Impact

_ROOT = "response/impact"
#: imbalance of energy above which an event-exact run is none
_LARGEST_RESIDUAL = 1e-6
#: relative standard error above which a statistic has not settled
_UNSETTLED = 0.2
#: a drift between the halves of the counted revolutions: standard errors, and part of the mean
_DRIFT, _DRIFT_SHARE = 5.0, 0.01


def run_impact(scene: Scene) -> None:
    """Emit statistics, parting, first contacts, and what leads next to the impacts."""
    options = scene.case.response.impact if scene.case.response else None
    assert options is not None  # or the stage is not planned
    joints = joints_of(scene.case)
    study = Study(
        np.array(options.clearances or [joints.linkage.wrist_pin.clearance]),
        options.members,
        options.discard,
        options.revolutions,
        options.orders,
    )
    _cite(scene, options)
    exact = run_ensemble(joints.linkage, study, options.perturbation)
    forces, found = exact.forces, statistics(exact.forces, joints.linkage)
    errors = numerical_errors(found, exact, float(joints.linkage.wrist_pin.stiffness))
    if options.method != "event_exact":
        forces = run_fixed_steps(joints.linkage, study, options.method, options.steps)
        followed, found = found, statistics(forces, joints.linkage)
        errors = differences(found, followed)
    axes = {"clearance": study.clearance, "order": np.arange(1, study.orders + 1)}
    for name, statistic in found.items():
        _emit(scene, name, statistic, errors[name], axes)
    mean = found["mean_force"].standard_error
    uncertain = mean / np.sqrt(2.0 * (study.members - 1))
    _emit(scene, "mean_force_standard_error", Statistic(mean, uncertain), EPSILON * mean, axes)
    _emit_energy(scene, exact, axes)
    _emit_parting(scene, exact, axes, options.perturbation)
    _emit_first_motion(scene, joints, study.clearance)
    emit_dominance(scene, joints, found["added_force"], axes)
    _warn(scene, options, study, found, errors, forces)


def _emit(
    scene: Scene, name: str, statistic: Statistic, error: np.ndarray, axes: Mapping[str, np.ndarray]
) -> None:
    uncertainty = float(np.max(statistic.standard_error))
    scene.emit(f"{_ROOT}/{name}", statistic.value, error, axes, uncertainty)


def _emit_energy(scene: Scene, exact: Ensemble, axes: Mapping[str, np.ndarray]) -> None:
    error = np.mean(exact.residual * exact.exchanged, axis=(1, 2))
    _emit(scene, "dissipated", mean_over_runs(exact.dissipated), error, axes)
    residual = np.max(exact.residual, axis=(1, 2))
    worst = float(np.max(residual))
    if worst > _LARGEST_RESIDUAL:
        raise NumericalFailure(
            f"the energy of the impacts does not balance: {worst:.1e} of what is exchanged in a "
            f"revolution is missing, more than {_LARGEST_RESIDUAL:g}"
        )
    # of rounding only the size means something
    off = residual + 64.0 * EPSILON
    scene.emit(f"{_ROOT}/energy_residual", residual, off, axes, terms=1.0)


def _emit_parting(
    scene: Scene, exact: Ensemble, axes: Mapping[str, np.ndarray], perturbation: float
) -> None:
    turns = exact.distances.shape[-1] - 1
    found = parting(exact.distances)
    (when,) = quantiles(found.revolutions[:, :, None], (0.5,))
    (rate,) = quantiles(found.rate[:, :, None], (0.5,))
    # rounding of the state next to the perturbation, taken as in the first motion
    level = ROUNDINGS * EPSILON * axes["clearance"] / perturbation
    fastest = np.maximum(np.abs(rate.value), 1.0 / turns)
    uncertainty = np.where(np.isfinite(when.standard_error), when.standard_error, float(turns))
    _emit(scene, "parting", Statistic(when.value, uncertainty), level / fastest, axes)
    _emit(scene, "divergence", rate, level, axes)


def _emit_first_motion(scene: Scene, joints: Joints, clearance: np.ndarray) -> None:
    paths = f"{_ROOT}/first_contacts", f"{_ROOT}/first_turn_force"
    if not scene.wants(*paths):
        return
    first = first_motion(joints.linkage, clearance)
    axes = {
        "clearance": clearance,
        "contact": np.arange(1, first.contacts.shape[1] + 1),
        "crank_angle": first.angle,
    }
    scene.emit(paths[0], first.contacts, first.contacts_error, axes)
    scene.emit(paths[1], first.force, first.force_error, axes)


def _cite(scene: Scene, options: "Impact") -> None:
    scene.cite(
        "piston between two contacts, followed from contact to contact",
        "impacts in joints with play",
        "model of Ong (2000), equation 5.1, with a continuous contact spring and the true sense of "
        "the pressure unless the case says otherwise; power series, docs/theory.md",
    )
    if options.method != "event_exact":
        scene.cite(
            f"{options.method} with {options.steps} fixed steps per revolution",
            "statistics of the impact force",
            "Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993",
        )
    scene.cite(
        "members spread by an additive recurrence",
        "ensemble of impacts",
        "Niederreiter, Random Number Generation and Quasi-Monte Carlo Methods, 1992, ch. 3",
    )
    scene.cite(
        "quantiles of samples in clusters",
        "standard errors of quantiles",
        "Woodruff, J. American Statistical Association 47 (1952) 635-646",
    )


def _warn(
    scene: Scene,
    options: "Impact",
    study: Study,
    found: Mapping[str, Statistic],
    errors: Mapping[str, FloatArray],
    forces: GapForces,
) -> None:
    for name, words in (("mean_force", "mean force"), ("average_amplitude", "spectrum")):
        value, uncertainty = found[name]
        for at in np.flatnonzero(uncertainty > _UNSETTLED * value):
            scene.warn(
                f"the {words} of impacts with a clearance of {study.clearance[at]:.6g} m has not "
                f"settled: its standard error is {100.0 * uncertainty[at] / value[at]:.0f} %; use "
                "more members"
            )
    half, force = study.revolutions // 2, forces.mean[0]
    drift = np.mean(force[:, :, -half:], axis=2) - np.mean(force[:, :, :half], axis=2)
    size, uncertainty = np.abs(np.mean(drift, axis=1)), standard_error(drift)
    mean = found["mean_force"].value
    for at in np.flatnonzero((size > _DRIFT * uncertainty) & (size > _DRIFT_SHARE * mean)):
        scene.warn(
            f"impacts with a clearance of {study.clearance[at]:.6g} m still depend on their start: "
            f"the mean force moves by {100.0 * size[at] / mean[at]:.1f} % between the halves of "
            f"the evaluated revolutions; discard more"
        )
    if options.method != "event_exact":
        share = float(np.max(errors["mean_force"] / mean))
        scene.warn(
            f"impact forces are those of {options.method} with {options.steps} steps per "
            f"revolution, whose mean force is off by up to {100.0 * share:.1f} % (with standard "
            "errors); contacts, parting and energies are event-exact"
        )


# ----------------------------------------------------------------------------
# How exact the statistics are.
# ----------------------------------------------------------------------------


def numerical_errors(
    values: Mapping[str, Statistic], exact: Ensemble, stiffness: float
) -> dict[str, FloatArray]:
    """What imbalance of energy and rounding make of each statistic: absolute, at most.

    `stiffness`, N/m, is that of the contacts of the wrist pin.
    """
    relative = np.max(exact.residual, axis=(1, 2)) + 32.0 * EPSILON
    # a harmonic is twice a mean
    force = 2.0 * relative * np.max(exact.forces.mean[0], axis=(1, 2))
    # energy of a contact spring: dF = K dE / F
    energy = relative * np.max(exact.exchanged, axis=(1, 2))
    smallest = np.maximum(np.min(exact.forces.peak[0], axis=(1, 2)), np.sqrt(stiffness * energy))
    of_peak = stiffness * energy / np.where(smallest > 0.0, smallest, 1.0)
    errors = dict.fromkeys(values, force)
    for name, (value, _) in values.items():
        if name.endswith("impacts"):
            errors[name] = np.asarray(64.0 * EPSILON * np.max(value))
        elif "/" in name:
            errors[name] = np.asarray(2.0 * relative * np.max(np.abs(value), axis=0))
    errors["peak_force"] = errors["peak_force_high"] = of_peak
    errors["contact_share"] = np.asarray(64.0 * EPSILON)
    return errors


def differences(
    values: Mapping[str, Statistic], exact: Mapping[str, Statistic]
) -> dict[str, FloatArray]:
    """How far a fixed-step method is off: the event-exact statistics, and two standard errors."""
    return {
        name: np.abs(statistic.value - exact[name].value)
        + 2.0 * np.hypot(statistic.standard_error, exact[name].standard_error)
        for name, statistic in values.items()
    }


# ----------------------------------------------------------------------------
# Adapter: impact force next to the piston's inertia force and the motor's axial force, by order.
# ----------------------------------------------------------------------------


def emit_dominance(
    scene: Scene, joints: Joints, impact: Statistic, axes: Mapping[str, np.ndarray]
) -> None:
    """Emit both forces and who leads; `impact` (C, N) has the orders of `axes`."""
    orders = axes["order"]
    shaking = _shaking(scene, joints, int(orders[-1]))
    scene.emit(f"{_ROOT}/shaking", shaking, axes=axes)
    motor, machine = Bounded(np.zeros(len(orders)), np.zeros(len(orders))), scene.case.machine
    if machine.motor is not None and scene.case.excitation is not None:
        acting, force = axial_force(machine.motor)
        here = np.isin(acting, orders)
        at = acting[here] - orders[0]
        motor.value[at], motor.error[at] = abs(force.axial_force[here])
        scene.emit(f"{_ROOT}/motor", motor, axes=axes)
    dominant = dominance(impact, shaking.value, motor.value)
    # whole numbers, which a spectrum moves by whole orders
    for name, value, spread in (
        ("dominant", dominant.dominant, dominant.dominant_spread),
        ("dominant_from", dominant.dominant_from, dominant.dominant_from_spread),
    ):
        scene.emit(f"{_ROOT}/{name}", value, 0.0, axes, float(np.max(spread)))


def _shaking(scene: Scene, joints: Joints, highest: int) -> Bounded:
    """Inertia force (N,), N, of all that moves with the piston, magnitudes of orders 1 to N."""
    train, speed = scene.parts.crank_train, scene.case.machine.speed
    ratio = train.crank_radius / train.rod_length
    offset = train.wrist_pin_offset / train.crank_radius
    motion = harmonics_with_error(ratio, highest, offset, derivative=2)
    scale = joints.reciprocating_mass * train.crank_radius * speed**2
    size = scale * np.abs(motion.values[1:])
    # R / L is itself rounded: d ln C_n / d ln(R / L) is about n / sqrt(1 - (R / L)^2)
    steepness = np.arange(1, highest + 1) / np.sqrt(1.0 - ratio**2)
    return Bounded(size, scale * motion.error[1:] + EPSILON * (8.0 + steepness) * size)

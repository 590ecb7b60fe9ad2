"""Adapter: play in the joints of one cylinder to statistics of its impacts."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.machine.joints import Joints, build_joints
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.impact_dominance import emit_dominance
from vibecalc.pipeline.stages.impact_statistics import differences, numerical_errors, statistics
from vibecalc.response.impact.ensemble import Statistic, mean_over_runs, quantiles, standard_error
from vibecalc.response.impact.first_motion import ROUNDINGS, first_motion
from vibecalc.response.impact.parting import parting
from vibecalc.response.impact.runs import Ensemble, Forces, Study, run_ensemble, run_fixed_steps

if TYPE_CHECKING:
    from vibecalc.case.response_tables import Impact

#: imbalance of energy above which an event-exact run is none
_LARGEST_RESIDUAL = 1e-6
#: relative standard error above which a statistic has not settled
_UNSETTLED = 0.2
#: a drift between the halves of the counted revolutions: standard errors, and part of the mean
_DRIFT, _DRIFT_SHARE = 5.0, 0.01


def run(scene: Scene) -> None:
    """Emit statistics, parting, first contacts, and what leads beside the impacts."""
    options = scene.case.response.impact if scene.case.response else None
    if options is None or scene.case.machine.joints is None:
        raise ValueError("impacts need [response.impact] and [machine.joints]")
    excitation = scene.case.excitation
    joints = build_joints(
        scene.case.machine,
        excitation.working if excitation else None,
        gas_towards_crank=options.pressure == "towards_crank",
    )
    own = (scene.case.machine.joints.wrist_pin.clearance,)
    study = Study(
        np.array(options.clearances or own),
        options.members,
        options.discard,
        options.revolutions,
        options.orders,
    )
    _cite(scene, options)
    exact = run_ensemble(joints.linkage, study, options.perturbation)
    _check_energy(exact)
    forces, other = exact.forces, None
    if options.method != "event_exact":
        other = exact.forces
        forces = run_fixed_steps(joints.linkage, study, options.method, options.steps)
    found = statistics(forces, joints.linkage)
    if other is None:
        errors = numerical_errors(found, exact, joints.linkage)
    else:
        errors = differences(found, statistics(other, joints.linkage))
    orders = np.arange(1, study.orders + 1)
    axes = {"clearance": study.clearance, "order": orders}
    for name, statistic in found.items():
        _emit(scene, name, statistic, errors[name], axes)
    mean = found["mean_force"].standard_error
    doubt = float(np.max(mean)) / np.sqrt(2.0 * (study.members - 1))
    scene.emit("response/impact/mean_force_standard_error", mean, EPSILON * mean, axes, doubt)
    _emit_energy(scene, exact, axes)
    _emit_parting(scene, exact, axes, options.perturbation)
    _emit_first_motion(scene, joints, study.clearance)
    emit_dominance(scene, joints, found["added_force"], axes)
    _warn(scene, options, study, found, errors, forces)


def _emit(
    scene: Scene, name: str, found: Statistic, error: np.ndarray, axes: dict[str, np.ndarray]
) -> None:
    doubt = float(np.max(found.standard_error))
    scene.emit(f"response/impact/{name}", found.value, error, axes, doubt)


def _emit_energy(scene: Scene, exact: Ensemble, axes: dict[str, np.ndarray]) -> None:
    error = np.mean(exact.residual * exact.exchanged, axis=(1, 2))
    _emit(scene, "dissipated", mean_over_runs(exact.dissipated), error, axes)
    residual = np.max(exact.residual, axis=(1, 2))
    # of rounding only the size means something
    path = "response/impact/energy_residual"
    scene.emit(path, residual, residual + 64.0 * EPSILON, axes, terms=1.0)


def _emit_parting(
    scene: Scene, exact: Ensemble, axes: dict[str, np.ndarray], perturbation: float
) -> None:
    turns = exact.distances.shape[-1] - 1
    found = parting(exact.distances)
    (when,) = quantiles(found.revolutions[:, :, None], (0.5,))
    (rate,) = quantiles(found.rate[:, :, None], (0.5,))
    # rounding of the state beside the perturbation, taken as in the first motion
    level = ROUNDINGS * EPSILON * axes["clearance"] / perturbation
    fastest = np.maximum(np.abs(rate.value), 1.0 / turns)
    doubt = np.where(np.isfinite(when.standard_error), when.standard_error, float(turns))
    _emit(scene, "parting", Statistic(when.value, doubt), level / fastest, axes)
    _emit(scene, "divergence", rate, level, axes)


def _emit_first_motion(scene: Scene, joints: Joints, clearance: np.ndarray) -> None:
    if not scene.wants("response/impact/first_contacts", "response/impact/first_turn_force"):
        return
    first = first_motion(joints.linkage, clearance)
    axes = {
        "clearance": clearance,
        "contact": np.arange(1, first.contacts.shape[1] + 1),
        "crank_angle": first.angle,
    }
    contacts = "response/impact/first_contacts"
    scene.emit(contacts, first.contacts, first.contacts_error, axes)
    scene.emit("response/impact/first_turn_force", first.force, first.force_error, axes)


def _check_energy(exact: Ensemble) -> None:
    worst = float(np.max(exact.residual))
    if worst > _LARGEST_RESIDUAL:
        raise NumericalFailure(
            f"the energy of the impacts does not balance: {worst:.1e} of what is exchanged in a "
            f"revolution is missing, more than {_LARGEST_RESIDUAL:g}"
        )


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
    found: dict[str, Statistic],
    errors: dict[str, np.ndarray],
    forces: Forces,
) -> None:
    for name, words in (("mean_force", "mean force"), ("average_amplitude", "spectrum")):
        value, doubt = found[name]
        for at in np.flatnonzero(doubt > _UNSETTLED * value):
            scene.warn(
                f"the {words} of impacts with a clearance of {study.clearance[at]:.6g} m has not "
                f"settled: its standard error is {100.0 * doubt[at] / value[at]:.0f} %; more "
                "members help"
            )
    half, force = study.revolutions // 2, forces.wrist_pin.force
    drift = np.mean(force[:, :, -half:], axis=2) - np.mean(force[:, :, :half], axis=2)
    size, doubt = np.abs(np.mean(drift, axis=1)), standard_error(drift)
    mean = found["mean_force"].value
    for at in np.flatnonzero((size > _DRIFT * doubt) & (size > _DRIFT_SHARE * mean)):
        scene.warn(
            f"impacts with a clearance of {study.clearance[at]:.6g} m still remember their start: "
            f"the mean force moves by {100.0 * size[at] / mean[at]:.1f} % between the halves of "
            f"the counted revolutions; discard more"
        )
    if options.method != "event_exact":
        share = float(np.max(errors["mean_force"] / mean))
        scene.warn(
            f"impact forces are those of {options.method} with {options.steps} steps per "
            f"revolution, whose mean force is off by up to {100.0 * share:.1f} % (standard errors "
            "counted); contacts, parting and energies are event-exact"
        )

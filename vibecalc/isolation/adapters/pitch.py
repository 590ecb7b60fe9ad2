"""Adapter: the body pitching on its mounts at operating speed."""

import numpy as np

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing
from vibecalc.excitation.inertia_forces import about_point, at_speed, size_of_terms
from vibecalc.isolation import pitch as model
from vibecalc.isolation.adapters.common import (
    RunUpSetup,
    emit_peak,
    emit_static,
    emit_support_motion,
    isolation_of,
    peak_with_tail,
)
from vibecalc.isolation.model import PitchParts, pitch_parts
from vibecalc.isolation.pitch import pitch_resonances, pitch_static
from vibecalc.isolation.rows import distinct, pitch_readout, pitch_rows, with_left_out
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.resonances import check_operating_point, idle_warnings, left_out

LEVER_FORCES = tuple(path for path in CATALOGUE if path.startswith("isolation/lever_force/"))


def run_isolation_pitch(scene: Scene) -> None:
    """Emit the pitch model, its response, both readings of the support force, and the sag."""
    forcing: Forcing = scene.handed_on["forcing"]
    options = isolation_of(scene)
    if scene.parts.body is None or scene.parts.mounts is None:
        raise ValueError("isolation needs a body and mounts")
    train = scene.case.machine.crank_train
    parts = pitch_parts(scene.parts.body, scene.parts.mounts, train.axis, train.stroke)
    pitch = model.pitch_model(
        parts.inertia, parts.position, parts.stiffness, parts.damping, parts.structural
    )
    lever = options.lever or parts.lever or float(np.abs(parts.position).max())
    scene.cite(
        "pitch model with complex amplitudes",
        "response on the mounts",
        "Gibson (2008), equations 13 to 19, with the phase kept",
    )
    _emit_model(scene, pitch)

    about_centre = about_point(forcing.per_speed_squared, parts.centre)
    couple = Bounded(
        about_centre.couple @ parts.across, about_centre.couple_error @ np.abs(parts.across)
    )
    resonances = pitch_resonances(pitch, couple)
    undriven = left_out(resonances)[:, 0]
    couple = Bounded(np.where(undriven, 0.0, couple.value), couple.error)
    used, speed = forcing.retained, scene.case.machine.speed
    for warning in check_operating_point(resonances, forcing.orders, speed):
        scene.warn(warning)
    frequency = forcing.orders * speed
    driven = at_speed(about_centre, speed)
    torque = Bounded(
        np.where(undriven, 0.0, driven.couple @ parts.across),
        driven.couple_error @ np.abs(parts.across),
    )
    angle = model.angle_harmonics(pitch, torque.value, torque.error, frequency, undriven)
    axes = {"order": forcing.orders[:used]}
    if scene.wants("isolation/pitch/transmissibility"):
        passing = model.transmissibility(pitch, frequency[:used])
        scene.emit("isolation/pitch/transmissibility", passing.value, passing.error, axes)
    if scene.wants("isolation/pitch/transmissibility_curve"):
        _emit_curve(scene, pitch, float(frequency[used - 1]))
    rounding = angle.error[:used]
    terms = size_of_terms(rounding)
    scene.emit("isolation/pitch/angle_harmonics", angle.value[:used], rounding, axes, terms=terms)
    emit_peak(scene, "isolation/pitch/angle_peak", angle, forcing)
    if scene.wants(*LEVER_FORCES):
        through = model.transmitted_couple(pitch, angle, frequency)
        _emit_lever_force(scene, forcing, torque, through, lever)
    _emit_supports(scene, forcing, parts, torque, angle, frequency)

    readout, row_of = distinct(
        pitch_readout(
            pitch, lever, parts.position, parts.stiffness, parts.damping, parts.structural
        )
    )
    first = Bounded(couple.value[:used], couple.error[:used])
    in_run_up, few = pitch_resonances(pitch, first), forcing.few
    higher = Bounded(couple.value[few], couple.error[few])
    scene.handed_on["run_up"] = RunUpSetup(
        rows=with_left_out(
            pitch_rows(pitch, readout, forcing.orders[:used], first, undriven[:used]),
            pitch_rows(pitch, readout, forcing.orders[few], higher, undriven[few]),
            forcing.few_tail,
        ),
        harmonics=forcing.orders[:used],
        step=1,
        resonances=in_run_up,
        shows=(readout.spring[:, 0, 0].real != 0.0)[None, :],
        row_of=row_of,
        lever_rows=1,
        idle=lambda low, high: idle_warnings(in_run_up, forcing.orders[:used], low, high),
    )


def _emit_model(scene: Scene, pitch: model.Pitch) -> None:
    rounding = pitch.rounding
    for name, value in (
        ("inertia", pitch.inertia),
        ("stiffness", pitch.stiffness),
        ("damping", pitch.damping),
    ):
        scene.emit(f"isolation/pitch/{name}", value, rounding * np.abs(value))
    scene.emit(
        "isolation/pitch/natural_frequency", pitch.natural_frequency, pitch.natural_frequency_error
    )
    scene.emit("isolation/pitch/damping_ratio", pitch.damping_ratio, pitch.damping_ratio_error)


def _emit_curve(scene: Scene, pitch: model.Pitch, highest: float) -> None:
    """Transmissibility from .05 to 50 times the natural frequency, for the picture.

    Whole decades more where the `highest` order lies beyond: the samples must not follow its bits.
    """
    beyond = highest / float(50.0 * pitch.natural_frequency)
    decades = np.ceil(np.log10(min(max(beyond, 1.0), 1e6)))
    end = 6.0 if decades == 0.0 else np.arcsinh((np.log(50.0) + decades * np.log(10.0)) / 0.02)
    # Dense around 1 and never on it, where an undamped body has no value.
    ratio = np.exp(0.02 * np.sinh(np.linspace(-5.7, end, 300)))
    curve = model.transmissibility(pitch, ratio * pitch.natural_frequency)
    axes = {"frequency_ratio": ratio}
    scene.emit("isolation/pitch/transmissibility_curve", curve.value, curve.error, axes)


def _emit_lever_force(
    scene: Scene, forcing: Forcing, torque: Bounded, through: Bounded, lever: float
) -> None:
    """The source's reading: couple over lever, with the body held still and on its mounts."""
    used = forcing.retained
    for name, couple in (("rigid", torque), ("steady", through)):
        force = model.lever_force(couple, lever)
        scene.emit(
            f"isolation/lever_force/{name}_harmonics",
            force.value[:used],
            force.error[:used],
            {"order": forcing.orders[:used]},
            terms=size_of_terms(force.error[:used]),
        )
        emit_peak(scene, f"isolation/lever_force/{name}_peak", force, forcing)


def _emit_supports(
    scene: Scene,
    forcing: Forcing,
    parts: PitchParts,
    torque: Bounded,
    angle: Bounded,
    frequency: np.ndarray,
) -> None:
    """One support of all: static share and sag, force with the body still and on its mounts."""
    options, body = isolation_of(scene), scene.parts.body
    if body is None:
        raise ValueError("isolation needs a body")
    static = pitch_static(body.mass * options.gravity, 0.0, parts.position, parts.stiffness)
    emit_static(scene, parts.names, static.sag, static.sag_error, static.share, static.share_error)
    if scene.wants("isolation/support_force/rigid_peak"):
        share = np.abs(model.support_share(parts.position, parts.stiffness))
        still, spread, terms = peak_with_tail(torque, forcing)
        scene.emit(
            "isolation/support_force/rigid_peak",
            share * still,
            share * (spread + 8.0 * EPSILON * still),
            {"mount": parts.names},
            terms=share * terms,
        )
    displacement = model.support_displacement(angle, parts.position)
    force = model.support_force(
        displacement, frequency, parts.stiffness, parts.damping, parts.structural
    )
    # the one component of a pitching body at a support: along the stroke
    emit_support_motion(
        scene,
        forcing,
        parts.names,
        (scene.case.machine.crank_train.stroke,),
        Bounded(displacement.value[:, None, :], displacement.error[:, None, :]),
        Bounded(force.value[:, None, :], force.error[:, None, :]),
        np.array([1.0]),
        Bounded(static.sag, static.sag_error),
    )

"""Adapter: the body pitching on its mounts at operating speed."""

from dataclasses import replace

import numpy as np

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.run.columns import PointsScene
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import (
    CyclePeak,
    Forcing,
    couples_of,
    few_orders,
    forces_of,
    length_over_cycle,
    peak_with_tail,
)
from vibecalc.excitation.inertia_forces import about_point, size_of_terms
from vibecalc.isolation import pitch as model
from vibecalc.isolation.adapters.common import (
    EXCURSION,
    LARGEST,
    LOADS,
    OF_RUN_UP,
    VERTICAL,
    KeptRows,
    OfBody,
    RunUpSetup,
    emit_static,
    emit_support_motion,
    emit_with_constant,
    isolation_of,
)
from vibecalc.isolation.model import PitchParts, pitch_parts
from vibecalc.isolation.pitch import pitch_resonances, pitch_static
from vibecalc.isolation.rows import Readout, distinct, pitch_readout, pitch_rows, with_left_out
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.forced import MotionByOrder
from vibecalc.response.resonances import check_operating_point, idle_warnings, left_out

LEVER, RIGID = "isolation/lever_force", "isolation/support_force/rigid_peak"
HARMONICS = tuple(
    f"isolation/support_{group}/steady_harmonics" for group in ("displacement", "force")
)
LEVER_FORCES = tuple(path for path in CATALOGUE if path.startswith(f"{LEVER}/"))


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
    scene.cite(
        "pitch model with complex amplitudes",
        "response on the mounts",
        "Gibson (2008), equations 13 to 19, with the phase kept",
    )
    _emit_model(scene, pitch)

    shaking = about_point(forcing.per_speed_squared, parts.centre[..., None, :])
    about = couples_of(shaking)
    couple = Bounded(about.value @ parts.across, about.error @ np.abs(parts.across))
    resonances = pitch_resonances(pitch, couple)
    undriven = left_out(resonances)[..., 0]
    couple = Bounded(np.where(undriven, 0.0, couple.value), couple.error)
    used, speed = forcing.retained, scene.case.machine.speed
    for warning in check_operating_point(resonances, forcing.order, speed):
        scene.warn(warning)
    _emit_left_out(scene, forcing, forces_of(shaking), about, parts.across)
    frequency = forcing.order * np.asarray(speed)[..., None]
    torque = couple * np.square(speed)[..., None]
    angle = model.angle_harmonics(pitch, torque, frequency, undriven)
    if scene.case.point:
        turned = reshaped(angle, lambda one: one[..., None]) * of_pitch(parts)[..., None, :]
        scene.handed_on["motion_by_order"] = MotionByOrder(
            forcing.order, used, forcing.tail, turned
        )
    axes = {"order": forcing.order[:used]}
    if scene.wants("isolation/pitch/transmissibility"):
        passing = model.transmissibility(pitch, frequency[..., :used])
        scene.emit("isolation/pitch/transmissibility", passing, axes=axes)
    if scene.wants("isolation/pitch/transmissibility_curve"):
        _emit_curve(scene, pitch, float(frequency[used - 1]))
    kept = angle[..., :used]
    terms = size_of_terms(kept.error)
    scene.emit("isolation/pitch/angle_harmonics", kept, axes=axes, terms=terms)
    lever = options.lever if options.lever is not None else parts.lever
    if lever is None:
        lever = np.abs(parts.position).max(axis=-1)
    still = None
    if scene.wants(RIGID, f"{LEVER}/rigid_peak"):
        still = _at_speed(peak_with_tail(couple, forcing), speed)
    if scene.wants(*LEVER_FORCES):
        through = model.transmitted_couple(pitch, angle, frequency)
        _emit_lever_force(scene, forcing, torque, still, through, np.asarray(lever))
    _emit_supports(scene, forcing, parts, still, angle, frequency)
    if scene.wants(*OF_RUN_UP) and isinstance(scene, PointsScene):
        from vibecalc.isolation.arrays import hand_on_pitch

        hand_on_pitch(scene, forcing, parts, pitch, couple, lever)
    elif scene.wants(*OF_RUN_UP):
        _hand_on_run_up(scene, forcing, parts, pitch, couple, undriven, float(lever))


def _at_speed(peak: CyclePeak, speed: float) -> CyclePeak:
    """Of couples per speed squared, for all speeds at once."""
    square = np.square(speed)
    value, error = Bounded(peak.value, peak.error) * square
    return CyclePeak(value, error, peak.terms * float(np.max(square)))


def _hand_on_run_up(
    scene: Scene,
    forcing: Forcing,
    parts: PitchParts,
    pitch: model.Pitch,
    couple: Bounded,
    undriven: np.ndarray,
    lever: float,
) -> None:
    used = forcing.retained
    readout, row_of = distinct(
        pitch_readout(
            pitch, lever, parts.position, parts.stiffness, parts.damping, parts.structural
        )
    )
    few, few_tail = few_orders(forcing)
    in_run_up = pitch_resonances(pitch, couple[:used])

    def rows(readout: Readout) -> KeptRows:
        return KeptRows(
            pitch_rows(pitch, readout, forcing.order[:used], couple[:used], undriven[:used]),
            pitch_rows(pitch, readout, forcing.order[few], couple[few], undriven[few]),
            few_tail,
            forcing.order[few],
        )

    of_angle = of_pitch(parts)[:, None]
    scene.handed_on["run_up"] = RunUpSetup(
        rows=with_left_out(*rows(readout)[:3]),
        harmonics=forcing.order[:used],
        step=1,
        resonances=in_run_up,
        shows=(readout.spring[:, 0, 0].real != 0.0)[None, :],
        row_of=row_of,
        lever_rows=1,
        idle=lambda low, high: idle_warnings(in_run_up, forcing.order[:used], low, high),
        of_body=OfBody(rows, of_angle, of_angle),
    )


def of_pitch(parts: PitchParts) -> np.ndarray:
    """Motion (..., 6) of the reference point for a unit angle about the mass centre."""
    across = np.broadcast_to(parts.across, parts.centre.shape)
    return np.concatenate([-np.cross(across, parts.centre), across], axis=-1)


def _emit_left_out(
    scene: Scene, forcing: Forcing, force: Bounded, couple: Bounded, across: np.ndarray
) -> None:
    """Peaks of the shaking that turns no body which can only pitch.

    `force` and `couple` (..., orders, 3) are per crank speed squared.
    """
    aside = np.eye(3) - np.outer(across, across)
    for name, part in (("force", force), ("couple", Bounded(couple.value @ aside, couple.error))):
        path = f"isolation/pitch/{name}_left_out"
        if scene.wants(path):
            vector = reshaped(part, lambda one: np.swapaxes(one, -1, -2))
            peak = _at_speed(length_over_cycle(vector, forcing), scene.case.machine.speed)
            scene.emit(path, peak.value, peak.error, terms=peak.terms)


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
    scene: Scene,
    forcing: Forcing,
    torque: Bounded,
    still: CyclePeak | None,
    through: Bounded,
    lever: np.ndarray,
) -> None:
    """The source's reading: couple over lever, with the body held still and on its mounts."""
    used = forcing.retained
    axes = {"order": forcing.order[:used]}
    for name, couple in (("rigid", torque), ("steady", through)):
        force = model.lever_force(couple[..., :used], lever[..., None])
        terms = size_of_terms(force.error)
        scene.emit(f"{LEVER}/{name}_harmonics", force, axes=axes, terms=terms)
        if scene.wants(f"{LEVER}/{name}_peak"):
            known = still if name == "rigid" and still else peak_with_tail(couple, forcing)
            peak = model.lever_force(Bounded(known.value, known.error), lever)
            terms = known.terms / float(np.min(lever))
            scene.emit(f"{LEVER}/{name}_peak", peak, terms=terms)


def _emit_supports(
    scene: Scene,
    forcing: Forcing,
    parts: PitchParts,
    still: CyclePeak | None,
    angle: Bounded,
    frequency: np.ndarray,
) -> None:
    """One support of all: static share and sag, force with the body still and on its mounts."""
    options, body = isolation_of(scene), scene.parts.body
    if body is None:
        raise ValueError("isolation needs a body")
    static = pitch_static(body.mass * options.gravity, 0.0, parts.position, parts.stiffness)
    sag, weight = emit_static(scene, parts.names, static)
    if still is not None and scene.wants(RIGID):
        share = np.abs(model.support_share(parts.position, parts.stiffness))
        top = still.value[..., None]
        force = Bounded(share * top, share * (still.error[..., None] + 8.0 * EPSILON * top))
        terms = np.max(share) * still.terms
        scene.emit(RIGID, force, axes={"mount": parts.names}, terms=terms)
    if scene.wants(*HARMONICS):
        # the one component of a pitching body at a support: along the stroke
        direction = (scene.case.machine.crank_train.stroke,)
        motion = (one[..., None, :] for one in _support_motion(parts, angle, frequency))
        emit_support_motion(scene, forcing, parts.names, direction, *motion)
    if scene.wants(LARGEST):
        few, which = _alike(parts)
        peak = peak_with_tail(_support_motion(few, angle, frequency)[1], forcing)
        largest = Bounded(peak.value, peak.error)[..., which]
        scene.emit(LARGEST, largest, axes={"mount": parts.names}, terms=peak.terms)
    if scene.wants(VERTICAL, "isolation/pitch/angle_peak"):
        value, error, terms = peak_with_tail(angle, forcing)
        scene.emit("isolation/pitch/angle_peak", value, error, terms=terms)
        arm = np.abs(parts.position)
        height = arm * Bounded(value[..., None], error[..., None])
        terms = float(np.max(arm)) * terms
        scene.emit(VERTICAL, height, axes={"mount": parts.names}, terms=terms)
    if scene.wants(EXCURSION, *LOADS):
        down, load = (-one for one in _support_motion(parts, angle, frequency))
        emit_with_constant(scene, parts.names, down, load, sag, weight, forcing)


def _support_motion(
    parts: PitchParts, angle: Bounded, frequency: np.ndarray
) -> tuple[Bounded, Bounded]:
    """Vertical displacement and force (..., mounts, orders)."""
    displacement = model.support_displacement(angle, parts.position)
    return displacement, model.support_force(
        displacement, frequency, parts.stiffness, parts.damping, parts.structural
    )


def _alike(parts: PitchParts) -> tuple[PitchParts, list[int]]:
    """Mounts that stand for all, and which of them has the force of each, up to its sign.

    Equal mounts at the same distance on either side feel the same at opposite times.
    """
    names = ("position", "stiffness", "damping", "structural")
    columns = {name: getattr(parts, name) for name in names}
    count = parts.position.shape[-1]
    rows = [np.broadcast_to(np.abs(one), (*one.shape[:-1], count)) for one in columns.values()]
    first: list[int] = []
    which: list[int] = []
    for place in range(count):
        same = [k for k in first if all(np.array_equal(r[..., k], r[..., place]) for r in rows)]
        first += [] if same else [place]
        which.append(first.index(same[0] if same else place))
    return replace(parts, **{name: one[..., first] for name, one in columns.items()}), which

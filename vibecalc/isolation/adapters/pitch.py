"""What is of a body that only pitches: its model, couples over a lever, what it does not follow."""

import numpy as np

from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import (
    CyclePeak,
    Forcing,
    couples_of,
    forces_of,
    length_over_cycle,
    peak_with_tail,
)
from vibecalc.excitation.inertia_forces import about_point, as_loads, size_of_terms
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.adapters.loads import BodyLoads
from vibecalc.isolation.adapters.steady import Moved
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.numerics.bounded import Bounded, reshaped, where
from vibecalc.numerics.linear import Linear, each_order
from vibecalc.numerics.rounding import EPSILON, SINGULAR
from vibecalc.parts.body import build_frame

LEVER, RIGID = "isolation/lever_force", "isolation/support_force/rigid_peak"
LEVER_FORCES = tuple(path for path in CATALOGUE if path.startswith(f"{LEVER}/"))


def emit_pitch_model(scene: Scene, system: OnMounts) -> None:
    """Emit inertia, stiffness, damping, natural frequency and damping ratio."""
    scene.cite(
        "pitch model with complex amplitudes",
        "response on the mounts",
        "Gibson (2008), equations 13 to 19, with the phase kept",
    )
    matrices, shapes = system.matrices, system.shapes
    for name, value, error in (
        ("inertia", matrices.mass, matrices.mass_error),
        ("stiffness", matrices.stiffness, matrices.stiffness_error),
        ("damping", matrices.damping, matrices.damping_error),
    ):
        scene.emit(f"isolation/pitch/{name}", value[..., 0, 0], error[..., 0, 0])
    frequency = Bounded(shapes.natural_frequency, shapes.natural_frequency_error)
    scene.emit("isolation/pitch/natural_frequency", frequency[..., 0])
    scene.emit("isolation/pitch/damping_ratio", system.damping_ratio()[..., 0])


def lever_of(scene: Scene, system: OnMounts) -> np.ndarray:
    """The lever (...) of couples in m: that of the case, or the distance of the mounts."""
    given = isolation_of(scene).lever
    if given is not None:
        return np.asarray(given)
    return np.asarray(np.abs(system.stretch[..., 0, 0]).max(axis=-1))


def emit_pitch(scene: Scene, system: OnMounts, loads: BodyLoads, moved: Moved) -> None:
    """Emit the pitch angle, transmissibility, couples over the lever, and what pitch leaves out."""
    forcing: Forcing = scene.handed_on["forcing"]
    used, speed = loads.retained, scene.case.machine.speed
    frequency = loads.order * np.asarray(speed)[..., None]
    axes = {"order": loads.order[:used]}
    if scene.wants("isolation/pitch/transmissibility"):
        found = transmissibility(system.matrices, frequency[..., :used])
        scene.emit("isolation/pitch/transmissibility", found, axes=axes)
    if scene.wants("isolation/pitch/transmissibility_curve"):
        _emit_curve(scene, system, float(frequency[used - 1]))
    angle = moved.motion[..., system.freedoms[0]]
    terms = size_of_terms(angle.error[..., :used])
    scene.emit("isolation/pitch/angle_harmonics", angle[..., :used], axes=axes, terms=terms)
    if scene.wants("isolation/pitch/angle_peak"):
        value, error, terms = peak_with_tail(angle, loads)
        scene.emit("isolation/pitch/angle_peak", value, error, terms=terms)
    _emit_left_out(scene, forcing, system)
    still = None
    if scene.wants(RIGID, f"{LEVER}/rigid_peak"):
        # of all speeds at once
        couple = system.felt(as_loads(forcing.per_speed_squared))[..., 0]
        still = _at_speed(peak_with_tail(couple, forcing), speed)
    if still is not None and scene.wants(RIGID):
        _emit_rigid(scene, system, still)
    if scene.wants(*LEVER_FORCES):
        passing = each_order(system.matrices).passing(frequency)[..., 0, 0]
        both = {"rigid": system.felt(loads.load)[..., 0], "steady": passing * angle}
        _emit_lever_force(scene, loads, both, still, lever_of(scene, system))


def transmissibility(matrices: Linear, frequency: np.ndarray) -> Bounded:
    """Complex couple on the ground over couple on the body, at frequencies (..., orders).

    Infinite on an undamped natural frequency, where the order must not be driven. Source: Gibson
    (2008), equation 18, with the phase kept.
    """
    each = each_order(matrices)
    passing = each.passing(frequency)[..., 0, 0]
    inertia = Bounded(each.mass, each.mass_error)[..., 0, 0]
    resisting = passing - np.square(frequency) * inertia
    lost = resisting.error >= SINGULAR * np.abs(resisting.value)
    ratio = passing / where(lost, 1.0, resisting)
    return where(lost, Bounded(np.asarray(np.inf), np.zeros(())), ratio)


def _at_speed(peak: CyclePeak, speed: float) -> CyclePeak:
    """Of couples per speed squared, for all speeds at once."""
    square = np.square(speed)
    value, error = Bounded(peak.value, peak.error) * square
    return CyclePeak(value, error, peak.terms * float(np.max(square)))


def _emit_left_out(scene: Scene, forcing: Forcing, system: OnMounts) -> None:
    """Peaks of the shaking about the mass centre that turns no body which can only pitch."""
    body, train = scene.parts.body, scene.case.machine.crank_train
    assert body is not None
    shaking = about_point(forcing.per_speed_squared, body.centre[..., None, :])
    across = build_frame(train.axis, train.stroke).across
    aside = np.eye(3) - np.outer(across, across)
    couple = couples_of(shaking)
    couple = Bounded(couple.value @ aside, couple.error)
    for name, part in (("force", forces_of(shaking)), ("couple", couple)):
        path = f"isolation/pitch/{name}_left_out"
        if scene.wants(path):
            vector = reshaped(part, lambda one: np.swapaxes(one, -1, -2))
            peak = _at_speed(length_over_cycle(vector, forcing), scene.case.machine.speed)
            scene.emit(path, peak.value, peak.error, terms=peak.terms)


def _emit_curve(scene: Scene, system: OnMounts, highest: float) -> None:
    """Transmissibility from .05 to 50 times the natural frequency, for the picture.

    Whole decades more where the `highest` order lies beyond: the samples must not follow its bits.
    """
    natural = float(system.shapes.natural_frequency[0])
    beyond = highest / (50.0 * natural)
    decades = np.ceil(np.log10(min(max(beyond, 1.0), 1e6)))
    end = 6.0 if decades == 0.0 else np.arcsinh((np.log(50.0) + decades * np.log(10.0)) / 0.02)
    # Dense around 1 and never on it, where an undamped body has no value.
    ratio = np.exp(0.02 * np.sinh(np.linspace(-5.7, end, 300)))
    curve = transmissibility(system.matrices, ratio * natural)
    axes = {"frequency_ratio": ratio}
    scene.emit("isolation/pitch/transmissibility_curve", curve.value, curve.error, axes)


def _emit_rigid(scene: Scene, system: OnMounts, still: CyclePeak) -> None:
    """Largest force of each mount with the body held still: its share of the couple.

    What the mounts pass on at low frequency, and at any frequency where they are stiff.
    """
    pressed = np.abs(system.mounts.stiffness * system.stretch)[..., 0, 0]
    share = pressed / system.matrices.stiffness[..., 0]
    top = still.value[..., None]
    force = Bounded(share * top, share * (still.error[..., None] + 8.0 * EPSILON * top))
    axes = {"mount": system.mounts.names}
    scene.emit(RIGID, force, axes=axes, terms=np.max(share) * still.terms)


def _emit_lever_force(
    scene: Scene,
    loads: BodyLoads,
    couples: dict[str, Bounded],
    still: CyclePeak | None,
    lever: np.ndarray,
) -> None:
    """Couple over lever, the source's reading of "the force on a support".

    With the body held still, and through its mounts. It is the force of one pair of supports that
    far from the pitch axis if that pair alone resisted. Source: Gibson, equations 11, 12.
    """
    axes = {"order": loads.order[: loads.retained]}
    for name, couple in couples.items():
        force = couple[..., : loads.retained] / lever[..., None]
        terms = size_of_terms(force.error)
        scene.emit(f"{LEVER}/{name}_harmonics", force, axes=axes, terms=terms)
        if scene.wants(f"{LEVER}/{name}_peak"):
            known = still if name == "rigid" and still else peak_with_tail(couple, loads)
            peak = Bounded(known.value, known.error) / lever
            terms = known.terms / float(np.min(lever))
            scene.emit(f"{LEVER}/{name}_peak", peak, terms=terms)

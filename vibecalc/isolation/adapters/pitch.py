"""What is of a body that only pitches: its model, couples over a lever, what it does not follow."""

import numpy as np

from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import Forcing, kept, length_over_cycle, peak_with_tail
from vibecalc.excitation.inertia_forces import about_point, couples_of, forces_of
from vibecalc.isolation.adapters.common import isolation_of
from vibecalc.isolation.adapters.steady import Moved
from vibecalc.isolation.on_mounts import OnMounts
from vibecalc.isolation.results import LeverForce, Pitch, SupportForce
from vibecalc.numerics.bounded import Bounded, Summed, reshaped, rounded, where
from vibecalc.numerics.linear import Linear, bounded_parts, each_order
from vibecalc.numerics.rounding import SINGULAR
from vibecalc.parts.body import build_frame
from vibecalc.response.adapters.loads import BodyLoads


def lever_of(scene: Scene, system: OnMounts) -> np.ndarray:
    """The lever (...) of couples in m: that of the case, or the distance of the mounts."""
    given = isolation_of(scene).lever
    if given is not None:
        return np.asarray(given)
    return np.asarray(np.abs(system.stretch[..., 0, 0]).max(axis=-1))


def emit_pitch(scene: Scene, system: OnMounts, loads: BodyLoads, moved: Moved) -> None:
    """Emit the model, the pitch angle, transmissibility, pitch couples / lever, and what pitch
    leaves out.

    Couples over a lever are the source's reading of "the force on a support", with the body held
    still and through its mounts: the force of one pair of supports that far from the pitch axis if
    that pair alone resisted. Source: Gibson, equations 11, 12.
    """
    scene.cite(
        "pitch model with complex amplitudes",
        "response on the mounts",
        "Gibson (2008), equations 13 to 19, with the phase kept",
    )
    mass, stiffness, damping, _ = (one[..., 0, 0] for one in bounded_parts(system.matrices))
    forcing: Forcing = scene.handed_on["forcing"]
    used, speed = loads.retained, scene.case.machine.speed
    frequency, square = loads.order * np.asarray(speed)[..., None], np.square(speed)
    turned = system.freedoms[0]
    # about the axis across the crankshaft, which may point against the coordinate
    angle = moved.motion[..., turned] * system.reach[..., turned, :]
    force, couple = _left_out(scene, forcing)
    passed = each_order(system.matrices).passing(frequency)[..., 0, 0] * angle
    held, over = system.felt(loads.load)[..., 0], 1.0 / lever_of(scene, system)

    def still() -> Summed:
        """Largest couple on a body that is held still, of all speeds at once."""
        couple = system.felt(forcing.per_speed_squared)[..., 0]
        return _times(peak_with_tail(couple, forcing), square)

    found = Pitch(
        inertia=mass,
        stiffness=stiffness,
        damping=damping,
        natural_frequency=system.shapes.bounded_frequency[..., 0],
        damping_ratio=system.damping_ratio()[..., 0],
        transmissibility=lambda: transmissibility(system.matrices, frequency[..., :used]),
        angle_harmonics=kept(angle, loads),
        angle_peak=lambda: peak_with_tail(angle, loads),
        force_left_out=lambda: _times(length_over_cycle(force, forcing), square),
        couple_left_out=lambda: _times(length_over_cycle(couple, forcing), square),
    )
    over_lever = LeverForce(
        blocked_harmonics=lambda: kept(held * over[..., None], loads),
        blocked_peak=lambda: _times(still(), over),
        steady_harmonics=lambda: kept(passed * over[..., None], loads),
        steady_peak=lambda: _times(peak_with_tail(passed, loads), over),
    )
    for group in (found, over_lever):
        scene.emit_all(group, {"order": loads.order[:used]})
    if scene.wants(*paths_of(Pitch, "transmissibility_curve")):
        _emit_curve(scene, system, float(frequency[used - 1]))
    # what mounts pass on at low frequency, and at any where they are stiff: shares of the couple
    share = np.abs(system.mounts.stiffness * system.stretch)[..., 0, 0]
    share = share / system.matrices.stiffness[..., 0]
    rigid = SupportForce(blocked_peak=lambda: _times(still(), share, shared=True))
    scene.emit_all(rigid, {"mount": system.mounts.names})


def _times(peak: Summed, factor: np.ndarray, shared: bool = False) -> Summed:
    """A peak (...) times a factor (...), or `shared` among several as factors (..., n)."""
    known = Bounded(peak.value, peak.error)
    value, error = (known[..., None] if shared else known) * rounded(factor, 8)
    return Summed(value, error, peak.terms * float(np.max(factor)))


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


def _left_out(scene: Scene, forcing: Forcing) -> tuple[Bounded, ...]:
    """Shaking about the mass centre that turns no body which can only pitch.

    Force and couple (..., 3, orders) per crank speed squared.
    """
    body, train = scene.parts.body, scene.case.machine.crank_train
    assert body is not None
    shaking = about_point(forcing.per_speed_squared, body.centre[..., None, :])
    across = build_frame(train.axis, train.stroke_axis).across
    aside = couples_of(shaking) @ (np.eye(3) - np.outer(across, across))
    return tuple(reshaped(one, np.matrix_transpose) for one in (forces_of(shaking), aside))


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
    scene.emit_all(Pitch(transmissibility_curve=curve), {"frequency_ratio": ratio})

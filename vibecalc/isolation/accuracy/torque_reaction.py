"""Accuracy of an engine on its mounts: peak of a support force, orders left out."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import Signal, peak_topic, samples_of_harmonics
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.cylinder_torque import gas_torque_at
from vibecalc.excitation.gas_tables import card_weights
from vibecalc.excitation.inertia_forces import at_speed
from vibecalc.excitation.model import build_firing, crank_geometry, firing_angle, gas_cards
from vibecalc.isolation.adapters.torque_couple import couples_of
from vibecalc.isolation.results import TORQUE_REACTION_ROOT
from vibecalc.isolation.rigid_body import displacement, mount_force
from vibecalc.isolation.torque_reaction import with_shaking
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.matrices import Matrices
from vibecalc.numerics.rounding import ComplexArray, FloatArray, WithError
from vibecalc.parts.firing import is_separate
from vibecalc.parts.matrices import assemble
from vibecalc.response.forced import dynamics, response
from vibecalc.torsion.accuracy.by_other_means import through_three
from vibecalc.torsion.accuracy.steady import apart

# ----------------------------------------------------------------------------
# An engine on its mounts: peak of a support force over the cycle, and orders left out.
# ----------------------------------------------------------------------------

#: orders of the trusted answer over those kept, and samples of its second way
MORE, FINEST = 12, 1 << 15
SAMPLES = (32.0, 64.0, 128.0, 256.0, 512.0, 1024.0)
_QUANTITY = f"{TORQUE_REACTION_ROOT}/support_force_peak"


class _Body(NamedTuple):
    """The body on its mounts at the operating speed, with what shakes it next to gas torques."""

    scene: Scene
    matrices: Matrices
    shaking: WithError
    axis: FloatArray
    speed: float


def torque_reaction_topics(scene: Scene) -> list[Topic]:
    """The peak at the most loaded support; orders left out where the driven machine is apart."""
    body, mounts = scene.parts.body, scene.parts.mounts
    if body is None or mounts is None or "forcing" not in scene.handed_on:
        return []
    forcing, speed = scene.handed_on["forcing"], scene.case.machine.speed
    matrices = assemble(
        body.mass_matrix, mounts.position, mounts.stiffness, mounts.damping, mounts.structural
    )
    driven = at_speed(forcing.per_speed_squared, speed)
    shaking = WithError(
        np.concatenate([driven.force, driven.couple], axis=-1),
        np.concatenate([driven.force_error, driven.couple_error], axis=-1),
    )
    seen = _Body(scene, matrices, shaking, scene.parts.crank_train.axis, speed)
    couples = couples_of(scene, forcing.retained)
    order, kept = couples.order, couples.retained
    force = _forces(seen, order[:kept], couples.added.value[:kept])
    doubled = np.rint(2.0 * order[:kept]).astype(np.int64)
    worst = int(np.argmax(vector_cycle_peak(force, doubled).value))
    peak = peak_topic(
        "torque reaction", "peak of a support force",
        f"largest length over the cycle of the force of mount {mounts.names[worst]!r}, "
        f"{kept} orders",
        _QUANTITY, "N", Signal(force[worst], doubled),
    )  # fmt: skip
    if peak.position:
        peak = peak._replace(position="half the crank angle [rad]")
    found = [peak]
    if is_separate(scene.case) and np.all(build_firing(scene.case).fires):
        found.append(_left_out(seen, kept, float(order[0])))
    return found


def _forces(seen: _Body, order: FloatArray, couple: ComplexArray) -> ComplexArray:
    """Dynamic forces (mounts, 3, m) under couples (m,) about the crankshaft and the shaking."""
    mounts = seen.scene.parts.mounts
    assert mounts is not None
    given = WithError(couple, np.zeros(len(order)))
    loads = with_shaking(given, order, seen.axis, seen.shaking)
    system = dynamics(seen.matrices, order * seen.speed)
    motion = response(system, loads.value, loads.error)
    return mount_force(
        displacement(motion, mounts.position), order * seen.speed, mounts.stiffness,
        mounts.damping, mounts.structural,
    ).value  # fmt: skip


def _left_out(seen: _Body, kept: int, step: float) -> Topic:
    known: list[tuple[FloatArray, ComplexArray]] = []

    def couples(count: int) -> tuple[FloatArray, ComplexArray]:
        if not known:
            found = couples_of(seen.scene, round(0.5 * MORE * kept * step))
            known.append((found.order, found.added.value))
        order, couple = known[0]
        return order[:count], couple[:count]

    def peaks(order: FloatArray, couple: ComplexArray) -> FloatArray:
        force = _forces(seen, order, couple)
        return vector_cycle_peak(force, np.rint(2.0 * order).astype(np.int64)).value

    def orders(count: float) -> Answer:
        # as many orders again are solved: they say what the orders left out may add
        return Answer(peaks(*couples(int(count))), 2.0 * count)

    def sampled(number: float) -> Answer:
        order, couple = _of_samples(seen, int(number), step)
        return Answer(peaks(order, couple), float(len(order)))

    def magnitudes(_: float) -> Answer:
        force = _forces(seen, *couples(kept))
        return Answer(np.sqrt(np.square(np.abs(force).sum(axis=-1)).sum(axis=-1)), float(kept))

    def reference() -> Reference:
        many = peaks(*couples(MORE * kept))
        order, couple = _of_samples(seen, FINEST, step)
        order, couple = order[: 2 * MORE * kept], couple[: 2 * MORE * kept]
        place = np.arange(1, len(order) + 1)
        courses = samples_of_harmonics(_forces(seen, order, couple), place, FINEST)
        other = through_three(np.sqrt(np.square(courses).sum(axis=1)))[0]
        return Reference(
            many, apart(many, other),
            f"{MORE * kept} orders by quadrature, held against {2 * MORE * kept} orders of "
            f"{FINEST} samples and the best of as many angles with a parabola",
        )  # fmt: skip

    settings = sorted({*(float(kept >> k) for k in (3, 2, 1) if kept >> k), float(kept)})
    settings += [2.0 * kept, 4.0 * kept]
    solvers = (
        Solver(
            "orders kept", "of exact harmonics, as many again for the error", "orders",
            tuple(settings), orders, default=float(kept),
        ),
        Solver(
            "samples", "Fourier transform of the gas torque at even angles, all its orders",
            "angles", SAMPLES, sampled,
        ),
        Solver(
            "sum of magnitudes", "all orders at their highest together", "", NOTHING_TO_SET,
            magnitudes,
        ),
    )  # fmt: skip
    return Topic(
        "torque reaction", "orders left out",
        "peaks of the forces of all supports from all orders of the gas torque",
        _QUANTITY, "N", "orders solved (6 x 6)", reference, solvers,
        default_extra=2.5,
        default_why="as many orders again tell what those left out may add",
    )  # fmt: skip


def _of_samples(seen: _Body, count: int, step: float) -> tuple[FloatArray, ComplexArray]:
    """Orders (m,) and couples (m,) of the gas torque from `count` crank angles."""
    case = seen.scene.case
    firing, geometry = build_firing(case), crank_geometry(case.machine)
    speeds, cards = gas_cards(case.machine)
    share = card_weights(speeds if len(speeds) else [0.0], seen.speed)
    angle = firing.cycle * np.arange(count) / count
    total = np.zeros(count)
    for late, scale in zip(firing_angle(case.machine), firing.pressure_scale, strict=True):
        for part, card in zip(share, cards, strict=True):
            total += scale * part * gas_torque_at(card, geometry, angle - late)
    couple = -np.fft.rfft(total)[1 : count // 2] * (2.0 / count)
    return np.asarray(step * np.arange(1, count // 2)), couple

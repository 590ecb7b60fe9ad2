"""The run-up of a machine whose cylinders turn its body, too: all orders of shaking and torque.

Between two gas cards the torque is linear in the speed, so each such part of the range is a run-up
of its own.
"""

from itertools import pairwise

import numpy as np

from vibecalc.case.engine_firing import TURN, cycle_angle
from vibecalc.case.engine_mounted import shakes_with_torque
from vibecalc.excitation.sums import as_loads
from vibecalc.isolation.body_rows import CoupleAt, body_rows
from vibecalc.isolation.left_out import with_left_out
from vibecalc.isolation.rows import HarmonicsAt
from vibecalc.isolation.torque_reaction import (
    TAIL,
    couple_by_differences,
    couple_on_body,
    linear_couple,
    with_shaking,
)
from vibecalc.numerics.rounding import WithError
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.excitation import Forcing
from vibecalc.pipeline.stages.isolation_common import RunUpSetup, Section
from vibecalc.pipeline.stages.isolation_rigid_body import MountedBody
from vibecalc.pipeline.stages.torque_reaction_couple import (
    Passing,
    TorqueLaw,
    line_passing,
    torque_law,
    total_torque,
)
from vibecalc.response.damped_poles import with_damped_poles
from vibecalc.response.direct import Undriven
from vibecalc.response.modal_resonance import body_resonances
from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import idle_warnings, left_out

#: damping ratio from which a resonance of a shaft line is looked for
_NARROW = 1e-3


def torque_sections(scene: Scene, start: float, stop: float) -> tuple[Section, ...]:
    """The range from `start` to `stop`, cut at the speeds of the gas cards within it."""
    forcing: Forcing = scene.handed_on["forcing"]
    law = torque_law(scene, forcing.kept)
    within = law.speeds[(law.speeds > start) & (law.speeds < stop)]
    passing = None if shakes_with_torque(scene.case) else line_passing(scene)
    return tuple(
        Section(_setup(scene, law, passing, low, high), low, high)
        for low, high in pairwise([start, *within.tolist(), stop])
    )


def _setup(
    scene: Scene, law: TorqueLaw, passing: Passing | None, low: float, high: float
) -> RunUpSetup:
    """Rows and resonances between two speeds."""
    mounted: MountedBody = scene.handed_on["mounted"]
    forcing: Forcing = scene.handed_on["forcing"]
    own = np.zeros(0) if passing is None else _line_frequencies(scene, high)
    axis, ends = scene.parts.crank_train.axis, np.array([low, high])
    none = WithError(np.zeros(len(law.order)), np.zeros(len(law.order)))
    whole = WithError(*as_loads(forcing.per_speed_squared))
    shaking = with_shaking(none, law.order, axis, whole)
    about = np.concatenate([np.zeros(3), axis])[mounted.freedoms]

    def of_orders(part: slice) -> tuple[HarmonicsAt, Resonances]:
        force = WithError(*(each[part][:, mounted.freedoms] for each in shaking))
        couple = _couple(law, passing, ends, part)
        at_ends = couple(ends, errors=True)
        forces = [force, *_about(WithError(at_ends.value, at_ends.error), about)]
        resonances = _met(mounted, forces)
        undriven = Undriven(left_out(resonances), mounted.shapes.shape, mounted.shapes.eigenvalue)
        given = (mounted.matrices, mounted.readout, law.order[part], force, undriven)
        return body_rows(*given, couple, about), _with_poles(mounted, resonances, forces)

    rows, resonances = of_orders(slice(law.kept))
    beyond, _ = of_orders(slice(law.kept, None))
    step, order = TURN / cycle_angle(scene.case.machine), law.order[: law.kept]
    return RunUpSetup(
        rows=with_left_out(rows, beyond, TAIL),
        harmonics=np.arange(1, law.kept + 1),
        step=step,
        resonances=resonances._replace(
            frequency=resonances.frequency / step,
            moved_frequency=np.concatenate([resonances.moved_frequency, own]) / step,
            moved_ratio=np.concatenate([resonances.moved_ratio, np.full(len(own), _NARROW)]),
        ),
        shows=mounted.shows,
        row_of=np.arange(mounted.shows.shape[1]),
        lever_rows=0,
        idle=lambda first, last: idle_warnings(resonances, order, first, last),
    )


def _line_frequencies(scene: Scene, speed: float) -> np.ndarray:
    """Natural frequencies of the shaft line above zero, rad/s, where its torque has resonances."""
    from vibecalc.torsion.model import build_shaft_line
    from vibecalc.torsion.modes import natural_modes

    frequency = natural_modes(build_shaft_line(scene.case).at(speed)).frequency
    return frequency[frequency > 0.0]


def _couple(law: TorqueLaw, passing: Passing | None, ends: np.ndarray, part: slice) -> CoupleAt:
    """Couple of the orders `part` that the shaking lacks, as a function of the speed."""
    if passing is None:
        low, high = (couple_on_body(law.gas_at(end), share=law.share) for end in ends)
        return linear_couple(ends, *(WithError(c.value[part], c.error[part]) for c in (low, high)))
    order = law.order[part]

    def by_the_line(speed: np.ndarray) -> WithError:
        torque = total_torque(law, speed)
        torque = WithError(torque.value[..., part], torque.error[..., part])
        return couple_on_body(torque, passing(order, speed))

    return couple_by_differences(by_the_line)


def _about(couple: WithError, axis: np.ndarray) -> list[WithError]:
    """Loads (orders, f) of the couples (speeds, orders) about an axis (f,), speed by speed."""
    return [
        WithError(value[:, None] * axis, error[:, None] * np.abs(axis))
        for value, error in zip(couple.value, couple.error, strict=True)
    ]


def _met(mounted: MountedBody, forces: list[WithError]) -> Resonances:
    """Resonances of which an order is idle that none of the forces (orders, f) gives a force."""
    found = [body_resonances(mounted.matrices, mounted.shapes, force) for force in forces]
    return found[0]._replace(idle=np.all([one.idle for one in found], axis=0))


def _with_poles(
    mounted: MountedBody, resonances: Resonances, forces: list[WithError]
) -> Resonances:
    found = [
        with_damped_poles(resonances, mounted.matrices, mounted.shapes, force) for force in forces
    ]
    return found[0]._replace(idle=np.all([one.idle for one in found], axis=0))

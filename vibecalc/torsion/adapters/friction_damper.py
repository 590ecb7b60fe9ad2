"""Adapter: one order of a shaft line whose ring dry friction drags along, by its first harmonic."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, square, where
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.parts.dry_friction import MOST_WORK, settled, shares
from vibecalc.torsion.adapters.largest_alone import BareLine, bare_line, hung, torque_under
from vibecalc.torsion.adapters.setup import Setup, line_speeds
from vibecalc.torsion.adapters.steady import setup_of
from vibecalc.torsion.shaft_line_tables import LineDamper, ShaftLine
from vibecalc.torsion.study_results import FRICTION

# ----------------------------------------------------------------------------
# With the share t of friction in the torque that would hold the ring on its plates, of the angle Y,
# the friction pulls with J w^2 s(t) Y (vibecalc.parts.dry_friction). Linings of the stiffness k are
# twisted by it: the station moves by Y (1 - J w^2 s / k), and the line has a ring of the dynamic
# stiffness -J w^2 s / (1 - J w^2 s / k). With the angles a and h of the station without the ring,
# under the torques of the line and under one, Y |1 - J w^2 s (1 / k + h)| = |a|.
# ----------------------------------------------------------------------------

#: relative change that tells how far friction moves t; rounding of t where it is found
_CHANGE, _FOUND = 1e-6, 1e-13
#: roundings of a share of the ring, and of the sum that a is divided by
_ROUNDINGS = 16.0


def friction_damper(line: ShaftLine) -> tuple[int, LineDamper] | None:
    """The damper with dry friction, of which a line has one at most, and its place."""
    return next(((n, one) for n, one in enumerate(line.dampers) if one.kind == "friction"), None)


class _Ring(NamedTuple):
    """Referred inertia, friction torque in N m, place of its element and of its order."""

    inertia: float
    friction: float
    element: int
    order: int


class _Line(NamedTuple):
    """The line without its ring at frequencies (s,) of one order, and what the ring is on it.

    `carried` (s,) is J w^2 and `linings` (s,) their complex stiffness, both in N m/rad.
    """

    bare: BareLine
    carried: FloatArray
    linings: ComplexArray

    def resistance(self, t: FloatArray) -> FloatArray:
        """|a| over the angle of the plates, at t (s,) or (k, 1)."""
        soft = 1.0 / self.linings + self.bare.unit_angle[:, 0]
        return np.asarray(np.abs(1.0 - self._pull(t) * soft))

    def _pull(self, t: FloatArray) -> ComplexArray:
        share = shares(t)
        return np.asarray(self.carried * (share.inertia - 1j * share.damping))

    def uncertainty(self, t: FloatArray) -> FloatArray:
        """Relative (s,), of the angle of the plates at a known t (s,)."""
        bare, pull = self.bare, np.abs(self._pull(t))
        soft = np.abs(1.0 / self.linings) + np.abs(bare.unit_angle[:, 0])
        off = pull * bare.unit_error[:, 0] + _ROUNDINGS * EPSILON * (1.0 + pull * soft)
        size = np.abs(bare.angle[:, 0])
        return np.asarray(off / self.resistance(t) + bare.error[:, 0] / np.maximum(size, 1e-300))

    def dragged(self, t: Bounded) -> "_Dragged":
        """With relative errors of t (s,) as its errors."""
        stiff = [self._stiffness(t.value * (1.0 + sign * t.error)) for sign in (0.0, 1.0)]
        found = hung(self.bare, stiff[0][:, None])
        moved = hung(self.bare, stiff[1][:, None])
        off, pulled = moved.angle - found.angle, moved.pull - found.pull
        wrong = found.error[:, 0] + np.abs(off[:, 0])
        # the pull is as wrong as the angle, and by what t makes of it
        pull_off = np.abs(stiff[0]) * found.error[:, 0] + np.abs(pulled[:, 0])
        plates = Bounded(np.abs(self.bare.angle[:, 0]) / self.resistance(t.value),
                         np.zeros(len(wrong)))  # fmt: skip
        share, other = shares(t.value), shares(t.value * (1.0 + t.error))
        both = [
            Bounded(one, np.abs(one - two) + _ROUNDINGS * EPSILON * np.abs(one))
            for one, two in zip(share, other, strict=True)
        ]
        relative = self.uncertainty(t.value) + t.error
        plates = Bounded(plates.value, plates.value * relative)
        return _Dragged(
            Bounded(np.abs(found.angle[:, 0]), wrong), Bounded(found.pull[:, 0], pull_off), plates,
            both[0], both[1],
        )  # fmt: skip

    def _stiffness(self, t: FloatArray) -> ComplexArray:
        pull = self._pull(t)
        return -pull / (1.0 - pull / self.linings)


class _Dragged(NamedTuple):
    """Referred angles (s,) of station and plates in rad, pull in N m, shares of the ring."""

    angle: Bounded
    pull: Bounded
    plates: Bounded
    inertia: Bounded
    damping: Bounded


def run_torsion_friction_damper(scene: Scene) -> None:
    """Emit one order at the operating speed, and over the speeds of the case."""
    setup, line = setup_of(scene), scene.case.machine.shaft_line
    assert line is not None
    found = friction_damper(line)
    assert found is not None
    place, given = found
    assert given.friction_torque is not None and given.order is not None
    damper, ratio = setup.shaft.dampers[place], abs(setup.shaft.station_ratio)
    own = float(ratio[damper.station])
    order = int(np.argmin(np.abs(setup.drive.order - given.order)))
    inertia = float(setup.model.line.inertia[damper.ring])
    ring = _Ring(inertia, given.friction_torque * own, damper.element, order)
    _emit_here(scene, setup, ring, damper.carrier, own)
    if setup.torsion.speeds is not None:
        speed = line_speeds(setup.torsion.speeds)
        alone = _line(setup, ring, damper.carrier, speed)
        held = alone.dragged(_known(1.0, len(speed))).angle
        dragged = alone.dragged(_settled(alone, ring.friction)).angle
        for name, angle in (("angle", dragged), ("locked_angle", held)):
            scene.emit(f"{FRICTION}speeds/{name}", angle * own, axes={"speed": speed})
    scene.warn(
        f"damper {given.name!r}: results of all orders together take its ring as locked on its "
        f"linings; it slips in those of order {given.order:g}, by the first harmonic of its "
        "friction, and in a transient"
    )
    scene.cite(
        "first harmonic of the friction on a ring that slips, slips and locks, or is locked",
        "friction damper of a shaft line",
        "J. P. Den Hartog, Mechanical Vibrations (1956); docs/theory_torsion.md",
    )


def _emit_here(scene: Scene, setup: Setup, ring: _Ring, carrier: int, own: float) -> None:
    """All at the operating speed, on own shafts."""
    alone = _line(setup, ring, carrier, np.array([setup.speed]))
    held, free = (alone.dragged(_known(t, 1)) for t in (1.0, 0.0))
    one, best = alone.dragged(_settled(alone, ring.friction)), alone.dragged(_known(MOST_WORK, 1))
    w = np.sqrt(alone.carried / ring.inertia)
    bare, ratio = alone.bare, np.abs(setup.shaft.section_ratio)
    torque = np.empty((len(ratio), 1, 1), dtype=complex)
    torque_under(bare, one.pull.value[:, None], torque)
    size = np.abs(bare.torque) + np.abs(bare.unit_torque) * np.abs(one.pull.value)
    stiffness = np.abs(setup.model.at(setup.speed).stiffness)[:, None, None]
    off = np.abs(bare.unit_torque) * one.pull.error + _ROUNDINGS * EPSILON * size
    off += 2.0 * stiffness * (bare.error + np.abs(one.pull.value) * bare.unit_error)
    section = Bounded(np.abs(torque[:, 0, 0]), off[:, 0, 0])
    at_ring = np.arange(len(ratio)) == ring.element
    section = where(at_ring, abs(one.pull), section) / ratio
    work = one.damping * (0.5 * ring.inertia * w**3) * square(one.plates)
    held_by = held.plates * alone.carried / ring.friction
    results = {
        "angle": one.angle * own,
        "locked_angle": held.angle * own,
        "free_angle": free.angle * own,
        "locked_utilisation": held_by,
        "equivalent_inertia": one.inertia * (ring.inertia / own**2),
        "equivalent_damping": one.damping * (ring.inertia * w / own**2),
        "heat": work,
        "best_friction_torque": best.plates * (MOST_WORK * alone.carried / own),
        "best_angle": best.angle * own,
    }
    for name, value in results.items():
        scene.emit(f"{FRICTION}{name}", value[0])
    scene.emit(f"{FRICTION}torque", section, axes={"section": setup.shaft.section_names})


def _known(t: float, count: int) -> Bounded:
    return Bounded(np.full(count, t), np.zeros(count))


def _settled(alone: _Line, friction: ArrayLike) -> Bounded:
    """t (s,) at which the ring is dragged along, with relative errors."""
    size = np.maximum(np.abs(alone.bare.angle[:, 0]), 1e-300)
    f = np.asarray(friction, dtype=float) / size
    t = settled(alone.resistance, f, alone.carried)[1]
    beside = [settled(alone.resistance, f * (1.0 + one), alone.carried)[1]
              for one in (-_CHANGE, _CHANGE)]  # fmt: skip
    grows = np.abs(np.log(beside[1] / beside[0])) / (2.0 * _CHANGE)
    return Bounded(t, np.where(t < 1.0, grows * (alone.uncertainty(t) + _FOUND) + _FOUND, 0.0))


def _line(setup: Setup, ring: _Ring, carrier: int, speed: FloatArray) -> _Line:
    """The line without what holds its ring, under one order at crank speeds (s,) in rad/s.

    Raises NumericalFailure where it has an undamped resonance there, to within rounding.
    """
    model, drive = setup.model, setup.drive
    frequency = drive.frequency(speed)[:, ring.order, None]
    line = model.at(speed[:, None], frequency)
    linings = line.stiffness[..., ring.element] + 1j * frequency * line.damping[..., ring.element]
    loose = [np.array(one, dtype=float) for one in (line.stiffness, line.damping)]
    for one in loose:
        one[..., ring.element] = 0.0
    line = line._replace(stiffness=loose[0], damping=loose[1])
    load = drive.load(speed)[:, ring.order, None]
    bare = bare_line(line, frequency, load, drive.freedom, carrier)
    if np.any(bare.masked):
        at = float(speed[np.argmax(np.any(bare.masked, axis=1))])
        raise NumericalFailure(
            f"friction damper at {at * 30.0 / np.pi:.6g} rpm: the line without its ring has an "
            "undamped resonance there; a slightly different speed"
        )
    carried = ring.inertia * frequency[:, 0] ** 2
    return _Line(bare, carried, np.broadcast_to(linings, frequency.shape)[:, 0])

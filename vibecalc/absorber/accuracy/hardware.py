"""Accuracy of the hardware: lowest bending frequency of the rod, damping of the gap."""

from functools import cache
from typing import Any

import numpy as np

from vibecalc.absorber.hardware.oil_gap import RingGap, gap_shares, published_shares
from vibecalc.absorber.hardware.overhung import (
    bending_frequencies,
    determinant,
    element_frequencies,
    rayleigh_frequency,
    start_elements,
)
from vibecalc.absorber.hardware.rods_and_springs import EndBody, OverhungRod
from vibecalc.absorber.model import build_absorber
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Topics of the stage "hardware": lowest bending frequency of the rod, damping of the gap.
# ----------------------------------------------------------------------------

_STAGE = "hardware"
#: determinants that the root takes as a rule: a bracket that grows twice, steps, and the slope
_DETERMINANTS = 6 + 7 + 2
#: multiplications of one determinant with its bound of rounding
_DETERMINANT = 150.0
_WHY_BENDING = (
    "the bracket grows from both sides of what the elements say until the determinant changes its "
    "sign, and two more determinants tell the error"
)
#: what that takes over the same determinant closed in from a bracket taken on trust
_EXTRA = 2.0


def absorber_parts_topics(scene: Scene) -> list[Topic]:
    """Bending of a rod, where there is one, and the films of a gap."""
    parts = build_absorber(scene.case)
    made = []
    if parts.bending is not None:
        made.append(_bending_topic(parts.bending.rod, parts.bending.body))
    if parts.filling is not None:
        made.append(_gap_topic(parts.filling.gap))
    return made


def _bending_topic(rod: OverhungRod, body: EndBody) -> Topic:
    def own(_: float) -> Answer:
        value = bending_frequencies(rod, body, 1).value
        work = _DETERMINANT * _DETERMINANTS + _elements_work(*start_elements(1))
        return Answer(np.atleast_1d(value)[:1], work)

    def elements(count: float) -> Answer:
        span = int(count)
        end = max(1, round(span / 4))
        value = element_frequencies(rod, body, 0.0, span, end)[0]
        return Answer(np.atleast_1d(value)[:1], _elements_work(span, end))

    def secant(steps: float) -> Answer:
        low, high = _bracket(rod, body)
        return Answer(np.array([_regula(rod, body, low, high, int(steps))]),
                      _DETERMINANT * (steps + 2.0) + _elements_work(2, 1))  # fmt: skip

    def rayleigh(_: float) -> Answer:
        return Answer(np.atleast_1d(rayleigh_frequency(rod, body).value), 30.0)

    return Topic(
        stage=_STAGE,
        name="lowest bending frequency",
        words="of the overhung rod with the flywheel on its end, not spinning",
        quantity="hardware/bending/",
        unit="rad/s",
        work="multiplications",
        reference=lambda: _bending_truth(rod, body),
        solvers=(
            Solver("determinant of the beam", "Chandrupatla's steps next to elements", "",
                   NOTHING_TO_SET, own, 1.0, "", "docs/theory_absorber_parts.md"),
            Solver("beam elements", "cubic shapes, a fourth of them beyond the support",
                       "elements", (2.0, 4.0, 8.0, 16.0, 32.0), elements, None, "order 4"),
            Solver("determinant of the beam, false position",
                       "from two beam elements, Illinois", "steps", (2.0, 4.0, 6.0, 8.0, 12.0),
                       secant),
            Solver("Rayleigh's quotient", "a sine over the span", "", NOTHING_TO_SET, rayleigh,
                   citation="Baca Vasquez (2007), section 3.16"),
        ),
        default_extra=_EXTRA,
        default_why=_WHY_BENDING,
    )  # fmt: skip


def _elements_work(span: int, end: int) -> float:
    """Two factors, two solutions and the eigenvalues of a matrix of twice the size."""
    size = 2 * (span + end + 1) - 2
    return 2.0 * size**3 + 4.0 / 3.0 * (2 * size) ** 3


def _at(rod: OverhungRod, body: EndBody, frequency: float) -> float:
    place = np.array([frequency])
    return float(determinant(rod, body, np.zeros(()), place)[0][0])


def _bracket(rod: OverhungRod, body: EndBody) -> tuple[float, float]:
    """Two beam elements bring the lowest frequency to some per cent, from above."""
    rough = float(element_frequencies(rod, body, 0.0, 2, 1)[0][0])
    low, high = 0.9 * rough, 1.001 * rough
    if _at(rod, body, low) * _at(rod, body, high) > 0.0:
        raise NumericalFailure("two beam elements are too far from the lowest frequency")
    return low, high


def _regula(rod: OverhungRod, body: EndBody, low: float, high: float, steps: int) -> float:
    """False position with the end that stays halved (Illinois)."""
    at_low, at_high = _at(rod, body, low), _at(rod, body, high)
    middle = low
    for _ in range(steps):
        middle = high - at_high * (high - low) / (at_high - at_low)
        value = _at(rod, body, middle)
        if value == 0.0:
            break
        if value * at_high < 0.0:
            low, at_low = high, at_high
        else:
            at_low *= 0.5
        high, at_high = middle, value
        if at_high == at_low:
            break
    return middle


def _bending_truth(rod: OverhungRod, body: EndBody) -> Reference:
    """A beam from end to end in many digits: deflection, slope, moment, shear carried along."""
    from mpmath import mp

    start = float(np.atleast_1d(bending_frequencies(rod, body, 1).value)[0])
    near = float(f"{start:.6g}")
    found = []
    for digits in (34, 50):
        with mp.workdps(digits):
            given = [mp.mpf(float(np.asarray(part))) for part in (*rod, *body)]
            ends = mp.mpf(near) * (1 - mp.mpf(10) ** -7), mp.mpf(near) * (1 + mp.mpf(10) ** -7)
            root = mp.findroot(lambda w, given=given: _carried(mp, given, w), ends)
            found.append(root)
    if abs(float(found[1]) / start - 1.0) > 1e-4:
        raise NumericalFailure("the root in many digits is another one")
    apart = float(abs(found[0] / found[1] - 1))
    words = "four values carried along the beam in 50 digits; held against 34"
    return Reference(np.array([float(found[1])]), max(apart, UNIT_ROUNDOFF), words)


def _carried(mp: Any, given: list[Any], w: Any) -> Any:
    """What the end of the rod leaves over, as a determinant of slope, shear and reaction."""
    stiff, line, span, overhang, mass, diametral, _, offset = given
    b = mp.sqrt(w * mp.sqrt(line / stiff))
    whole, rest = b * (span + overhang), b * overhang

    def along(x: Any, first: int) -> list[Any]:
        # derivatives at x of the solution whose derivative `first` alone is 1 at the start
        cosh, sinh, cos, sin = mp.cosh(x), mp.sinh(x), mp.cos(x), mp.sin(x)
        base = [(cosh + cos) / 2, (sinh + sin) / 2, (cosh - cos) / 2, (sinh - sin) / 2]
        return [base[(first - order) % 4] for order in range(4)]

    slope, shear, reaction = along(whole, 1), along(whole, 3), along(rest, 3)
    at_support = [along(b * span, 1)[0], along(b * span, 3)[0], mp.mpf(0)]

    def left(end: list[Any]) -> tuple[Any, Any]:
        place, turn, moment, force = end[0], end[1] * b, end[2] * b**2, end[3] * b**3
        moved = mass * w * w * (place + offset * turn)
        # E I w'' = w^2 (J w' + M e (w + e w')), E I w''' = -w^2 M (w + e w')
        return (
            stiff * moment - w * w * diametral * turn - offset * moved,
            stiff * force + moved,
        )

    rows = [at_support, *zip(*(left(end) for end in (slope, shear, reaction)), strict=True)]
    return mp.det(mp.matrix([list(row) for row in rows])) / mp.exp(2 * whole)


def _gap_topic(gap: RingGap) -> Topic:
    outer, inner, wide, rim, side, bore = (float(np.asarray(part)) for part in gap)
    has_bore = bool(np.isfinite(bore))

    def own(_: float) -> Answer:
        return Answer(np.atleast_1d(gap_shares(gap).total.value), 20.0)

    def thin(_: float) -> Answer:
        value = published_shares(outer, wide, rim).value
        return Answer(np.atleast_1d(value), 8.0)

    def summed(rings: float) -> Answer:
        """Films as if flat, ring by ring: midpoint radii of the sides, mean radii of the others."""
        share = (np.arange(int(rings)) + 0.5) / rings
        radius = inner + (outer - inner) * share
        sides = 4.0 * np.pi * (outer - inner) / rings * float(np.sum(radius**3)) / side
        value = sides + _film(outer, outer + rim, wide, share)
        if has_bore:
            value += _film(inner - bore, inner, wide, share)
        return Answer(np.array([value]), (3.0 if has_bore else 2.0) * 3.0 * rings)

    @cache
    def reference() -> Reference:
        from mpmath import mp

        def films(low: Any, high: Any) -> Any:
            return 2 * mp.pi * wide / mp.quad(lambda r: r**-3, [low, high])

        with mp.workdps(34):
            near, far, play = mp.mpf(inner), mp.mpf(outer), mp.mpf(rim)
            total = films(far, far + play)
            total += mp.quad(lambda r: 4 * mp.pi * r**3 / mp.mpf(side), [near, far])
            if has_bore:
                total += films(near - mp.mpf(bore), near)
            value = float(total)
        return Reference(np.array([value]), UNIT_ROUNDOFF, "quadrature of the films in 34 digits")

    return Topic(
        stage=_STAGE,
        name="damping of the gap",
        words="damping over dynamic viscosity of the films at rim, sides and bore",
        quantity="hardware/gap/",
        unit="m^3",
        work="multiplications",
        reference=reference,
        solvers=(
            Solver("closed forms", "cylinders turning in each other, rings next to a wall", "",
                   NOTHING_TO_SET, own, 1.0),
            Solver("midpoint sums", "films cut into rings", "rings",
                   (1.0, 4.0, 16.0, 64.0, 256.0, 1024.0), summed, None, "order 2"),
            Solver("formula as published", "flat films at the rim and on a full disc", "",
                   NOTHING_TO_SET, thin, citation="Baca Vasquez (2007), equations 3.16 and 3.17"),
        ),
    )  # fmt: skip


def _film(low: float, high: float, wide: float, share: np.ndarray) -> float:
    """2 pi b / integral of r^-3 dr by midpoints: the torque is the same at any radius."""
    radius = low + (high - low) * share
    return 2.0 * np.pi * wide / float(np.mean(radius**-3) * (high - low))

"""Topics of the kinematics: the acceleration over a turn, and what leaving out orders costs it."""

from typing import Any, NamedTuple

import numpy as np

from vibecalc.accuracy.topic import NOTHING_TO_SET, Answer, Ladder, Reference, Topic
from vibecalc.accuracy.topics.kinematics_dropped import SMALLEST_TAIL, dropped_topic
from vibecalc.kinematics.dropped_orders import dropped_acceleration
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.kinematics.truncated_series import truncated_motion
from vibecalc.machine.crank_train import CrankTrain
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.kinematics import PistonMotion

ANGLES = 24
#: a sine, cosine or root counts as ten multiplications
LONG = 10


class _Crank(NamedTuple):
    """Crank radius, rod length and wrist pin offset, m."""

    radius: float
    length: float
    offset: float

    @property
    def ratios(self) -> tuple[float, float]:
        """R/L and e/R."""
        return self.radius / self.length, self.offset / self.radius


def topics(scene: Scene) -> list[Topic]:
    """The curve where the case has one; the dropped orders where the series is the exact one."""
    motion: PistonMotion = scene.handed_on["motion"]
    crank, options = _crank(scene.parts.crank_train), scene.case.kinematics
    found = []
    cut = None
    if options is not None:
        cut = (options.terms or 1) if options.series == "truncated" else None
        found.append(_curve(crank, cut))
    ratio, offset = crank.ratios
    if cut is None and dropped_acceleration(ratio, motion.kept, offset) > SMALLEST_TAIL:
        found.append(dropped_topic(*crank.ratios, motion.kept))
    return found


def _crank(train: CrankTrain) -> _Crank:
    return _Crank(train.crank_radius, train.rod_length, train.wrist_pin_offset)


def _curve(crank: _Crank, cut: int | None) -> Topic:
    angle = 2.0 * np.pi * (np.arange(ANGLES) + 0.37) / ANGLES
    radius, length, offset = crank.radius, crank.length, crank.offset
    ratio, shift = crank.ratios

    def closed(_: float) -> Answer:
        path = piston_path(angle, radius, length, offset)
        return Answer(path.acceleration, ANGLES * (3 * LONG + 15))

    def summed(highest: float) -> Answer:
        count = int(highest)
        harmonics = radius * motion_harmonics(ratio, count, shift, derivative=2)
        used = np.flatnonzero(harmonics)
        waves = np.exp(1j * np.multiply.outer(angle, used))
        return Answer((waves @ harmonics[used]).real, ANGLES * len(used) * (2.0 * LONG + 2))

    def series(terms: float) -> Answer:
        found = truncated_motion(angle, radius, length, int(terms))
        return Answer(found.acceleration, ANGLES * (2.0 * LONG + 6 * terms + 12))

    def differences(step: float) -> Answer:
        ahead, here, behind = (
            piston_path(angle + k * step, radius, length, offset).position for k in (1, 0, -1)
        )
        values = (ahead - 2.0 * here + behind) / (step * step)
        return Answer(values, ANGLES * (3 * (3 * LONG + 4) + 4))

    orders = sorted({1, 2, 4, 6, 8, 12, 16, 24})
    ladders = [
        Ladder(
            "closed form",
            "derivatives of the exact motion at each angle",
            "",
            NOTHING_TO_SET,
            closed,
            default=1.0 if cut is None else None,
            citation="docs/theory.md",
        ),
        Ladder(
            "exact harmonics summed",
            "orders 1 to N of the exact motion",
            "orders",
            tuple(float(x) for x in orders),
            summed,
            theory="geometric",
        ),
        Ladder(
            "differences",
            "central differences of the exact position",
            "step [rad]",
            (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4, 1e-6),
            differences,
            theory="order 2",
        ),
    ]
    if offset == 0.0:
        terms = sorted({1, 2, 4, 8, 16, 40} | ({cut} if cut else set()))
        ladders.append(
            Ladder(
                "truncated series",
                "binomial series of the root, cut after some terms",
                "terms",
                tuple(float(x) for x in terms),
                series,
                default=None if cut is None else float(cut),
                theory="geometric",
                citation="Gibson (2008), equation 5; Ong (2000), equation 2.15",
            )
        )
    return Topic(
        stage="kinematics",
        name="acceleration over a turn",
        words=f"piston acceleration over crank speed squared at {ANGLES} angles"
        + ("" if cut is None else "; the case asks for the cut series of its source"),
        quantity="kinematics/acceleration",
        unit="m",
        work="multiplications (a sine or root as ten)",
        reference=lambda: _curve_reference(crank, angle),
        ladders=tuple(ladders),
        default_extra=1.0 if cut is None or cut < 3 else 1.0 + 0.15 * cut,
        default_why="" if cut is None or cut < 3 else "the case asks for the cut series",
    )


def _curve_reference(crank: _Crank, angle: np.ndarray) -> Reference:
    import mpmath

    with mpmath.workdps(60):
        radius, length, offset = (mpmath.mpf(x) for x in (crank.radius, crank.length, crank.offset))

        def position(t: Any) -> Any:
            across = radius * mpmath.sin(t) - offset
            return radius * mpmath.cos(t) + mpmath.sqrt(length**2 - across**2)

        def acceleration(t: Any) -> Any:
            sine, cosine = mpmath.sin(t), mpmath.cos(t)
            across, lever = radius * sine - offset, radius * cosine
            rod = mpmath.sqrt(length**2 - across**2)
            return -lever + across * radius * sine / rod - (lever * length) ** 2 / rod**3

        values = [acceleration(mpmath.mpf(float(t))) for t in angle]
        step = mpmath.mpf(10) ** -15
        apart = mpmath.mpf(0)
        for t, value in zip(angle.tolist(), values, strict=True):
            at = mpmath.mpf(t)
            slope = (position(at + step) - 2 * position(at) + position(at - step)) / step**2
            apart = max(apart, abs(slope - value))
        largest = max(abs(value) for value in values)
        agreement = float(apart / largest)
    return Reference(
        np.array([float(value) for value in values]),
        agreement,
        "closed form in 60 digits (mpmath) against second differences of the position there",
    )

"""The motion after a change at once, by modes in many digits."""

from typing import Any

import numpy as np

from vibecalc.accuracy.yardsticks.changes import Change

DIGITS = 34


def exact_change(change: Change, times: np.ndarray) -> np.ndarray:
    """Translations (times, 3): modal closed form by mpmath; modes, loads, ratios as stored."""
    import mpmath

    with mpmath.workdps(DIGITS):
        speed, angle = mpmath.mpf(float(change.speed)), mpmath.mpf(float(change.angle))
        modal, system = change.modal, change.system
        orders = [int(n) for n in modal.orders]
        courses = [
            _exact_mode(
                [[mpmath.mpc(complex(x)) for x in modal.amplitude[k, :, m]] for k in (0, 1)],
                orders,
                mpmath.mpf(float(system.frequency[m])),
                mpmath.mpf(float(system.damping_ratio[m])),
                speed,
                angle,
                [mpmath.mpf(float(t)) for t in times],
            )
            for m in range(len(system.frequency))
        ]
        shape = [[mpmath.mpf(float(x)) for x in row] for row in system.shape[:3]]
        return np.array(
            [
                [
                    float(
                        mpmath.fsum(s * course[k] for s, course in zip(row, courses, strict=True))
                    )
                    for row in shape
                ]
                for k in range(len(times))
            ]
        )


def _exact_mode(
    loads: list[list[Any]],
    orders: list[int],
    frequency: Any,
    ratio: Any,
    speed: Any,
    angle: Any,
    times: list[Any],
) -> list[Any]:
    """Displacements of one mode: steady motion before, steady and free motion after."""
    import mpmath

    def steady(load: list[Any], at: Any) -> tuple[Any, Any]:
        place = rate = mpmath.mpf(0)
        for order, part in zip(orders, load, strict=True):
            w = order * speed
            amplitude = part * speed**2 / (frequency**2 - w**2 + 2j * ratio * frequency * w)
            wave = amplitude * mpmath.expj(order * at)
            place, rate = place + wave.real, rate + (1j * w * wave).real
        return place, rate

    before, after = steady(loads[0], angle), steady(loads[1], angle)
    place, rate = before[0] - after[0], before[1] - after[1]
    root = mpmath.sqrt(mpmath.mpc(ratio**2 - 1)) * frequency
    first, second = -ratio * frequency + root, -ratio * frequency - root
    apart = first - second
    if apart == 0:
        parts = [(place + (rate - first * place) * t) * mpmath.exp(first * t) for t in times]
    else:
        one, two = (rate - second * place) / apart, (first * place - rate) / apart
        parts = [one * mpmath.exp(first * t) + two * mpmath.exp(second * t) for t in times]
    return [
        steady(loads[1], angle + speed * t)[0] + mpmath.re(part)
        for t, part in zip(times, parts, strict=True)
    ]

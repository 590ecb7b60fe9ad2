"""What an overhung rod and the body on its end ask of a frequency.

Euler and Bernoulli's beam. On the span, pinned at both ends, the deflection is a multiple C of
sin bx sinh bL - sinh bx sin bL, b^4 = m w^2 / (E I); beyond the second support it continues with
slope and curvature, and with a jump of the shear that is the second unknown. At the free end

    E I w''  =  w^2 [J w' + M e (w + e w')],      E I w''' = -w^2 M (w + e w'),

M the mass of the body, e how far its mass centre lies beyond the end, and J = Jd - Jp W / w for a
spin W of the body about the rod and whirl with the angular frequency w (w < 0: against the spin).
The determinant of these two equations in the two unknowns is zero.
"""

from collections.abc import Sequence

import numpy as np

from vibecalc.hardware.overhung_parts import EndBody, OverhungRod
from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray


def determinant(
    rod: OverhungRod, body: EndBody, spin: FloatArray, frequency: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Determinant at frequencies (..., modes) and a bound of its rounding."""
    stiff, line, span, overhang, mass, diametral, polar, offset, turning = (
        value[..., None] for value in floats(*rod, *body, spin)
    )
    w = frequency
    b = np.sqrt(w * np.sqrt(line / stiff))
    # shape on the span over exp(bL): slope and curvature at the second support, with length 1/b
    decay = np.exp(-2.0 * b * span)
    sinh, cosh = 0.5 * (1.0 - decay), 0.5 * (1.0 + decay)
    sine, cosine = np.sin(b * span), np.cos(b * span)
    tilt, bent = cosine * sinh - cosh * sine, -2.0 * sine * sinh
    tilt_size = np.abs(cosine) * sinh + cosh * np.abs(sine)
    k = _krylov(b * overhang)
    # deflection at the end and its derivatives over b, for the two unknowns; then their sizes
    first = _derivatives(k, (np.zeros_like(tilt), tilt, bent))
    second = (k[3], k[2], k[1], k[0])
    sizes = _derivatives(
        [np.abs(part) for part in k], (np.zeros_like(tilt), tilt_size, np.abs(bent))
    )
    loads = (
        mass * w * w / (stiff * b**3),
        offset * b,
        (diametral * w * w - polar * turning * w) / (stiff * b),
    )
    turn_size = (diametral * w * w + polar * np.abs(turning) * w) / (stiff * b)
    bound = (loads[0], np.abs(loads[1]), -turn_size)
    (top, low), (other_top, other_low) = _end_rows(first, *loads), _end_rows(second, *loads)
    top_size, low_size = _end_sizes(sizes, *bound)
    other_top_size, other_low_size = _end_sizes([np.abs(part) for part in second], *bound)
    noise = 16.0 * UNIT_ROUNDOFF * (top_size * other_low_size + other_top_size * low_size)
    return top * other_low - other_top * low, np.asarray(noise)


def _krylov(x: FloatArray) -> list[FloatArray]:
    """Half sums and differences of cosh, cos and sinh, sin, over exp(x), none by cancellation."""
    fade = np.exp(-x)
    sinh, cosh = -0.5 * np.expm1(-2.0 * x), 0.5 * (1.0 + fade**2)
    half = 0.5 * x
    between = np.square(-0.5 * np.expm1(-x)) + np.square(np.sin(half)) * fade
    short = np.minimum(x, 1.0)
    power = short**4
    series = 1.0 + power / 840.0 * (
        1.0 + power / 7920.0 * (1.0 + power / 32760.0 * (1.0 + power / 93024.0))
    )
    last = np.where(x < 1.0, short**3 / 6.0 * series * fade, 0.5 * (sinh - np.sin(x) * fade))
    return [0.5 * (cosh + np.cos(x) * fade), 0.5 * (sinh + np.sin(x) * fade), between, last]


def _derivatives(
    k: Sequence[FloatArray], start: tuple[FloatArray, FloatArray, FloatArray]
) -> list[FloatArray]:
    """Deflection, slope, curvature and third derivative at the end of a beam that starts with
    those three first values and no third derivative."""
    return [sum((k[(i - j) % 4] * start[i] for i in range(3)), np.zeros(())) for j in range(4)]


def _end_rows(
    end: Sequence[FloatArray], force: FloatArray, arm: FloatArray, turn: FloatArray
) -> tuple[FloatArray, FloatArray]:
    moved = force * (end[0] + arm * end[1])
    return end[2] - turn * end[1] - arm * moved, end[3] + moved


def _end_sizes(
    end: Sequence[FloatArray], force: FloatArray, arm: FloatArray, turn: FloatArray
) -> tuple[FloatArray, FloatArray]:
    moved = force * (end[0] + arm * end[1])
    return end[2] - turn * end[1] + arm * moved, end[3] + moved

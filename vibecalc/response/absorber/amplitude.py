"""Complex amplitude of any response at any frequency, with its error."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.absorber.coefficients import Coupling, coupling, ends, numerator
from vibecalc.response.absorber.model import Absorber, Transfer, transfer_of

#: beyond this frequency ratio only the leading powers are left in double precision
_FAR = 1e30
#: places computed at once, and |D|^2 below which it is not divided by
_BLOCK, _TINY = 8192, 1e-200


def amplitude(
    absorber: Absorber, frequency: ArrayLike, excitation: str = "force",
    response: str = "displacement",
) -> np.ndarray:  # fmt: skip
    """Complex amplitude H(x), 0-to-peak, theta(t) = Re(H e^{i w t}), of a unit excitation.

    `absorber` and `frequency` x = w / w1 broadcast together; `transfer_of` says what H is
    relative to. Infinite on an undamped natural frequency and where H grows without bound.
    Source: Baca Vasquez (2007), eqs. 2.8 to 2.10, 3.13 and 3.14.
    """
    return _amplitude(absorber, frequency, excitation, response)


def amplitude_with_error(
    absorber: Absorber, frequency: ArrayLike, excitation: str = "force",
    response: str = "displacement",
) -> WithError:  # fmt: skip
    """`amplitude` with the absolute error of |H| due to rounding; infinite where H is."""
    value = _amplitude(absorber, frequency, excitation, response)
    x = np.minimum(np.abs(np.asarray(frequency, dtype=float)), _FAR)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        top, bottom, gain = _sizes(coupling(absorber), x, excitation, response)
        relative = top[0] / top[1] + bottom[0] / bottom[1] + 3.0
        error = 4.0 * UNIT_ROUNDOFF * np.abs(value) * relative
        # at a zero of the numerator nothing is left to be relative to
        small = 4.0 * UNIT_ROUNDOFF * top[0] * gain / bottom[1]
        error = np.where(np.isinf(value), np.inf, np.where(value == 0.0, small, error))
    return WithError(value, error)


def phase(value: ArrayLike) -> np.ndarray:
    """Phase of an amplitude in (-pi, pi]; negative where the response lags behind."""
    angle: np.ndarray = np.angle(np.asarray(value, dtype=complex))
    return angle


def _amplitude(
    absorber: Absorber, frequency: ArrayLike, excitation: str, response: str
) -> np.ndarray:
    """H, in blocks that stay in the processor's cache."""
    transfer = transfer_of(excitation, response)
    parts = coupling(absorber)
    full = np.asarray(frequency, dtype=float)
    far = np.abs(full) > _FAR
    x = np.where(far, _FAR, full) if np.any(far) else full
    n0, n1, n2 = np.moveaxis(parts.motion, -1, 0)
    g0, g1 = np.moveaxis(parts.link, -1, 0)
    c, m = 2.0 * parts.primary_damping, parts.mass
    above = () if transfer.motion == "primary" else np.moveaxis(numerator(parts, transfer), -1, 0)
    known = (c, n0, n1, n2, c * n1 + m * g0, m * g1, x, *above)
    shape = np.broadcast_shapes(parts.mass.shape, x.shape)
    value = np.empty(shape, dtype=complex)
    if value.size <= _BLOCK:
        value[...] = _block(transfer, *known)
    else:
        wide = [np.reshape(a, (1,) * (len(shape) - a.ndim) + a.shape) for a in known]
        rows = max(1, _BLOCK * shape[0] // value.size)
        for start in range(0, shape[0], rows):
            part = slice(start, start + rows)
            some = [a[part] if a.shape[0] > 1 else a for a in wide]
            value[part] = _block(transfer, *some)
    if np.any(far):
        limit = ends(parts, transfer)
        ahead = limit.leading * _unit_power(limit.degree, full)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            size = np.abs(full) ** limit.degree.astype(float)
            blow = np.where(limit.degree == 0, 1.0, size)
            value = np.where(far, _scaled(ahead, blow), value)
    return value


def _block(
    transfer: Transfer, c: np.ndarray, n0: np.ndarray, n1: np.ndarray, n2: np.ndarray,
    real_pull: np.ndarray, imaginary_pull: np.ndarray, x: np.ndarray, *above: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """H = M conj(D) / |D|^2 with its factors, in real arithmetic.

    D = (1 - u) N1 + i c x N1 - m u g; what goes with u alone is summed beforehand.
    """
    u, stiff = x * x, (1.0 - x) * (1.0 + x)
    real, imaginary = n0 - n2 * u, n1 * x
    bottom = stiff * real - real_pull * u
    turned = (stiff * n1 + c * real - imaginary_pull * u) * x
    if above:
        a0, a1, a2 = above
        real, imaginary = a0 - a2 * u, a1 * x
    size = bottom * bottom + turned * turned
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        sharp = bool(np.min(size, initial=1.0) < _TINY)
        if sharp:
            value = _complex(real, imaginary) / _complex(bottom, turned)
            # a free secondary stays at rest on the primary's resonance too
            still = np.where((real == 0.0) & (imaginary == 0.0), 0.0, np.inf)
            value = np.where((bottom == 0.0) & (turned == 0.0), still, value)
        else:
            share = 1.0 / size
            value = _complex(
                (real * bottom + imaginary * turned) * share,
                (imaginary * bottom - real * turned) * share,
            )
        for _ in range(transfer.ground):
            drag = c * x
            value = _complex(value.real - drag * value.imag, value.imag + drag * value.real)
        if transfer.power:
            gain = transfer.sign * x**transfer.power
            one, two = value.real * gain, value.imag * gain
            quarter = transfer.power % 4
            value = (
                _complex(one, two), _complex(-two, one), _complex(-one, -two), _complex(two, -one)
            )[quarter]  # fmt: skip
    if sharp:
        # infinity times a zero component
        value = np.where(np.isnan(value), np.inf, value)
    return value


def _complex(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    """Both parts in one complex array, without a multiplication by i."""
    both = np.empty(np.broadcast_shapes(np.shape(real), np.shape(imaginary)), dtype=complex)
    both.real = real
    both.imag = imaginary
    return both


def _unit_power(degree: np.ndarray, x: np.ndarray) -> np.ndarray:
    """i^degree, conjugate for a negative frequency, exactly."""
    turn = np.array([1.0, 1j, -1.0, -1j])
    power: np.ndarray = turn[np.where(x < 0.0, -degree, degree) % 4]
    return power


def _scaled(direction: np.ndarray, size: np.ndarray) -> np.ndarray:
    """direction times size, which may be infinite, without infinity times zero."""

    def part(value: np.ndarray) -> np.ndarray:
        return np.where(value == 0.0, 0.0, value * size)

    return _complex(part(direction.real), part(direction.imag))


def _sizes(
    parts: Coupling, x: np.ndarray, excitation: str, response: str
) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray], np.ndarray]:
    """Sum of magnitudes behind M, and |M|; the same of D; magnitude of the other factors."""
    transfer = transfer_of(excitation, response)
    n0, n1, n2 = np.moveaxis(parts.motion, -1, 0)
    g0, g1 = np.moveaxis(parts.link, -1, 0)
    a0, a1, a2 = np.moveaxis(numerator(parts, transfer), -1, 0)
    u = x * x
    stiff, drag, pull = (1.0 - x) * (1.0 + x), 2.0 * parts.primary_damping * x, parts.mass * u
    real, imaginary = n0 - n2 * u, n1 * x
    bottom = np.hypot(
        stiff * real - drag * imaginary - pull * g0, stiff * imaginary + drag * real - pull * x * g1
    )
    blur = (np.abs(stiff) + drag) * (n0 + n1 * x + n2 * u) + pull * (g0 + g1 * x)
    top = np.hypot(a0 - a2 * u, a1 * x)
    top_blur = np.abs(a0) + np.abs(a1) * x + np.abs(a2) * u
    gain = x**transfer.power * (1.0 + drag) ** transfer.ground
    return (top_blur, top), (blur, bottom), gain

"""Contests on pistons, on a body on its mounts, and on peaks."""

import mpmath
import numpy as np
from isolation_machines import LEVER, random_body, shows
from stability.hard_compressor import true_frequencies
from stability.hard_kinematics import closed
from stability.search import Contest

from vibecalc.isolation.rigid_body import mount_readout
from vibecalc.isolation.rows import body_rows
from vibecalc.isolation.run_up import cycle_peaks, run_up_peak
from vibecalc.kinematics.harmonics import harmonics_with_error
from vibecalc.kinematics.slider_crank import piston_motion
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.response.forced import dynamics, modal_response, require_digits, response
from vibecalc.response.modal_damping import body_resonances
from vibecalc.response.modes import modes
from vibecalc.response.resonances import check_operating_point


def between(value: float, low: float, high: float) -> float:
    """Logarithmic from low to high."""
    return float(low * (high / low) ** value)


def worst(off: object, error: object) -> float:
    """Largest |off| / error; a difference without any error is infinite."""
    apart, uncertainty = np.abs(np.asarray(off, dtype=float)), np.asarray(error, dtype=float)
    share = np.where(apart == 0.0, 0.0, apart / np.where(uncertainty > 0.0, uncertainty, 1e-320))
    return float(np.max(share))


def rod_ratio(value: float) -> float:
    """1e-3 to .5 in the lower half, to 1 - 1e-7 in the upper."""
    return between(2 * value, 1e-3, 0.5) if value < 0.5 else 1.0 - between(2 - 2 * value, 1e-7, 0.5)


def harmonics(point: np.ndarray) -> float:
    """Series of vibecalc against the hypergeometric function of mpmath."""
    ratio = rod_ratio(point[0])
    order = 2 * (1 + int(point[1] * 99.9))
    found = harmonics_with_error(ratio, order, derivative=2)
    with mpmath.workdps(40):
        (exact,) = closed(mpmath.mpf(ratio), (order,))
        off = abs(mpmath.mpf(float(found.values[order].real)) - exact)
        return float(off / mpmath.mpf(float(found.error[order])))


def offset_harmonics(point: np.ndarray) -> float:
    """Autocorrelation of a series against a transform of samples in extended precision."""
    ratio = between(point[0], 0.02, 0.9)
    offset = between(point[1], 1e-12, 0.999 * (0.95 / ratio - 1.0) + 1e-12) * (
        1 - 2 * (point[2] > 0.5)
    )
    orders = 24
    found = harmonics_with_error(ratio, orders, offset)
    lam, e = np.longdouble(ratio), np.longdouble(offset)
    count = 1024
    angle = 2 * np.longdouble("3.14159265358979323846264338327950288") * np.arange(count) / count
    sine = lam * (np.sin(angle) - e)
    path = np.cos(angle) + np.sqrt((1 - sine) * (1 + sine)) / lam
    wave = np.exp(-1j * angle.astype(np.clongdouble))
    place = np.outer(np.arange(orders + 1), np.arange(count)) % count
    exact = (wave[place] @ path) * 2 / count
    exact[0] /= 2
    noise = 8e-18 * float(np.max(np.abs(path)))
    return worst(np.abs(found.values - exact), found.error + noise)


def motion(point: np.ndarray) -> float:
    """Formulas of vibecalc against the same motion in forty digits."""
    ratio, angle = rod_ratio(point[0]), float(2 * np.pi * point[1])
    if point[2] > 0.5:
        angle = float(np.pi / 2 + between(point[1], 1e-12, 1.0))
    found = piston_motion(angle, ratio, 1.0)
    with mpmath.workdps(50):
        lam, t = mpmath.mpf(ratio), mpmath.mpf(angle)
        sine, cosine = mpmath.sin(t), mpmath.cos(t)
        rod = mpmath.sqrt(1 - (lam * sine) ** 2)
        exact = (
            lam * cosine + rod,
            -lam * sine - lam * lam * sine * cosine / rod,
            -lam * cosine + (lam * sine) ** 2 / rod - (lam * cosine) ** 2 / rod**3,
        )
        return max(
            float(abs(mpmath.mpf(float(value)) - true) / (mpmath.mpf(float(error)) + 1e-320))
            for value, true, error in zip(found[:3], exact, found[3:], strict=True)
        )


def body_response(point: np.ndarray) -> float:
    """Direct solution against the sum of modes, next to a resonance, damped or nearly not."""
    body = random_body(int(point[0] * 1e5))
    damping = 0.0 if point[1] < 0.2 else between(point[1], 1e-12, 1.0)
    matrices = body.matrices
    matrices = matrices._replace(**{
        name: damping * getattr(matrices, name)
        for name in ("damping", "structural", "damping_error", "structural_error")
    })  # fmt: skip
    shapes = modes(matrices)
    random = np.random.default_rng(int(point[2] * 1e5))
    force = (random.normal(size=6) + 1j * random.normal(size=6))[None]
    load = Bounded(force, 1e-16 * np.abs(force))
    away = between(point[3], 1e-12, 3.0) * (1 if point[4] > 0.5 else -1)
    speed = abs(float(shapes.natural_frequency[int(point[5] * 5.99)]) * (1.0 + away))
    one = np.array([1])
    check_operating_point(body_resonances(matrices, shapes, load), one, speed)
    system = dynamics(matrices, one * speed)
    direct = response(system, *load)
    require_digits(matrices, system, load, direct, one, speed)
    modal = modal_response(matrices, shapes.shape, one * speed, *load)
    return worst(np.abs(direct.value - modal.value), direct.error + modal.error)


def body_modes(point: np.ndarray) -> float:
    """Cholesky, eigh and a Newton step against mpmath, one direction made stiff or soft."""
    body = random_body(int(point[0] * 1e5))
    along = np.random.default_rng(int(point[1] * 1e5)).normal(size=6)
    factor = between(point[2], 1e-12, 1e12) * float(np.max(body.matrices.stiffness))
    stiffness = body.matrices.stiffness + factor * np.outer(along, along)
    stiffness = 0.5 * (stiffness + stiffness.T)
    zero = np.zeros((6, 6))
    # the matrices as they are stored: no error of their own
    matrices = body.matrices._replace(stiffness=stiffness, stiffness_error=zero, mass_error=zero)
    found = modes(matrices)
    exact = true_frequencies(matrices)
    with mpmath.workdps(40):
        off = [float(abs(mpmath.mpf(float(a)) - b))
               for a, b in zip(found.natural_frequency, exact, strict=True)]  # fmt: skip
    return worst(off, found.natural_frequency_error)


def peak_over_cycle(point: np.ndarray) -> float:
    """Branch and bound against 40 000 samples: none may lie above the peak."""
    random = np.random.default_rng(int(point[0] * 1e5))
    count = 1 + int(point[1] * 11.9)
    highest = 1 + int(between(point[2], 1.0, 300.0))
    orders = np.unique(random.integers(0, highest + 1, count))
    size = 10.0 ** random.uniform(-16.0 * point[3], 0.0, len(orders))
    wave = size * np.exp(2j * np.pi * np.round(random.random(len(orders)) * 4) ** (point[4] > 0.5))
    found = cycle_peak(wave, orders)
    angle = np.concatenate([
        np.linspace(0.0, 2.0 * np.pi, 40_001), found.angle + np.linspace(-1e-6, 1e-6, 2001)
    ])  # fmt: skip
    top = float(np.max(np.abs((np.exp(1j * np.outer(angle, orders)) @ wave).real)))
    noise = 4e-16 * float(np.sum(np.abs(wave)))
    return max(0.0, top - float(found.value)) / (float(found.error) + noise)


def run_up(point: np.ndarray) -> float:
    """Newton on the peak against 4000 speeds over the range and next to resonances."""
    body = random_body(int(point[0] * 1e5))
    weak = between(point[1], 1e-6, 1.0)
    mounts = body.mounts._replace(
        damping=weak * body.mounts.damping, structural=weak * body.mounts.structural
    )
    matrices = body.matrices._replace(**{
        name: weak * getattr(body.matrices, name)
        for name in ("damping", "structural", "damping_error", "structural_error")
    })  # fmt: skip
    random = np.random.default_rng(int(point[2] * 1e5))
    orders = np.unique(random.integers(1, 13, 3))
    force = random.normal(size=(len(orders), 6)) + 1j * random.normal(size=(len(orders), 6))
    load = Bounded(force / LEVER, 1e-16 * np.abs(force))
    shapes = modes(matrices)
    readout = mount_readout(*mounts)
    rows = body_rows(matrices, readout, orders, load)
    resonances = body_resonances(matrices, shapes, load)
    stop = float(np.max(shapes.natural_frequency)) * between(point[3], 0.1, 3.0)
    seen = shows(readout, shapes.shape, shapes.natural_frequency)
    found = run_up_peak(rows, orders, resonances, 0.0, stop, seen)
    near = np.outer(shapes.natural_frequency, 1.0 / orders).ravel()
    nearby = np.concatenate([near * (1.0 + sign * step) for sign in (-1, 1)
                             for step in np.geomspace(1e-9, 0.1, 60)])  # fmt: skip
    speed = np.concatenate([np.linspace(0.0, stop, 2001)[1:], nearby[nearby < stop]])
    looked = cycle_peaks(rows, orders, speed)
    above = np.max((looked.value - found.value) / (looked.error + found.error + 1e-300))
    return max(0.0, float(above))


MACHINES = (
    Contest("harmonics", "series against 2F1 in forty digits", 2, harmonics),
    Contest("offset harmonics", "recurrence against samples in extended precision", 3,
            offset_harmonics),
    Contest("motion", "formulas against forty digits", 3, motion),
    Contest("body response", "direct against modal", 6, body_response),
    Contest("body modes", "Newton step after eigh against forty digits", 3, body_modes),
    Contest("peak over a cycle", "branch and bound against samples", 5, peak_over_cycle),
    Contest("run-up peak", "Newton on the peak against a grid of speeds", 4, run_up),
)  # fmt: skip

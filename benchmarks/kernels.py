"""Kernels against the plain way of getting the same numbers, each pair timed in this one run.

Every row states the relative error that both sides reach, so that speed is compared at equal
error or, where the plain way cannot follow, at an error that favours it. CPU time, one thread.
"""

import os
from collections.abc import Callable, Iterator

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import mpmath
import numpy as np
from rows import Report, Row, reported, seconds
from timing import in_turns

from vibecalc.isolation.on_mounts import pitching
from vibecalc.isolation.rows import body_rows, joined_rows
from vibecalc.isolation.run_up import Range, cycle_peaks, run_up_peak
from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak
from vibecalc.numerics.linear import dynamics, response
from vibecalc.parts.body import RigidBody
from vibecalc.parts.matrices import assemble
from vibecalc.parts.mounts import Mounts

SPEED = 4900.0 * np.pi / 30.0


def pair(
    kernel: str,
    ours: Callable[[], object],
    error: float,
    plain_way: str,
    plain: Callable[[], object],
    plain_error: float,
) -> Row:
    """The row of a kernel and of the plain way, which has one repeat to five of ours."""
    took = in_turns({"ours": ours, "plain": plain}, {"ours": 5, "plain": 2})
    return Row(
        kernel,
        "vibecalc",
        plain_way,
        took["plain"] / took["ours"],
        error=f"{error:.0e} (plain {plain_error:.0e})",
        note=f"{seconds(took['ours'])} against {seconds(took['plain'])}",
    )


def harmonics_against_quadrature() -> Row:
    """Exact harmonics at orders 1 to 200 against a discrete Fourier sum of the sampled motion.

    The last of them is 1e-44 of the first, so doubles cannot reach it by sampling (an FFT has no
    digit left from order 70 on): the sum runs in as many digits as the same relative error needs.
    """
    ratio, highest = 0.9, 200

    def by_sampling(digits: int, points: int) -> list[mpmath.mpf]:
        with mpmath.workdps(digits):
            cosine = [mpmath.cos(2 * mpmath.pi * k / points) for k in range(points)]
            square = mpmath.mpf(ratio) ** 2
            rod = [mpmath.sqrt(1 - square * (1 - c * c)) / mpmath.mpf(ratio) for c in cosine]
            return [
                2 * mpmath.fdot(rod, (cosine[order * k % points] for k in range(points))) / points
                for order in range(2, highest + 1, 2)
            ]

    def error_of(values: list[mpmath.mpf] | np.ndarray) -> float:
        return max(float(abs(v / t - 1)) for v, t in zip(values, truth, strict=True))

    truth = by_sampling(90, 1024)
    ours = motion_harmonics(ratio, highest)[2::2].real
    plain = by_sampling(57, 560)
    return pair(
        "harmonics 1 to 200, R/L = 0.9",
        lambda: motion_harmonics(ratio, highest),
        error_of([mpmath.mpf(float(v)) for v in ours]),
        "Fourier sum in 57 digits",
        lambda: by_sampling(57, 560),
        error_of(plain),
    )


def run_up_against_sweep() -> Row:
    """The highest force of a run-up, refined, against the highest of uniformly spaced speeds."""
    inertia = 100.0 / 12.0 * (0.35**2 + 0.8**2)
    body = RigidBody(
        mass=100.0,
        centre=np.zeros(3),
        mass_matrix=np.diag([100.0] * 3 + [inertia] * 3),
        inertia=inertia * np.eye(3),
    )
    each = np.broadcast_to(np.eye(3), (2, 3, 3))
    place = np.array([[-0.4, 0.0, 0.0], [0.4, 0.0, 0.0]])
    mounts = Mounts(
        names=("front", "rear"),
        position=place,
        stiffness=2.0e4 * each,
        damping=100.0 * each,
        structural=0.0 * each,
    )
    pitch = pitching(body, mounts, "x", "z")
    orders = np.array([1, 2])
    couple = 0.3 * np.sqrt(3.0) * 0.4 * 0.06 * np.array([-1j, 0.3j])
    driving = Bounded(couple, 1e-16 * np.abs(couple))[:, None]
    readout = joined_rows(pitch.couple_over(0.4), pitch.forces().rows(slice(1)))
    rows = body_rows(pitch.matrices, readout, orders, driving)
    shows = np.ones((1, 2), dtype=bool)

    def refined() -> float:
        found = run_up_peak(Range(rows, orders, pitch.resonances(driving), 0.0, SPEED, shows))
        return float(found.value[1])

    def swept(points: int) -> float:
        return float(cycle_peaks(rows, orders, np.linspace(0.0, SPEED, points)).value[:, 1].max())

    # golden section within the step of a sweep finds the same maximum in another way
    truth = _golden(lambda at: float(cycle_peaks(rows, orders, np.array([at])).value[0, 1]))
    points = 60_001
    return pair(
        "maximum of a run-up, 2 rows",
        refined,
        abs(refined() / truth - 1.0),
        f"{points - 1} uniform speeds in numpy",
        lambda: swept(points),
        abs(swept(points) / truth - 1.0),
    )


def _golden(height: Callable[[float], float]) -> float:
    low, high, section = 31.0, 33.0, 0.5 * (5.0**0.5 - 1.0)
    for _ in range(60):
        left, right = high - section * (high - low), low + section * (high - low)
        low, high = (left, high) if height(left) < height(right) else (low, right)
    return height(0.5 * (low + high))


def bodies_against_loop() -> Row:
    """6 x 6 responses at 2000 speeds and 7 orders at once against one `solve` after the other.

    Ours refines each solution once and carries an error estimate for every entry besides. The
    error shown for both is how far they are apart.
    """
    generator = np.random.default_rng(7)
    position = generator.uniform(-0.4, 0.4, (4, 3))
    stiffness = np.array([np.diag(generator.uniform(1e4, 5e4, 3)) for _ in position])
    mass = np.diag([100.0, 100.0, 100.0, 3.0, 6.0, 7.0])
    matrices = assemble(mass, position, stiffness, 0.005 * stiffness, 0.0 * stiffness)
    orders = np.arange(1, 8)
    speed = np.linspace(5.0, SPEED, 2000)
    frequency = speed[:, None] * orders
    per_square = generator.normal(size=(7, 6)) + 1j * generator.normal(size=(7, 6))
    load = np.square(speed)[:, None, None] * per_square
    load_error = 1e-16 * np.abs(load)

    def batched() -> np.ndarray:
        return response(dynamics(matrices, frequency), load, load_error).value

    def looped() -> np.ndarray:
        found = np.empty_like(load)
        for row in range(len(speed)):
            for column in range(len(orders)):
                rate = frequency[row, column]
                system = matrices.stiffness - rate * rate * matrices.mass
                system = system + 1j * rate * matrices.damping
                found[row, column] = np.linalg.solve(system, load[row, column])
        return found

    apart = np.abs(batched() - looped()).max(axis=-1) / np.abs(looped()).max(axis=-1)
    return pair(
        "6 x 6 at 2000 speeds, 7 orders, with error estimates",
        batched,
        float(apart.max()),
        "numpy loop of linalg.solve, no estimate",
        looped,
        float(apart.max()),
    )


def peaks_against_sampling() -> Row:
    """Peaks over the cycle of 1000 signals of 12 orders against dense samples of each (FFT)."""
    generator = np.random.default_rng(11)
    shape = (1000, 12)
    harmonics = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    orders = np.arange(1, 13)

    def sampled(points: int) -> np.ndarray:
        highest = np.empty(len(harmonics))
        for start in range(0, len(harmonics), 50):
            part = harmonics[start : start + 50]
            spectrum = np.zeros((len(part), points // 2 + 1), dtype=complex)
            spectrum[:, orders] = 0.5 * points * part
            highest[start : start + 50] = np.abs(np.fft.irfft(spectrum, points)).max(axis=1)
        return highest

    exact = cycle_peak(harmonics, orders)
    points = 1 << 14
    return pair(
        "peak over the cycle, 1000 signals of 12 orders",
        lambda: cycle_peak(harmonics, orders),
        float((exact.error / exact.value).max()),
        f"numpy FFT, {points} samples of each",
        lambda: sampled(points),
        float(np.abs(sampled(points) / exact.value - 1.0).max()),
    )


def all_rows() -> Iterator[Row]:
    """Every kernel in turn."""
    yield harmonics_against_quadrature()
    yield run_up_against_sweep()
    yield bodies_against_loop()
    yield peaks_against_sampling()


def measure() -> Report:
    """All pairs."""
    return Report(
        "Kernels against the plain way",
        "Errors are relative, the worst entry's. The plain way gets the same numbers.",
        list(all_rows()),
    )


if __name__ == "__main__":
    reported(measure)

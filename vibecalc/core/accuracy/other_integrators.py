"""Plain integrators and sums over a cycle, which several subjects hold their methods against."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_searches import cyclic_parabola_maximum
from vibecalc.core.accuracy.topic import NOTHING_TO_SET, Answer, Reference, Solver, Topic
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.cycle_peak import SAMPLES_PER_ORDER, needed_orders, vector_cycle_peak

# ----------------------------------------------------------------------------
# Integrators of first-order systems that count what they evaluate: Euler, RK4, those of scipy.
# ----------------------------------------------------------------------------

#: right-hand side: time and state (n,) to rates (n,)
Rates = Callable[[float, np.ndarray], np.ndarray]

#: evaluations of the right-hand side in one step
STAGES = {"euler": 1, "rk4": 4}


class Marched(NamedTuple):
    """Times (k,), states (k, n) at them, and evaluations of the right-hand side."""

    times: np.ndarray
    states: np.ndarray
    evaluations: int


def march_fixed(
    rates: Rates, state: np.ndarray, start: float, stop: float, steps: int, method: str = "rk4"
) -> Marched:
    """`steps` equal steps from `start` to `stop`: explicit Euler or the classical Runge-Kutta.

    Parameters
    ----------
    rates : the right-hand side.
    state : array (n,), real or complex, at `start`.
    start, stop : s; the march may also go backwards.
    steps : number of equal steps.
    method : "euler" or "rk4".

    Returns
    -------
    Marched
        The state after every step, the first one included.

    Raises
    ------
    NumericalFailure
        The states leave the range of double precision: the step is unstable.
    """
    step = (stop - start) / steps
    one_step = _euler if method == "euler" else _rk4
    current = np.array(state, dtype=np.result_type(state, float))
    states = np.empty((steps + 1, *current.shape), dtype=current.dtype)
    states[0] = current
    with np.errstate(over="ignore", invalid="ignore"):
        for number in range(steps):
            current = one_step(rates, start + number * step, current, step)
            states[number + 1] = current
    if not np.all(np.isfinite(states[-1])):
        raise NumericalFailure(f"{method} with a step of {step:.3g} s is unstable: it overflowed")
    times = start + step * np.arange(steps + 1)
    return Marched(times, states, STAGES[method] * steps)


def _euler(rates: Rates, time: float, state: np.ndarray, step: float) -> np.ndarray:
    return state + step * rates(time, state)


def _rk4(rates: Rates, time: float, state: np.ndarray, step: float) -> np.ndarray:
    half = 0.5 * step
    first = rates(time, state)
    second = rates(time + half, state + half * first)
    third = rates(time + half, state + half * second)
    fourth = rates(time + step, state + step * third)
    return state + step / 6.0 * (first + 2.0 * (second + third) + fourth)


def march_scipy(
    rates: Rates,
    state: np.ndarray,
    times: np.ndarray,
    rtol: float,
    atol: float | np.ndarray = 0.0,
    method: str = "DOP853",
    jacobian: Any = None,
) -> Marched:
    """`scipy.integrate.solve_ivp` from the first to the last of `times`, states at all of them.

    Parameters
    ----------
    rates, state : as in `march_fixed`.
    times : array (k,), s, rising or falling; the states between steps are the method's own
        interpolation.
    rtol, atol : tolerances of scipy; scipy raises an `rtol` below 2e-14 to that.
    method : "RK45", "DOP853", "Radau", "BDF" or "LSODA".
    jacobian : matrix (n, n) or function for the implicit ones; not counted as evaluations.

    Raises
    ------
    NumericalFailure
        scipy gives up, or the states are not finite.
    """
    import warnings

    from scipy.integrate import solve_ivp

    extra = {} if jacobian is None else {"jac": jacobian}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        # scipy tells by a warning what is said in the docstring above
        warnings.simplefilter("ignore", UserWarning)
        found = solve_ivp(
            rates,
            (float(times[0]), float(times[-1])),
            np.array(state, dtype=np.result_type(state, float)),
            method=method,
            t_eval=times,
            rtol=rtol,
            atol=atol,
            **extra,
        )
    if not found.success:
        raise NumericalFailure(f"{method} at rtol {rtol:.1g} gave up: {found.message}")
    if not np.all(np.isfinite(found.y)):
        raise NumericalFailure(f"{method} at rtol {rtol:.1g} left the range of double precision")
    return Marched(np.asarray(found.t), np.asarray(found.y.T), int(found.nfev))


# ----------------------------------------------------------------------------
# Harmonics from samples of a cycle and samples from harmonics, by the plain Fourier transform.
# ----------------------------------------------------------------------------


def harmonics_of_samples(samples: np.ndarray, highest_order: int) -> np.ndarray:
    """Complex 0-to-peak amplitudes of x(t) = Re sum X_n exp(i n w t), orders 0 to highest.

    Parameters
    ----------
    samples : real array (..., count)
        One cycle, evenly spaced, its first point once.
    highest_order : int

    Returns
    -------
    complex array (..., highest_order + 1)
        Order 0 is the mean.

    Raises
    ------
    NumericalFailure
        There are not more samples than twice the highest order: it folds onto lower ones.
    """
    count = samples.shape[-1]
    if count <= 2 * highest_order:
        raise NumericalFailure(
            f"{count} samples cannot tell order {highest_order} from lower ones: more than "
            f"{2 * highest_order} are needed"
        )
    found: np.ndarray = np.fft.rfft(samples, axis=-1)[..., : highest_order + 1] * (2.0 / count)
    found[..., 0] *= 0.5
    return found


def samples_of_harmonics(harmonics: np.ndarray, orders: np.ndarray, count: int) -> np.ndarray:
    """One cycle (..., count) of the sum of harmonics (..., orders) at evenly spaced angles.

    Any count will do: orders beyond half of it fold down, as samples of the true sum do.
    """
    spectrum = np.zeros((*harmonics.shape[:-1], count), dtype=complex)
    for place, order in enumerate(orders.tolist()):
        spectrum[..., order % count] += harmonics[..., place]
    return np.asarray(np.fft.ifft(spectrum, axis=-1).real * count)


def transform_work(count: int) -> float:
    """Complex multiplications of a fast transform of `count` samples, count/2 log2(count)."""
    return 0.5 * count * max(float(np.log2(count)), 1.0)


# ----------------------------------------------------------------------------
# A periodic vector as harmonics: its length with derivatives, its peaks by Newton's method.
# ----------------------------------------------------------------------------

#: maxima that agree to this share count as equal
EQUAL = 1e-10
NEWTON_STEPS = 8
#: samples of each order on which peaks are looked for
CYCLE_SIGNALS_SAMPLES_PER_ORDER = 48


class Signal(NamedTuple):
    """Harmonics (components, orders) of a vector, 0-to-peak, and their orders (orders,)."""

    harmonics: np.ndarray
    orders: np.ndarray


def square_and_slopes(signal: Signal, angle: np.ndarray) -> tuple[np.ndarray, ...]:
    """Squared length (k,) at crank angles (k,), with its first two derivatives by the angle."""
    waves = np.exp(1j * np.multiply.outer(signal.orders, angle))
    factor = 1j * signal.orders
    value, slope, bend = (((signal.harmonics * factor**power) @ waves).real for power in (0, 1, 2))
    return (
        np.sum(value * value, axis=0),
        2.0 * np.sum(value * slope, axis=0),
        2.0 * np.sum(slope * slope + value * bend, axis=0),
    )


def lengths(signal: Signal, angle: np.ndarray) -> np.ndarray:
    """Length of the vector (k,) at crank angles (k,)."""
    waves = np.exp(1j * np.multiply.outer(signal.orders, angle))
    return np.asarray(np.sqrt(np.sum(np.square((signal.harmonics @ waves).real), axis=0)))


def newton_maximum(signal: Signal, angle: float) -> tuple[float, float, int]:
    """Newton's method on the slope of the squared length: length, angle, evaluations.

    Raises NumericalFailure where it leads to no maximum.
    """
    taken, moved = 0, 1.0
    while taken < NEWTON_STEPS and abs(moved) >= 1e-12:
        _, slope, bend = (float(part[0]) for part in square_and_slopes(signal, np.array([angle])))
        if not bend < 0.0:
            raise NumericalFailure(f"Newton's method leaves the peak near {angle:.6g} rad")
        moved = -slope / bend
        angle += moved
        taken += 1
    return float(lengths(signal, np.array([angle]))[0]), angle, 3 * taken + 1


def equal_maxima(signal: Signal, first: float, value: float) -> list[float]:
    """Angles in [0, 2 pi) of all maxima as high as `value`, that at `first` before the others."""
    points = CYCLE_SIGNALS_SAMPLES_PER_ORDER * int(signal.orders.max())
    angle = 2.0 * np.pi * np.arange(points) / points
    height = lengths(signal, angle)
    top = (height >= np.roll(height, 1)) & (height >= np.roll(height, -1))
    found = [first % (2.0 * np.pi)]
    for start in angle[top & (height > 0.98 * value)]:
        try:
            length, place, _ = newton_maximum(signal, float(start))
        except NumericalFailure:
            continue
        place %= 2.0 * np.pi
        new = all(abs(turned(place - other)) > 1e-6 for other in found)
        if new and length >= value * (1.0 - EQUAL):
            found.append(place)
    return found


def turned(angle: float) -> float:
    """The angle between -pi and pi."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


# ----------------------------------------------------------------------------
# The peak of a periodic signal over its cycle: a topic that several stages have.
# ----------------------------------------------------------------------------

__all__ = ["Signal", "peak_topic"]

#: of a step, how far next to a point of a grid the peak lies: on average a grid that knows
#: nothing misses it by so much, while one from dead centre on may meet it by luck
MISSED = 0.25
#: with more equal maxima the signal is as good as constant, and has no place
MOST_EQUALS = 8
#: so is one whose length changes by less than this share
FLAT = 1e-9
#: what `cycle_peak` evaluates next to its samples: Taylor polynomials of about two cells
TAYLOR = 30
PROOF = "no maximum can be missed: every order above rounding is sampled twelvefold, however small"
#: what a reader of the trials has to know
LAID = "laid a quarter of a step next to the known peak, as far off as on average"


def peak_topic(
    stage: str, name: str, words: str, quantity: str, unit: str, signal: Signal
) -> Topic:
    """A topic on the largest length of `signal` over the cycle, with its crank angle.

    Work is counted in evaluations of the sum at one crank angle. Of several equal maxima the
    nearest counts as the place; a signal that is the same all around has none.
    """
    used = np.any(signal.harmonics != 0.0, axis=0) & (signal.orders > 0)
    signal = Signal(signal.harmonics[:, used], signal.orders[used])
    known = vector_cycle_peak(signal.harmonics, signal.orders)
    value, first = float(known.value), float(known.angle)
    equals = equal_maxima(signal, first, value)
    around = lengths(signal, _angles(first, 64))
    placed = len(equals) <= MOST_EQUALS and bool(around.min() < value * (1.0 - FLAT))
    highest = int(signal.orders.max()) // max(int(np.gcd.reduce(signal.orders)), 1)
    step = max(int(np.gcd.reduce(signal.orders)), 1)
    kept = int(needed_orders(signal.harmonics[None], signal.orders // step)[0][0])
    own_work = SAMPLES_PER_ORDER * kept + TAYLOR if highest > 1 else 1

    def answer(height: float, angle: float, work: float) -> Answer:
        nearest = min(equals, key=lambda place: abs(turned(angle - place)))
        position = equals[0] + turned(angle - nearest) if placed else None
        return Answer(np.array([height]), work, position)

    def proven(_: float) -> Answer:
        peak = vector_cycle_peak(signal.harmonics, signal.orders)
        return answer(float(peak.value), float(peak.angle), own_work)

    def grid(points: float) -> Answer:
        angle = _angles(first, int(points))
        height = lengths(signal, angle)
        best = int(np.argmax(height))
        return answer(float(height[best]), float(angle[best]), points)

    def parabola(points: float) -> Answer:
        begin = float(_angles(first, int(points))[0])
        best = cyclic_parabola_maximum(
            lambda angle: lengths(signal, begin + angle), 2.0 * np.pi, int(points)
        )
        return answer(best.value, begin + best.position, points)

    def newton(points: float) -> Answer:
        angle = _angles(first, int(points))
        place = float(angle[int(np.argmax(lengths(signal, angle)))])
        height, place, work = newton_maximum(signal, place)
        return answer(height, place, points + work)

    def bounded(points: float) -> Answer:
        return _bounded(signal, _angles(first, int(points)), answer)

    coarse = tuple(float(8 << k) for k in range(0, 12, 2))
    solvers = (
        Solver(
            "cycle_peak",
            "samples that cannot miss, Taylor polynomials, Newton in concave cells",
            "",
            NOTHING_TO_SET,
            proven,
            default=1.0,
            citation="M. Riesz (1914); Ehlich and Zeller (1964)",
        ),
        Solver(
            "grid", f"highest of N crank angles, {LAID}", "angles", coarse, grid, theory="order 2"
        ),
        Solver(
            "grid with parabola",
            f"parabola through the best of N angles and its neighbours, {LAID}",
            "angles",
            coarse,
            parabola,
        ),
        Solver(
            "Newton from a grid",
            "Newton's method for the slope from the best of N angles",
            "angles",
            tuple(float(8 << k) for k in range(6)),
            newton,
            theory="exact once the start lies on the highest peak",
        ),
        Solver(
            "scipy minimize_scalar",
            "bounded Brent search around the best of N angles",
            "angles",
            tuple(float(8 << k) for k in range(6)),
            bounded,
        ),
    )
    least = float(solvers[3].settings[0] + 7.0)
    extra = max(1.0, float(np.ceil(own_work / least)))
    return Topic(
        stage=stage,
        name=name,
        words=words,
        quantity=quantity,
        unit=unit,
        work="evaluations of the sum at one angle",
        reference=lambda: _exact(signal, first, value, placed),
        solvers=solvers,
        position="crank angle [rad]" if placed else "",
        default_extra=extra,
        default_why=PROOF if extra > 1.0 else "",
    )


def _angles(peak: float, points: int) -> np.ndarray:
    """A grid over one turn that misses the peak as a grid does on average."""
    step = 2.0 * np.pi / points
    return np.asarray(peak + step * (MISSED + np.arange(points)))


def _bounded(
    signal: Signal, angle: np.ndarray, answer: Callable[[float, float, float], Answer]
) -> Answer:
    from scipy.optimize import minimize_scalar

    step = 2.0 * np.pi / len(angle)
    best = float(angle[int(np.argmax(lengths(signal, angle)))])
    found = minimize_scalar(
        lambda place: -float(lengths(signal, np.array([place]))[0]),
        bounds=(best - step, best + step),
        method="bounded",
        options={"xatol": 1e-10},
    )
    if not found.success:
        raise NumericalFailure(f"minimize_scalar gave up: {found.message}")
    return answer(-float(found.fun), float(found.x), len(angle) + float(found.nfev))


def _exact(signal: Signal, first: float, value: float, placed: bool) -> Reference:
    """The highest peak in 40 digits, held against a dense grid and the value in doubles."""
    import mpmath

    with mpmath.workdps(40):
        rows = [[mpmath.mpc(complex(x)) for x in row] for row in signal.harmonics]
        orders = [int(n) for n in signal.orders]

        def jet(angle: Any) -> tuple[Any, ...]:
            waves = [mpmath.expj(n * angle) for n in orders]
            square = slope = bend = mpmath.mpf(0)
            for row in rows:
                parts = [x * wave for x, wave in zip(row, waves, strict=True)]
                x = mpmath.fsum(part.real for part in parts)
                v = mpmath.fsum(-n * part.imag for n, part in zip(orders, parts, strict=True))
                a = mpmath.fsum(-n * n * part.real for n, part in zip(orders, parts, strict=True))
                square, slope, bend = square + x * x, slope + x * v, bend + v * v + x * a
            return mpmath.sqrt(square), slope, bend

        angle = mpmath.mpf(first)
        for _ in range(6 if placed else 0):
            _, slope, bend = jet(angle)
            if not bend < 0:
                break
            angle -= slope / bend
        height = float(jet(angle)[0])
        place = float(angle)
    points = 96 * int(signal.orders.max())
    dense = float(lengths(signal, 2.0 * np.pi * np.arange(points) / points).max())
    over = max(dense / height - 1.0, 0.0)
    agreement = max(abs(value / height - 1.0), over)
    return Reference(
        np.array([height]),
        agreement,
        f"peak in 40 digits (mpmath); none of {points} angles is higher, cycle_peak agrees to "
        f"{agreement:.1e}",
        place if placed else None,
    )

"""Integrators of first-order systems that count what they evaluate: Euler, RK4, those of scipy."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure

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

"""Least largest response where stiffness, damping or the travel of the spring are limited."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.absorber.bounded_free import free_optimum
from vibecalc.optimisation.absorber.several import SeveralTuning, tuned
from vibecalc.optimisation.absorber.several_problem import Problem, Travel
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks

#: an optimum that exceeds a limit of travel by less than this keeps it
_KEPT = 1e-9
#: what may hold an optimum
HELD_BY = (
    "least stiffness", "least damping", "largest stiffness", "largest damping", "spring travel",
)  # fmt: skip


class BoundedTuning(NamedTuple):
    """The optimum within the limits beside the one without; arrays of one entry are plain numbers.

    `tuning` as for several absorbers, with one; `travel` of the spring there (largest relative
    amplitude at its own worst frequency, in the unit of displacement of `transfer_of`),
    `free_peak` and `free_travel` of the unlimited optimum, `penalty` = peak / free_peak - 1 with
    `penalty_error`. `active`: names of the limits that hold the optimum.
    """

    tuning: SeveralTuning
    travel: float
    travel_error: float
    free_peak: float
    free_travel: float
    penalty: float
    penalty_error: float
    active: tuple[str, ...]


def bounded_tuning(
    primary_damping: float, mass_ratio: float, excitation: str = "force",
    response: str = "displacement", *, stiffness: tuple[float, float] = (0.0, np.inf),
    damping: tuple[float, float] = (0.0, np.inf), travel: float = np.inf,
) -> BoundedTuning:  # fmt: skip
    """Minimise the largest |H| over k and z2 within [low, high] each, and a largest spring travel.

    The free optimum is found first, by itself, and is the answer where it keeps the limits.
    Raises NumericalFailure where a bound is crossed over, where nothing within the bounds keeps
    the travel, and where the response grows with frequency without bound.
    """
    for name, (low, high) in (("stiffness", stiffness), ("damping", damping)):
        if not 0.0 <= low <= high:
            raise NumericalFailure(
                f"bounds of the {name} ratio, {low:.6g} to {high:.6g}, leave nothing: they must be "
                "zero or positive, and the lower not above the upper"
            )
    if not travel > 0.0:
        raise NumericalFailure(f"a largest spring travel of {travel:.6g} leaves no motion to use")
    m = np.array([float(mass_ratio)])
    bare = Problem(
        float(primary_damping), m, (0,), excitation, response, np.zeros(2), np.full(2, np.inf)
    )
    free = free_optimum(bare)
    free = tuned(bare, 8) if free is None else free
    free_travel, free_doubt = spring_travel(primary_damping, m[0], free, excitation)
    lower = np.array([stiffness[0], damping[0]], dtype=float)
    upper = np.array([stiffness[1], damping[1]], dtype=float)
    limits = (Travel(1, float(travel)),) if np.isfinite(travel) else ()
    there = float(free.stiffness_ratio[0]), float(free.secondary_damping[0])
    if (
        keeps(there, stiffness, damping)
        and not free.is_set
        and free_travel <= travel * (1.0 + _KEPT)
    ):
        reach = np.array([free_travel] * len(limits))
        held = free._replace(travel=reach, travel_active=reach >= travel * (1.0 - _KEPT))
        return BoundedTuning(
            held, free_travel, free_doubt, free.peak, free_travel, 0.0, 4e-16,
            ("spring travel",) if np.any(held.travel_active) else (),
        )  # fmt: skip
    found = tuned(bare._replace(lower=lower, upper=upper, travel=limits), 8)
    reached, doubt = spring_travel(primary_damping, m[0], found, excitation)
    active = tuple(
        name
        for name, held in zip(
            HELD_BY,
            (*found.on_lower, *found.on_upper, bool(limits) and bool(found.travel_active[0])),
            strict=True,
        )
        if held
    )
    ratio = found.peak / free.peak
    return BoundedTuning(
        found, reached, doubt, free.peak, free_travel, ratio - 1.0,
        ratio * (found.peak_error / found.peak + free.peak_error / free.peak) + 4e-16,
        active,
    )  # fmt: skip


def keeps(
    ratios: tuple[float, float], stiffness: tuple[float, float], damping: tuple[float, float]
) -> bool:
    """Whether stiffness and damping ratio lie within their bounds."""
    both = zip(ratios, (stiffness, damping), strict=True)
    return all(low <= ratio <= high for ratio, (low, high) in both)


def spring_travel(
    primary_damping: float, mass_ratio: float, tuning: SeveralTuning, excitation: str
) -> tuple[float, float]:
    """Largest relative amplitude of one tuned secondary over all frequencies, and its error."""
    absorber = Absorber(
        primary_damping, mass_ratio, tuning.stiffness_ratio[0], tuning.secondary_damping[0]
    )
    found = peaks(absorber, excitation, "relative_displacement")
    return float(found.largest), float(found.largest_error)

"""One tuning by the norm and kind that a case asks for."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.absorber_tables import Tuning
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, WithError
from vibecalc.optimisation.absorber.closed_forms import lanchester
from vibecalc.optimisation.absorber.mean_square import mean_square_tuning
from vibecalc.optimisation.absorber.minimax import BALANCED, NO_HELP, SET, UNBOUNDED, minimax
from vibecalc.optimisation.absorber.minimax_restricted import pure_viscous, undamped_spring
from vibecalc.optimisation.absorber.threshold import threshold
from vibecalc.response.absorber.mean_square import mean_square
from vibecalc.response.absorber.model import Absorber, transfer_of
from vibecalc.response.absorber.peaks import peaks


class Best(NamedTuple):
    """Stiffness and damping found, what they make small (`value`; `alone` without an absorber).

    `is_held`: one tuning, held by its peaks, and no set of them. `remarks`: words for the report.
    `above_floor`: the peak less what no absorber changes at rest or at high frequency, to its own
    digits; NaN where it is not known so.
    """

    stiffness_ratio: float
    secondary_damping: float
    stiffness_error: float
    damping_error: float
    value: float
    value_error: float
    alone: float
    peak_error: float
    helps: bool
    evaluations: int
    remarks: tuple[str, ...] = ()
    is_held: bool = True
    above_floor: float = np.nan
    above_floor_error: float = 0.0


def best_tuning(options: Tuning, z1: float, m: float) -> Best:
    """The optimum for one primary damping and mass ratio.

    Raises NumericalFailure where there is none: a response that grows without bound, or has no
    mean square, or is never finite.
    """
    pair = options.excitation, options.response
    if options.norm == "h2":
        return _least_squares(options, z1, m)
    if options.kind == "free":
        return _free(z1, m, pair)
    if options.kind == "lanchester":
        _, z2, _ = lanchester(np.asarray(m))
        damping = float(z2)
        return Best(
            0.0, damping, 0.0, 8.0 * EPSILON * damping, np.nan, 0.0, np.nan, 0.0, True, 1,
        )  # fmt: skip
    if is_endless(pair, z1):
        raise NumericalFailure(_endless(pair, threshold(*pair).why))
    viscous = options.kind == "viscous"
    found = pure_viscous(z1, m, *pair) if viscous else undamped_spring(z1, m, *pair)
    value, error = float(found.value), float(found.value_error)
    if not np.isfinite(value):
        raise NumericalFailure(
            "the best such absorber is locked to the primary: a mass fastened rigidly does more"
        )
    place = (0.0, value, 0.0, error) if viscous else (value, 0.0, error, 0.0)
    return Best(
        *place, float(found.largest), float(found.largest_error), np.nan,
        float(found.largest_error), bool(found.held_by), int(np.max(found.evaluations)),
    )  # fmt: skip


def is_endless(pair: tuple[str, str], z1: float) -> bool:
    """Whether the response grows with frequency without bound, whatever the absorber."""
    transfer = transfer_of(*pair)
    # the motion of the primary falls with the square of the frequency
    return transfer.power + transfer.ground * (z1 > 0.0) > 2


def level_of(options: Tuning, absorber: Absorber) -> WithError:
    """What is made small: the largest amplitude, or the mean square."""
    pair = options.excitation, options.response
    if options.norm == "h2":
        return mean_square(absorber, *pair)
    found = peaks(absorber, *pair)
    return WithError(found.largest, found.largest_error)


def _free(z1: float, m: float, pair: tuple[str, str]) -> Best:
    found = minimax(z1, m, *pair)
    outcome, limit = int(found.outcome), threshold(*pair)
    if outcome == UNBOUNDED:
        raise NumericalFailure(_endless(pair, limit.why))
    remarks: tuple[str, ...] = ()
    if outcome == NO_HELP:
        remarks = (
            f"no absorber helps: the primary's damping {z1:.6g} is not below the threshold "
            f"{limit.exact} ({limit.primary_damping:.6g}); {limit.why}",
        )
    elif outcome == SET:
        remarks = (f"many tunings are as good: {limit.why}; the one given is one of them",)
    return Best(
        float(found.stiffness_ratio), float(found.secondary_damping),
        float(found.stiffness_error), float(found.damping_error), float(found.largest),
        float(found.largest_error), np.nan, float(found.largest_error), outcome != NO_HELP,
        int(found.evaluations), remarks, outcome == BALANCED,
        float(found.above_floor),
        float(found.excess_error / (found.largest + found.floor)) + 4.0 * EPSILON * float(
            found.above_floor
        ),
    )  # fmt: skip


def _least_squares(options: Tuning, z1: float, m: float) -> Best:
    if options.kind != "free":
        raise NumericalFailure(
            f"a mean square is tuned with both spring and damper, not of kind {options.kind!r}"
        )
    found = mean_square_tuning(z1, m, options.excitation, options.response)
    if bool(found.locked):
        raise NumericalFailure(
            "a mass fastened rigidly to the primary has a lower mean square than any absorber"
        )
    helps = not bool(found.no_help)
    remarks = () if helps else ("no absorber of this mass lowers the mean square",)
    return Best(
        float(found.stiffness_ratio), float(found.secondary_damping),
        float(found.stiffness_error), float(found.damping_error), float(found.value),
        float(found.value_error), float(found.alone), 0.0, helps, found.steps, remarks,
    )  # fmt: skip


def _endless(pair: tuple[str, str], why: str) -> str:
    return f"no tuning makes the {pair[1]} under excitation by {pair[0]} small: {why}"

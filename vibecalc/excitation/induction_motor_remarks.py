"""What has to be said beside a fitted motor, in words."""

import numpy as np

from vibecalc.excitation.induction_motor import InductionMotor
from vibecalc.excitation.induction_motor_identify import Identifiability, product_of_powers
from vibecalc.excitation.induction_motor_search import Found
from vibecalc.numerics.typing import BoolArray, FloatArray

#: relative differences from the table that are worth a word
MISFIT = 0.05


def assumptions_of(
    motor: InductionMotor, inductance_assumed: bool, stator_share: float, no_load_ratio: float
) -> tuple[str, ...]:
    """What was held because a torque table does not tell it."""
    total = float(np.asarray(motor.stator_leakage) + np.asarray(motor.magnetising_inductance))
    given = (
        f"assumed: {no_load_ratio:g} times the leakage that the breakdown torque shows"
        if inductance_assumed
        else "given"
    )
    return (
        f"the inductance of the stator (leakage and magnetising) is {total:.4g} H, {given}; the "
        "steady torque does not depend on it, transients do",
        f"the stator leakage is {stator_share:g} of the transient inductance, by convention; "
        "torque and stator current do not depend on it, at no time",
    )


def warnings_of(
    slip: FloatArray,
    relative: FloatArray,
    used: BoolArray,
    found: Found,
    told: Identifiability,
) -> tuple[str, ...]:
    """Misfit, rows left out, a cage that the table does not need, what the table does not tell."""
    said = []
    worst = int(np.argmax(np.where(used, np.abs(relative), -1.0)))
    if abs(relative[worst]) > MISFIT:
        said.append(
            f"no circuit of this kind meets the table: {100 * relative[worst]:+.1f} % at a slip of "
            f"{slip[worst]:.4g} rad/s is the worst of the fitted rows"
        )
    if not used.all():
        last = int(np.argmax(np.where(used, -1.0, np.abs(relative))))
        said.append(
            f"{int((~used).sum())} rows beyond the largest torque are not fitted; the motor misses "
            f"them by up to {100 * relative[last]:+.1f} % (at {slip[last]:.4g} rad/s)"
        )
    if found.at_bound or not np.isfinite(found.log_error):
        said.append(
            "the table does not settle every parameter of the cages: fewer cages would do as well"
        )
    if found.agreeing < 2:
        said.append(
            f"only one of {found.starts} searches ended in the minimum taken; another may be lower"
        )
    for exponents, spread, is_told in zip(told.combinations, told.spread, told.told, strict=True):
        if not is_told:
            words = product_of_powers(told.names, exponents)
            size = (
                "at all"
                if not np.isfinite(spread)
                else f"better than to a factor of {_factor(spread)} for 1 % of error in its rows"
            )
            said.append(f"the table does not tell {words} {size}")
    return tuple(said)


def _factor(spread: float) -> str:
    """exp(spread), readable also where it would overflow."""
    power = spread / np.log(10.0)
    return f"{10.0**power:.2g}" if power < 3.0 else f"10^{power:.0f}"

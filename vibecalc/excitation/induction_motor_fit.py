"""Parameters of an induction motor from a table of slip and torque."""

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure, in_rpm
from vibecalc.excitation.induction_motor import STEP, InductionMotor, steady_torque, torque_of
from vibecalc.excitation.induction_motor_identify import (
    Identifiability,
    identifiability,
    product_of_powers,
    transient_inductance,
    with_stator_leakage,
)
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray

# ----------------------------------------------------------------------------
# Least squares of a motor's rotor against a table, from many starts, ended by Newton steps.
# ----------------------------------------------------------------------------

#: how far a parameter may go from its scale, as a factor
REACH = 1e4
#: a table met to this in every row leaves nothing to search for
EXACT = 1e-11
#: searches that are run to their end, from the best points of the grid
STARTS = 10


class LeastSquares(NamedTuple):
    """`logarithms` (2 cages,) of the resistances (ohm), then the leakages (H), of the best minimum.

    `log_error` as in `MotorFit`; `at_bound` whether a parameter ran away from its scale.
    """

    logarithms: FloatArray
    log_error: float
    starts: int
    agreeing: int
    at_bound: bool


class FitTable(NamedTuple):
    """Rows to fit: slips (rad/s) and torques (N m), and the motor without its rotor."""

    motor: InductionMotor
    slip: FloatArray
    torque: FloatArray

    def residual(self, logarithms: FloatArray) -> FloatArray:
        """Relative differences (..., rows) for parameters (..., 2 cages)."""
        value = torque_of(self._with(logarithms[..., None, :]), self.slip)
        return np.asarray(value / self.torque - 1.0)

    def jacobian(self, logarithms: FloatArray) -> FloatArray:
        """Derivatives (rows, 2 cages) of the residual."""
        moved = logarithms + 1j * STEP * np.eye(logarithms.size)
        return np.asarray(self.residual(moved).imag.T / STEP)

    def gradient(self, logarithms: FloatArray) -> FloatArray:
        """Of half the sum of squares."""
        return self.jacobian(logarithms).T @ self.residual(logarithms)

    def _with(self, logarithms: FloatArray) -> InductionMotor:
        cages = logarithms.shape[-1] // 2
        values = np.exp(logarithms)
        return self.motor._replace(
            rotor_resistance=values[..., :cages], rotor_leakage=values[..., cages:]
        )


def best_start(
    motor: InductionMotor,
    slip: FloatArray,
    torque: FloatArray,
    breakdown_slip: float,
) -> LeastSquares:
    """Lowest minimum over rotor resistances and leakages, everything else of the motor held.

    The starts lie on a grid of slips at which a cage is strongest and of leakages; they are the
    same for the same table. `motor.rotor_leakage` gives the scale of the leakages.
    """
    from scipy.optimize import least_squares

    table = FitTable(motor, slip, torque)
    scale, starts = _starts(table, breakdown_slip)

    def descend(start: FloatArray, most: int) -> tuple[float, FloatArray, bool]:
        end = least_squares(
            table.residual, start, table.jacobian,
            bounds=(scale - np.log(REACH), scale + np.log(REACH)),
            xtol=1e-12, ftol=1e-14, gtol=1e-14, max_nfev=most,
        )  # fmt: skip
        met = float(np.max(np.abs(end.fun))) < EXACT
        return float(end.cost), end.x, end.status > 0 or met

    ends = [descend(start, 400) for start in starts]
    cost, logarithms, converged = min(ends, key=lambda end: end[0])
    if not converged:
        cost, logarithms, converged = descend(logarithms, 4000)
    if not converged:
        raise NumericalFailure("the fit of a motor to its torque table does not converge")
    agreeing = max(1, sum(end[0] <= cost * (1.0 + 1e-6) + 1e-20 for end in ends))
    at_bound = bool(np.any(np.abs(logarithms - scale) > np.log(REACH) - 0.1))
    polished, error = (logarithms, np.inf) if at_bound else _newton(table, logarithms)
    return LeastSquares(polished, error, len(ends), agreeing, at_bound)


def _starts(table: FitTable, breakdown_slip: float) -> tuple[FloatArray, FloatArray]:
    """Scale (2 cages,) and starts (n, 2 cages) of the logarithms.

    Of every set of slips at which the cages are strongest, the best leakages; of these the best.
    """
    pairs = float(np.asarray(table.motor.pole_pairs))
    leakage = np.asarray(table.motor.rotor_leakage)
    cages = leakage.size
    slips = [breakdown_slip * np.array([0.1, 0.25, 0.5, 1.0, 2.0])] * cages
    if cages > 1:
        end = max(table.slip[-1], 2.0 * breakdown_slip)
        slips[-1] = end * np.array([0.25, 0.5, 1.0, 2.0, 5.0])
    inductances = leakage[0] * np.array(list(product([0.5, 1.0, 2.0, 5.0], repeat=cages)))
    candidates = []
    for strongest in product(*slips):
        if np.any(np.diff(strongest) <= 0.0):
            continue  # the same cages in another sequence, or two that would never part
        resistances = pairs * inductances * np.array(strongest)
        family = np.log(np.concatenate([resistances, inductances], axis=1))
        squares = (table.residual(family) ** 2).sum(axis=-1)
        best = int(np.argmin(squares))
        candidates.append((float(squares[best]), family[best]))
    candidates.sort(key=lambda entry: entry[0])
    middle = np.concatenate([np.full(cages, pairs * breakdown_slip * leakage[0]), leakage])
    return np.log(middle), np.array([start for _, start in candidates[:STARTS]])


def _newton(table: FitTable, start: FloatArray) -> tuple[FloatArray, float]:
    """Newton steps on the gradient and the distance they leave; infinite where it is flat."""
    place, last = start, np.inf
    for _ in range(8):
        width = 1e-5
        shifts = width * np.eye(place.size)
        bend = np.array(
            [(table.gradient(place + s) - table.gradient(place - s)) / (2 * width) for s in shifts]
        )
        curvature, directions = np.linalg.eigh(0.5 * (bend + bend.T))
        if curvature[0] <= 1e-11 * curvature[-1]:
            return start, np.inf
        gradient = table.gradient(place)
        step = directions @ ((directions.T @ gradient) / curvature)
        size = np.abs(table.jacobian(place)).T @ (1.0 + np.abs(table.residual(place)))
        noise = 32.0 * EPSILON * float(np.linalg.norm(size)) / curvature[0]
        length = float(np.linalg.norm(step))
        if length > 0.5 * last or length > 0.1:
            return place, max(2.0 * length, noise)
        place, last = place - step, length
        if length <= noise:
            break
    return place, 2.0 * last + noise


# ----------------------------------------------------------------------------
# What has to be said next to a fitted motor, in words.
# ----------------------------------------------------------------------------

#: relative differences from the table that are worth a word
MISFIT = 0.05


def assumptions_of(
    motor: InductionMotor, inductance_assumed: bool, stator_share: float, no_load_ratio: float
) -> tuple[str, ...]:
    """What was held because a torque table does not tell it."""
    total = float(np.asarray(motor.stator_leakage) + np.asarray(motor.magnetising_inductance))
    given = (
        f"assumed: {no_load_ratio:g} times the leakage inductance from the breakdown torque"
        if inductance_assumed
        else "given"
    )
    return (
        f"stator inductance (leakage and magnetising) {total:.4g} H, {given}; it affects the "
        "transients, not the steady torque",
        f"stator leakage {stator_share:g} of the transient inductance, by convention; it affects "
        "neither torque nor stator current",
    )


def warnings_of(
    slip: FloatArray,
    relative: FloatArray,
    used: BoolArray,
    minimum: LeastSquares,
    known: Identifiability,
) -> tuple[str, ...]:
    """Misfit, rows left out, a cage that the table does not need, what the table does not tell."""
    said = []
    worst = int(np.argmax(np.where(used, np.abs(relative), -1.0)))
    if abs(relative[worst]) > MISFIT:
        said.append(
            f"the fitted motor misses the slip table by up to {100 * relative[worst]:+.1f} % (at a "
            f"slip of {in_rpm(slip[worst])})"
        )
    if not used.all():
        last = int(np.argmax(np.where(used, -1.0, np.abs(relative))))
        said.append(
            f"{int((~used).sum())} rows beyond the breakdown torque are not fitted; the motor "
            f"misses them by up to {100 * relative[last]:+.1f} % (at a slip of "
            f"{in_rpm(slip[last])})"
        )
    if minimum.at_bound or not np.isfinite(minimum.log_error):
        said.append(
            "the table does not settle every parameter of the cages: fewer cages would do as well"
        )
    if minimum.agreeing < 2:
        said.append(
            f"only one of {minimum.starts} searches ended in the minimum taken; "
            "another may be lower"
        )
    for exponents, spread, is_known in zip(
        known.combinations, known.spread, known.identifiable, strict=True
    ):
        if not is_known:
            words = product_of_powers(known.names, exponents)
            known_to = (
                "not identifiable from the slip table"
                if not np.isfinite(spread)
                else f"uncertain by a factor of {_factor(spread)} for 1 % error in the slip table"
            )
            said.append(f"{known_to}: {words}")
    return tuple(said)


def _factor(spread: float) -> str:
    """exp(spread), readable also where it would overflow."""
    power = spread / np.log(10.0)
    return f"{10.0**power:.2g}" if power < 3.0 else f"10^{power:.0f}"


# ----------------------------------------------------------------------------
# Parameters of an induction motor from a table of slip and torque.
#
# Torque alone does not give a motor: two of its numbers take no part in the steady torque at one
# voltage and one frequency. Where the leakage sits, in the stator or in the rotor, nothing at the
# shaft or the terminals can tell, ever (`induction_motor_split.py`). And, the resistance R of the
# stator being given, its inductance is not identifiable: with the impedance z seen behind R, the
# torque is V^2 (1 - |g|^2) / (4 R) to a factor, g = (z - R) / (z + R), and a turn of g by a
# constant angle maps motors on motors with other inductances and the same torque at every slip (own
# derivation; without R the inductance does not enter at all). Both are assumed and held, and said
# to be. The two numbers that are left for each cage are fitted in the form with all leakage in the
# rotor, by least squares of relative differences, from many starts, with Newton steps at the end.
# ----------------------------------------------------------------------------

#: stator inductance over the leakage that the breakdown torque shows; a motor of some ten kilowatts
#: and several poles then draws about a third of its rated current without load
NO_LOAD_RATIO = 10.0
#: of the transient inductance; in motors of design B two fifths are commonly put into the stator
#: (IEEE Standard 112)
STATOR_SHARE = 0.4


class MotorFit(NamedTuple):
    """A motor fitted to a table, and how well.

    `motor` has the cage with the lowest R / l first. `slip` (rows,) in rad/s and `table`, `torque`
    and `residual` = torque - table in N m cover every row with a slip above 0; `used` says which
    were fitted (those up to the largest torque for one cage). `worst_relative` and `rms_relative`
    are of residual / table over the fitted rows. `log_error` bounds the error of the logarithms
    of the fitted parameters as the minimum of the sum of squares (not as the truth of the
    machine, which is shown by `identifiability`); infinite where that minimum is a flat valley.
    `starts` searches ran, of which `agreeing` ended in the best minimum.
    """

    motor: InductionMotor
    slip: FloatArray
    table: FloatArray
    torque: Bounded
    residual: FloatArray
    used: BoolArray
    worst_relative: float
    rms_relative: float
    log_error: float
    starts: int
    agreeing: int
    identifiability: Identifiability
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]


def fit_induction_motor(
    slip: ArrayLike,
    torque: ArrayLike,
    *,
    line_frequency: float,
    pole_pairs: int,
    phase_voltage: float,
    stator_resistance: float,
    cages: int = 2,
    stator_inductance: float | None = None,
    stator_share: float = STATOR_SHARE,
) -> MotorFit:
    """Fit a motor with one, two or three cages to a table of its steady torque.

    Parameters
    ----------
    slip, torque
        (rows,) in rad/s, rising, 0 or above, and in N m, above 0 where the slip is. A row with slip
        0 is met by any motor and left out.
    line_frequency, pole_pairs, phase_voltage, stator_resistance
        As in `InductionMotor`: rad/s, number, peak V of the star, ohm per phase.
    cages
        2: all rows are fitted. 1: those up to the largest torque; one cage cannot have both the
        breakdown and the locked-rotor torque of most motors. 3: as 2; the third stands for the
        crowding of the current in deep bars near standstill.
    stator_inductance
        Leakage plus magnetising inductance, H. Held. Default: `NO_LOAD_RATIO` times
        3 p V^2 / (4 w^2 T), the leakage of a motor without stator resistance whose breakdown torque
        is the largest T of the table.
    stator_share
        Stator leakage over transient inductance, 0 to below 1. Held; changes neither torque nor
        stator current, at no time.

    Raises
    ------
    NumericalFailure
        Fewer rows than the two parameters for each cage, or no search ends in a minimum.
    """
    all_slips, all_torques = np.asarray(slip, dtype=float), np.asarray(torque, dtype=float)
    loaded = all_slips > 0.0
    slips, table = all_slips[loaded], all_torques[loaded]
    if table.size == 0 or not np.all(table > 0.0):
        raise NumericalFailure("a motor is fitted to torques above 0 at slips above 0")
    top = int(np.argmax(table))
    used = np.ones(table.size, dtype=bool) if cages > 1 else np.arange(table.size) <= top
    if used.sum() < 2 * cages:
        raise NumericalFailure(
            f"the table has {used.sum()} rows to fit and the motor {2 * cages} parameters"
        )
    leakage = 3.0 * pole_pairs * phase_voltage**2 / (4.0 * line_frequency**2 * table[top])
    inductance = NO_LOAD_RATIO * leakage if stator_inductance is None else stator_inductance
    bare = InductionMotor(
        line_frequency, pole_pairs, phase_voltage, stator_resistance, 0.0, inductance,
        np.full(cages, stator_resistance), np.full(cages, leakage),
    )  # fmt: skip
    minimum = best_start(bare, slips[used], table[used], slips[top])
    resistance, rotor_leakage = np.exp(minimum.logarithms).reshape(2, cages)
    gathered = bare._replace(rotor_resistance=resistance, rotor_leakage=rotor_leakage)
    share = stator_share * transient_inductance(gathered)
    motor = with_stator_leakage(gathered, share)
    fitted = steady_torque(motor, slips)
    residual = fitted.value - table
    relative = (residual / table)[used]
    known = identifiability(motor, slips[used])
    return MotorFit(
        motor=motor,
        slip=slips,
        table=table,
        torque=fitted,
        residual=residual,
        used=used,
        worst_relative=float(np.max(np.abs(relative))),
        rms_relative=float(np.sqrt(np.mean(relative**2))),
        log_error=minimum.log_error,
        starts=minimum.starts,
        agreeing=minimum.agreeing,
        identifiability=known,
        assumptions=assumptions_of(motor, stator_inductance is None, stator_share, NO_LOAD_RATIO),
        warnings=warnings_of(slips, residual / table, used, minimum, known),
    )

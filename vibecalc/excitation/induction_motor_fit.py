"""Parameters of an induction motor from a table of slip and torque.

Torque alone does not give a motor: two of its numbers take no part in the steady torque at one
voltage and one frequency. Where the leakage sits, in the stator or in the rotor, nothing at the
shaft or the terminals can tell, ever (`induction_motor_split.py`). And, the resistance R of the
stator being given, its inductance is not told: with the impedance z seen behind R, the torque is
V^2 (1 - |g|^2) / (4 R) to a factor, g = (z - R) / (z + R), and a turn of g by a constant angle maps
motors on motors with other inductances and the same torque at every slip (own derivation; without
R the inductance does not enter at all). Both are assumed and held, and said to be. The two numbers
that are left for each cage are fitted in the form with all leakage in the rotor, by least squares
of relative differences, from many starts, with Newton steps at the end.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor, steady_torque
from vibecalc.excitation.induction_motor_identify import Identifiability, identifiability
from vibecalc.excitation.induction_motor_remarks import assumptions_of, warnings_of
from vibecalc.excitation.induction_motor_search import best_start
from vibecalc.excitation.induction_motor_split import transient_inductance, with_stator_leakage
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import BoolArray, FloatArray

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
    machine, which is told by `identifiability`); infinite where that minimum is a flat valley.
    `starts` searches ran, of which `agreeing` ended in the best minimum.
    """

    motor: InductionMotor
    slip: FloatArray
    table: FloatArray
    torque: WithError
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
    weight: ArrayLike = 1.0,
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
    weight
        Of the squared relative difference of each row.
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
    weights = np.broadcast_to(np.asarray(weight, dtype=float), all_slips.shape)[loaded]
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
    found = best_start(bare, slips[used], table[used], weights[used], slips[top])
    resistance, rotor_leakage = np.exp(found.logarithms).reshape(2, cages)
    gathered = bare._replace(rotor_resistance=resistance, rotor_leakage=rotor_leakage)
    share = stator_share * transient_inductance(gathered)
    motor = with_stator_leakage(gathered, share)
    fitted = steady_torque(motor, slips)
    residual = fitted.value - table
    relative = (residual / table)[used]
    told = identifiability(motor, slips[used], weights[used])
    return MotorFit(
        motor=motor,
        slip=slips,
        table=table,
        torque=fitted,
        residual=residual,
        used=used,
        worst_relative=float(np.max(np.abs(relative))),
        rms_relative=float(np.sqrt(np.mean(relative**2))),
        log_error=found.log_error,
        starts=found.starts,
        agreeing=found.agreeing,
        identifiability=told,
        assumptions=assumptions_of(motor, stator_inductance is None, stator_share, NO_LOAD_RATIO),
        warnings=warnings_of(slips, residual / table, used, found, told),
    )

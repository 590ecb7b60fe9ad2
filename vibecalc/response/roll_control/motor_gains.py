"""Another motor and no controller: what its torque per slip does to speed and levels."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.response.roll_control.evaluate import Controlled, Load, evaluate
from vibecalc.response.roll_control.model import Controller, ReducedModel

#: the motor fed at constant speed of its field: u = R
UNCONTROLLED = Controller(gain=1.0, speed_feedback=0.0, acceleration_feedback=0.0)


def motor_gain_study(model: ReducedModel, motor_gains: ArrayLike, load: Load) -> Controlled:
    """Speed and levels for `motor_gains` (m,) in N m s/rad: Herold 1977, Table 8, Fig. 27.

    The speed is R + d_0 / K_M, with R the synchronous speed and d_0 negative. Eq. 114 prints
    203.4 / K_M in place of 303.3 / K_M; the table was computed with the latter. The torque
    d(t) is taken as it is at one speed, though the speed moves a little with the motor.
    """
    return evaluate(model._replace(motor_gain=np.asarray(motor_gains)), UNCONTROLLED, load)

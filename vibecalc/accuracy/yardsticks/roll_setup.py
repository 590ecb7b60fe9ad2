"""The roll machine of a case with its running state: what every way to that state is told."""

from math import ceil, log
from typing import NamedTuple

import numpy as np

from vibecalc.machine.roll import build_roll, roll_drive
from vibecalc.machine.roll_motor import fitted_motor
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.pipeline.scene import Scene
from vibecalc.response.roll.machine import RollDrive, RollMachine, as_batch, is_mounted
from vibecalc.response.roll.readings import readings
from vibecalc.response.roll.running import Running, running_state
from vibecalc.response.roll.steady import started_momentum
from vibecalc.response.roll.turn import Turn, harmonics

#: what is left of a disturbance when a march counts as settled
_FADED = 1e-12
#: Gauss points on each panel of the mean demand (`demand.py`)
_DEMAND = 4


class RollSetup(NamedTuple):
    """One machine, alone and as a batch of one (B = 1), and what its marches begin with.

    `momentum` (1,) N m s is that of a free machine; `speed` and `shell_speed`, rad/s, have it at
    crank angle zero; `turns` is how many turns a march takes until 1e-12 of a disturbance is left.
    """

    alone: RollMachine
    machine: RollMachine
    drive: RollDrive
    running: Running
    started_at: float | None
    momentum: FloatArray
    speed: float
    shell_speed: float
    turns: int
    orders: FloatArray
    rtol: float
    points: int | None

    @property
    def mounted(self) -> bool:
        """Whether the shell is held to the ground."""
        return is_mounted(self.machine)

    @property
    def panels(self) -> int:
        """Panels between the kinks that hang on the crank angle alone."""
        return int(np.asarray(self.running.state.problem.edges).shape[-1]) - 1

    @property
    def demand_work(self) -> int:
        """Crank angles at which the mean demand is taken, which every quick start needs."""
        return _DEMAND * self.panels


def roll_setup(scene: Scene) -> RollSetup:
    """The machine of [response.roll] and its running state at the tolerance of the case."""
    case = scene.case
    assert case.response is not None and case.response.roll is not None
    options, parts = case.response.roll, build_roll(case)
    drive, machine = roll_drive(parts), as_batch(parts.machine)
    fitted = fitted_motor(parts.motor)
    if fitted is not None:
        drive = drive._replace(circuit=fitted.circuit)
    points = options.points if options.method == "collocation" else None
    running = running_state(
        machine, drive, rtol=case.accuracy.rtol, orders=options.orders,
        started_at=options.started_at, points=points, course=True,
    )  # fmt: skip
    fading = max(float(np.max(np.abs(running.multiplier))), 1e-12)
    turns = 1 + ceil(log(_FADED) / log(fading))
    momentum, speed, shell = running.state.momentum, options.started_at, 0.0
    if speed is None:
        need = running.state.demand
        speed = float(np.max(drive.synchronous_speed) - np.max(need.slip))
        if not is_mounted(machine):
            still = float(started_momentum(machine, speed)[0])
            whole = float(machine.shell_inertia[0] + machine.rotor_inertia[0])
            shell = (float(momentum[0]) - still) / whole
    return RollSetup(
        parts.machine, machine, drive, running, options.started_at, momentum, speed, shell,
        turns, np.arange(1.0, options.orders + 1), case.accuracy.rtol, points,
    )  # fmt: skip


def spectrum(
    setup: RollSetup, turn: Turn, shell_acceleration: FloatArray | None = None
) -> ComplexArray:
    """Harmonics (orders,) of the shell's acceleration, rad/s^2, complex 0-to-peak, of a turn."""
    if shell_acceleration is None:
        read = readings(setup.machine, setup.drive, turn, pistons=False)
        shell_acceleration = read.shell_acceleration
    return np.asarray(harmonics(turn, shell_acceleration, setup.orders)[0])

"""Levels, lags and loads that the program of Herold (1977) gives, and those that he printed."""

from functools import cache

import numpy as np
from herold_simulation import Simulation, hexadecimal, open_tables, simulate
from roll_machines import (
    FIRST_MASS,
    ROTOR,
    RPM,
    SHELL,
    SYNCHRONOUS,
    columns,
    source_drive,
    source_machine,
)

from vibecalc.roll.mechanism import gas_forces, gas_torque, inertia

#: harmonics 1 to 10 of appendix A: levels in dB against 1 rad/s^2, lags in rad
LEVELS = np.array([4.3, 8.9, 0.2, 0.4, -22.2, -15.0, -18.2, -20.0, -25.1, -26.6])
LAGS = np.array([0.957, 3.789, 1.153, 3.492, 1.815, 0.455, 3.616, 6.156, 3.203, 4.455])
#: Table 7, equal pressure forces
EQUAL_FORCES = np.array([-38.7, 4.2, -50.1, -0.4, -42.0, -25.7, -53.2, -22.9, -59.2, -26.2])


@cache
def program(single: bool = False) -> Simulation:
    """The program on the machine of the source, in double or in the source's single precision."""
    rounded = {"rounded": hexadecimal} if single else {}
    return simulate(source_machine(), open_tables(source_drive()), **rounded)


def changed(**fields: object) -> np.ndarray:
    """Levels of a changed machine less those of the best estimate, dB."""
    drive = open_tables(source_drive())
    return simulate(source_machine(**fields), drive).level - program().level


@cache
def equal_pressure(single: bool = False) -> np.ndarray:
    """First stage's forces and weight (104.7 N) on both sides, straight lines between nodes."""
    machine = source_machine(reciprocating_mass=[FIRST_MASS, FIRST_MASS])
    rounded = {"rounded": hexadecimal} if single else {}
    return simulate(machine, source_drive("linear", equal=True), **rounded).level


def disturbance(speed: float, **curves: str) -> np.ndarray:
    """Harmonics 0, 1, 2 of the torque of gas and pistons on a rotor of that constant speed.

    As A_n + i B_n of equation 95 and 96: an angle of equation 94 lags.
    """
    machine, drive = source_machine(), source_drive(**curves)
    drive = drive if curves else open_tables(drive)
    angle = (np.arange(7200) + 0.5) * 2.0 * np.pi / 7200
    moved = inertia(machine, angle)
    torque = gas_torque(moved, gas_forces(machine, drive, angle))
    torque = torque - 0.5 * moved.crank_slope * speed**2
    return np.array([np.mean(torque * np.exp(1j * n * angle)) * (2 if n else 1) for n in range(3)])


def reduced(gain: float | None) -> np.ndarray:
    """Levels of the reduced model of section 7.1: torque over the angle at the mean speed.

    I_R w dw/db = motor + torque(b), and the shell takes it by I_R / I_S; with the motor's whole
    table or with a gain in N m s/rad. Runge and Kutta's rule over four turns.
    """
    machine, drive, speed, count = source_machine(), source_drive(), 92.97, 1440
    angle = np.arange(2 * count) * np.pi / count
    moved = inertia(machine, angle)
    torque = gas_torque(moved, gas_forces(machine, drive, angle))
    torque = (torque - 0.5 * moved.crank_slope * speed**2).tolist()
    slip, height = (x.tolist() for x in columns("roll_motor.csv"))

    def motor(w: float) -> float:
        away = SYNCHRONOUS - w
        if gain is not None:
            return gain * away
        return float(np.copysign(np.interp(abs(away) / RPM, slip, height), away))

    h, w, rows = 2.0 * np.pi / count, speed, []
    for turn in range(4):
        for i in range(count):
            load = torque[2 * i], torque[2 * i + 1], torque[(2 * i + 2) % (2 * count)]
            if turn == 3:
                rows.append((w, motor(w) + load[0]))
            k1 = (motor(w) + load[0]) / (ROTOR * w)
            w2 = w + 0.5 * h * k1
            k2 = (motor(w2) + load[1]) / (ROTOR * w2)
            w3 = w + 0.5 * h * k2
            k3 = (motor(w3) + load[1]) / (ROTOR * w3)
            w4 = w + h * k3
            k4 = (motor(w4) + load[2]) / (ROTOR * w4)
            w += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    speeds, driving = np.array(rows).T
    spent = h / speeds
    time = np.concatenate([[0.0], np.cumsum(0.5 * (spent[1:] + spent[:-1]))])
    phase = 2.0 * np.pi * time / np.sum(spent)
    shell = -driving / SHELL
    turned = np.exp(1j * np.arange(1, 11)[:, None] * phase)
    return 20.0 * np.log10(np.abs(turned @ (shell * spent)) * 2.0 / np.sum(spent))

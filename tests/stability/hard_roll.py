"""Hard cases of a rotor, its pistons and their shell under a motor.

Herold (1977). The asked numbers are harmonics 1 to 10 of the shell's acceleration, relative to
the largest of them. Truth: 18 Gauss points on short panels, which DOP853 meets to 1e-12.
"""

from functools import cache

import mpmath
import numpy as np
from exact_roll import exact_harmonics, exact_turn
from roll_machines import RADIUS, ROTOR, SYNCHRONOUS, source_drive, source_machine
from stability.hard_case import HardCase, Numbers, Way, singular

from vibecalc.numerics.bounded import Bounded
from vibecalc.roll.march import march_to_repeat
from vibecalc.roll.mechanism import RollDrive, RollMachine
from vibecalc.roll.rates import RollRates, shell_speed
from vibecalc.roll.running import running_state
from vibecalc.roll.steady import started_momentum, steady_state
from vibecalc.roll.turn import Turn, harmonics, readings, rounding_left

SMOOTH = {"gas": "cubic", "motor": "monotone"}
OFFSET = {"wrist_pin_offset": 0.012, "rod_inertia_difference": [-0.02, -0.01]}
#: fields of the machine, curves, Gauss points on a panel
CASES = {
    "rod of 1.01 radii": ({"rod_length": RADIUS / 0.99}, {}, 16),
    "shell of 5": ({"shell_inertia": 5.0}, {}, 10),
    "shell of 0.001": ({"shell_inertia": 0.001}, {}, 10),
    "half as much gas again": ({"gas_scale": [1.5, 1.5]}, {}, 10),
    "offset": (OFFSET | {"crank_angle_offset": [0.3, 2.7]}, SMOOTH, 10),
    "friction": (OFFSET | {"piston_friction": 120.0, "friction_damping": 0.2}, {}, 10),
    "rotor of 0.05": ({"rotor_inertia": 0.05}, {}, 14),
    "rotor of 0.3": ({"rotor_inertia": 0.3}, {}, 10),
    "rotor of 200": ({"rotor_inertia": 200.0}, {}, 10),
    "rod of 1.1 radii": ({"rod_length": RADIUS / 0.9}, {}, 14),
    "rotor of 0.1": ({"rotor_inertia": 0.1}, {}, 14),
    "trigonometric": ({}, {"gas": "trigonometric", "motor": "monotone"}, 10),
}
ORDERS = np.arange(1.0, 11.0)
ODD = np.arange(1.0, 11.0, 2.0)
NAME = "shell_acceleration"


def boxed(fields: dict[str, object], curves: dict[str, str]) -> tuple[RollMachine, RollDrive]:
    """The machine as a batch of one."""
    arrays = {k: v if np.ndim(v) else [v] for k, v in ({"rotor_inertia": ROTOR} | fields).items()}
    return source_machine(**arrays), source_drive(
        **curves, synchronous_speed=np.full(1, SYNCHRONOUS)
    )


def spectrum(machine: RollMachine, drive: RollDrive, turn: Turn, orders: np.ndarray) -> np.ndarray:
    return harmonics(turn, readings(machine, drive, turn).shell_acceleration, orders)[0]


def own(machine: RollMachine, drive: RollDrive, orders: np.ndarray, started: float | None
        ) -> Bounded:  # fmt: skip
    """As the stage does it: two numbers of points, their difference and what rounding leaves."""
    found = running_state(machine, drive, rtol=1e-9, orders=10, started_at=started)
    turn = found.state.turn
    value = spectrum(machine, drive, turn, orders)
    other = spectrum(machine, drive, found.check.turn, orders)
    rounding = rounding_left(machine, readings(machine, drive, turn), NAME)
    return Bounded(value, np.abs(value - other) + rounding)


def marched(method: str, orders: np.ndarray, fields: dict[str, object], drive: RollDrive,
            **settings: float) -> np.ndarray:  # fmt: skip
    machine = source_machine(**fields)
    found = march_to_repeat(machine, drive, method, started_at=SYNCHRONOUS, **settings)  # type: ignore[arg-type]
    there = {name: np.asarray(part)[None] for name, part in found.turn._asdict().items()
             if part is not None}  # fmt: skip
    return harmonics(Turn(**there), found.shell_acceleration[None], orders)[0]


def newton(machine: RollMachine, drive: RollDrive, orders: np.ndarray) -> np.ndarray:
    """Whole Newton steps from the synchronous speed, Fourier collocation at 181 angles."""
    points = 181
    momentum = started_momentum(machine, SYNCHRONOUS)
    rates = RollRates(machine, drive, momentum)
    x = 2.0 * np.pi * np.arange(points) / points
    step = x[:, None] - x
    sine = np.where(step == 0.0, 1.0, np.sin(0.5 * step))
    sign = (-1.0) ** (np.arange(points)[:, None] + np.arange(points))
    matrix = np.where(step == 0.0, 0.0, 0.5 * sign / sine)
    speed = np.full(points, SYNCHRONOUS)
    for _ in range(30):
        value, slope = rates(x[None, None], speed[None, None, :, None], None)
        if not np.all(np.isfinite(value)):
            raise ArithmeticError("a negative speed")
        move = np.linalg.solve(matrix - np.diag(slope.ravel()), value.ravel() - matrix @ speed)
        speed = speed + move
        if np.max(np.abs(move)) < 1e-10 * SYNCHRONOUS:
            break
    else:
        raise ArithmeticError("no convergence")
    wave = np.fft.rfft(1.0 / speed)
    wave[1:] /= 1j * np.arange(1, len(wave))
    period = 2.0 * np.pi * wave[0].real / points
    wave[0] = 0.0
    time = period / (2.0 * np.pi) * x + np.fft.irfft(wave, points)
    weight = np.full((1, points), 2.0 * np.pi / points)
    crank = speed[None]
    shell = shell_speed(rates.place(x[None, None]), momentum, crank)
    turn = Turn(x[None], weight, (time - time[0])[None], crank, shell, 0.0 * shell,
                np.array([period]))  # fmt: skip
    return spectrum(machine, drive, turn, orders)


@cache
def truth_of(name: str) -> Numbers:
    """18 points on panels of .05 rad; a long test holds it to `second_truth`."""
    machine, drive = boxed(*CASES[name][:2])
    fine = steady_state(machine, drive, 18, started_at=SYNCHRONOUS, widest=0.05)
    return [mpmath.mpmathify(complex(one)) for one in spectrum(machine, drive, fine.turn, ORDERS)]


def second_truth(name: str) -> np.ndarray:
    """DOP853 from one smooth piece of the equations to the next."""
    fields, curves, _ = CASES[name]
    exact = exact_turn(source_machine(**fields), source_drive(**curves), started_at=SYNCHRONOUS,
                       rtol=3e-14, longest=0.02)  # fmt: skip
    return exact_harmonics(exact, exact.shell_acceleration, ORDERS)


def condition(name: str) -> float:
    fields, curves, points = CASES[name]
    return sensitivity(*boxed(fields, curves), points, SYNCHRONOUS)


def sensitivity(machine: RollMachine, drive: RollDrive, points: int, started: float | None
                ) -> float:  # fmt: skip
    """By a change of gas, rotor, shell, masses and motor, each by itself."""

    def values(changed: RollMachine) -> np.ndarray:
        found = steady_state(changed, drive, points, started_at=started)
        return spectrum(changed, drive, found.turn, ORDERS)

    base, part, total = values(machine), 1e-6, 0.0
    for field in ("gas_scale", "rotor_inertia", "shell_inertia", "reciprocating_mass",
                  "motor_scale"):  # fmt: skip
        moved = values(machine._replace(**{field: getattr(machine, field) * (1.0 + part)}))
        total += float(np.max(np.abs(moved - base)) / np.max(np.abs(base)) / part)
    return total


def running(name: str, words: str) -> HardCase:
    fields, curves, _ = CASES[name]
    machine, drive = boxed(fields, curves)
    size = float(
        np.max(
            np.abs(
                spectrum(
                    machine,
                    drive,
                    steady_state(machine, drive, 8, started_at=SYNCHRONOUS).turn,
                    ORDERS,
                )
            )
        )
    )
    return HardCase(
        words, lambda: condition(name), lambda: truth_of(name),
        lambda: own(machine, drive, ORDERS, SYNCHRONOUS),
        (Way("Euler .5 ms, third turn, as published", lambda: marched(
            "euler", ORDERS, fields, source_drive(**curves), turns=3)),
         Way("Runge-Kutta .5 ms until a turn repeats to 1 %", lambda: marched(
             "rk4", ORDERS, fields, source_drive(**curves), repeats=1e-2)),
         Way("Newton from constant speed, 181 angles", lambda: newton(machine, drive, ORDERS),
             loose=True)),
        scale=size,
    )  # fmt: skip


def equal_stages() -> HardCase:
    fields: dict[str, object] = {"reciprocating_mass": [10.0, 10.0]}

    machine, _ = boxed(fields, {})
    drive = source_drive(equal=True, synchronous_speed=np.full(1, SYNCHRONOUS))
    even = spectrum(
        machine, drive, steady_state(machine, drive, 8, started_at=SYNCHRONOUS).turn, ORDERS
    )
    return HardCase(
        "equal stages and masses: the odd harmonics are zero", singular,
        lambda: [mpmath.mpf(0)] * len(ODD), lambda: own(machine, drive, ODD, SYNCHRONOUS),
        (Way("Euler .5 ms, third turn, as published",
             lambda: marched("euler", ODD, fields, source_drive(equal=True), turns=3)),),
        scale=float(np.max(np.abs(even))),
    )  # fmt: skip


def overloaded() -> HardCase:
    fields: dict[str, object] = {"gas_scale": [3.5, 3.5]}
    machine, drive = boxed(fields, {})
    return HardCase(
        "gas times 3.5: the demand is above the breakdown torque", singular,
        None, lambda: own(machine, drive, ORDERS, SYNCHRONOUS),
        (Way("Newton from constant speed, 181 angles", lambda: newton(machine, drive, ORDERS)),
         Way("Euler .5 ms, third turn, as published",
             lambda: marched("euler", ORDERS, fields, source_drive(), turns=3))),
    )  # fmt: skip


def mounted() -> HardCase:
    """Its start-up dies away with 2 J / c = 5 s, some seventy turns."""
    fields: dict[str, object] = {"shell_stiffness": 3e4, "shell_damping": 60.0}
    machine, drive = boxed({k: [v] for k, v in fields.items()}, {})

    @cache
    def truth() -> Numbers:
        fine = steady_state(machine, drive, 20, widest=0.05)
        return [mpmath.mpmathify(complex(one))
                for one in spectrum(machine, drive, fine.turn, ORDERS)]  # fmt: skip

    size = float(
        np.max(np.abs(spectrum(machine, drive, steady_state(machine, drive, 8).turn, ORDERS)))
    )
    return HardCase(
        "soft mounts: the start-up lasts for a hundred turns",
        lambda: sensitivity(machine, drive, 8, None), truth,
        lambda: own(machine, drive, ORDERS, None),
        (Way("Euler .5 ms, third turn, as published",
             lambda: marched("euler", ORDERS, fields, source_drive(), turns=3)),
         Way("Runge-Kutta .5 ms until a turn repeats to 1 %",
             lambda: marched("rk4", ORDERS, fields, source_drive(), repeats=1e-2))),
        scale=size,
    )  # fmt: skip


def cases() -> tuple[HardCase, ...]:
    return (
        equal_stages(),
        running("rotor of 0.3", "rotor of .3 kg m^2: the slip goes to breakdown"),
        running("rotor of 0.1", "rotor of .1 kg m^2"),
        running("rotor of 0.05", "rotor of .05 kg m^2"),
        running("rotor of 200", "rotor of 200 kg m^2: slow to settle"),
        running("rod of 1.1 radii", "R/L = .9"),
        running("rod of 1.01 radii", "R/L = .99"),
        running("shell of 5", "shell of 5 kg m^2"),
        running("half as much gas again", "gas times 1.5"),
        overloaded(),
        mounted(),
    )  # fmt: skip

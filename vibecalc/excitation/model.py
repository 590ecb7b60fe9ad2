"""The cylinders of an engine or a pump as arrays: when they work, with what pressure."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vibecalc.excitation import pressure_cycle as pump_cycle
from vibecalc.excitation.gas_tables import GasCard, GasForce, card_of_force, gas_card, gas_force
from vibecalc.excitation.pressure_cycle import Liquid
from vibecalc.kinematics.slider_crank import stroke
from vibecalc.parts.crank_train import crank_geometry
from vibecalc.parts.firing import TURN, angles_in_order, cycle_angle
from vibecalc.parts.geometry import CrankGeometry
from vibecalc.schema import Case, Machine

if TYPE_CHECKING:
    from vibecalc.excitation.cylinder_torque import CylinderTorque
    from vibecalc.excitation.pressure_cycle import PressureCycle
    from vibecalc.parts.gas_tables import GasPressure

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Firing:
    """c cylinders in the order of the crank train; angles in rad.

    `angle` (c,), from 0 to below `cycle`, is the crank angle at which each fires, counted from the
    firing position of the first cylinder in the firing order; `first` is where that one stands on
    the angle from which crank phases count. `pressure_scale` (c,) multiplies the gas pressure of
    each; `fires` (c,) is false for those that the case lets misfire; `bank` (c,) is the bank
    angle.
    """

    names: tuple[str, ...]
    angle: Array
    first: float
    cycle: float
    pressure_scale: Array
    fires: NDArray[np.bool_]
    bank: Array


def firing_angle(machine: Machine) -> Array:
    """Crank angle (c,) at which each cylinder fires, rad, from 0 to below a cycle.

    It counts as crank phases do: a throw that leads by its phase fires so much earlier.
    """
    first, angle = firing_sequence(machine)
    return np.asarray(np.mod(first + angle, cycle_angle(machine)))


def firing_sequence(machine: Machine) -> tuple[float, Array]:
    """Crank angle of the first firing, and those of all cylinders (c,) from there on, rad.

    In the order of firing from the dead centre of the first of it on, or, without an order, as
    said, or, of a two-stroke or a single cylinder, at its dead centre; the earliest is then first.
    """
    train = machine.crank_train
    cycle = cycle_angle(machine)
    given = [cylinder.firing_angle for cylinder in train.cylinders]
    top = {c.name: (c.bank_angle - c.crank_phase) % TURN for c in train.cylinders}
    top = {name: 0.0 if TURN - angle < 1e-9 else angle for name, angle in top.items()}
    if train.firing_order:
        angle_of = angles_in_order(train.firing_order, train.firing_intervals, cycle, 0.0)
        angles = np.array([angle_of[cylinder.name] for cylinder in train.cylinders])
        return top[train.firing_order[0]], np.asarray(np.mod(angles, cycle))
    found = [
        top[cylinder.name] if angle is None else angle
        for cylinder, angle in zip(train.cylinders, given, strict=True)
    ]
    angles = np.mod(found, cycle)
    return float(angles.min()), angles - angles.min()


def build_firing(case: Case) -> Firing:
    """When the cylinders of a validated engine fire."""
    machine = case.machine
    torsion = None if case.response is None else case.response.torsion
    silent = () if torsion is None else torsion.misfire
    cylinders = machine.crank_train.cylinders
    first, angle = firing_sequence(machine)
    return Firing(
        names=tuple(cylinder.name for cylinder in cylinders),
        angle=angle,
        first=first,
        cycle=cycle_angle(machine),
        pressure_scale=np.array(
            [1.0 if c.pressure_scale is None else c.pressure_scale for c in cylinders]
        ),
        fires=np.array([cylinder.name not in silent for cylinder in cylinders]),
        bank=np.array([cylinder.bank_angle for cylinder in cylinders]),
    )


def gas_cards(machine: Machine) -> tuple[Array, tuple[GasCard, ...]]:
    """Speeds (k,) in rad/s, ascending, and the card at each; one card for all speeds has none.

    Raises NumericalFailure where a cycle of such a peak or mean pressure does not exist.
    """
    train, geometry = machine.crank_train, crank_geometry(machine.crank_train)
    how = train.gas_interpolation or "linear"

    def read(table: "GasPressure") -> GasCard:
        return gas_card(table.crank_angle, table.pressure, how, cycle=cycle_angle(machine))

    cards = sorted(train.gas_cards, key=lambda card: card.speed)
    speeds = np.array([card.speed for card in cards])
    if cards:
        return speeds, tuple(read(card.gas_pressure) for card in cards)
    if train.gas_pressure is not None:
        return speeds, (read(train.gas_pressure),)
    if (given := train.gas_cycle) is not None:
        targets = given.peak_pressure, given.mean_indicated_pressure
        return speeds, (_computed(cycle_of(machine), geometry, *targets),)
    return speeds, () if train.pump_cycle is None else (pump_card(machine),)


def has_cards(machine: Machine) -> bool:
    """Whether one card stands for what is in all cylinders; else each has a curve over a turn."""
    return machine.kind in ("engine", "pump")


def force_curves(machine: Machine) -> list[GasForce | None]:
    """Force of the gas on each piston over its own turn: its own, or that of the common pressure.

    None for a cylinder without any.
    """
    train = machine.crank_train
    how, common = train.gas_interpolation or "linear", train.gas_pressure
    area, curves = crank_geometry(machine.crank_train).piston_area, list[GasForce | None]()
    for cylinder in train.cylinders:
        given = cylinder.gas_force
        if given is not None:
            curves.append(gas_force(given.crank_angle, given.force, how))
        elif common is not None:
            force = area * np.asarray(common.pressure)
            curves.append(gas_force(common.crank_angle, force, how))
        else:
            curves.append(None)
    return curves


def gas_of_cylinders(case: Case) -> tuple[Array, list[tuple[tuple[GasCard, ...], Array]]]:
    """Speeds (k,) in rad/s of the cards, none where they hold at all; the gas of cylinders that
    work: cards, one for each speed, with the area (c,) of the pistons that they act on in m^2.

    They are cards of an engine, and of those of its cylinders that misfire, the liquid of a pump, a
    pressure or force over a turn of a compressor as force on 1 m^2, or nothing. Raises
    NumericalFailure where a cycle of such a peak or mean pressure does not exist.
    """
    machine, firing = case.machine, build_firing(case)
    working = None if case.excitation is None else case.excitation.working
    runs = np.array([working is None or name in working for name in firing.names], dtype=float)
    if not has_cards(machine):
        each, curves = np.diag(runs), enumerate(force_curves(machine))
        own = [(card_of_force(one), i) for i, one in curves if one is not None and runs[i]]
        return np.zeros(0), [((card,), each[i]) for card, i in own]
    speeds, cards = gas_cards(machine)
    area = crank_geometry(machine.crank_train).piston_area * runs * firing.pressure_scale
    given = (cards, area * firing.fires), (misfire_cards(case, cards), area * ~firing.fires)
    return speeds, [group for group in given if group[0]]


def motored_cards(machine: Machine, cards: Sequence[GasCard]) -> tuple[GasCard, ...]:
    """Cards of a cylinder without combustion, for those of one that fires."""
    if machine.crank_train.gas_cycle is None:
        from vibecalc.excitation.cylinder_torque import motored_card

        return tuple(motored_card(card, crank_geometry(machine.crank_train)) for card in cards)
    from vibecalc.excitation.pressure_cycle import motored_cycle

    return (motored_cycle(cycle_of(machine), crank_geometry(machine.crank_train)),)


def misfire_cards(case: Case, cards: Sequence[GasCard]) -> tuple[GasCard, ...]:
    """Cards of the cylinders that the case lets misfire: motored ones, or () without gas in them.

    () also where all of them fire.
    """
    torsion = None if case.response is None else case.response.torsion
    if torsion is None or not torsion.misfire or torsion.misfire_kind != "motored":
        return ()
    return motored_cards(case.machine, cards)


def with_tangential_effort(
    machine: Machine, torque: "CylinderTorque"
) -> tuple[Array, "CylinderTorque"]:
    """Speeds (k,) in rad/s, and the torque of a cylinder with gas (k, m) out of the maker's table.

    One mean indicated pressure for all speeds has none. The table is of the gas alone: the torque
    of the masses stays. Raises NumericalFailure for a load that is not inside the table.
    """
    from vibecalc.excitation.tangential_effort import effort_table, effort_torque

    given = machine.crank_train.tangential_effort
    assert given is not None
    geometry = crank_geometry(machine.crank_train)
    rows, over_speed = given.harmonics, given.over_speed
    if over_speed is not None:
        speed, load = over_speed.speed, over_speed.mean_indicated_pressure
    else:
        assert given.mean_indicated_pressure is not None
        speed, load = (), (given.mean_indicated_pressure,)
    found = effort_torque(
        effort_table(rows.mean_indicated_pressure, rows.order, rows.cosine, rows.sine),
        speed,
        load,
        torque.order,
        lever=geometry.piston_area * geometry.crank_radius,
        swept_volume=geometry.piston_area * stroke(*geometry[:2], geometry.wrist_pin_offset),
        cycle=cycle_angle(machine),
    )
    return found.speed, torque._replace(gas=found.gas, mean=found.mean)


def cycle_of(machine: Machine) -> "PressureCycle":
    """The computed cycle of an engine, with usual values for what the case does not say."""
    from vibecalc.excitation.pressure_cycle import usual_cycle

    given = machine.crank_train.gas_cycle
    assert given is not None
    targets = {"kind", "peak_pressure", "mean_indicated_pressure"}
    said = given.model_dump(exclude_none=True, exclude=targets)
    return usual_cycle(given.kind, machine.cycle or "four_stroke", **said)


# checks and several stages ask for the same one, and it takes longer than most of what they do
@lru_cache(maxsize=16)
def _computed(
    cycle: "PressureCycle", geometry: CrankGeometry, peak: float | None, mean: float | None
) -> GasCard:
    from vibecalc.excitation.pressure_cycle import card_of_mean_pressure, card_of_peak

    if peak is not None:
        return card_of_peak(cycle, geometry, peak)
    assert mean is not None
    return card_of_mean_pressure(cycle, geometry, mean)


# ----------------------------------------------------------------------------
# The cylinders of a pump as arrays: the liquid of a case, and its pressure over a turn.
# ----------------------------------------------------------------------------


def liquid_of(machine: Machine) -> Liquid:
    """What the cylinders of a validated pump work with."""
    given = machine.crank_train.pump_cycle
    if given is None:
        raise ValueError("the case has no pump_cycle")
    return Liquid(**given.model_dump())


def pump_card(machine: Machine) -> GasCard:
    """The pressure on a plunger; NumericalFailure where a pump draws nothing."""
    return _pump_card(liquid_of(machine), crank_geometry(machine.crank_train))


# the stages of the pump and of its mounts ask for the same one
_pump_card = lru_cache(maxsize=16)(pump_cycle.pump_card)

"""From a case to arrays: running gear, gas, what turns with the shaft, where the bearings stand."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.bearings.crank_loads import bearing_shares
from vibecalc.bearings.loads import Gas, Loads, RunningGear, Shaft
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rod_difference
from vibecalc.excitation.gas_tables import card_of_force
from vibecalc.excitation.model import (
    build_firing,
    force_curves,
    gas_cards,
    has_cards,
    misfire_cards,
)
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.body import DIRECTIONS
from vibecalc.parts.crank_train import CrankTrain, RotatingMasses, crank_geometry, rod_share
from vibecalc.unit_table import FREE_FALL

if TYPE_CHECKING:
    from vibecalc.bearings.tables import BearingLoads, ShaftLoad
    from vibecalc.schema import Case


def loads_of(scene: Scene) -> Loads:
    """What loads the bearings of a scene with [bearing_loads]."""
    case, train = scene.case, scene.parts.crank_train
    assert case.bearing_loads is not None
    shaft = shaft_of(case, case.bearing_loads, train, scene.parts.rotating_masses)
    return Loads(running_gear(case, train), train.bank_angle, gas_of(case, train), shaft)


def running_gear(case: "Case", train: CrankTrain) -> RunningGear:
    """The running gear of the cylinders that move; the others have no mass."""
    written = case.machine.crank_train
    rod, share = written.rod, rod_share(written)
    moves = (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)
    mass, difference = (0.0, 0.0) if rod is None else (rod.mass, 0.0)
    if rod is not None and rod.inertia is not None:
        difference = float(rod_difference(train, rod).value)
    return RunningGear(
        crank_geometry(case.machine.crank_train),
        train.crank_phase - train.bank_angle,
        train.reciprocating_mass,
        moves * mass * share,
        moves * mass * (1.0 - share),
        moves * difference,
    )


def shaft_of(
    case: "Case", table: "BearingLoads", train: CrankTrain, rotating: RotatingMasses
) -> Shaft:
    """What loads the bearings besides the rods; balance shafts have bearings of their own."""
    bearings = [bearing.position for bearing in table.main_bearings]
    own = np.arange(len(rotating.names)) < len(rotating.names) - len(
        case.machine.crank_train.balance_shafts
    )
    along = rotating.position[own] @ train.axis
    fall = free_fall(case, table, train)
    loads = [_constant(load, train, fall) for load in table.shaft_loads]
    places = [load.position for load in table.shaft_loads]
    shares = bearing_shares(bearings, places)
    return Shaft(
        tuple(bearing.name for bearing in table.main_bearings),
        bearing_shares(bearings, train.position),
        rotating.unbalance[own],
        rotating.phase[own],
        bearing_shares(bearings, along),
        shares @ np.array(loads, dtype=complex),
    )


def _constant(load: "ShaftLoad", train: CrankTrain, fall: FloatArray) -> complex:
    if load.force is not None:
        force = np.asarray(load.force)
    else:
        assert load.mass is not None
        force = load.mass * fall
    return complex(force @ train.stroke, force @ -train.across)


def free_fall(case: "Case", table: "BearingLoads", train: CrankTrain) -> FloatArray:
    """Acceleration (3,) of free fall in m/s^2: that of the body on its mounts, where it has any."""
    isolation = case.isolation
    name = table.up if isolation is None else isolation.up
    up = train.stroke if name is None else np.eye(3)[DIRECTIONS.index(name.strip("-"))]
    size = FREE_FALL if isolation is None else isolation.gravity
    return np.asarray((size if name is not None and name.startswith("-") else -size) * up)


def gas_of(case: "Case", train: CrankTrain) -> Gas:
    """The gas of the cylinders that work: cards of an engine, the liquid of a pump, a pressure or
    force over a turn of a compressor, or nothing.

    Raises NumericalFailure where a cycle of such a peak or mean pressure does not exist.
    """
    machine, working = case.machine, None if case.excitation is None else case.excitation.working
    runs = np.array([working is None or name in working for name in train.names], dtype=float)
    start, none = train.bank_angle - train.crank_phase, np.zeros(1)
    if not has_cards(machine):
        curves = enumerate(force_curves(machine))
        each = np.diag(runs)
        own = ((i, curve) for i, curve in curves if curve is not None and runs[i])
        return Gas(start, none, tuple(((card_of_force(curve),), each[i]) for i, curve in own))
    speeds, cards = gas_cards(machine)
    if not cards:
        return Gas(start, none, ())
    force = crank_geometry(machine.crank_train).piston_area * runs
    if machine.kind == "pump":
        return Gas(start, none, ((cards, force),))
    firing = build_firing(case)
    force = force * firing.pressure_scale
    groups = (cards, force * firing.fires), (misfire_cards(case, cards), force * ~firing.fires)
    return Gas(firing.first + firing.angle, speeds if len(speeds) else none, groups)

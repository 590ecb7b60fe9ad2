"""From a case to arrays: running gear, gas, what turns with the shaft, where the bearings stand."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.bearings.crank_loads import bearing_shares
from vibecalc.bearings.loads import Gas, Loads, RunningGear, Shaft
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rod_difference
from vibecalc.excitation.model import build_firing, gas_of_cylinders
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
    """The gas of the cylinders that work.

    Raises NumericalFailure where a cycle of such a peak or mean pressure does not exist.
    """
    speeds, groups = gas_of_cylinders(case)
    start = train.bank_angle - train.crank_phase
    if case.machine.kind == "engine":
        firing = build_firing(case)
        start = firing.first + firing.angle
    return Gas(start, speeds if len(speeds) else np.zeros(1), tuple(groups))

"""From a case to arrays: running gear, gas, what turns with the shaft, where the bearings stand."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.bearings.crank_loads import bearing_shares
from vibecalc.bearings.loads import Gas, Loads, Shaft
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
from vibecalc.parts.body import unit_vector
from vibecalc.parts.crank_train import CrankTrain, RotatingMasses, crank_geometry, rod_share
from vibecalc.parts.firing import cycle_angle
from vibecalc.unit_table import FREE_FALL

if TYPE_CHECKING:
    from vibecalc.schema import Case


def loads_of(scene: Scene) -> Loads:
    """What loads the bearings of a scene with [bearing_loads]; cylinders at rest have no mass."""
    case, train = scene.case, scene.parts.crank_train
    written = case.machine.crank_train
    rod, share = written.rod, rod_share(written)
    moves = (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)
    mass = moves * (0.0 if rod is None else rod.mass)
    inertia = rod is not None and rod.inertia is not None
    return Loads(
        cycle_angle(case.machine),
        crank_geometry(written),
        train.bank_angle,
        train.crank_phase - train.bank_angle,
        train.reciprocating_mass,
        mass * share,
        mass * (1.0 - share),
        moves * (rod_difference(train, rod).value if rod is not None and inertia else 0.0),
        gas_of(case, train),
        shaft_of(case, train, scene.parts.rotating_masses),
    )


def shaft_of(case: "Case", train: CrankTrain, rotating: RotatingMasses) -> Shaft:
    """What loads the bearings besides the rods; balance shafts have bearings of their own."""
    table = case.bearing_loads
    assert table is not None
    bearings = [bearing.position for bearing in table.main_bearings]
    count = len(rotating.names) - len(case.machine.crank_train.balance_shafts)
    fall = free_fall(case, table.up, train)
    loads = [
        fall * (one.mass or 0.0) if one.force is None else np.array(one.force)
        for one in table.shaft_loads
    ]
    at_rest = np.array([force @ (train.stroke - 1j * train.across) for force in loads], complex)
    return Shaft(
        tuple(bearing.name for bearing in table.main_bearings),
        bearing_shares(bearings, train.position),
        rotating.unbalance[:count],
        rotating.phase[:count],
        bearing_shares(bearings, rotating.position[:count] @ train.axis),
        bearing_shares(bearings, [load.position for load in table.shaft_loads]) @ at_rest,
    )


def free_fall(case: "Case", up: str | None, train: CrankTrain) -> FloatArray:
    """Acceleration (3,) of free fall in m/s^2: that of the body on its mounts, where it has any."""
    size = FREE_FALL
    if case.isolation is not None:
        up, size = case.isolation.up, case.isolation.gravity
    against = train.stroke if up is None else unit_vector(up.strip("-"))
    return np.asarray((size if (up or "").startswith("-") else -size) * against)


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

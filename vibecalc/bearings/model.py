"""From a case to arrays: running gear, gas, what turns with the shaft, where the bearings stand."""

import numpy as np

from vibecalc.bearings.crank_loads import bearing_shares
from vibecalc.bearings.loads import Gas, Loads, Shaft
from vibecalc.core.run.stage import Scene
from vibecalc.excitation.crank_forces import rod_moments
from vibecalc.excitation.model import build_firing, gas_of_cylinders
from vibecalc.numerics.rounding import FloatArray
from vibecalc.parts.body import unit_vector
from vibecalc.parts.crank_train import CrankTrain, RotatingMasses, crank_geometry, rod_share
from vibecalc.parts.firing import cycle_angle
from vibecalc.schema import Case
from vibecalc.unit_table import FREE_FALL


def loads_of(scene: Scene) -> Loads:
    """What loads the bearings of a scene with [bearing_loads]; cylinders at rest have no mass."""
    case, train = scene.case, scene.parts.crank_train
    written = case.machine.crank_train
    rod, share = written.rod, rod_share(written)
    moves = (train.reciprocating_mass + train.rotating_mass > 0.0).astype(float)
    mass = moves * (0.0 if rod is None else rod.mass)
    moments = rod_moments(train, rod)
    return Loads(
        cycle_angle(case.machine),
        crank_geometry(written),
        train.bank_angle,
        train.crank_phase - train.bank_angle,
        train.reciprocating_mass,
        mass * share,
        mass * (1.0 - share),
        0.0 * moves if moments is None else moments.value,
        gas_of(case, train),
        shaft_of(case, train, scene.parts.rotating_masses),
    )


def shaft_of(case: Case, train: CrankTrain, rotating: RotatingMasses) -> Shaft:
    """What loads the bearings besides the rods; balance shafts have bearings of their own."""
    table = case.bearing_loads
    assert table is not None
    bearings = [bearing.position for bearing in table.main_bearings]
    count = len(rotating.names) - len(case.machine.crank_train.balance_shafts)
    fall, plane = free_fall(case, table.up, train), train.stroke - 1j * train.across
    loads = [(one.mass or 0.0) * fall + (one.force or np.zeros(3)) for one in table.shaft_loads]
    at_rest = np.array([load @ plane for load in loads], dtype=complex)
    return Shaft(
        tuple(bearing.name for bearing in table.main_bearings),
        bearing_shares(bearings, train.position),
        rotating.unbalance[:count],
        rotating.phase[:count],
        bearing_shares(bearings, rotating.position[:count] @ train.axis),
        bearing_shares(bearings, [load.position for load in table.shaft_loads]) @ at_rest,
    )


def free_fall(case: Case, up: str | None, train: CrankTrain) -> FloatArray:
    """Acceleration (3,) of free fall in m/s^2: that of the body on its mounts, where it has any."""
    size = FREE_FALL
    if case.isolation is not None:
        up, size = case.isolation.up, case.isolation.gravity
    against = train.stroke if up is None else unit_vector(up.strip("-"))
    return np.asarray((size if (up or "").startswith("-") else -size) * against)


def gas_of(case: Case, train: CrankTrain) -> Gas:
    """The gas of the cylinders that work.

    Raises NumericalFailure where a cycle of such a peak or mean pressure does not exist.
    """
    speeds, groups = gas_of_cylinders(case)
    start = train.bank_angle - train.crank_phase
    if case.machine.kind == "engine":
        firing = build_firing(case)
        start = firing.first + firing.angle
    return Gas(start, speeds if len(speeds) else np.zeros(1), tuple(groups))

"""Angular momentum of a shaft line: how much, and which way round, its freedoms carry."""

import numpy as np

from vibecalc.case.schema import Case
from vibecalc.machine.crank_train import build_crank_train
from vibecalc.machine.shaft_line import ShaftLine
from vibecalc.machine.shaft_line_elements import station_inertia
from vibecalc.numerics.rounding import EPSILON, WithError


def spin_inertia(case: Case, built: ShaftLine) -> WithError:
    """Own inertia times own speed ratio (n,) in kg m^2, summed over what turns with a freedom.

    Times the referred angular velocity it is the angular momentum about the crankshaft, positive in
    its sense; the referred inertia holds the ratio twice. Inertias of stations count as those of
    parts that turn.
    """
    line = case.machine.shaft_line
    assert line is not None, "only asked of a machine with a shaft line"
    train = case.machine.crank_train
    own = np.array(station_inertia(line, train, build_crank_train(train)))
    found, size = np.zeros(len(built.freedom_names)), np.zeros(len(built.freedom_names))
    spin = own * built.station_ratio
    np.add.at(found, built.freedom, spin)
    np.add.at(size, built.freedom, np.abs(spin))
    for damper in built.dampers:
        found[damper.ring] = damper.inertia * built.station_ratio[damper.station]
    size += np.abs(found)
    return WithError(found, (len(own) + 2) * EPSILON * size)

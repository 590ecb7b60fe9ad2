"""Throws of a case as the rule for crankshafts counts them, and their stresses by bending."""

from collections.abc import Sequence

import numpy as np

from vibecalc.torsion.crank_strength import CrankThrow, NominalBending
from vibecalc.torsion.limit_tables import Crank, TorsionLimit
from vibecalc.torsion.shaft_line_tables import Throw


def crank_throws(given: Sequence[Crank | Throw], crank_radius: float) -> CrankThrow:
    """Dimensions (r,) of throws of a case."""
    keys = CrankThrow._fields
    rows = [
        [crank_radius if key == "crank_radius" else getattr(one, key) or 0.0 for key in keys]
        for one in given
    ]
    return CrankThrow(*np.array(rows, dtype=float).reshape(-1, len(keys)).T)


def nominal_bending(limit: TorsionLimit) -> NominalBending:
    """Stresses of the case that are not of torsion."""
    one = limit.bending
    assert one is not None  # the rule needs it, says the form
    given = (one.web, one.compressive, one.oil_bore or 0.0, one.additional)
    return NominalBending(*(np.asarray(stress) for stress in given))

"""Natural frequencies by Riccati transfer, mode count and bisection alone: the independent way."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.bisection import tree_frequencies
from vibecalc.response.torsion.count import rooted
from vibecalc.response.torsion.graph import pieces
from vibecalc.response.torsion.line import Line


def riccati_frequencies(line: Line) -> FloatArray:
    """Natural frequencies (m,) in rad/s, ascending, of a row or branched line; rigid exactly 0.

    Shares no step with the eigenvalue route of rows. Stations without inertia stay in the
    recurrence. Raises `NumericalFailure` for a closed loop of shafts, which has no leaf to
    begin at.
    """
    found = []
    for piece in pieces(line):
        if not piece.is_tree:
            raise NumericalFailure(
                "the transfer matrix follows rows and branches of shafts, not a closed loop: "
                "use the eigenvalues"
            )
        found.append(tree_frequencies(rooted(piece)))
    return np.sort(np.concatenate(found))

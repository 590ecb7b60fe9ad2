"""How sure the stiffness of a crank throw from its dimensions can be."""

import numpy as np

from vibecalc.case.schema import Case
from vibecalc.hardware.crank_stiffness import stiffness_spread
from vibecalc.machine.shaft_line_elements import throw_dimensions
from vibecalc.machine.shaft_line_graph import shaft_ends


def throw_cautions(case: Case) -> list[str]:
    """A sentence for each kind of throw whose formulas are compared."""
    line = case.machine.shaft_line
    if line is None:
        return []
    named: dict[str, list[str]] = {}
    for shaft, ends in zip(line.shafts, shaft_ends(line), strict=True):
        if shaft.throw is None or shaft.stiffness is not None:
            continue
        dimensions = throw_dimensions(shaft.throw, case.machine.crank_train.crank_radius)
        spread = stiffness_spread(dimensions, np.asarray(shaft.throw.shear_modulus))
        low, high = float(spread.stiffness.min()), float(spread.stiffness.max())
        words = (
            f"the formulas for the stiffness of a throw give {low:.3g} to {high:.3g} N*m/rad, "
            f"{100.0 * float(spread.doubt):.0f} % to either side of their middle, and "
            f"'{shaft.throw.formula}' is one of them: natural frequencies in which the throws "
            "twist are unsure by up to that share"
        )
        named.setdefault(words, []).append(shaft.name or " - ".join(ends))
    return [f"{', '.join(names)}: {words}" for words, names in named.items()]

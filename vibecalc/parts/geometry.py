"""The lengths of a slider-crank, held once: for one machine or for many."""

from typing import Any, NamedTuple

import numpy as np


class CrankGeometry(NamedTuple):
    """Lengths of one cylinder in m: crank radius, rod between centres, bore, wrist pin offset.

    The one holder of these lengths: numbers of one machine, or arrays with leading axes of many.
    """

    crank_radius: Any
    rod_length: Any
    bore: Any = 0.0
    wrist_pin_offset: Any = 0.0

    @property
    def lengths(self) -> tuple[Any, Any, Any]:
        """Crank radius, rod length, wrist pin offset."""
        return self.crank_radius, self.rod_length, self.wrist_pin_offset

    @property
    def piston_area(self) -> Any:
        """Area of the piston, m^2."""
        return 0.25 * float(np.pi) * self.bore**2

"""Warburton's closed forms by excitation and response, for an undamped primary."""

import numpy as np

from vibecalc.absorber.tuning.closed_forms import METHODS, Method

# ----------------------------------------------------------------------------
# Points that the curves of all dampings pass, made equally high by the spring; the damper has the
# mean of the two squared dampings that make each of the points a maximum. The optimum is near: its
# peaks stand beside these points.
# ----------------------------------------------------------------------------


def deflection(m: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Against a ground of constant acceleration: k, z2 and the height of the fixed points; m < 2.

    Tuning sqrt(1 - m / 2) / (1 + m), damping^2 3 m / (8 (1 + m) (1 - m / 2)) on the absorber's own
    frequency.
    """
    k = m * (1.0 - m / 2.0) / np.square(1.0 + m)
    own = np.sqrt(3.0 * m / (8.0 * (1.0 + m) * (1.0 - m / 2.0)))
    return k, own * np.sqrt(m * k), (1.0 + m) * np.sqrt(2.0 / m)


_SOURCE = "G. B. Warburton, Earthq. Eng. Struct. Dyn. 10 (1982)"
_DEFLECTION = Method(
    deflection, "base_acceleration", "deflection", False,
    "undamped primary; mass ratios below 2, the better the smaller", _SOURCE,
)  # fmt: skip
_PLAIN, _FAST = METHODS["den_hartog_brock"], METHODS["warburton_acceleration"]

#: (excitation, response) -> closed form of the least largest amplitude
WARBURTON = {
    ("force", "displacement"): _PLAIN,
    ("force", "transmitted_force"): _PLAIN,
    ("base", "displacement"): _PLAIN,
    ("base_acceleration", "acceleration"): _PLAIN,
    ("force", "acceleration"): _FAST,
    ("unbalance", "displacement"): _FAST,
    ("base_acceleration", "deflection"): _DEFLECTION,
    ("base_acceleration", "transmitted_force"): _DEFLECTION,
}

"""Pictures of the modal route of the source: twist against speed, by order and at criticals."""

from dataclasses import replace

import numpy as np

from vibecalc.core.report.canvas import COLOURS
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Panel,
    Source,
    decades,
    entry_of,
    operating,
    sourced,
)
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.torsion.study_results import PUBLISHED

#: elastic modes that have a curve of their own; the source shows three
_MODES = 6


def _at_criticals(mode: int) -> Source:
    """The twist of one mode over the speeds at which its orders meet its frequency."""

    def made(result: Result) -> Quantity | None:
        natural = result.record.quantities.get(PUBLISHED + "natural_frequency")
        if natural is None or mode >= len(natural.values):
            return None
        found = sourced(entry_of(PUBLISHED + "twist_at_critical", mode), result)
        if found is None:
            return None
        order = np.asarray(found.axes[1].values, dtype=float)
        speeds = natural.values[mode] / order[order > 0.0]
        axis = Axis(name="speed", values=speeds, unit="rad/s", long_name="speed")
        values = np.abs(found.values[:, order > 0.0])
        return replace(found, path="", values=values, axes=(found.axes[0], axis))

    return made


AS_PUBLISHED = Curves(
    "modal route of the source: shapes with 1 at the first freedom, no twist of a shaft",
    (
        Panel(
            "twist",
            (Curve(PUBLISHED + "twist_magnitude", "mode {}"), operating),
            "size of the modal twist at crank angle 0 against speed",
            log="y",
        ),
        Panel(
            "vector sum",
            (Curve(PUBLISHED + "intensity", bars=True),),
            "intensity: torques weighted by the shape, summed over the stations",
            log="y",
            ends=decades(4),
        ),
        Panel(
            "twist",
            tuple(
                Curve(
                    _at_criticals(mode),
                    look={"color": COLOURS[mode], "marker": "v", "linestyle": ""},
                )
                for mode in range(_MODES)
            ),
            "size of the modal twist at the critical speeds, all orders",
            log="xy",
        ),
    ),
)

"""Pictures of absorbers in units: motions and forces by frequency, with and without."""

from dataclasses import replace

import numpy as np

from vibecalc.absorber.motion_results import MOTION_ROOT, WITHOUT_ROOT
from vibecalc.core.report.canvas import COLOURS
from vibecalc.core.report.curves import Curve, Curves, Panel
from vibecalc.core.report.sources import Source, sourced
from vibecalc.core.results.record import Quantity, Result

_TRAVELS = ("travel", "twist")
_FORCES = ("spring_force", "damper_force", "spring_torque", "damper_torque")


def _topped(root: str, name: str) -> Source:
    """A curve with its largest, which may stand between the frequencies drawn."""

    def made(result: Result) -> Quantity | None:
        curve = sourced(f"{root}/{name}", result)
        found = [result.record.quantities.get(f"{root}/{table}/{name}") for table in (
            "largest", "largest_at")]  # fmt: skip
        top, place = found
        if curve is None or top is None or place is None:
            return curve
        *others, over = curve.axes
        at = np.atleast_1d(np.asarray(place.values, float))
        x = np.unique(np.concatenate([over.values, at[np.isfinite(at)]]))
        rows = np.abs(curve.values).reshape(-1, len(over.values))
        drawn = np.stack([np.interp(x, over.values, row) for row in rows])
        for row, height, where in zip(drawn, np.atleast_1d(top.values), at, strict=True):
            row[x == where] = height
        shape = (*(len(axis.values) for axis in others), len(x))
        return replace(curve, values=drawn.reshape(shape), axes=(*others, replace(over, values=x)))

    return made


def _panel(label: str, *names: str, height: float = 1.0) -> Panel:
    lines = tuple(
        Curve(_topped(root, name), words, {"marker": "", "color": color})
        for name in names
        for root, words, color in (
            (MOTION_ROOT, "with absorber", COLOURS[0]),
            (WITHOUT_ROOT, "without absorber", COLOURS[1]),
        )
    )  # fmt: skip
    return Panel(label, lines, log="y", height=height, legend={"loc": "best"})


ABSORBER_MOTION = Curves(
    "motions and forces by frequency",
    (
        _panel("motion of the primary", "displacement", "angle", height=1.5),
        _panel("motion against ground", "deflection", height=1.5),
        _panel("acceleration", "acceleration", "angular_acceleration"),
        _panel("load on the ground", "transmitted_force", "transmitted_torque"),
        Panel(
            "travel of the\nabsorber",
            (
                *(Curve(_topped(MOTION_ROOT, name), "", {"marker": ""}) for name in _TRAVELS),
                *(Curve(_topped(MOTION_ROOT, f"each/{name}"), "{}", {"marker": ""})
                  for name in _TRAVELS),
            ),
            legend={"loc": "best"},
        ),
        Panel(
            "load of the\nabsorber",
            (
                *(Curve(_topped(MOTION_ROOT, name), name.split("_")[0],
                        {"marker": "", "color": COLOURS[1 + i % 2]})
                  for i, name in enumerate(_FORCES)),
                *(Curve(_topped(MOTION_ROOT, f"each/{name}"), f"{name.split('_')[0]} of {{}}",
                        {"marker": ""}) for name in _FORCES),
            ),
            legend={"loc": "best"},
            below="frequency in Hz",
        ),
    ),
)  # fmt: skip

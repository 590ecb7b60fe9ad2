"""Adapter: motion of the body to readings at its points, at the operating speed."""

from functools import partial
from typing import Any

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.excitation.adapter import MotionByOrder, kept, left_out, peak_with_tail
from vibecalc.numerics.bounded import where
from vibecalc.points.model import QUANTITIES, band_of, boundaries_of, readings_of
from vibecalc.points.readings import in_band, rms, signals
from vibecalc.points.results import BOUNDARY, ROOT
from vibecalc.points.severity import severity, zones


def run_points(scene: Scene) -> None:
    """Emit readings by order, their peaks over the cycle, r.m.s. in the band, and the severity."""
    case, readings = scene.case, readings_of(scene.case)
    given = motion_of_body(scene)
    speed, used = case.machine.speed, given.retained
    frequency = given.order * np.asarray(speed)[..., None]
    counts = in_band(frequency, band_of(case))[..., None, :]
    found = dict(zip(QUANTITIES, signals(given.motion, readings.row, frequency), strict=True))
    levels = {}
    for name, one in found.items():
        _, dropped = left_out(where(counts, one, 0.0), given)
        levels[name] = rms(one[..., :used], counts[..., :used], dropped)
    axes = {"sensor": readings.names, "order": given.order[:used]}
    results: dict[str, Any] = {f"{ROOT}/{name}": kept(one, given) for name, one in found.items()}
    for name, one in found.items():
        results[f"{ROOT}/{name}_peak"] = partial(peak_with_tail, one, given)
    results |= {f"{ROOT}/{name}_rms": level for name, level in levels.items()}
    scene.emit_all(results, axes)
    scene.cite(
        "readings at points of a rigid body, r.m.s. of the orders in a band by Parseval's theorem",
        "vibration where it is measured",
        "docs/theory_mounts.md",
    )
    if not np.any(counts[..., :used]):
        low, high = (one / (2.0 * np.pi) for one in band_of(case))
        scene.warn(
            f"no order of the speed lies between {low:.6g} and {high:.6g} Hz, the band of the "
            "r.m.s. values at points: these are zero, without severity; the peaks contain all "
            "orders"
        )
        return
    if case.vibration_severity is None:
        return
    scene.emit(f"{ROOT}/severity", severity(*levels.values()), axes=axes)
    boundaries = boundaries_of(case.vibration_severity)
    exceeded = [zones(levels[name].value, each) for name, each in boundaries.items()]
    if exceeded:
        scene.emit(f"{ROOT}/zone", np.max(exceeded, axis=0), axes=axes)
        scene.cite(
            f"zones of vibration severity, {case.vibration_severity.standard}, informative",
            "severity of vibration",
            case.vibration_severity.standard,
        )
    for name, between in boundaries.items():
        limits = {"zone_limit": np.arange(1, len(between) + 1)}
        scene.emit(f"{BOUNDARY}/{name}", between, axes=limits)


def motion_of_body(scene: Scene) -> MotionByOrder:
    """Motion of the body at its speed by all that drives it, with the foundation if that moves."""
    given: MotionByOrder = scene.handed_on["motion_by_order"]
    return given

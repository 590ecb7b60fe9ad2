"""Adapter, continued: what springs and oils in stock give, and the pair with the lowest peak."""

from typing import NamedTuple

import numpy as np

from vibecalc.case.absorber_tables import Tuning
from vibecalc.errors import NumericalFailure
from vibecalc.hardware.oils import Oil, dynamic_viscosity, oil_damping, right_temperature
from vibecalc.hardware.spring_couple import couple_stiffness
from vibecalc.hardware.viscosity import kinematic_viscosity
from vibecalc.machine.absorber import AbsorberParts, Scale
from vibecalc.machine.absorber_hardware import Filling
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.absorber.stock import stock_choice
from vibecalc.pipeline.entries.absorber_parts import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.absorber_bounds import limits_of
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks

#: names where nothing is wanted, and where the stock has nothing, so that the tuning's own stays
NO_SPRING = "none"
AS_TUNED = "as tuned"
_VISCOUS = ("viscous", "lanchester")
#: results of a choice among stock parts
_CHOSEN = (f"{ROOT}/pair/", f"{ROOT}/damper_pair/", f"{ROOT}/buy/", f"{ROOT}/warming/")


class Held(NamedTuple):
    """Springs and oil that stay while the oil warms: the best pair in stock, else those built in.

    `least` is the peak of the tuning.
    """

    stiffness_ratio: float
    oil: Oil
    least: float


class Offers(NamedTuple):
    """What every part in stock gives: names, ratios (n,), errors of the ratios."""

    names: tuple[str, ...]
    ratio: FloatArray
    error: FloatArray


def emit_stock(scene: Scene, parts: AbsorberParts, tuned: Absorber | None) -> Held | None:
    """Emit springs, oils and their pairs; give what stays while the oil warms, if there is any.

    Pairs are priced against the tuning.
    """
    scale, filled = parts.scale, parts.filling
    if scale is None or filled is None:
        return None
    tuning = scene.case.tuning
    viscous = tuning is not None and tuning.kind in _VISCOUS
    springs = _springs(scene, parts, scale)
    oils = _oils(scene, parts, scale, filled, tuned)
    if tuning is None or tuned is None:
        return None
    pair = tuning.excitation, tuning.response
    least = float(peaks(tuned, *pair).largest)
    if viscous:
        springs = Offers((NO_SPRING,), np.zeros(1), np.zeros(1))
    if springs is None or oils is None:
        return _as_built(parts, scale, filled, least, viscous)
    if tuning.norm == "h2":
        scene.warn(
            "stock parts are ranked by their largest peak, which is not what a mean square makes "
            'small: under norm = "h2" no pair of them is chosen'
        )
        return _as_built(parts, scale, filled, least, viscous)
    best = _emit_pairs(scene, tuning, tuned, springs, oils, "pair", "stock_oil", least)
    if best is None:
        return _as_built(parts, scale, filled, least, viscous)
    oil = next(oil for oil in parts.stock.oils if oil.name == oils.names[best[1]])
    return Held(float(springs.ratio[best[0]]), oil, least)


def emit_stock_in_line(scene: Scene, parts: AbsorberParts, tuned: Absorber | None) -> None:
    """Emit springs, dampers and their pairs for a mass that moves in a line.

    Without dampers in stock the springs go with the damper of the tuning, and the other way round.
    """
    scale, stock, tuning = parts.scale, parts.stock, scene.case.tuning
    if scale is None:
        return
    springs, dampers = _springs(scene, parts, scale), None
    if stock.damper_names:
        ratio = stock.dampings / scale.damping
        axes = {"stock_damper": stock.damper_names}
        scene.emit(f"{ROOT}/damper/damping", stock.dampings, 0.0, axes)
        scene.emit(f"{ROOT}/damper/secondary_damping", ratio, 8.0 * EPSILON * ratio, axes)
        dampers = Offers(stock.damper_names, ratio, 8.0 * EPSILON * ratio)
    if tuning is None or tuned is None or tuning.norm == "h2" or not (springs or dampers):
        return
    if tuning.kind in _VISCOUS:
        springs = Offers((NO_SPRING,), np.zeros(1), np.zeros(1))
    if tuning.kind == "undamped_spring":
        dampers = Offers((NO_SPRING,), np.zeros(1), np.zeros(1))
    doubt = scene.handed_on["tuned_doubt"]
    springs = springs or _as_tuned(tuned.stiffness_ratio, doubt.stiffness)
    dampers = dampers or _as_tuned(tuned.secondary_damping, doubt.damping)
    least = float(peaks(tuned, tuning.excitation, tuning.response).largest)
    _emit_pairs(scene, tuning, tuned, springs, dampers, "damper_pair", "stock_damper", least)


def _as_tuned(ratio: object, error: object) -> Offers:
    return Offers((AS_TUNED,), *(np.array([float(np.asarray(x))]) for x in (ratio, error)))


def _emit_pairs(
    scene: Scene, tuning: Tuning, tuned: Absorber, springs: Offers, dampers: Offers, name: str,
    axis: str, least: float,
) -> tuple[int, int] | None:  # fmt: skip
    """Emit the peak of every pair, and the best one; None, with a warning, where there is none."""
    pair, limits = (tuning.excitation, tuning.response), limits_of(tuning)
    z1, m = float(np.asarray(tuned.primary_damping)), float(np.asarray(tuned.mass_ratio))
    k, z2 = springs.ratio[:, None], dampers.ratio[None, :]
    try:
        found = stock_choice(
            z1, m, springs.ratio, dampers.ratio, least, *pair,
            stiffness=limits.stiffness, damping=limits.damping, travel=limits.travel,
        )  # fmt: skip
    except NumericalFailure as failure:
        if any(path.startswith(_CHOSEN) for path in scene.wanted or ()):
            raise
        scene.warn(f"no stock parts chosen: {failure}")
        return None
    stray = springs.error[:, None] / np.where(k > 0.0, k, 1.0)
    stray = stray + dampers.error / np.where(z2 > 0.0, z2, 1.0)
    finite = np.isfinite(found.peak)
    top = np.where(finite, found.peak, 0.0)
    error = np.where(finite, found.error, 0.0) + 4.0 * top * (1.0 + top) * stray
    axes = {"stock_spring": springs.names, axis: dampers.names}
    scene.emit(f"{ROOT}/{name}/peak", found.peak, error, axes)
    scene.emit(f"{ROOT}/{name}/penalty", found.penalty, 2.0 * error / least, axes)
    moved = np.where(np.isfinite(found.travel), found.travel, 0.0)
    scene.emit(f"{ROOT}/{name}/travel", found.travel, 1e-9 * moved, axes)
    scene.emit(f"{ROOT}/{name}/allowed", found.allowed.astype(int), 0.0, axes)
    best = found.spring, found.oil
    peak, doubt = float(found.peak[best]), float(error[best])
    if found.unsure:
        scene.warn("the best two pairs of stock parts differ by less than the error of their peaks")
    scene.emit(f"{ROOT}/buy/peak", peak, doubt)
    scene.emit(f"{ROOT}/buy/penalty", peak / least - 1.0, 2.0 * doubt / least)
    return best


def _as_built(
    parts: AbsorberParts, scale: Scale, filled: Filling, least: float, viscous: bool
) -> Held | None:
    springs = parts.springs
    if filled.oil is None:
        return None
    if viscous:
        return Held(0.0, filled.oil, least)
    if springs is None or springs.stiffness is None:
        return None
    return Held(springs.stiffness / scale.stiffness, filled.oil, least)


def _springs(scene: Scene, parts: AbsorberParts, scale: Scale) -> Offers | None:
    springs, stock = parts.springs, parts.stock
    if springs is None or not stock.spring_names:
        return None
    found = couple_stiffness(stock.spring_rates, springs.count, springs.radius, springs.angle)
    ratio = found.value / scale.stiffness
    error = found.error / scale.stiffness + 4.0 * EPSILON * ratio
    axes = {"stock_spring": stock.spring_names}
    scene.emit(f"{ROOT}/spring/rate", stock.spring_rates, 0.0, axes)
    scene.emit(f"{ROOT}/spring/stiffness_ratio", ratio, error, axes)
    return Offers(stock.spring_names, ratio, error)


def _oils(
    scene: Scene, parts: AbsorberParts, scale: Scale, filled: Filling, wanted: Absorber | None
) -> Offers | None:
    oils, thick, damping = [], [], []
    for oil in parts.stock.oils:
        try:
            dynamic_viscosity(oil, filled.temperature)
            line = kinematic_viscosity(oil.line, filled.temperature)
            drag = oil_damping(oil, filled.gap, filled.temperature)
        except NumericalFailure as failure:
            scene.warn(f"oil {oil.name!r} in stock is left out: {failure}")
            continue
        oils.append(oil)
        thick.append(line)
        damping.append(drag)
    if not oils:
        return None
    names = tuple(oil.name for oil in oils)
    axes = {"stock_oil": names}
    values, errors = (np.array([float(x[i]) for x in thick]) for i in range(2))
    scene.emit(f"{ROOT}/oil/kinematic_viscosity", values, errors, axes)
    values, errors = (np.array([float(x[i]) for x in damping]) for i in range(2))
    scene.emit(f"{ROOT}/oil/damping", values, errors, axes)
    ratio = values / scale.damping
    error = errors / scale.damping + 8.0 * EPSILON * ratio
    scene.emit(f"{ROOT}/oil/secondary_damping", ratio, error, axes)
    if wanted is not None:
        drag_wanted = float(np.asarray(wanted.secondary_damping)) * scale.damping
        warm, slack = np.array([_right(oil, filled, drag_wanted) for oil in oils]).T
        scene.emit(f"{ROOT}/oil/right_temperature", warm, slack, axes)
    scene.cite(
        "straight line of ASTM D341 through two viscosities (in mm^2/s and K, so that it does not "
        "scale with the units of a case), density by API MPMS 11.1",
        "viscosity against temperature",
        "ASTM D341; Baca Vasquez (2007), equation 3.18",
    )
    return Offers(names, ratio, error)


def _right(oil: Oil, filled: Filling, wanted: float) -> tuple[float, float]:
    """Temperature at which an oil is as thick as wanted, and its error; zeros where it never is."""
    try:
        found = right_temperature(oil, filled.gap, wanted)
    except NumericalFailure:
        return 0.0, 0.0
    return float(found.value), float(found.error)

"""Adapter: rod, springs, ring, gap and oils of an absorber, and what to buy for its tuning."""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.adapters.band import problem_of
from vibecalc.absorber.adapters.optimum import limits_of
from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.hardware.oil_gap import (
    Oil,
    dynamic_viscosity,
    gap_shares,
    kinematic_viscosity,
    oil_damping,
    right_temperature,
    viscosity_for_damping,
    warming,
)
from vibecalc.absorber.hardware.overhung import (
    bending_frequencies,
    rayleigh_frequency,
    whirl_frequencies,
)
from vibecalc.absorber.hardware.rods_and_springs import (
    couple_stiffness,
    rate_for_couple,
    ring_inertia,
    torsional_stiffness,
)
from vibecalc.absorber.model import AbsorberParts, Bending, Filling, Scale, build_absorber
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.results import HARDWARE_ROOT
from vibecalc.absorber.stage import AS_TUNED, NO_SPRING, VISCOUS, is_banded
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.levels import at_least, largest_of_pairs
from vibecalc.absorber.tuning.restricted import (
    Read,
    given_damping,
    leading_pairs,
    stock_choice,
)
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded, stack
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Adapter, continued: what springs and oils in stock give, and the pair with the lowest peak.
# ----------------------------------------------------------------------------

#: results of a choice among stock parts
_CHOSEN = (
    f"{HARDWARE_ROOT}/pair/",
    f"{HARDWARE_ROOT}/damper_pair/",
    f"{HARDWARE_ROOT}/buy/",
    f"{HARDWARE_ROOT}/warming/",
)


class InstalledParts(NamedTuple):
    """Springs and oil that stay while the oil warms: the best pair in stock, else those built in.

    `least` is the peak of the tuning.
    """

    stiffness_ratio: float
    oil: Oil
    least: float


class Offers(NamedTuple):
    """What every part in stock gives: names, N/m or N s/m, ratios (n,), errors of the ratios.

    Mixtures of kinds stand behind the `plain` ones.
    """

    names: tuple[str, ...]
    amount: FloatArray
    ratio: FloatArray
    error: FloatArray
    plain: int

    def some(self, places: IntArray) -> "Offers":
        """Those at some places, in their order."""
        names = tuple(self.names[place] for place in places)
        amount, ratio, error = (part[places] for part in self[1:4])
        return Offers(names, amount, ratio, error, int(np.sum(places < self.plain)))

    @property
    def kept(self) -> "Offers":
        """Without mixtures."""
        return self.some(np.arange(self.plain))


_NOTHING = Offers((NO_SPRING,), np.zeros(1), np.zeros(1), np.zeros(1), 1)


def emit_stock(scene: Scene, parts: AbsorberParts, tuned: Absorber | None) -> InstalledParts | None:
    """Emit springs, oils and their pairs; give what stays while the oil warms, if there is any.

    Pairs are priced against the tuning.
    """
    scale, filled = parts.scale, parts.filling
    if scale is None or filled is None:
        return None
    tuning = scene.case.tuning
    viscous = tuning is not None and tuning.kind in VISCOUS
    springs = _springs(parts, scale)
    oils = _oils(scene, parts, scale, filled, tuned)
    if tuning is None or tuned is None or viscous or oils is None or tuning.norm == "h2":
        _emit_springs(scene, springs and springs.kept)
    if tuning is None or tuned is None:
        return None
    pair = tuning.excitation, tuning.response
    least = float(peaks(tuned, *pair).largest)
    if viscous:
        springs = _NOTHING
    if springs is None or oils is None:
        return _as_built(parts, scale, filled, least, viscous)
    if tuning.norm == "h2":
        scene.warn(
            "stock parts are ranked by their largest peak, which is not what a mean square makes "
            'small: under norm = "h2" no pair of them is chosen'
        )
        return _as_built(parts, scale, filled, least, viscous)
    if not viscous:
        springs, oils = _shortlist(scene, parts, tuning, tuned, springs, oils)
        _emit_springs(scene, springs)
    best = _emit_pairs(scene, tuning, tuned, springs, oils, "pair", "stock_oil", least)
    if best is None:
        return _as_built(parts, scale, filled, least, viscous)
    oil = next(oil for oil in parts.stock.oils if oil.name == oils.names[best[1]])
    return InstalledParts(float(springs.ratio[best[0]]), oil, least)


def emit_stock_in_line(scene: Scene, parts: AbsorberParts, tuned: Absorber | None) -> None:
    """Emit springs, dampers and their pairs for a mass that moves in a line.

    Without dampers in stock the springs go with the damper of the tuning, and the other way round.
    """
    scale, stock, tuning = parts.scale, parts.stock, scene.case.tuning
    if scale is None:
        return
    springs, dampers = _springs(parts, scale), None
    if stock.damper_names:
        ratio = stock.dampings / scale.damping
        dampers = Offers(
            stock.damper_names, stock.dampings, ratio, 8.0 * EPSILON * ratio, stock.plain_dampers
        )
    if tuning is None or tuned is None or tuning.norm == "h2" or not (springs or dampers):
        _emit_springs(scene, springs and springs.kept)
        _emit_dampers(scene, scale, dampers and dampers.kept)
        return
    uncertainty = scene.handed_on["tuned_uncertainty"]
    chosen = springs or _as_tuned(tuned.stiffness_ratio, uncertainty.stiffness)
    chosen = _NOTHING if tuning.kind in VISCOUS else chosen
    damped = dampers or _as_tuned(tuned.secondary_damping, uncertainty.damping)
    damped = _NOTHING if tuning.kind == "undamped_spring" else damped
    chosen, damped = _shortlist(scene, parts, tuning, tuned, chosen, damped)
    _emit_springs(scene, springs and (springs.kept if tuning.kind in VISCOUS else chosen))
    idle = tuning.kind == "undamped_spring"
    _emit_dampers(scene, scale, dampers and (dampers.kept if idle else damped))
    if is_banded(scene.case):
        read = _in_band(scene, tuning)
        k, z = np.asarray(tuned.stiffness_ratio), np.asarray(tuned.secondary_damping)
        least = float(read(k, z, tuning.response)[0])
    else:
        least = float(peaks(tuned, tuning.excitation, tuning.response).largest)
    _emit_pairs(scene, tuning, tuned, chosen, damped, "damper_pair", "stock_damper", least)


def _in_band(scene: Scene, tuning: Tuning) -> Read:
    """Largest response of pairs within the band, in the worst state."""
    problem = problem_of(tuning, build_absorber(scene.case), scene.case.machine)

    def read(k: FloatArray, z: FloatArray, response: str) -> tuple[FloatArray, FloatArray]:
        return largest_of_pairs(problem, k, z, response)

    return read


def _as_tuned(ratio: object, error: object) -> Offers:
    value, off = (np.array([float(np.asarray(x))]) for x in (ratio, error))
    return Offers((AS_TUNED,), np.zeros(1), value, off, 1)


#: best pairs whose mixtures are shown, and pairs whose peaks are computed together
_SHOWN, _BLOCK = 10, 5000


def _shortlist(
    scene: Scene, parts: AbsorberParts, tuning: Tuning, tuned: Absorber, springs: Offers,
    dampers: Offers,
) -> tuple[Offers, Offers]:  # fmt: skip
    """Of mixtures those that stand in the best pairs of all; everything else stays."""
    if parts.stock.unmixed:
        scene.warn(
            "kinds in stock are so many that not all of their mixtures are tried: give fewer "
            "kinds, or a lower parallel"
        )
    if not any(len(one.names) > one.plain for one in (springs, dampers)):
        return springs, dampers
    limits, pair = limits_of(tuning), (tuning.excitation, tuning.response)
    z1, m = tuned.primary_damping, tuned.mass_ratio
    inside = [
        (one.ratio >= low) & (one.ratio <= high)
        for one, (low, high) in ((springs, limits.stiffness), (dampers, limits.damping))
    ]
    in_band = _in_band(scene, tuning) if is_banded(scene.case) else None

    def height(k: FloatArray, z: FloatArray, response: str) -> FloatArray:
        if in_band is not None:
            return in_band(k, z, response)[0]
        return np.asarray(peaks(Absorber(z1, m, k, z), pair[0], response).largest)

    def read(k: FloatArray, z: FloatArray) -> FloatArray:
        found = height(k, z, pair[1])
        if np.isfinite(limits.travel):
            name = "relative_displacement" if in_band is None else "travel"
            found = np.where(height(k, z, name) <= limits.travel, found, np.inf)
        return found

    def bound(k: FloatArray, z: FloatArray) -> FloatArray:
        if in_band is None:
            return height(k, z, pair[1])
        problem = problem_of(tuning, parts, scene.case.machine)
        return at_least(problem, k, z, *scene.handed_on["band_active"])

    def below(k: FloatArray, z: FloatArray) -> FloatArray:
        blocks = np.array_split(np.arange(len(k)), 1 + len(k) // _BLOCK)
        return np.concatenate([bound(k[some], z[some]) for some in blocks])

    pairs = leading_pairs(
        springs.ratio, dampers.ratio, np.logical_and.outer(*inside), read, below, _SHOWN
    )
    if not pairs:
        return springs.kept, dampers.kept
    shown = [
        np.unique([*range(one.plain), *used])
        for one, used in zip((springs, dampers), zip(*pairs, strict=True), strict=True)
    ]
    return springs.some(shown[0]), dampers.some(shown[1])


def _emit_pairs(
    scene: Scene, tuning: Tuning, tuned: Absorber, springs: Offers, dampers: Offers, name: str,
    axis: str, least: float,
) -> tuple[int, int] | None:  # fmt: skip
    """Emit the peak of every pair, and the best one; None, with a warning, where there is none."""
    pair, limits = (tuning.excitation, tuning.response), limits_of(tuning)
    z1, m = float(np.asarray(tuned.primary_damping)), float(np.asarray(tuned.mass_ratio))
    k, z2 = springs.ratio[:, None], dampers.ratio[None, :]
    try:
        choice = stock_choice(
            z1, m, springs.ratio, dampers.ratio, least, *pair,
            stiffness=limits.stiffness, damping=limits.damping, travel=limits.travel,
            read=_in_band(scene, tuning) if is_banded(scene.case) else None,
        )  # fmt: skip
    except NumericalFailure as failure:
        if any(path.startswith(_CHOSEN) for path in scene.wanted or ()):
            raise
        scene.warn(f"no stock parts chosen: {failure}")
        return None
    stray = springs.error[:, None] / np.where(k > 0.0, k, 1.0)
    stray = stray + dampers.error / np.where(z2 > 0.0, z2, 1.0)
    finite = np.isfinite(choice.peak)
    top = np.where(finite, choice.peak, 0.0)
    error = np.where(finite, choice.error, 0.0) + 4.0 * top * (1.0 + top) * stray
    axes = {"stock_spring": springs.names, axis: dampers.names}
    scene.emit(f"{HARDWARE_ROOT}/{name}/peak", choice.peak, error, axes)
    scene.emit(f"{HARDWARE_ROOT}/{name}/penalty", choice.penalty, 2.0 * error / least, axes)
    moved = np.where(np.isfinite(choice.travel), choice.travel, 0.0)
    scene.emit(f"{HARDWARE_ROOT}/{name}/travel", choice.travel, 1e-9 * moved, axes)
    scene.emit(f"{HARDWARE_ROOT}/{name}/allowed", choice.allowed.astype(int), 0.0, axes)
    best = choice.spring, choice.oil
    peak, uncertainty = float(choice.peak[best]), float(error[best])
    if choice.unsure:
        scene.warn("the best two pairs of stock parts differ by less than the error of their peaks")
    scene.emit(f"{HARDWARE_ROOT}/buy/peak", peak, uncertainty)
    scene.emit(f"{HARDWARE_ROOT}/buy/penalty", peak / least - 1.0, 2.0 * uncertainty / least)
    return best


def _as_built(
    parts: AbsorberParts, scale: Scale, filled: Filling, least: float, viscous: bool
) -> InstalledParts | None:
    springs = parts.springs
    if filled.oil is None:
        return None
    if viscous:
        return InstalledParts(0.0, filled.oil, least)
    if springs is None or springs.stiffness is None:
        return None
    return InstalledParts(springs.stiffness / scale.stiffness, filled.oil, least)


def _springs(parts: AbsorberParts, scale: Scale) -> Offers | None:
    springs, stock = parts.springs, parts.stock
    if springs is None or not stock.spring_names:
        return None
    counts = np.where(np.isnan(stock.spring_counts), springs.count, stock.spring_counts)
    found = couple_stiffness(stock.spring_rates, counts, springs.radius, springs.angle)
    ratio = found.value / scale.stiffness
    error = found.error / scale.stiffness + 4.0 * EPSILON * ratio
    return Offers(stock.spring_names, stock.spring_rates, ratio, error, stock.plain_springs)


def _emit_springs(scene: Scene, springs: Offers | None) -> None:
    if springs is not None:
        axes = {"stock_spring": springs.names}
        scene.emit(f"{HARDWARE_ROOT}/spring/rate", springs.amount, 0.0, axes)
        scene.emit(f"{HARDWARE_ROOT}/spring/stiffness_ratio", springs.ratio, springs.error, axes)


def _emit_dampers(scene: Scene, scale: Scale, dampers: Offers | None) -> None:
    if dampers is not None:
        axes = {"stock_damper": dampers.names}
        scene.emit(f"{HARDWARE_ROOT}/damper/damping", dampers.amount, 0.0, axes)
        root = f"{HARDWARE_ROOT}/damper/secondary_damping"
        scene.emit(root, dampers.ratio, dampers.error, axes)


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
    scene.emit(f"{HARDWARE_ROOT}/oil/kinematic_viscosity", stack(thick), axes=axes)
    scene.emit(f"{HARDWARE_ROOT}/oil/damping", stack(damping), axes=axes)
    ratio, error = stack(damping) / rounded(scale.damping, 14.0)
    scene.emit(f"{HARDWARE_ROOT}/oil/secondary_damping", ratio, error, axes)
    if wanted is not None:
        drag_wanted = float(np.asarray(wanted.secondary_damping)) * scale.damping
        warm, slack = np.array([_right(oil, filled, drag_wanted) for oil in oils]).T
        scene.emit(f"{HARDWARE_ROOT}/oil/right_temperature", warm, slack, axes)
    scene.cite(
        "straight line of ASTM D341 through two viscosities (in mm^2/s and K, so that it does not "
        "scale with the units of a case), density by API MPMS 11.1",
        "viscosity against temperature",
        "ASTM D341; Baca Vasquez (2007), equation 3.18",
    )
    return Offers(names, stack(damping).value, ratio, error, len(names))


def _right(oil: Oil, filled: Filling, wanted: float) -> tuple[float, float]:
    """Temperature at which an oil is as thick as wanted, and its error; zeros where it never is."""
    try:
        found = right_temperature(oil, filled.gap, wanted)
    except NumericalFailure:
        return 0.0, 0.0
    return float(found.value), float(found.error)


# ----------------------------------------------------------------------------
# Adapter, continued: what a tuned absorber becomes while its oil warms.
# ----------------------------------------------------------------------------


def emit_warming(scene: Scene, options: Tuning, parts: AbsorberParts, held: InstalledParts) -> None:
    """Damping and peak at each temperature, springs kept; and the springs that would be best."""
    asked, filled, scale = options.temperatures, parts.filling, parts.scale
    if asked is None or filled is None or scale is None or parts.absorber is None:
        return
    z1, m = parts.primary_damping, float(np.asarray(parts.absorber.mass_ratio))
    pair = options.excitation, options.response

    def peak_of(damping: FloatArray) -> Bounded:
        found = peaks(Absorber(z1, m, held.stiffness_ratio, damping), *pair)
        return Bounded(found.largest, found.largest_error)

    def damping_at(warm: FloatArray) -> Bounded:
        return oil_damping(held.oil, filled.gap, warm)

    warm = np.linspace(asked.start, asked.stop, asked.points)
    warmed = warming(warm, damping_at, scale.stiffness, scale.inertia, peak_of, held.least)
    axes = {"temperature": warm}
    scene.emit(f"{HARDWARE_ROOT}/warming/damping", warmed.damping, axes=axes)
    scene.emit(f"{HARDWARE_ROOT}/warming/secondary_damping", warmed.secondary_damping, axes=axes)
    scene.emit(f"{HARDWARE_ROOT}/warming/peak", warmed.peak, axes=axes)
    if options.kind in ("viscous", "lanchester"):
        return
    best = given_damping(z1, m, warmed.secondary_damping.value, *pair)
    value = np.where(np.isfinite(best.value), best.value, 0.0)
    error = np.where(np.isfinite(best.value), best.value_error, 0.0)
    # the spring follows the damping that the oil gives
    spread = warmed.secondary_damping.error / warmed.secondary_damping.value
    scene.emit(
        f"{HARDWARE_ROOT}/warming/best_stiffness_ratio", value, error + 4.0 * value * spread, axes
    )
    uncertainty = best.largest_error + 4.0 * best.largest * spread
    scene.emit(f"{HARDWARE_ROOT}/warming/best_peak", best.largest, uncertainty, axes)


# ----------------------------------------------------------------------------
# Adapter: rod, springs, ring, gap and oils of an absorber, and what to buy for its tuning.
# ----------------------------------------------------------------------------


def run_absorber_parts(scene: Scene) -> None:
    """Emit what the parts give, what the tuning asks of them, and the best parts in stock."""
    parts = build_absorber(scene.case)
    _emit_rod(scene, parts)
    if parts.bending is not None:
        _emit_bending(scene, parts.bending)
    if parts.scale is None or parts.absorber is None:
        return
    natural = parts.scale.frequency
    scene.emit(f"{HARDWARE_ROOT}/primary_frequency", natural, 8.0 * EPSILON * natural)
    _emit_built(scene, parts)
    _emit_gap(scene, parts)
    tuned: Absorber | None = scene.handed_on.get("tuned")
    if tuned is not None:
        _emit_wanted(scene, parts, tuned)
    if not parts.scale.torsion:
        emit_stock_in_line(scene, parts, tuned)
    held = None if parts.filling is None else emit_stock(scene, parts, tuned)
    if held is not None:
        _emit_warming(scene, parts, held)


def _emit_rod(scene: Scene, parts: AbsorberParts) -> None:
    machine = scene.case.machine
    rod, ring = machine.rod, machine.ring
    if rod is not None and rod.length is not None and rod.shear_modulus is not None:
        found = torsional_stiffness(rod.shear_modulus, rod.diameter, rod.length, rod.bore)
        scene.emit(f"{HARDWARE_ROOT}/rod_stiffness", found.value, found.error)
        scene.cite(
            "torsion of a round rod", "stiffness of the primary", "Baca Vasquez (2007), section 3.7"
        )
    if ring is not None:
        inertia = ring_inertia(ring.density, ring.outer_radius, ring.inner_radius, ring.width)
        scene.emit(f"{HARDWARE_ROOT}/ring_mass", inertia.mass.value, inertia.mass.error)
        scene.emit(f"{HARDWARE_ROOT}/ring_inertia", inertia.polar.value, inertia.polar.error)


def _emit_bending(scene: Scene, given: Bending) -> None:
    modes = {"mode": np.arange(1, given.modes + 1)}
    bending = bending_frequencies(given.rod, given.body, given.modes)
    scene.emit(f"{HARDWARE_ROOT}/bending/frequency", bending.value, bending.error, modes)
    if given.spin:
        whirl = whirl_frequencies(given.rod, given.body, given.spin, given.modes)
        scene.emit(
            f"{HARDWARE_ROOT}/bending/forward", whirl.forward.value, whirl.forward.error, modes
        )
        scene.emit(
            f"{HARDWARE_ROOT}/bending/backward", whirl.backward.value, whirl.backward.error, modes
        )
    guess = rayleigh_frequency(given.rod, given.body)
    scene.emit(f"{HARDWARE_ROOT}/bending/rayleigh", guess.value, guess.error)
    scene.cite(
        "characteristic determinant of an overhung beam with a rigid body on its end",
        "bending of the rod",
        "docs/theory_absorber_parts.md; Baca Vasquez (2007), section 3.16, for the quotient",
    )


def _emit_built(scene: Scene, parts: AbsorberParts) -> None:
    """Springs and oil that are in, and the response that they make."""
    if parts.scale is None or parts.absorber is None:
        return
    z1, m, k, _ = (float(np.asarray(part)) for part in parts.absorber)
    springs = parts.springs
    if springs is not None and springs.rate is not None and springs.stiffness is not None:
        ratio = springs.stiffness / parts.scale.stiffness
        scene.emit(f"{HARDWARE_ROOT}/built/stiffness_ratio", ratio, 40.0 * EPSILON * ratio)
        scene.emit(
            f"{HARDWARE_ROOT}/built/spring_rate", springs.rate, 16.0 * EPSILON * springs.rate
        )
    filled = parts.filling
    if filled is None or filled.oil is None:
        return
    of_oil = oil_damping(filled.oil, filled.gap, filled.temperature)
    size = of_oil.value / parts.scale.damping
    error = of_oil.error / parts.scale.damping + 8.0 * EPSILON * size
    scene.emit(f"{HARDWARE_ROOT}/built/secondary_damping", size, error)
    if not scene.wants(f"{HARDWARE_ROOT}/built/peak", f"{HARDWARE_ROOT}/built/peak_frequency"):
        return
    if springs is None or springs.rate is None:
        tuning = scene.case.tuning
        if tuning is None or tuning.kind not in ("viscous", "lanchester"):
            return
        k = 0.0
    pair = _pair(scene)
    top = peaks(Absorber(z1, m, k, float(size)), *pair)
    value = float(top.largest)
    uncertainty = float(top.largest_error) + 2.0 * value * (float(error / size) + 40.0 * EPSILON)
    scene.emit(f"{HARDWARE_ROOT}/built/peak", value, uncertainty if np.isfinite(value) else 0.0)
    place = float(top.where) * parts.scale.frequency
    scene.emit(
        f"{HARDWARE_ROOT}/built/peak_frequency", place, 1e-9 * place if np.isfinite(place) else 0.0
    )


def _emit_gap(scene: Scene, parts: AbsorberParts) -> None:
    filled = parts.filling
    if filled is None:
        return
    gap = filled.gap
    play = float(np.asarray(gap.rim_clearance))
    scene.emit(f"{HARDWARE_ROOT}/clearance", play, 8.0 * EPSILON * play)
    shares = gap_shares(gap)
    error = float(shares.total.error)
    for name in ("rim", "sides", "bore"):
        scene.emit(f"{HARDWARE_ROOT}/gap/{name}", float(getattr(shares, name)), error)
    scene.cite(
        "films between cylinders and at the sides of a ring",
        "damping from viscosity",
        "docs/theory_absorber_parts.md; Baca Vasquez (2007), equations 3.16, 3.17 and 3.19",
    )


def _emit_wanted(scene: Scene, parts: AbsorberParts, wanted: Absorber) -> None:
    """Rate of the springs and viscosity of the oil that the wanted tuning asks for."""
    scale, springs, filled = parts.scale, parts.springs, parts.filling
    if scale is None:
        return
    k, z2 = float(np.asarray(wanted.stiffness_ratio)), float(np.asarray(wanted.secondary_damping))
    if springs is not None:
        rate = rate_for_couple(k * scale.stiffness, springs.count, springs.radius, springs.angle)
        scene.emit(
            f"{HARDWARE_ROOT}/spring_rate",
            rate.value,
            float(rate.error) + 1e-11 * float(rate.value),
        )
    if filled is not None:
        thick = viscosity_for_damping(filled.gap, z2 * scale.damping)
        scene.emit(
            f"{HARDWARE_ROOT}/dynamic_viscosity",
            thick.value,
            thick.error + 1e-11 * float(thick.value),
        )


def _pair(scene: Scene) -> tuple[str, str]:
    tuning = scene.case.tuning
    if tuning is None:
        return "force", "displacement"
    return tuning.excitation, tuning.response


def _emit_warming(scene: Scene, parts: AbsorberParts, held: InstalledParts) -> None:

    tuning = scene.case.tuning
    if tuning is not None and tuning.temperatures is not None:
        emit_warming(scene, tuning, parts, held)

"""Adapter: rod, springs, ring, gap and oils of an absorber, and what to buy for its tuning."""

from typing import NamedTuple

import numpy as np

from vibecalc.absorber.adapters.band import problem_of
from vibecalc.absorber.adapters.optimum import limits_of
from vibecalc.absorber.asked_tables import Tuning
from vibecalc.absorber.hardware.oil_gap import (
    Oil,
    RingGap,
    gap_shares,
    kinematic_viscosity,
    oil_damping,
    right_temperature,
    viscosity_for_damping,
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
from vibecalc.absorber.model import AbsorberParts, Filling, Scale, build_absorber
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.results import (
    Bending,
    Built,
    Buy,
    DamperPairs,
    Films,
    Hardware,
    OilPairs,
    StockDampers,
    StockOils,
    StockSprings,
    Warming,
)
from vibecalc.absorber.stage import AS_TUNED, NO_SPRING, VISCOUS, is_banded
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.levels import at_least, largest_of_pairs
from vibecalc.absorber.tuning.restricted import given_damping, leading_pairs, stock_choice
from vibecalc.core.results.described import paths_of
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded, stack
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray

# ----------------------------------------------------------------------------
# What parts are, alone and as they are built together, and what a tuning asks of them.
# ----------------------------------------------------------------------------


def run_absorber_parts(scene: Scene) -> None:
    """Emit what the parts give, what the tuning asks of them, and the best parts in stock."""
    parts = build_absorber(scene.case)
    _emit_rod(scene, parts)
    if parts.scale is None or parts.absorber is None:
        return
    scene.emit_all(Hardware(primary_frequency=rounded(parts.scale.frequency, 16.0)))
    _emit_built(scene, parts, parts.scale, parts.absorber)
    tuned: Absorber | None = scene.handed_on.get("tuned")
    if parts.filling is not None:
        _emit_gap(scene, parts.filling)
    if tuned is not None:
        _emit_wanted(scene, parts, parts.scale, tuned)
    _emit_stock(scene, parts, parts.scale, tuned)


def _emit_rod(scene: Scene, parts: AbsorberParts) -> None:
    """Rod and ring, and how the rod bends."""
    rod, ring = scene.case.machine.rod, scene.case.machine.ring
    if rod is not None and rod.length is not None and rod.shear_modulus is not None:
        found = torsional_stiffness(rod.shear_modulus, rod.diameter, rod.length, rod.bore)
        scene.emit_all(Hardware(rod_stiffness=found))
        scene.cite(
            "torsion of a round rod", "stiffness of the primary", "Baca Vasquez (2007), section 3.7"
        )
    if ring is not None:
        body = ring_inertia(ring.density, ring.outer_radius, ring.inner_radius, ring.width)
        scene.emit_all(Hardware(ring_mass=body.mass, ring_inertia=body.polar))
    given = parts.bending
    if given is None:
        return
    modes = {"mode": np.arange(1, given.modes + 1)}
    scene.emit_all(
        Bending(frequency=bending_frequencies(given.rod, given.body, given.modes)), modes
    )
    if given.spin:
        whirl = whirl_frequencies(given.rod, given.body, given.spin, given.modes)
        scene.emit_all(Bending(forward=whirl.forward, backward=whirl.backward), modes)
    scene.emit_all(Bending(rayleigh=rayleigh_frequency(given.rod, given.body)))
    scene.cite(
        "characteristic determinant of an overhung beam with a rigid body on its end",
        "bending of the rod",
        "docs/theory_absorber_parts.md; Baca Vasquez (2007), section 3.16, for the quotient",
    )


def _emit_built(scene: Scene, parts: AbsorberParts, scale: Scale, absorber: Absorber) -> None:
    """Springs and oil that are in, and the response that they make."""
    springs, filled, tuning = parts.springs, parts.filling, scene.case.tuning
    sprung = springs is not None and springs.stiffness is not None
    if springs is not None and springs.stiffness is not None:
        scene.emit_all(Built(
            stiffness_ratio=rounded(springs.stiffness / scale.stiffness, 80.0),
            spring_rate=rounded(springs.rate or 0.0, 32.0),
        ))  # fmt: skip
    if filled is None or filled.oil is None:
        return
    drag = oil_damping(filled.oil, filled.gap, filled.temperature) / rounded(scale.damping, 14.0)
    scene.emit_all(Built(damping_over_primary_critical=drag))
    if not sprung and (tuning is None or tuning.kind not in VISCOUS):
        return
    k = absorber.stiffness_ratio if sprung else 0.0
    pair = ("force", "displacement") if tuning is None else (tuning.excitation, tuning.response)
    top = peaks(absorber._replace(stiffness_ratio=k, secondary_damping=drag.value), *pair)
    off = top.largest_error + 2.0 * top.largest * (drag.error / drag.value + 40.0 * EPSILON)
    place = top.where * scale.frequency
    scene.emit_all(Built(
        peak=Bounded(top.largest, off), peak_frequency=Bounded(place, 1e-9 * place)
    ))  # fmt: skip


def _emit_gap(scene: Scene, filled: Filling) -> None:
    """The clearance, and where the damping of the gap comes from."""
    shares = gap_shares(filled.gap)
    films = (Bounded(one, shares.total.error) for one in shares[:3])
    scene.emit_all(Hardware(clearance=rounded(filled.gap.rim_clearance, 16.0)))
    scene.emit_all(Films(*films))
    scene.cite(
        "films between cylinders and at the sides of a ring",
        "damping from viscosity",
        "docs/theory_absorber_parts.md; Baca Vasquez (2007), equations 3.16, 3.17 and 3.19",
    )


def _emit_wanted(scene: Scene, parts: AbsorberParts, scale: Scale, tuned: Absorber) -> None:
    """Rate of the springs and viscosity of the oil that the tuning asks for."""
    springs, filled = parts.springs, parts.filling
    exact = Bounded(np.ones(()), np.full((), 1e-11))
    if springs is not None:
        k = np.asarray(tuned.stiffness_ratio) * scale.stiffness
        rate = rate_for_couple(k, springs.count, springs.radius, springs.angle)
        scene.emit_all(Hardware(spring_rate=rate * exact))
    if filled is not None:
        thick = viscosity_for_damping(
            filled.gap, np.asarray(tuned.secondary_damping) * scale.damping
        )
        scene.emit_all(Hardware(dynamic_viscosity=thick * exact))


# ----------------------------------------------------------------------------
# What springs with oils, or with dampers, in stock give, and the pair with the lowest peak.
# ----------------------------------------------------------------------------


#: best pairs whose mixtures are shown, and pairs whose peaks are computed together
_SHOWN, _BLOCK = 10, 5000


class Offers(NamedTuple):
    """What every part in stock gives: names, N/m or N s/m, and ratios (n,) to the primary.

    Mixtures of kinds stand behind the `plain` ones.
    """

    names: tuple[str, ...]
    amount: FloatArray
    ratio: Bounded
    plain: int

    def some(self, places: IntArray) -> "Offers":
        """Those at some places, in their order."""
        names = tuple(self.names[place] for place in places)
        plain = int(np.sum(places < self.plain))
        return Offers(names, self.amount[places], self.ratio[places], plain)

    @property
    def kept(self) -> "Offers":
        """Without mixtures."""
        return self.some(np.arange(self.plain))


def _alone(name: str, ratio: object = 0.0, error: object = 0.0) -> Offers:
    """Nothing, or the part of the tuning, where the stock has none."""
    value, off = (np.atleast_1d(np.asarray(one, dtype=float)) for one in (ratio, error))
    return Offers((name,), np.zeros(1), Bounded(value, off), 1)


def _emit_stock(scene: Scene, parts: AbsorberParts, scale: Scale, tuned: Absorber | None) -> None:
    """Emit springs, dampers or oils and their pairs, and what the best oil does as it warms.

    In a line springs without dampers go with the damper of the tuning, and the other way round.
    """
    tuning, filled, in_line = scene.case.tuning, parts.filling, not scale.torsion
    springs = spring = _springs(parts, scale)
    dampers = damper = (
        _dampers(parts, scale) if filled is None else _oils(scene, parts, scale, filled, tuned)
    )
    if in_line and tuned is not None and (springs or dampers):
        off = scene.handed_on["tuned_uncertainty"]
        spring = springs or _alone(AS_TUNED, tuned.stiffness_ratio, off.stiffness)
        damper = dampers or _alone(AS_TUNED, tuned.secondary_damping, off.damping)
    viscous = tuning is not None and tuning.kind in VISCOUS
    undamped = tuning is not None and tuning.kind == "undamped_spring" and in_line
    spring = _alone(NO_SPRING) if viscous else spring
    damper = _alone(NO_SPRING) if undamped and damper else damper
    shown, best = (springs and springs.kept, dampers and dampers.kept), None
    if tuning is not None and tuned is not None and spring and damper:
        if tuning.norm == "h_infinity":
            choice = _Choice(scene, parts, tuning, tuned)
            spring, damper = choice.shortlist(spring, damper)
            shown = shown[0] if viscous else spring, shown[1] if undamped else damper
            best = choice.emit(spring, damper)
        elif not in_line:
            scene.warn(
                "stock parts are ranked by their largest peak, which is not what a mean square "
                'makes small: under norm = "h2" no pair of them is chosen'
            )
    if springs and shown[0]:
        axes = {"stock_spring": shown[0].names}
        scene.emit_all(StockSprings(shown[0].amount, shown[0].ratio), axes)
    if filled is None:
        if dampers and shown[1]:
            axes = {"stock_damper": shown[1].names}
            scene.emit_all(StockDampers(shown[1].amount, shown[1].ratio), axes)
        return
    if tuning is None or tuned is None or tuning.temperatures is None:
        return
    oil, k = filled.oil, 0.0 if viscous else None
    if best and spring and damper:
        k = float(spring.ratio.value[best[0]])
        oil = next(one for one in parts.stock.oils if one.name == damper.names[best[1]])
    elif parts.springs and parts.springs.stiffness and not viscous:
        k = parts.springs.stiffness / scale.stiffness
    if oil is not None and k is not None:
        _emit_warming(scene, tuning, tuned._replace(stiffness_ratio=k), scale, filled.gap, oil)


def _springs(parts: AbsorberParts, scale: Scale) -> Offers | None:
    springs, stock = parts.springs, parts.stock
    if springs is None or not stock.spring_names:
        return None
    counts = np.where(np.isnan(stock.spring_counts), springs.count, stock.spring_counts)
    found = couple_stiffness(stock.spring_rates, counts, springs.radius, springs.angle)
    ratio = found / rounded(scale.stiffness, 8.0)
    return Offers(stock.spring_names, stock.spring_rates, ratio, stock.plain_springs)


def _dampers(parts: AbsorberParts, scale: Scale) -> Offers | None:
    stock = parts.stock
    ratio = rounded(stock.dampings / scale.damping, 16.0)
    found = Offers(stock.damper_names, stock.dampings, ratio, stock.plain_dampers)
    return found if stock.damper_names else None


def _oils(
    scene: Scene, parts: AbsorberParts, scale: Scale, filled: Filling, tuned: Absorber | None
) -> Offers | None:
    """Emit what the oils in stock give that are known at the temperature of the gap."""
    oils, found = [], []
    for oil in parts.stock.oils:
        try:
            line = kinematic_viscosity(oil.line, filled.temperature)
            drag = oil_damping(oil, filled.gap, filled.temperature)
        except NumericalFailure as failure:
            scene.warn(f"oil {oil.name!r} in stock is left out: {failure}")
            continue
        oils.append(oil)
        found.append((line, drag))
    if not oils:
        return None
    thick, damping = (stack(column) for column in zip(*found, strict=True))
    ratio, axes = damping / rounded(scale.damping, 14.0), {"stock_oil": [one.name for one in oils]}
    scene.emit_all(StockOils(thick, damping, ratio), axes)
    if tuned is not None:
        wanted = float(np.asarray(tuned.secondary_damping)) * scale.damping
        right = stack([right_temperature(oil, filled.gap, wanted) for oil in oils])
        scene.emit_all(StockOils(right_temperature=right), axes)
    scene.cite(
        "straight line of ASTM D341 through two viscosities (in mm^2/s and K, so that it does not "
        "scale with the units of a case), density by API MPMS 11.1",
        "viscosity against temperature",
        "ASTM D341; Baca Vasquez (2007), equation 3.18",
    )
    return Offers(tuple(axes["stock_oil"]), damping.value, ratio, len(oils))


class _Choice:
    """Pairs of parts in stock, by their largest response, within the bounds of the tuning."""

    def __init__(self, scene: Scene, parts: AbsorberParts, tuning: Tuning, tuned: Absorber) -> None:
        self.scene, self.tuning, self.tuned, self.stock = scene, tuning, tuned, parts.stock
        self.limits, self.problem = limits_of(tuning), None
        if is_banded(scene.case):
            self.problem = problem_of(tuning, parts, scene.case.machine)

    def largest(self, k: FloatArray, z: FloatArray, response: str) -> tuple[FloatArray, FloatArray]:
        """Largest response, or travel, of springs and dampers (they broadcast), and its error."""
        if self.problem is not None:
            return largest_of_pairs(self.problem, k, z, response)
        what = "relative_displacement" if response == "travel" else response
        pairs = self.tuned._replace(stiffness_ratio=k, secondary_damping=z)
        found = peaks(pairs, self.tuning.excitation, what)
        return found.largest, found.largest_error

    def height(self, k: FloatArray, z: FloatArray) -> FloatArray:
        """Largest response (n,) of pairs, infinite of those that travel too far."""
        found, _ = self.largest(k, z, self.tuning.response)
        if np.isfinite(self.limits.travel):
            found = np.where(self.largest(k, z, "travel")[0] <= self.limits.travel, found, np.inf)
        return found

    def below(self, k: FloatArray, z: FloatArray) -> FloatArray:
        """What the largest response of pairs (n,) is not below."""

        def bound(k: FloatArray, z: FloatArray) -> FloatArray:
            if self.problem is None:
                return self.largest(k, z, self.tuning.response)[0]
            return at_least(self.problem, k, z, *self.scene.handed_on["band_active"])

        blocks = np.array_split(np.arange(len(k)), 1 + len(k) // _BLOCK)
        return np.concatenate([bound(k[some], z[some]) for some in blocks])

    def shortlist(self, springs: Offers, dampers: Offers) -> tuple[Offers, Offers]:
        """Of mixtures those that stand in the best pairs of all; everything else stays."""
        if self.stock.unmixed:
            self.scene.warn(
                "kinds in stock are so many that not all of their mixtures are tried: give fewer "
                "kinds, or a lower parallel"
            )
        sides = (springs, self.limits.stiffness), (dampers, self.limits.damping)
        if not any(len(one.names) > one.plain for one, _ in sides):
            return springs, dampers
        k, z = springs.ratio.value, dampers.ratio.value
        inside = [
            (low <= one.ratio.value) & (one.ratio.value <= high) for one, (low, high) in sides
        ]
        allowed = np.logical_and.outer(*inside)
        pairs = leading_pairs(k, z, allowed, self.height, self.below, _SHOWN)
        used = np.array(pairs, dtype=int).reshape(-1, 2).T
        shown = (np.union1d(np.arange(one.plain), places) for (one, _), places in zip(
            sides, used, strict=True))  # fmt: skip
        first, second = (one.some(places) for (one, _), places in zip(sides, shown, strict=True))
        return first, second

    def emit(self, springs: Offers, dampers: Offers) -> tuple[int, int] | None:
        """Emit the peak of every pair and the best one, whose places are given.

        None, with a warning, where no pair keeps the bounds.
        """
        in_gap = self.scene.case.machine.gap is not None
        group = OilPairs if in_gap else DamperPairs
        k, z, limits = springs.ratio, dampers.ratio, self.limits
        least = float(self.largest(
            np.asarray(self.tuned.stiffness_ratio), np.asarray(self.tuned.secondary_damping),
            self.tuning.response,
        )[0])  # fmt: skip
        try:
            choice = stock_choice(
                k.value, z.value, least, self.largest, self.tuning.response, **limits._asdict()
            )
        except NumericalFailure as failure:
            chosen = *paths_of(group), *paths_of(Buy), *paths_of(Warming)
            if not (self.scene.wanted or frozenset()).isdisjoint(chosen):
                raise
            self.scene.warn(f"no stock parts chosen: {failure}")
            return None
        stray = k.error[:, None] / np.where(k.value > 0.0, k.value, 1.0)[:, None]
        stray = stray + z.error / np.where(z.value > 0.0, z.value, 1.0)
        finite = np.isfinite(choice.peak)
        top = np.where(finite, choice.peak, 0.0)
        error = np.where(finite, choice.error, 0.0) + 4.0 * top * (1.0 + top) * stray
        self.scene.emit_all(
            group(
                Bounded(choice.peak, error),
                Bounded(choice.penalty, 2.0 * error / least),
                Bounded(choice.travel, 1e-9 * choice.travel),
                choice.allowed.astype(int),
            ),
            {"stock_spring": springs.names, f"stock_{group.WORDS['part']}": dampers.names},
        )
        best = choice.spring, choice.oil
        peak = Bounded(choice.peak[best], error[best])
        if choice.unsure:
            self.scene.warn(
                "the best two pairs of stock parts differ by less than the error of their peaks"
            )
        self.scene.emit_all(Buy(peak, Bounded(peak.value / least - 1.0, 2.0 * peak.error / least)))
        return best


def _emit_warming(
    scene: Scene, options: Tuning, held: Absorber, scale: Scale, gap: RingGap, oil: Oil
) -> None:
    """Damping and peak at each temperature, springs kept; and the springs that would be best.

    Stiffnesses are taken as constant: those of steel fall by some 3 per cent over 100 K.
    """
    asked, pair = options.temperatures, (options.excitation, options.response)
    if asked is None:
        return
    warm = np.linspace(asked.start, asked.stop, asked.points)
    damping = oil_damping(oil, gap, warm)
    share = damping / rounded(scale.damping, 14.0)

    def top(share: FloatArray) -> FloatArray:
        return peaks(held._replace(secondary_damping=share), *pair).largest

    peak, moved = with_errors(top, share)
    own = peaks(held._replace(secondary_damping=share.value), *pair).largest_error
    axes = {"temperature": warm}
    scene.emit_all(Warming(damping, share, Bounded(peak, own + moved)), axes)
    if options.kind in VISCOUS:
        return
    best = given_damping(held.primary_damping, held.mass_ratio, share.value, *pair)
    # the spring follows the damping that the oil gives
    spread = 4.0 * share.error / share.value
    finite = np.isfinite(best.value)
    value, off = (np.where(finite, one, 0.0) for one in (best.value, best.value_error))
    scene.emit_all(
        Warming(
            best_stiffness_ratio=Bounded(value, off + value * spread),
            best_peak=Bounded(best.largest, best.largest_error + best.largest * spread),
        ),
        axes,
    )

"""Limits of a crankshaft by IACS UR M53, and how far each place of a throw is from them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray
from vibecalc.torsion.adapters.bounds import Bound, made
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.crank_strength import (
    ACCEPTABILITY,
    CRANKSHAFT_KINDS,
    PLACES,
    CrankThrow,
    NominalBending,
    bending_stresses,
    equivalent_stress,
    fatigue_strength,
    permissible_torsion,
    stress_concentration,
    torsion_ratio,
)
from vibecalc.torsion.limit_tables import Crank, TorsionLimit
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.shaft_line_tables import Throw

if TYPE_CHECKING:
    from vibecalc.torsion.adapters.limits import LimitTable

# ----------------------------------------------------------------------------
# Adapter: the nominal torsional stress of the pin with which the worst place of a throw just keeps
# its acceptability factor, as a limit of the stress.
#
# The factor falls as that stress rises, so that a use below one is a factor above 1.15.
# ----------------------------------------------------------------------------

#: relative, of sums of many terms that cancel in stress concentration factors
CANCELLED = 4096.0


class Judged:
    """Throws (r,) of a limit: stress concentration, fatigue strength, bending and torsion."""

    def __init__(self, setup: Setup, limit: TorsionLimit) -> None:
        shaft = setup.shaft
        names = shaft.section_names[: len(shaft.throws)]
        usable = [limit.crank or (one if one is not None and one.pin_fillet else None)
                  for one in shaft.throws]  # fmt: skip
        asked = limit.sections or [
            name for name, one in zip(names, shaft.throws, strict=True) if one and one.pin_fillet
        ]
        self.load = np.array([e for e, name in enumerate(names) if name in asked], dtype=np.int64)
        radius = float(setup.drive.geometry.crank_radius)
        self.throw = crank_throws([one for e in self.load if (one := usable[e])], radius)
        given = shaft.tensile_strength[self.load]
        self.tensile = np.where(given > 0.0, given, limit.tensile_strength or 0.0)
        self.kind_factor = CRANKSHAFT_KINDS[limit.crankshaft_kind or "free_form"]
        self.concentration = stress_concentration(self.throw)
        self.strength = fatigue_strength(self.throw, self.tensile, self.kind_factor)
        self.bending = bending_stresses(self.concentration, nominal_bending(limit))
        self.bored = np.stack(
            [*np.ones((2, len(self.load)), bool), self.throw.oil_bore > 0.0], axis=-1
        )
        #: torsional stress at the places over the nominal one of the pin
        self.torsion = self.concentration.torsion * torsion_ratio(self.throw)

    def allowed(self) -> FloatArray:
        """Nominal torsional stress (r,) of the pin with which the worst place has 1.15."""
        most = permissible_torsion(self.bending, self.strength)
        return np.min(most / np.where(self.bored, self.torsion, 1.0),
                      axis=-1, where=self.bored, initial=np.inf)  # fmt: skip

    def made_of(self, name: str) -> FloatArray:
        """What the factors come from (r, 3), by the names of the results."""
        parts = {
            "bending_factor": self.concentration.bending,
            "torsion_factor": self.concentration.torsion,
            "bending_stress": self.bending,
            "fatigue_strength": self.strength,
        }
        return parts[name]

    def acceptability(self, stress: Bounded) -> Bounded:
        """Q (r, 3) for nominal torsional stresses (r,) of the pin; 0 where nothing bounds them."""
        endless = ~np.isfinite(stress.value)
        size = np.where(endless, 0.0, stress.value)[:, None]
        error = np.broadcast_to(stress.error, stress.shape)[:, None]

        def factor(torsion: FloatArray) -> FloatArray:
            found = equivalent_stress(self.bending, self.torsion * torsion)
            some = (found > 0.0) & self.bored & ~endless[:, None]
            return np.where(some, self.strength / np.where(some, found, 1.0), 0.0)

        value = factor(size)
        low, high = factor(size + error), factor(np.maximum(size - error, 0.0))
        moved = np.maximum(np.abs(value - low), np.abs(high - value))
        return Bounded(value, moved + CANCELLED * UNIT_ROUNDOFF * value)


def crank_throws(given: Sequence[Crank | Throw], crank_radius: float) -> CrankThrow:
    """Dimensions (r,) of throws of a case."""
    keys = CrankThrow._fields
    rows = [
        [crank_radius if key == "crank_radius" else getattr(one, key) or 0.0 for key in keys]
        for one in given
    ]
    return CrankThrow(*np.array(rows, dtype=float).reshape(-1, len(keys)).T)


def nominal_bending(limit: TorsionLimit) -> NominalBending:
    """Stresses of the case that are not of torsion."""
    one = limit.bending
    assert one is not None  # the rule needs it, says the form
    given = (one.web, one.compressive, one.oil_bore or 0.0, one.additional)
    return NominalBending(*(np.asarray(stress) for stress in given))


def crank_bound(setup: Setup, limit: TorsionLimit) -> Bound:
    """IACS UR M53 as a limit of the nominal torsional stress of the pin, at every speed."""
    judged = Judged(setup, limit)
    level, throw = judged.allowed(), judged.throw
    modulus = np.pi / 16.0 * (throw.pin_diameter**4 - throw.pin_bore**4) / throw.pin_diameter
    bound = made(
        setup,
        judged.load,
        modulus,
        "stress",
        lambda speed: np.broadcast_to(level, (*speed.shape, len(level))),
    )
    basis = bound.basis._replace(
        diameter=throw.pin_diameter, tensile_strength=judged.tensile, rated_speed=setup.speed
    )
    most = judged.strength / ACCEPTABILITY
    near = np.max(most / np.maximum(most - judged.bending, 1e-9 * most), initial=1.0)
    return bound._replace(basis=basis, roundings=CANCELLED * float(near))


def emit_crank(scene: Scene, setup: Setup, table: "LimitTable", stresses: list[Bounded],
               name: str) -> None:  # fmt: skip
    """Acceptability factors for nominal stresses (r,) of each limit; what they are made of, once.

    `name` is the result of these factors.
    """
    limits = setup.torsion.limits
    judged = [Judged(setup, one) if one.rule == "iacs_m53" else None for one in limits]
    if not any(judged):
        return

    def put(path: str, rows: list[Bounded | None]) -> None:
        shape = (len(rows), len(table.columns), len(PLACES))
        value, error = np.zeros(shape), np.zeros(shape)
        for number, (row, place) in enumerate(zip(rows, table.places, strict=True)):
            if row is not None:
                columns = np.searchsorted(table.columns, place)
                value[number, columns] = row.value
                error[number, columns] = row.error
        axes = {**table.axes, "crank_place": PLACES}
        scene.emit(f"{ROOT}/limit/crank/{path}", value, error, axes)

    def known(value: FloatArray) -> Bounded:
        return Bounded(value, CANCELLED * UNIT_ROUNDOFF * np.abs(value))

    pairs = list(zip(judged, stresses, strict=True))
    put(name, [one.acceptability(stress) if one else None for one, stress in pairs])
    if name == "acceptability":
        return
    bored = [None if one is None else one.bored for one in judged]
    for path in ("bending_factor", "torsion_factor", "bending_stress", "fatigue_strength"):
        rows = [None if one is None else one.made_of(path) for one in judged]
        put(path, [known(row * on) if row is not None else None
                   for row, on in zip(rows, bored, strict=True)])  # fmt: skip

"""A crankshaft by IACS UR M53: how far each place of a throw is from its limit."""

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.crank_strength import (
    ACCEPTABILITY,
    CRANKSHAFT_KINDS,
    bending_stresses,
    crank_throws,
    equivalent_stress,
    fatigue_strength,
    permissible_torsion,
    stress_concentration,
    torsion_ratio,
)
from vibecalc.torsion.question_tables import TorsionLimit

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
        assert limit.bending is not None  # the rule needs it, says the form
        self.bending = bending_stresses(self.concentration, limit.bending)
        self.bored = np.stack(
            [*np.ones((2, len(self.load)), bool), self.throw.oil_bore > 0.0], axis=-1
        )
        #: torsional stress at the places over the nominal one of the pin
        self.torsion = self.concentration.torsion * torsion_ratio(self.throw)

    def allowed(self) -> FloatArray:
        """Nominal torsional stress (r,) of the pin with which the worst place has 1.15."""
        most = permissible_torsion(self.bending, self.strength)
        each = np.where(self.bored, most / np.where(self.bored, self.torsion, 1.0), np.inf)
        return np.asarray(np.min(each, axis=-1))

    def roundings(self) -> float:
        """Relative error of what is allowed, in units of rounding: bending is taken off."""
        most = self.strength / ACCEPTABILITY
        near = most / np.maximum(most - self.bending, 1e-9 * most)
        return CANCELLED * float(np.max(near, initial=1.0))

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

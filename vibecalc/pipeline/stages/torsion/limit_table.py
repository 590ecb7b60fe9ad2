"""Adapter: limits of a shaft line in a table by section, and the stress at the operating speed."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion import ROOT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.bounds import Bound, bounds
from vibecalc.pipeline.stages.torsion.setup import Setup

PLACE = f"{ROOT}/limit"
ROUNDING = 64.0 * EPSILON


def operating_uses(setup: Setup, torque: FloatArray) -> list[FloatArray]:
    """Stress over allowed (r,) by limit at the operating speed; own half ranges (e,) of torques."""
    modulus, at = setup.shaft.section_modulus, np.array(setup.speed)
    return [
        np.asarray(torque[bound.section] / (modulus[bound.section] * bound.continuous(at)))
        for bound in bounds(setup)
    ]


def emit_operating_use(scene: Scene, setup: Setup, torque: FloatArray, error: FloatArray) -> None:
    """Limits and what they are made of, with the stress at the operating speed.

    Own half ranges (e,) of torques and their errors.
    """
    asked, at = bounds(setup), np.array(setup.speed)
    modulus = setup.shaft.section_modulus
    uses, doubts = operating_uses(setup, torque), operating_uses(setup, error)
    largest_use = np.array([np.max(one, initial=0.0) for one in uses])
    doubt = np.array([np.max(one, initial=0.0) for one in doubts]) + ROUNDING * largest_use
    table = LimitTable(scene, setup, asked)
    scene.emit(f"{PLACE}/operating_use", largest_use, doubt, table.axes)
    rated = np.array([bound.basis.rated_speed for bound in asked])
    scene.emit(f"{PLACE}/basis/rated_speed", rated, 0.0, table.axes)
    for name in ("diameter", "tensile_strength", "counted_strength", "design_factor"):
        table.emit(f"basis/{name}", [getattr(bound.basis, name) for bound in asked])
    table.emit("basis/size_factor", [bound.basis.size_factor for bound in asked], ROUNDING)
    stress = [torque[bound.section] / modulus[bound.section] for bound in asked]
    off = [error[bound.section] / modulus[bound.section] for bound in asked]
    table.emit("operating/stress", stress, ROUNDING, off)
    table.emit("operating/allowed", [bound.continuous(at) for bound in asked], ROUNDING)
    table.emit("operating/transient", [bound.transient(at) for bound in asked], ROUNDING)
    table.emit("operating/use", uses, ROUNDING, doubts)


class LimitTable:
    """Emits values by limit and section; columns are the sections that some limit is for."""

    def __init__(self, scene: Scene, setup: Setup, asked: list[Bound]) -> None:
        self.scene, self.places = scene, [bound.section for bound in asked]
        self.columns = np.unique(np.concatenate(self.places))
        names = tuple(setup.shaft.section_names[e] for e in self.columns)
        self.axes = {"limit": np.arange(1, len(asked) + 1), "section": names}

    def emit(
        self,
        path: str,
        rows: list[FloatArray],
        relative: float = 0.0,
        errors: list[FloatArray] | None = None,
    ) -> None:
        """Rows (r,) of each limit, with absolute errors like them and a relative one."""
        values = self._filled(rows)
        off = relative * np.where(np.isfinite(values), np.abs(values), 0.0)
        if errors is not None:
            off = off + self._filled(errors)
        self.scene.emit(f"{PLACE}/{path}", values, off, self.axes)

    def _filled(self, rows: list[FloatArray]) -> FloatArray:
        found = np.zeros((len(rows), len(self.columns)))
        for line, place, row in zip(found, self.places, rows, strict=True):
            line[np.searchsorted(self.columns, place)] = row
        return found

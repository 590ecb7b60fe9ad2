"""Pumps: the shipped case with some keys set, and the arrays of its cylinder."""

import copy
from typing import Any

from shipped_cases import table_of

from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import set_key
from vibecalc.excitation.pressure_cycle import Liquid
from vibecalc.parts.geometry import CrankGeometry
from vibecalc.schema import Case

GEOMETRY = CrankGeometry(0.025, 0.125, 0.04)
LIQUID = Liquid(2e5, 100e5, 1.8e9, 30e-6)
#: four mounts, even about the plane of the crank: a body with all six motions
FOUR = [[x, y, -0.2] for x in (-0.3, 0.3) for y in (-0.35, 0.35)]


def table_with(**settings: Any) -> dict[str, Any]:
    """The shipped case as TOML reads it, without references and limits; `__` stands for a dot."""
    table = copy.deepcopy(table_of("pump"))
    for key in ("reference", "reference_table", "limit"):
        table.pop(key)
    for key, value in settings.items():
        set_key(table, key.replace("__", "."), value)
    return table


def pump_with(**settings: Any) -> Case:
    """The same, validated."""
    return validate(table_with(**settings))

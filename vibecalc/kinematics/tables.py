"""The table [kinematics] of a case."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import Table, key
from vibecalc.core.case.rules import by_kind


class Kinematics(Table):
    """Piston motion over one revolution."""

    series: Literal["exact", "truncated"] = key(
        "exact motion, or the binomial series in (R/L)^2 truncated after `terms`", "exact"
    )
    terms: Annotated[int, Field(strict=True, ge=1, le=400)] | None = key(
        "terms of the truncated series; 1: first and second order", None
    )
    RULES = (by_kind("", key="series", exact="", truncated="terms"),)

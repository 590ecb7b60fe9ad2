"""The table [kinematics] of a case."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Table,
    key,
)
from vibecalc.core.case.rules import by_kind


class Kinematics(Table):
    """Motion of the pistons; present, it also puts the motion over one turn into the result."""

    series: Literal["exact", "truncated"] = key(
        "exact motion, or the binomial series in (R/L)^2 cut after `terms`", "exact"
    )
    terms: Annotated[int, Field(strict=True, ge=1, le=400)] | None = key(
        "terms of a truncated series; 1 is the classic first and second order", None
    )
    RULES = (by_kind("", key="series", exact="", truncated="terms"),)

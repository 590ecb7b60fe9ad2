"""Keys of a case that are fitted to what was measured of the machine."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import Table
from vibecalc.core.case.raw import tables_at
from vibecalc.core.case.rules import Row, refuse
from vibecalc.core.case.study_tables import Variable
from vibecalc.errors import Problem


def _points(row: Row) -> Iterator[Problem]:
    """A fit needs something measured."""
    kinds = [
        one.get("kind", "published")
        for name in ("reference", "reference_table")
        for _, one in tables_at(row.case, name)
    ]
    wanted = row["references"]
    if kinds and (wanted == "all" or wanted in kinds):
        return
    yield row.problem(
        "",
        "there is nothing to fit to: the case has no "
        + ("[[reference]]" if wanted == "all" else f"[[reference]] of kind {wanted!r}"),
        allowed='[[reference]] or [[reference_table]] with kind = "measured"',
        hint='references = "all" takes published ones, too' if kinds else "",
    )


_FIRST = "write the values of the fit into the case, then search"


class Fit(Table):
    """Change some keys within bounds until the results come closest to what was measured."""

    variables: tuple[Variable, ...] = Field(min_length=1, max_length=32, description="what to fit")
    references: Literal["measured", "all"] = Field(
        "measured",
        description="what it is fitted to: references of kind measured, or all of them; those with "
        "a known_difference are left out",
    )
    starts: Annotated[int, Field(strict=True, ge=0, le=1000)] = Field(
        4, description="starting points spread over the bounds, besides the case as written"
    )
    RULES = (
        refuse(
            "",
            "a case with [optimisation] cannot have [fit], too",
            lambda t: "optimisation" in t.case,
            "one or the other",
            hint=_FIRST,
            also=("optimisation",),
        ),
        refuse(
            "",
            "a case with [[find]] cannot have [fit], too",
            lambda t: "find" in t.case,
            "one or the other",
            hint=_FIRST,
            also=("find",),
        ),
        refuse(
            "variables",
            "a fit moves numbers between bounds, it picks nothing from lists",
            lambda t: any("choices" in one or "integer" in one for one in t.each("variables")),
            "lower and upper",
            hint="[optimisation] picks from lists",
        ),
        _points,
        "vibecalc.core.case.search_checks:check_variables",
    )

    @property
    def moving(self) -> tuple[Variable, ...]:
        """The variables, all of which lie between bounds."""
        return self.variables

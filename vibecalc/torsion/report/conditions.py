"""Conditions of the cylinders in words, and the folders of their results."""

import numpy as np

from vibecalc.core.report.rows import Made, part_of
from vibecalc.core.report.sections import table_of
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import asked

#: folders of the line with all cylinders firing, and in conditions of the cylinders
VARIANTS = ("healthy/", "conditions/")
#: how the names of conditions of one cylinder end -> what is said of it
_CONDITIONS = {" misfires": "misfire", " out of balance": "imbalance"}


def condition_words(name: str) -> str:
    """A condition of the cylinders by its name in the file: `misfire of cylinder 5`."""
    for end, words in _CONDITIONS.items():
        if name.endswith(end):
            return f"{words} of cylinder {name.removesuffix(end)}"
    return name


def in_words(made: Made) -> Made:
    """Names of conditions as people read them."""

    def said(record: Record) -> Quantity | None:
        found = made(record)
        if found is None:
            return None
        return part_of(found, np.array([condition_words(str(one)) for one in found.values]),
                       *found.axes)  # fmt: skip

    return said


def variant_words(result: Result, variant: str) -> str:
    """What the cylinders do in a variant: `one cylinder misfiring`."""
    if variant == "healthy/":
        return "all cylinders firing"
    given = table_of(asked(result), "conditions")
    words = ["one cylinder misfiring"] * (given.get("misfire") != "none")
    words += ["one cylinder out of balance"] * bool(given.get("imbalance"))
    words += ["the given cylinder pressures"] * bool(given.get("pressure_scale"))
    return " or ".join(words)

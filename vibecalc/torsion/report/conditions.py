"""Conditions of the cylinders in words, and the folders of their results."""

from vibecalc.core.report.sections import table_of
from vibecalc.core.results.record import Result
from vibecalc.torsion.report.line import asked

#: folders of the line with all cylinders firing, and in conditions of the cylinders
VARIANTS = ("healthy/", "conditions/")


def variant_words(result: Result, variant: str) -> str:
    """What the cylinders do in a variant: `one cylinder misfiring`."""
    if variant == "healthy/":
        return "all cylinders firing"
    given = table_of(asked(result), "conditions")
    words = ["one cylinder misfiring"] * (given.get("misfire") != "none")
    words += ["one cylinder out of balance"] * bool(given.get("imbalance"))
    words += ["the given cylinder pressures"] * bool(given.get("pressure_scale"))
    return " or ".join(words)

"""Names of the shafts of a line, and which of them have a stress."""

from vibecalc.case.shaft_parts import Shaft, ShaftLine
from vibecalc.machine.shaft_line_graph import shaft_ends


def section_names(line: ShaftLine) -> list[str]:
    """Names of the shafts of a line, those without one after their ends."""
    pairs = zip(line.shafts, shaft_ends(line), strict=True)
    return [shaft.name or " - ".join(ends) for shaft, ends in pairs]


def has_stress(shaft: Shaft) -> bool:
    """Whether the case says enough for torque over section modulus."""
    given = (shaft.diameter, shaft.section_modulus, shaft.section, shaft.throw)
    return any(one is not None for one in given)

"""Rules for torsional vibration of shafts, as data: edition, scope and numbers, all informative.

A verdict by these rules is a reading aid. The societies apply their own current text; what is
written here follows the editions named and has not been checked against a bought copy.
"""

from typing import NamedTuple


class Rule(NamedTuple):
    """Where a limit comes from, what it is for and what it is not for."""

    name: str
    edition: str
    scope: str
    not_for: str
    measure: str
    status: str = "informative"


M68 = Rule(
    "IACS UR M68",
    "Rev.3, February 2021",
    "propulsion shafts (intermediate, thrust and propeller shafts) of traditional forged design, "
    "from 0 to 105 % of the rated speed",
    "crankshafts (UR M53), shafts of gears, electric motors, generators and turbines, additional "
    "strengthening for ice",
    "half range of the synthesis of all orders, nominal stress of the plain section",
)
API_618 = Rule(
    "API 618 torsional separation",
    "5th edition, 2007",
    "trains with reciprocating compressors: undamped torsional natural frequencies",
    "stress or torque limits; engines under a classification rule",
    "distance of a natural frequency from multiples of the operating speed",
)
API_684 = Rule(
    "API 617 / 684 torsional separation",
    "API RP 684, 2nd edition, 2005",
    "trains of turbomachinery: undamped torsional natural frequencies",
    "reciprocating machines with many orders",
    "distance of a natural frequency from one and two times the operating speed",
)
API_671 = Rule(
    "API 671",
    "4th edition, 2007",
    "special-purpose couplings: data sheet of stiffness and torque; separation as API 684",
    "limits on torsional stress",
    "distance of a natural frequency from one and two times the operating speed",
)
USER_TABLE = Rule(
    "table of the case",
    "as given",
    "what the case says it is for",
    "speeds outside the table",
    "as the case says",
)


class Separation(NamedTuple):
    """Least relative distance from the range of each order; orders not listed carry none."""

    rule: Rule
    margin: dict[float, float]


SEPARATIONS = {
    "api_618": Separation(API_618, {1.0: 0.10, **{float(n): 0.05 for n in range(2, 11)}}),
    "api_684": Separation(API_684, {1.0: 0.10, 2.0: 0.10}),
    "api_671": Separation(API_671, {1.0: 0.10, 2.0: 0.10}),
}

#: c_K of M68 by the design of the shaft. The first three stand so in a society's public rules; the
#: others are as the table of M68 is commonly quoted.
DESIGN_FACTORS = {
    "intermediate_flange": 1.0,
    "intermediate_shrink_fit": 1.0,
    "intermediate_keyway_tapered": 0.60,
    "intermediate_keyway_cylindrical": 0.45,
    "intermediate_radial_hole": 0.50,
    "intermediate_slot": 0.30,
    "thrust_collar": 0.85,
    "thrust_roller_bearing": 0.85,
    "propeller_flange_or_keyless": 0.55,
    "propeller_key": 0.55,
    "propeller_forward": 0.80,
}
#: Pa: tensile strength that M68 lets count at most, by material and part
STRENGTH_CAPS = {"carbon": 600e6, "alloy": 800e6, "propeller": 600e6}

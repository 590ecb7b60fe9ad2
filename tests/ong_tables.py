"""Ong (2000), the convertible compressor: its data in the source's units and its printed tables.

Two cylinders in a row, A and B, on a vertical crankshaft (z); both strokes are along y. Units are
lbf, in and s. Where text and script files differ, the data are those of the script files, with
which the tables were computed; what is known of the rest is at its line.
"""

from pathlib import Path

import numpy as np

from vibecalc.numerics.linear import Linear

PRINTED = Path(__file__).parent / "published"
POUND_FORCE, INCH, POUND = 4.4482216152605, 0.0254, 0.45359237
ENERGY = POUND_FORCE * INCH

SPEED, RADIUS, LENGTH = 361.0, 0.5, 2.375
ORDERS = np.array([1, *range(2, 81, 2)])
#: the runs used neither 386.088 (text) nor 384.088 (script files)
GRAVITY = 386.4
#: distances of the cylinders from the mass centre, along -z
LEVER_A, LEVER_B = 3.835, 5.71
#: rod length 2.374 here, as in the script files; 2.375 everywhere else
RECIPROCATING = (0.659 + 0.075 + 0.625 * 0.131 / 2.374) / GRAVITY
ROTATING = 0.131 / GRAVITY * 1.75 / 2.375

MASS = np.diag([0.206, 0.206, 0.206, 3.37, 2.97, 1.45])
#: +.49 in the text
MASS[4, 5] = MASS[5, 4] = -0.49
#: 382 is 282 in the text
STIFFNESS = np.array(
    [
        [1328, 18.9, 14.1, 101, -2123, 385],
        [18.9, 1355, 36.4, 2246, -141, 96.7],
        [14.1, 36.4, 1079, -115, -159, 32.9],
        [101, 2246, -115, 23046, -903, 382],
        [-2123, -141, -159, -903, 30870, -2006],
        [385, 96.7, 32.9, 382, -2006, 14486],
    ]
)

_LENGTHS = np.array([1.0, 1.0, 1.0, INCH, INCH, INCH])
#: a load (6,) in lbf and in lbf, as SI
LOAD = POUND_FORCE * _LENGTHS
_PAIRS = np.outer(_LENGTHS, _LENGTHS) * POUND_FORCE / INCH


def si_matrices(loss_factor: float = 0.0) -> Linear:
    """The machine in SI; entries count as exact to the rounding of the conversion."""
    mass, stiffness = MASS * _PAIRS, STIFFNESS * _PAIRS
    nothing, rounding = np.zeros((6, 6)), 2.0**-51
    structural = loss_factor * stiffness
    errors = (rounding * np.abs(part) for part in (mass, stiffness, nothing, structural))
    return Linear(mass, stiffness, nothing, structural, *errors)


#: piston accelerations in in/s^2 of the orders above, cut off after six digits
APPENDIX_I = """
65160.5 13873.2 -157.221 2.00448 -0.0252405 0.000312864 -3.8293E-6 4.64107E-8 -5.58169E-10
6.67161E-12 -7.93424E-14 9.39642E-16 -1.10888E-17 1.30469E-19 -1.53108E-21 1.7927E-23 -2.09486E-25
2.44364E-27 -2.84601E-29 3.30997E-31 -3.84468E-33 4.46062E-35 -5.1698E-37 5.98599E-39 -6.92493E-41
8.00463E-43 -9.24575E-45 1.06718E-46 -1.23099E-48 1.4191E-50 -1.63502E-52 1.88281E-54 -2.16707E-56
2.49309E-58 -2.86682E-60 3.29452E-62 -3.77895E-64 4.29632E-66 -4.69725E-68 4.46051E-70 -2.70029E-72
""".split()  # noqa: SIM905

#: kinetic energies in in lbf by order (last row: totals), for cylinders A and B, A, B at work
TABLE_4_1 = (PRINTED / "ong_table_4_1.txt").read_text(encoding="ascii")

#: potential energies, likewise
TABLE_4_3 = (PRINTED / "ong_table_4_3.txt").read_text(encoding="ascii")

#: kinetic and potential energy by the crankshaft, keyed by cylinders at work and balanced for
TABLE_4_2 = {
    ("AB", "AB"): ("0", "0"),
    ("A", "AB"): ("2.176216E-02", "1.709964E-03"),
    ("B", "AB"): ("3.503765E-02", "2.817279E-03"),
    ("AB", "A"): ("3.503765E-02", "2.817279E-03"),
    ("A", "A"): ("0", "0"),
    ("AB", "B"): ("2.176216E-02", "1.709964E-03"),
    ("B", "B"): ("0", "0"),
}
#: sums of tables 4.1 and 4.2, likewise; (B, AB) is cut off, all others are rounded
TABLE_4_5 = {
    ("AB", "AB"): "0.07148",
    ("AB", "A"): "0.10652",
    ("AB", "B"): "0.09324",
    ("A", "AB"): "0.63686",
    ("A", "A"): "0.61510",
    ("B", "AB"): "1.01021",
    ("B", "B"): "0.97518",
}
#: sums of tables 4.3 and 4.2; (B, AB) is a misprint, its terms are right
TABLE_4_6 = {
    ("AB", "AB"): "0.00468",
    ("AB", "A"): "0.00749",
    ("AB", "B"): "0.00639",
    ("A", "AB"): "0.04874",
    ("A", "A"): "0.04703",
    ("B", "AB"): "0.07526",
    ("B", "B"): "0.07355",
}
#: totals that appendix V carries as constants: (AB at work, AB) and (A at work, AB)
LITERAL_AB, LITERAL_A = 7.148112661499771e-2, 6.368625806814919e-1

"""Printed data and results of chapter 4 of Baca Vasquez (2007): the six-cylinder engine.

SI units and radians unless a name says otherwise. The card, Appendix II, has its row of 360 degrees
twice (once at the foot of a column, once at the head of the next); here it stands once.
"""

from math import radians

# ---- section 4.1: data of the engine
BORE, CRANK_RADIUS, ROD_LENGTH = 0.076, 0.035, 0.123
PISTON_MASS, ROD_MASS = 0.363, 0.096
#: section 4.2.2: a third of the rod turns, two thirds go up and down
RECIPROCATING_MASS, ROTATING_MASS = PISTON_MASS + 2.0 * ROD_MASS / 3.0, ROD_MASS / 3.0
CYLINDER_INERTIA, FLYWHEEL_INERTIA = 18.64, 2655.0
THROW_STIFFNESS, LAST_STIFFNESS = 22.82e6, 19.21e6
INERTIA = (CYLINDER_INERTIA,) * 6 + (FLYWHEEL_INERTIA,)
STIFFNESS = (THROW_STIFFNESS,) * 5 + (LAST_STIFFNESS,)

# ---- section 4.2.4: firing angles; orders 1/2 to 15
FIRING_ANGLE = tuple(radians(a) for a in (0.0, 480.0, 240.0, 600.0, 120.0, 360.0))
#: cylinders in the order in which they fire
FIRING_ORDER = (1, 5, 3, 6, 2, 4)
HALF_ORDERS = tuple(range(1, 31))
#: rad/s: the text works with the first, the program of Appendix IV with the second
SPEED_OF_TEXT, SPEED_OF_PROGRAM = 400.0, 800.0

# ---- section 4.4.2.1: the damper, with the row of Table 3.1 for a damping ratio of .01
DAMPER_STIFFNESS_RATIO, DAMPER_MASS_RATIO, PRIMARY_DAMPING_RATIO = 0.157, 0.246, 0.01
DAMPER_INERTIA, DAMPER_STIFFNESS = 27.5126, 5.9712e5
DAMPED_INERTIA = (DAMPER_INERTIA, *INERTIA)
DAMPED_STIFFNESS = (DAMPER_STIFFNESS, *STIFFNESS)

# ---- sections 4.4.1.1 and 4.4.2.2: frequencies in rad/s; shapes with 1 at the first station
FREQUENCY_7 = (0.0, 264.15, 767.52, 1235.91, 1639.16, 1949.90, 2145.93)
FREQUENCY_8 = (0.0, 135.05, 286.43, 773.29, 1238.70, 1640.55, 1950.49, 2146.07)
SHAPE_7 = (
    (1.00000, 1.00000, 1.00000, 1.00000, 1.00000, 1.00000, 1.00000),
    (1.00000, 0.94301, 0.83227, 0.67409, 0.47750, 0.25369, -0.02935),
    (1.00000, 0.51882, -0.21201, -0.84082, -1.06505, -0.77679, 0.00966),
    (1.00000, -0.24768, -1.18634, -0.64482, 0.70123, 1.17236, -0.00558),
    (1.00000, -1.19468, -0.76742, 1.34408, 0.50576, -1.44254, 0.00389),
    (1.00000, -2.10567, 1.32819, 0.63713, -2.03265, 1.61032, -0.00307),
    (1.00000, -2.76150, 3.86439, -4.04564, 3.26202, -1.70041, 0.00268),
)
SHAPE_8 = (
    (1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000, 1.0000),
    (1.0000, 0.1597, 0.1353, 0.1089, 0.0809, 0.0516, 0.0217, -0.0142),
    (1.0000, -2.7801, -2.6926, -2.4248, -1.9945, -1.4305, -0.7706, 0.0745),
    (1.0000, -26.5517, -14.3038, 4.9307, 21.7568, 27.9561, 20.5005, -0.2511),
    (1.0000, -69.6973, 15.8060, 81.4993, 45.0475, -47.8633, -80.7860, 0.3827),
    (1.0000, -123.0073, 144.1677, 94.4038, -162.8978, -62.0841, 175.2156, -0.4723),
    (1.0000, -174.2892, 362.7336, -227.4499, -110.8254, 350.1927, -277.0242, 0.5278),
    (1.0000, -211.2064, 577.7996, -806.8768, 843.9178, -680.1068, 354.4308, -0.5576),
)  # fmt: skip
APPENDIX_VI_SHAPE = (
    1.0, 0.15966499569224, 0.13529774698925, 0.10891490329351, 0.08090950239633,
    0.05169875409666, 0.02171782482792, -0.01428155083981,
)  # fmt: skip


# ---- sections 4.4.1.3 and 4.4.2.4: critical speeds 2 W / w, by (freedoms, mode)
CRITICAL_W = (1, 5, 10, 15, 20, 25, 30)
CRITICAL_SPEED = {
    (7, 2): (528.3, 105.7, 52.8, 35.2, 26.4, 21.1, 17.6),
    (7, 3): (1535.0, 307.0, 153.5, 102.3, 76.8, 61.4, 51.2),
    (7, 4): (2471.8, 494.4, 247.2, 164.8, 123.6, 89.9, 82.4),
    (8, 2): (270.2, 54.0, 27.0, 18.0, 13.5, 10.8, 9.0),
    (8, 3): (572.9, 114.6, 57.3, 38.2, 28.6, 22.9, 19.1),
    (8, 4): (1546.6, 309.3, 154.7, 103.1, 77.3, 61.9, 51.6),
}
#: frequencies that stand next to the critical speeds and in captions and belong to another damper
OLD_FREQUENCY = {(8, 2): 129.6, (8, 3): 287.8, (8, 4): 773.8}
#: harmonic j of largest intensity, modes 2, 3 and 4
LARGEST_HARMONIC = {7: (3, 4, 4), 8: (3, 3, 4)}
#: largest twists in rad: figures 4.16, 4.17 (seven) and 4.26, 4.27 (eight freedoms)
LARGEST_TWIST = {"4.16": 16.25e-5, "4.17": 20e-3, "4.26": 3.6e-3, "4.27": 9e-4}

# ---- Appendix II: pressure, used for the force as it stands, every 10 degrees over 720, from the
# top dead centre of firing on
CARD_STEP_DEGREES = 10.0
CARD_BAR = (
    30, 73, 60, 44, 31, 22.5, 17.5, 15, 11, 9.5, 9, 8,
    7, 6, 5, 4.5, 4, 3.5, 3, 2.5, 2, 1.5, 1, 1,
    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
    1, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.2, 0.3,
    0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1, 1.17, 1.33, 1.5, 1.66, 1.83,
    1.99, 2.16, 2.33, 2.5, 3, 3.5, 4, 5, 7.5, 12, 17.5, 22.5,
    30,
)  # fmt: skip
CARD_ANGLE = tuple(radians(CARD_STEP_DEGREES * i) for i in range(len(CARD_BAR)))
CARD_PRESSURE = tuple(1e5 * bar for bar in CARD_BAR)

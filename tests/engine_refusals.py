"""Engines that contradict themselves: the text of each, and the words that refuse it."""

from engine_cases import CARD, ENGINE, GEARED, cards, replaced

E, G, P = ENGINE, GEARED, CARD
#: a damper of a line whose own table is misspelt
NAMELESS = (
    '[[machine.shaft_line.dampers]]\nname = "disc"\non = "a"\nkind = "viscous"\n'
    "inertia = 1\ndamping = 1\n[response"
)

#: name -> (text, line of the problem, words of the message)
REFUSED: dict[str, tuple[str, int, tuple[str, ...]]] = {
    "ratio zero": (
        replaced(G, ("ratio = 4.0", "ratio = 0")),
        32,
        ("ratio is out of range", "found 0"),
    ),
    "same sense loop": (
        replaced(
            G,
            (
                "gears = [",
                'gears = [\n  { between = ["pinion", "take-off"], ratio = 1.3333333333 },',
            ),
        ),
        33,
        ("the ratios around a loop contradict each other: the line can",),
    ),
    "order unknown": (
        replaced(E, ('"1", "3", "2"]', '"1", "3", "4"]')),
        13,
        ("no cylinder is named '4'",),
    ),
    "order short": (
        replaced(E, ('"1", "3", "2"]', '"1", "3"]')),
        13,
        ("the firing order leaves cylinders out", "found '2'"),
    ),
    "firing both": (
        replaced(E, ('{ name = "2" }', '{ name = "2", firing_angle = "480 deg" }')),
        12,
        ("firing_angle and firing_order exclude each other",),
    ),
    "firing none": (
        replaced(E, ('firing_order = ["1", "3", "2"]\n', "")),
        7,
        ("[machine.crank_train] does not say when its cylinders fire",),
    ),
    "intervals": (
        replaced(E, ('"2"]\n', '"2"]\nfiring_intervals = ["240 deg", "240 deg", "230 deg"]\n')),
        14,
        ("the intervals between firings have to fill the cycle", "found 710 deg together"),
    ),
    "one turn": (
        replaced(E, ('"720 deg"', '"360 deg"')),
        14,
        (
            "the crank angles of the gas pressure have to span two turns",
            "found from 0 deg to 360 deg",
        ),
    ),
    "two turns": (
        replaced(G, ('"360 deg"', '"720 deg"')),
        13,
        (
            "the crank angles of the gas pressure have to span one turn",
            "found from 0 deg to 720 deg",
        ),
    ),
    "no name": (
        replaced(E, ('{ name = "b", inertia', "{ inertia")),
        18,
        ("missing key 'name' in [machine.shaft_line.stations[1]]",),
    ),
    "blank name": (
        replaced(E, ('{ name = "b", inertia', '{ name = " ", inertia')),
        18,
        ("the station has a name of blanks",),
    ),
    "name twice": (
        replaced(E, ('{ name = "b", inertia', '{ name = "a", inertia')),
        18,
        ("two entries of stations are named 'a'",),
    ),
    "shaft between": (
        replaced(G, ('["b", "pinion"]', '["b", "pinon"]')),
        26,
        ("no station is named 'pinon'",),
    ),
    "self": (
        replaced(G, ('["b", "pinion"]', '["b", "b"]')),
        26,
        ("this shaft leads from a station to itself",),
    ),
    "one speed cards": (
        replaced(E, (P, cards("1000 rpm", "1000 rpm"))),
        14,
        ("two cards have the same speed, 1000 rpm"),
    ),
    "neg inertia": (
        replaced(E, ('inertia = "2 kg*m^2"', 'inertia = "-2 kg*m^2"')),
        20,
        ("inertia is out of range", "found '-2 kg*m^2'"),
    ),
    "neg stiff": (
        replaced(E, ('{ stiffness = "1e6 N*m/rad" }', '{ stiffness = "-1e6 N*m/rad" }')),
        24,
        ("stiffness is out of range", "found '-1e6 N*m/rad'"),
    ),
    "zero stiff": (
        replaced(E, ('{ stiffness = "1e6 N*m/rad" }', "{ stiffness = 0 }")),
        24,
        ("stiffness is out of range", "found 0 N*m/rad"),
    ),
    "huge": (
        replaced(E, ('{ stiffness = "1e6 N*m/rad" }', "{ stiffness = 1e30 }")),
        24,
        ("the number is too large to compute with", "found 1e+30 in SI units"),
    ),
    "no station": (
        replaced(E, (', cylinder = "3"', "")),
        16,
        ("a cylinder has no station", "found '3'"),
    ),
    "unknown cyl": (
        replaced(E, (', cylinder = "3"', ', cylinder = "4"')),
        19,
        ("no cylinder is named '4'",),
    ),
    "no cycle": (
        replaced(E, ('cycle = "four_stroke"\n', "")),
        3,
        ("missing key 'cycle' in [machine]",),
    ),
    "no gas": (
        replaced(E, (P + "\n", "")),
        7,
        ("[machine.crank_train] has neither gas_pressure nor gas_cards nor gas_cycle",),
    ),
    "no bore": (
        replaced(E, ('bore = "100 mm"\n', "")),
        13,
        ("gas_pressure needs bore: the gas force is pressure times",),
    ),
    "two gases": (
        replaced(E, (P, P + '\ngas_cycle = { kind = "diesel", peak_pressure = "90 bar" }')),
        15,
        ("gas_cycle and gas_pressure exclude each other",),
    ),
    "low peak": (
        replaced(E, (P, 'gas_cycle = { kind = "diesel", peak_pressure = "9 bar" }')),
        14,
        ("gas cycle: a peak pressure of 900000 Pa is not above what th",),
    ),
    "cycle order": (
        replaced(
            E,
            (
                P,
                'gas_cycle = { kind = "diesel", peak_pressure = "99 bar", combustion_ends = "-20 deg" }',  # noqa: E501
            ),
        ),
        14,
        ("combustion_ends comes before combustion_starts", "found -20 deg and -8 deg"),
    ),
    "no peak": (
        replaced(E, (P, 'gas_cycle = { kind = "diesel" }')),
        14,
        ("[machine.crank_train.gas_cycle] has neither peak_pressure no",),
    ),
    "motor": (
        replaced(E, ("[machine.shaft_line]", "[machine.rotor]\ninertia = 3\n[machine.shaft_line]")),
        15,
        ("rotor and shaft_line exclude each other",),
    ),
    "viscous k": (
        replaced(E, ('damping = "30', 'stiffness = "3 N*m/rad", damping = "30')),
        27,
        ("a damper of kind 'viscous' has no stiffness",),
    ),
    "gear both": (
        replaced(G, ("teeth = [20, 60]", "teeth = [20, 60], ratio = 0.33333")),
        31,
        ("teeth and ratio exclude each other",),
    ),
    "mesh": (
        replaced(G, (', pitch_radius = "0.3 m"', "")),
        32,
        ("mesh_stiffness needs pitch_radius: it is along the line of a",),
    ),
    "cylinder off": (
        replaced(
            G,
            (', cylinder = "2"', ""),
            (
                '"generator", inertia = "0.4 kg*m^2"',
                '"generator", inertia = "0.4 kg*m^2", cylinder = "2"',
            ),
        ),
        22,
        (
            "this station has a cylinder and does not turn as the cranksh",
            "found 1.33333333 times the speed of 'a'",
        ),
    ),
    "bore": (
        replaced(
            E,
            (
                '{ stiffness = "1e6 N*m/rad" }',
                '{ section = { outer_diameter = "60 mm", inner_diameter = "60 mm", length = 1 } }',
            ),
        ),
        24,
        ("a bore has to be narrower than what it is in", "found 0.06 m"),
    ),
    "bore of a cone": (
        replaced(
            E,
            (
                '{ stiffness = "1e6 N*m/rad" }',
                "{ section = { outer_diameter = 0.06, end_outer_diameter = 0.04, "
                "inner_diameter = 0.05, length = 1 } }",
            ),
        ),
        24,
        ("a bore has to be narrower than what it is in", "found 0.05 m", "allowed: < 0.04 m"),
    ),
    "load": (
        replaced(G, ('load = "propeller"', 'load = "prop"')),
        34,
        ("no station is named 'prop'",),
    ),
    "loads": (
        replaced(G, ('load = "propeller"', 'loads = [{ on = "generator", torque = "300 N*m" }]')),
        34,
        ("station 'generator' takes up the mean torque that is left, a",),
    ),
    "rigid loop": (
        replaced(
            G, ("shafts = [", 'shafts = [\n { between = ["pinion", "wheel"], stiffness = 3 },')
        ),
        32,
        ("two sections of the line are named 'pinion - wheel'",),
    ),
    "ring name": (replaced(E, ('"ring"', '"b"')), 27, ("a station is named 'b', too",)),
    "pressure": (
        replaced(E, ('"0 bar"', '"-3 bar"')),
        14,
        ("pressure[1] is out of range", ">= -100000 Pa"),
    ),
    "gas_force": (
        replaced(
            E,
            (
                '{ name = "2" }',
                '{ name = "2", gas_force = { crank_angle = [0,1,2], force = [1,2,1] } }',
            ),
        ),
        12,
        ("gas_force is over one turn, an engine's gas over its cycle",),
    ),
    "interp": (
        replaced(E, ("bore =", 'gas_interpolation = "parabola"\nbore =')),
        11,
        ("the gas of an engine is read along straight lines or a cubic", "found 'parabola'"),
    ),
    "damper off": (
        replaced(
            E,
            ('kind = "viscous"', 'kind = "spring", stiffness = 9'),
            ('on = "a"', 'on = "flywhel"'),
        ),
        27,
        ("no station is named 'flywhel'", "did you mean 'flywheel'?"),
    ),
    "gear off": (
        replaced(G, ('["pinion", "wheel"]', '["pinion", "weel"]')),
        31,
        ("no station is named 'weel'", "did you mean 'wheel'?"),
    ),
    "one cylinder twice": (
        replaced(E, (', cylinder = "3"', ', cylinder = "2"')),
        19,
        ("cylinder '2' turns two stations",),
    ),
    "misspelt line": (
        replaced(E, ("[machine.shaft_line]", "[machine.shaftline]"), ("[response", NAMELESS)),
        15,
        ("unknown key 'shaftline' in [machine]", "did you mean 'shaft_line'?"),
    ),
}

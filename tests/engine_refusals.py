"""Engines that contradict themselves: the text of each, and the words that refuse it."""

from engine_cases import CARD, ENGINE, GEARED, cards, replaced

E, G, P = ENGINE, GEARED, CARD
#: a damper of a line whose own table is misspelt
NAMELESS = (
    '[[machine.shaft_line.dampers]]\nname = "disc"\non = "a"\nkind = "viscous"\n'
    "inertia = 1\ndamping = 1\n[response"
)

JOINED = (("a", "b"), ("b", "pinion"), ("wheel", "propeller"), ("take-off", "generator"))

#: name -> text
REFUSED: dict[str, str] = {
    "three at once": replaced(
        E, ('on = "a"', 'on = "z"'), ('"3", "2"]', '"3", "9"]'), ('bore = "100 mm"\n', "")
    ),
    "ratio zero": replaced(G, ("ratio = 4.0", "ratio = 0")),
    "same sense loop": replaced(
        G,
        (
            "gears = [",
            'gears = [\n  { between = ["pinion", "take-off"], ratio = 1.3333333333 },',
        ),
    ),
    "between unsaid of all": replaced(
        G, *((f'between = ["{a}", "{b}"], s', "s") for a, b in JOINED)
    ),
    "between unsaid of one": replaced(G, ('between = ["b", "pinion"], s', "s")),
    "damped without inertia": replaced(
        E,
        ('"c", inertia = "0.1 kg*m^2"', '"c", inertia = 0'),
        ('damping = "5 N*m*s/rad"', "damping_ratio = 0.1"),
    ),
    "order unknown": replaced(E, ('"1", "3", "2"]', '"1", "3", "4"]')),
    "order short": replaced(E, ('"1", "3", "2"]', '"1", "3"]')),
    "firing both": replaced(E, ('{ name = "2" }', '{ name = "2", firing_angle = "480 deg" }')),
    "firing none": replaced(E, ('firing_order = ["1", "3", "2"]\n', "")),
    "intervals": replaced(
        E, ('"2"]\n', '"2"]\nfiring_intervals = ["240 deg", "240 deg", "230 deg"]\n')
    ),
    "one turn": replaced(E, ('"720 deg"', '"360 deg"')),
    "two turns": replaced(G, ('"360 deg"', '"720 deg"')),
    "no name": replaced(E, ('{ name = "b", inertia', "{ inertia")),
    "blank name": replaced(E, ('{ name = "b", inertia', '{ name = " ", inertia')),
    "name twice": replaced(E, ('{ name = "b", inertia', '{ name = "a", inertia')),
    "shaft between": replaced(G, ('["b", "pinion"]', '["b", "pinon"]')),
    "self": replaced(G, ('["b", "pinion"]', '["b", "b"]')),
    "one speed cards": replaced(E, (P, cards("1000 rpm", "1000 rpm"))),
    "neg inertia": replaced(E, ('inertia = "2 kg*m^2"', 'inertia = "-2 kg*m^2"')),
    "neg stiff": replaced(E, ('{ stiffness = "1e6 N*m/rad" }', '{ stiffness = "-1e6 N*m/rad" }')),
    "zero stiff": replaced(E, ('{ stiffness = "1e6 N*m/rad" }', "{ stiffness = 0 }")),
    "huge": replaced(E, ('{ stiffness = "1e6 N*m/rad" }', "{ stiffness = 1e30 }")),
    "no station": replaced(E, (', cylinder = "3"', "")),
    "unknown cyl": replaced(E, (', cylinder = "3"', ', cylinder = "4"')),
    "no cycle": replaced(E, ('cycle = "four_stroke"\n', "")),
    "no gas": replaced(E, (P + "\n", "")),
    "no bore": replaced(E, ('bore = "100 mm"\n', "")),
    "two gases": replaced(
        E, (P, P + '\ngas_cycle = { kind = "diesel", peak_pressure = "90 bar" }')
    ),
    "low peak": replaced(E, (P, 'gas_cycle = { kind = "diesel", peak_pressure = "9 bar" }')),
    "cycle order": replaced(
        E,
        (
            P,
            'gas_cycle = { kind = "diesel", peak_pressure = 99e5, combustion_ends = "-20 deg" }',
        ),
    ),
    "no peak": replaced(E, (P, 'gas_cycle = { kind = "diesel" }')),
    "motor": replaced(
        E, ("[machine.shaft_line]", "[machine.rotor]\ninertia = 3\n[machine.shaft_line]")
    ),
    "viscous k": replaced(E, ('damping = "30', 'stiffness = "3 N*m/rad", damping = "30')),
    "gear both": replaced(G, ("teeth = [20, 60]", "teeth = [20, 60], ratio = 0.33333")),
    "mesh": replaced(G, (', pitch_radius = "0.3 m"', "")),
    "cylinder off": replaced(
        G,
        (', cylinder = "2"', ""),
        (
            '"generator", inertia = "0.4 kg*m^2"',
            '"generator", inertia = "0.4 kg*m^2", cylinder = "2"',
        ),
    ),
    "bore": replaced(
        E,
        (
            '{ stiffness = "1e6 N*m/rad" }',
            '{ section = { outer_diameter = "60 mm", inner_diameter = "60 mm", length = 1 } }',
        ),
    ),
    "bore of a cone": replaced(
        E,
        (
            '{ stiffness = "1e6 N*m/rad" }',
            "{ section = { outer_diameter = 0.06, end_outer_diameter = 0.04, "
            "inner_diameter = 0.05, length = 1 } }",
        ),
    ),
    "load": replaced(G, ('balanced_by = "propeller"', 'balanced_by = "prop"')),
    "loads": replaced(
        G,
        (
            'balanced_by = "propeller"',
            'absorbed_torques = [{ on = "generator", torque = "300 N*m" }]',
        ),
    ),
    "rigid loop": replaced(
        G, ("shafts = [", 'shafts = [\n { between = ["pinion", "wheel"], stiffness = 3 },')
    ),
    "ring name": replaced(E, ('"ring"', '"b"')),
    "pressure": replaced(E, ('"0 bar"', '"-3 bar"')),
    "gas_force": replaced(
        E,
        (
            '{ name = "2" }',
            '{ name = "2", gas_force = { crank_angle = [0,1,2], force = [1,2,1] } }',
        ),
    ),
    "interp": replaced(E, ("bore =", 'gas_interpolation = "parabola"\nbore =')),
    "damper off": replaced(
        E,
        ('kind = "viscous"', 'kind = "spring", stiffness = 9'),
        ('on = "a"', 'on = "flywhel"'),
    ),
    "gear off": replaced(G, ('["pinion", "wheel"]', '["pinion", "weel"]')),
    "one cylinder twice": replaced(E, (', cylinder = "3"', ', cylinder = "2"')),
    "misspelt line": replaced(
        E, ("[machine.shaft_line]", "[machine.shaftline]"), ("[response", NAMELESS)
    ),
}

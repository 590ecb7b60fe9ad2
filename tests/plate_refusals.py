"""Measured plates that are refused: text of the case, place of the problem, words of it."""

from plate_cases import PLATE, replaced

M = ("measurement",)
ON_A_LINE = """schema = 1
title = "three accelerometers in a row"
[machine]
kind = "plate"
[measurement]
amplitude = "zero_to_peak"
amplitude_step = 0.001
phase_step = "1 deg"
orders = [1]
positions = [
  { name = "a", x = -0.5, y = 0.2 },
  { name = "b", x = 0.1, y = 0.2 },
  { name = "c", x = 0.5, y = 0.2 },
  { name = "d", x = 0.5, y = -0.2 },
]
readings = [
  { at = "a", amplitude = [1.0], phase = ["0 deg"] },
  { at = "b", amplitude = [1.1], phase = ["5 deg"] },
  { at = "c", amplitude = [1.2], phase = ["9 deg"] },
]
"""
CASES = {
    "levels_without_a_reference": (
        replaced('reference_level = "1e-5 m/s^2"\n', ""),
        (*M, "readings", 0, "level"),
        ("levels without a reference", "1e-5 m/s^2"),
    ),
    "rotation_without_a_reference": (
        replaced('{ at = "a", level', '{ about = "x", level = [1.0, 2.0] },\n  { at = "a", level'),
        (*M, "readings", 0, "level"),
        ("levels of rotation without a reference", "angular_reference_level"),
    ),
    "position_unknown": (
        replaced('{ at = "b"', '{ at = "bb"'),
        (*M, "readings", 1, "at"),
        ("no position is named 'bb'", "did you mean 'b'?"),
    ),
    "position_of_a_difference_unknown": (
        replaced('between = ["a", "c"]', 'between = ["a", "x"]'),
        (*M, "readings", 4, "between", 1),
        ("no position is named 'x'",),
    ),
    "reference_position_unknown": (
        replaced("orders =", 'reference_position = "e"\norders ='),
        (*M, "reference_position"),
        ("no position is named 'e'",),
    ),
    "position_twice": (
        replaced('name = "d"', 'name = "a"'),
        (*M, "positions", 3, "name"),
        ("two positions are named 'a'",),
    ),
    "order_twice": (replaced("[1, 2]", "[1, 1]"), (*M, "orders", 1), ("order 1 stands twice",)),
    "too_few_levels_in_a_reading": (
        replaced("[108.7, 104.2]", "[108.7]"),
        (*M, "readings", 1, "level"),
        ("1 numbers for 2 harmonics", "orders = [...]"),
    ),
    "order_of_no_harmonic": (
        replaced("level = [108.7, 104.2]", "orders = [1, 3], level = [108.7, 104.2]"),
        (*M, "readings", 1, "orders", 1),
        ("covers harmonics of [measurement]", "1, 2"),
    ),
    "nothing_read": (
        replaced(", level = [108.7, 104.2]", ""),
        (*M, "readings", 1),
        ("has neither level nor amplitude nor angular_amplitude",),
    ),
    "nowhere_read": (
        replaced('{ at = "b", ', "{ "),
        (*M, "readings", 1),
        ("has neither at nor between nor about",),
    ),
    "point_and_rotation": (
        replaced('{ at = "b"', '{ about = "x", at = "b"'),
        (*M, "readings", 1, "about"),
        ("about and at exclude each other",),
    ),
    "angular_amplitude_of_a_point": (
        replaced("level = [108.7, 104.2]", "angular_amplitude = [1.0, 2.0]"),
        (*M, "readings", 1, "angular_amplitude"),
        ("angular_amplitude and at exclude each other",),
    ),
    "difference_of_one_name": (
        replaced('["a", "b"]', '["a", "a"]'),
        (*M, "readings", 3, "between"),
        ("between two positions", "['a', 'a']"),
    ),
    "difference_of_one_place": (
        replaced('{ name = "b", x = 0.5, y = 0.3 }', '{ name = "b", x = 0.5, y = -0.3 }'),
        (*M, "readings", 3, "between"),
        ("are one place", "'a' and 'b'"),
    ),
    "no_readings": (
        PLATE[: PLATE.index("readings")],
        M,
        ("[measurement] needs readings or scan",),
    ),
    "amplitude_without_its_last_digit": (
        replaced("level = [108.7, 104.2]", "amplitude = [0.1, 0.2]"),
        (*M, "readings", 1),
        ("does not say the amplitude step", "last digit"),
    ),
    "phase_without_its_last_digit": (
        replaced("level = [108.7, 104.2]", "level = [108.7, 104.2], phase = [0.0, 0.1]"),
        (*M, "readings", 1),
        ("does not say the phase step",),
    ),
    "amplitude_of_zero": (
        replaced("level = [108.7, 104.2]", "amplitude = [0.1, 0.0]"),
        (*M, "readings", 1, "amplitude", 1),
        ("zero without a phase has no level",),
    ),
    "level_too_loud": (
        replaced("[108.7, 104.2]", "[108.7, 1042.0]"),
        (*M, "readings", 1, "level", 1),
        ("is out of range", "1042"),
    ),
    "position_in_another_country": (
        replaced("x = -0.5, y = 0.3", "x = -5e7, y = 0.3"),
        (*M, "positions", 3, "x"),
        ("x is out of range",),
    ),
    "no_measurement": (
        PLATE[: PLATE.index("[measurement]")],
        ("machine", "kind"),
        ("its motion comes from readings", "without [measurement]", "positions and readings"),
    ),
    "plate_without_extent": (
        PLATE + "plate = { x = [0.5, 0.5], y = [-1.0, 1.0] }\n",
        (*M, "plate", "x"),
        ("x goes from a lower value to a higher one", "0.5 to 0.5"),
    ),
    "points_on_a_line": (
        ON_A_LINE,
        M,
        ("do not see roll about the line y = 0.2 m", "read at 'd'"),
    ),
    "four_levels": (
        replaced('  { between = ["a", "c"], level = [100.2, 102.3] },\n', ""),
        M,
        ("harmonics 1, 2: the levels determine 4 of the 5", "at 'd'"),
    ),
    "only_differences": (
        replaced(
            '{ at = "a", level = [104.0, 107.3] },\n  { at = "b", level = [108.7, 104.2] },\n'
            '  { at = "c", level = [103.0, 101.5] },\n',
            "",
        ),
        M,
        ("do not see translation",),
    ),
    "one_point": (
        PLATE[: PLATE.index('  { at = "b"')] + "]\n",
        M,
        ("do not see 2 of the three motions",),
    ),
    "nothing_to_solve_with": (
        replaced("orders = [1, 2]", "orders = [1, 2, 3]").replace(
            "level = [", "orders = [1, 2], level = ["
        ),
        M,
        ("harmonic 3: there is no reading to find the motion from",),
    ),
}

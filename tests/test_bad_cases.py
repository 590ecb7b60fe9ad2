"""Claim: a case that cannot be read, or cannot be, is refused with words that help.

Each file in `bad_cases/` holds what its name says. The message names the place (line and column),
what was found, what is allowed and, where there is one, the way out; all problems come at once.
"""

import errno
import re
from pathlib import Path

import pytest

from vibecalc.core.case.load import load_case
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import EXIT_USAGE, CaseError, UsageError

FOLDER = Path(__file__).parent / "bad_cases"

#: file -> (place of the first problem, words that the message has to hold)
EXPECTED: dict[str, tuple[str, tuple[str, ...]]] = {
    "not_toml": ("6:14", ("not TOML: expected newline", 'needs quotes, as in "4900 rpm"')),
    "empty": ("", ("is empty", "`vibecalc new generator`")),
    "only_blanks": ("", ("is empty",)),
    "doubled_key": ("11:23", ("not TOML: a key that stands twice in its table",)),
    "huge_whole_number": ("6:1", ("speed: too large for a double",)),
    "unknown_kind": ("5:1", ("unknown kind 'turbine'", "one of 'generator', 'compressor'")),
    "missing_key": ("8:1", ("missing key 'crank_radius' in [machine.crank_train]", "half the str")),
    "misspelt_key": ("10:1", ("unknown key 'rod_lenght'", "did you mean 'rod_length'?")),
    "misspelt_key_in_inline_table": ("14:37", ("'crank_fase'", "did you mean 'crank_phase'?")),
    "key_of_another_table": ("6:1", ("crank_radius belongs to [machine.crank_train]",)),
    "unknown_table": ("25:1", ("unknown key 'insulation'", "did you mean 'isolation'?")),
    "text_for_number": ("9:1", ("crank_radius: not a number", "found 'fifty'", "a length")),
    "number_for_text": ("2:1", ("title cannot be a number", "a text of 1 to 200 letters")),
    "true_for_number": ("9:1", ("crank_radius cannot be true or false", "found true")),
    "nan": ("18:1", ("mass is not finite", "found nan", "a mass > 0 kg")),
    "infinity": ("18:1", ("mass is not finite", "found inf")),
    "nan_in_text": ("18:1", ("mass: not finite", "found 'nan kg'")),
    "overflow": ("18:1", ("mass: too large for a double", "'1e400 kg'")),
    "negative_mass": ("18:1", ("mass is out of range", "found '-100 kg'; allowed: > 0 kg")),
    "negative_stiffness": ("22:33", ("stiffness[2] is out of range", "allowed: >= 0 N/m")),
    "wrong_dimension": ("10:1", ("found '3 kg', a mass; allowed: a length", "'200 mm'")),
    "unknown_unit": ("10:1", ("unknown unit", "'milimeter'", "did you mean 'millimeter'?")),
    "unit_in_capitals": ("10:1", ("wrong dimension", "did you mean 'mm'?")),
    "decimal_comma": ("10:1", ("not a number", "write a point: '0.2 m'")),
    "no_cylinders": ("12:1", ("cylinders is empty", "a list of 1 to 64 entries")),
    "short_point": ("23:31", ("positions[1] is too short", "a list of 3 entries")),
    "two_stiffnesses": ("22:10", ("stiffness is too short", "allowed: three numbers")),
    "list_for_table": ("19:1", ("box cannot be a list", "a table with length, width, height")),
    "wrong_schema": ("1:1", ("unknown schema 2", "reads cases of schema 1")),
    "unknown_choice": ("26:1", ("one of 'pitch', 'rigid_body'", "did you mean 'pitch'?")),
    "two_ways_of_mass": ("11:1", ("piston_mass and reciprocating_mass exclude each other",)),
    "no_mass": ("8:1", ("has neither reciprocating_mass nor piston_mass, pin_mass and rod",)),
    "rod_said_twice": ("12:60", ("reciprocating_fraction and crank_pin_to_mass_centre exclude",)),
    "box_and_inertia": ("20:1", ("box and inertia exclude each other", "19 | inertia =")),
    "no_inertia": ("17:1", ("[machine.body] has neither inertia nor box",)),
    "mounts_both_ways": ("22:1", ("individual and positions exclude each other",)),
    "mounts_empty": ("21:1", ("has neither stiffness_matrix nor positions nor individual",)),
    "mounts_without_stiffness": ("22:1", ("mounts given by positions have no stiffness",)),
    "isolation_without_mounts": ("21:1", ("[isolation] needs [machine.mounts]",)),
    "doubled_names": ("14:5", ("two entries of cylinders are named '1'", '13 |   { name = "1"')),
    "run_up_backwards": ("27:12", ("from a lower speed to a higher", "from 50 Hz to 2900 rpm")),
    "truncated_without_terms": ("28:1", ("series = 'truncated' needs terms", "a whole number")),
    "terms_without_truncated": (
        "29:1",
        ("series = 'exact' has no terms", "belongs to series = 'truncated'"),
    ),
    "limit_without_bound": ("28:1", ("a limit needs max or min",)),
    "limit_min_above_max": ("30:1", ("contradict each other", "min = '0.2 kN' and max = 100")),
    "contradicting_limits": ("34:1", ("contradict each other", '30 | max = "100 N"')),
    "reference_with_two_tolerances": ("32:1", ("atol and rtol exclude each other",)),
    "reference_not_a_number": ("30:1", ("value: not a number", "found 'ninety N'")),
    "variable_misspelt": ("31:5", ("no key 'stifness'; did you mean 'stiffness'?",)),
    "variable_not_a_number": ("31:5", ("only keys below machine", "not a continuous number")),
    "variable_without_table": ("31:5", ("machine.body has no key 'inertia_block'",)),
    "variable_bounds": ("31:44", ("lower < upper", "must not have", "found '5 kg', a mass")),
    "variable_twice": ("32:5", ("two variables change machine.mounts.each.damping",)),
    "mass_matrix_and_mass": ("20:1", ("mass and mass_matrix exclude each other",)),
    "stiffness_matrix_and_positions": ("38:1", ("positions and stiffness_matrix exclude",)),
    "loss_factor_nearby_positions": ("32:1", ("needs stiffness_matrix", "mounts.each]")),
    "matrix_unit": ("30:44", ("unit of the rotation block: wrong", "N*m", "leave rad out")),
    "isolation_with_a_matrix": ("33:1", ("mounts with places, not a stiffness_matrix",)),
    "response_without_mounts": ("29:1", ("[response] needs [machine.mounts]",)),
    "balances_without_operations": ("40:1", ("balances needs operations",)),
    "switching_misspelt": ("47:20", ("no operation is named 'A alon'", "mean 'A alone'?")),
    "switching_to_itself": ("47:1", ("from one operation to another", "two different names")),
    "operations_twice": ("42:5", ("two entries of operations are named 'both'",)),
    "speeds_backwards": ("40:12", ("from a lower speed to a higher", "from 60 Hz to 3450 rpm")),
    "impact_without_joints": ("19:1", ("[response.impact] needs [machine.joints]",)),
    "bore_without_pressure": ("14:1", ("cannot use bore without gas_pressure", "inertia alone")),
    "columns_of_two_lengths": ("22:1", ("not of one length", "3 of cosine, 2 of sine")),
    "pressure_from_no_file": ("15:1", ("there is no such file", "'no_such_pressure.csv'")),
    "reference_table_of_two_lengths": ("25:1", ("3 of entry and 2 of value", "24 | entry")),
    "reference_table_empty": ("21:1", ("a table without numbers", "a file, or entry and value")),
    "roll_speed_twice": ("6:1", ("a motor of kind 'slip_table' finds it", '24 | kind = "slip')),
    "roll_without_rotor": ("24:1", ("[response.roll] needs [machine.rotor]", "inertia of all")),
    "roll_without_motor": ("23:1", ("needs a motor that finds the speed", "found no motor")),
    "roll_nearby_mounts": ("22:1", ("needs no [machine.mounts]", "a case of its own")),
    "roll_nearby_kinematics": ("27:1", ("machine.speed, which the motor of this machine finds",)),
    "roll_generator": ("24:1", ("finds the speed of a machine of kind 'generator'", "5 | kind =")),
    "roll_euler_without_step": ("27:1", ("euler and rk4 need their step", "step = '0.1 ms'")),
    "roll_damping_feeds_energy": ("21:1", ("found -40 N*m*s/rad; allowed: >= 0", "energy in")),
    "roll_negative_friction": ("23:1", ("found -0.1 N*m*s/rad; allowed: >= 0", "energy in")),
    "roll_piston_lighter_than_nothing": ("13:42", ("found '-2 kg'; allowed: >= 0 kg",)),
    "roll_no_rotor_inertia": ("17:1", ("inertia is out of range", "allowed: > 0 kg*m^2")),
    "motor_kind_unsaid": ("22:1", ("does not say its kind", "kind = 'slip_table', with sync")),
    "motor_key_of_another_kind": ("25:1", ("a motor of kind 'slip_table' has no voltage",)),
    "motor_without_voltage": ("22:1", ("of kind 'dynamic' needs voltage", "line to")),
    "motor_without_synchronous_speed": ("22:1", ("needs synchronous_speed", "angular")),
    "compressor_without_speed": ("4:1", ("missing key 'speed' in [machine]", "or '4900 rpm'")),
    "plate_with_kinematics": ("7:1", ("needs machine.crank_train and machine.speed", "5 | kind")),
    "slip_columns_of_two_lengths": ("25:1", ("not of one length", "4 of slip, 3 of torque")),
    "start_within_without_angles": ("29:1", ("for starts from many angles", "angles = 24")),
    "control_speed_fed_back_twice": ("29:1", ("target_speed and speed_feedback exclude",)),
    "five_mistakes": ("5:1", ("5 errors in ",)),
    "absorber_infinite_mass": (
        "8:1",
        ("ratio of this mass", "too large", "found 1e+12", "second ground"),
    ),
    "absorber_locked_by_its_damper": ("10:1", ("ratio of this damping", "limits = true")),
    "absorber_gap_wider_than_the_mass": (
        "33:1",
        ("no film", "found 0.02 m; allowed: < 0.018 m", "32 |"),
    ),
    "absorber_gap_of_the_rule": ("29:1", ("0.000520683 m, by the rule for its radius",)),
    "absorber_oil_at_40_kelvins": (
        "34:1",
        ("found 40 K, -233.15 degC", "-70 degC to 370", "'60 degC'"),
    ),
    "absorber_oil_beyond_its_line": (
        "34:1",
        ("not known there", "1.637 mm^2/s at 300 C", "36 | visc"),
    ),
    "absorber_oil_thicker_with_heat": (
        "36:1",
        ("31 mm^2/s at 40 degC and 460 mm^2/s at 100 degC",),
    ),
    "absorber_oil_as_thin_as_petrol": (
        "43:16",
        ("outside the model", "found 1 mm^2/s; allowed: 2 to"),
    ),
    "absorber_coil_no_wider_than_its_wire": ("25:1", ("0.002 m; allowed: < 0.0016 m", "26 | coil")),
    "absorber_supports_beyond_the_rod": (
        "15:1",
        ("further apart than the rod is long", "<= 1.65 m"),
    ),
    "absorber_flywheel_of_no_body": ("21:1", ("at most twice the diametral one", "<= 0.4 kg*m^2")),
    "absorber_ring_inside_out": ("31:1", ("inner radius is not below the outer one", "< 0.14 m")),
    "absorber_chain_in_a_ring": ("9:1", ("carry each other", "'near' on 'far' on 'near'")),
    "absorber_chain_to_nobody": ("12:1", ("no absorber is named 'neer'", "did you mean 'near'?")),
    "absorber_two_of_one_name": ("11:1", ("two absorbers are named 'near'", "8 | name")),
    "absorber_named_primary": ("11:1", ("is the name of the primary system",)),
    "absorber_without_any_damping": (
        "11:1",
        ("there is no optimum", "infinite peaks", "5 | [machine.pr"),
    ),
    "absorber_warming_backwards": ("31:18", ("found from 100 degC to 20 degC",)),
    "absorber_pendulum_beyond_the_axis": (
        "10:1",
        ("nothing pulls the pendulum outwards", "9 | vertex"),
    ),
    "absorber_pendulum_that_creeps": (
        "15:1",
        ("found 1.5; allowed: >= 0 and < 1", "at 1 it creeps"),
    ),
    "absorber_pendulum_over_its_cusp": (
        "14:12",
        ("ends there in a cusp", "1.65806 rad; allowed: < 1.5708"),
    ),
    "engine_in_two_pieces": ("19:3", ("in two pieces", "these stations", "found 'c', 'flywheel'")),
    "engine_gears_in_a_loop": (
        "32:3",
        ("contradict each other", "'wheel' turns -0.5 times as fast"),
    ),
    "engine_fires_twice": ("13:27", ("cylinder '3' stands twice in firing_order",)),
    "engine_fires_off_centre": (
        "12:44",
        ("'2' fires at 480 deg", "allowed: 240 deg", "firing_order ="),
    ),
    "engine_open_card": (
        "14:64",
        ("after a cycle has to be that before it", "5900000 Pa (59 bar) in the last"),
    ),
    "engine_speed_beyond_the_cards": (
        "29:12",
        ("outside the range of the gas cards", "83.7758 rad/s"),
    ),
    "engine_damper_on_nothing": ("27:29", ("no station is named 'A'", "did you mean 'a'?")),
    "engine_chain_with_a_gap": (
        "22:1",
        ("one shaft less than stations", "2 shafts and 4 stations"),
    ),
    "engine_no_inertia": ("16:1", ("the line has no inertia at all",)),
    "engine_cylinder_on_two_stations": ("20:46", ("cylinder '3' turns two stations",)),
    "slip_of_one_row": ("25:1", ("of one row is no curve", "the first at slip 0")),
    "slip_out_of_order": ("25:38", ("have to ascend", "11.5192 rad/s, then 2.51327 rad/s in row")),
    "slip_twice": ("25:37", ("have to ascend", "then 2.51327 rad/s in row 3")),
    "slip_from_one": ("25:24", ("begin at slip 0 with torque 0", "0 N*m at slip 0.10472 rad/s")),
    "slip_that_brakes": ("25:84", ("does not brake", "found -420 N*m; allowed: >= 0 N*m")),
    "slip_too_short_for_a_start": ("25:37", ("104.72 rad/s at the start", "27 | [response.start")),
    "motor_of_seven_poles": ("24:1", ("as many north poles as south", "found 7", "even number")),
    "gas_force_of_one_row": ("12:17", ("cylinder '1' has too few rows", "one row", "3 rows")),
    "gas_force_backwards": ("12:66", ("have to ascend", "270 deg, then 90 deg, in rows 2 and 3")),
    "gas_force_over_half_a_turn": ("12:31", ("span one turn", "from 0 deg to 180 deg", "360 deg")),
    "gas_force_not_closed": ("13:113", ("gas force of cylinder '2' after a turn", "8000 N in the")),
    "gas_force_unevenly_spaced": ("13:31", ("evenly spaced", "gas_interpolation = 'cubic'")),
    "roll_piston_without_the_rods_share": ("14:42", ("lighter than nothing", "0.991304 kg of the")),
    "roll_started_on_mounts": ("30:1", ("mounts do not let be constant", "90000 N*m/rad", "21 |")),
    "roll_long_steps": ("30:1", ("too long for order 10", "<= 0.0015 s", "28 | orders")),
    "roll_few_points": ("30:1", ("below half their number", "20 points for 10 orders")),
    "load_backwards": ("29:28", ("entries of time have to ascend", "2 s, then 1 s")),
    "load_below_zero": ("29:39", ("found -0.5; allowed: >= 0", "of the gas forces")),
    "control_beyond_the_reference": ("29:1", ("below gain times reference", "< 99.4838 rad/s")),
    "control_gain_twice": ("28:17", ("value 1 stands twice in gains", "each value once")),
    "control_tuned_backwards": (
        "28:19",
        ("tune.gain] goes from a lower value", "found lower 10 and upper 1"),
    ),
    "matrix_not_symmetric": (
        "25:22",
        ("row 5, column 6: 0.06 kg*m^2; row 6, column 5: -0.06 kg*m^2",),
    ),
    "mass_matrix_without_body": ("20:17", ("some motion has a negative mass",)),
    "suspension_that_pushes": (
        "30:22",
        ("potential energy of -7602 J in x = 0.1234 m, ry = 1 rad",),
    ),
    "cylinder_misspelt": ("42:34", ("did you mean 'A'?",)),
    "switching_without_damping": ("29:1", ("without it the body never settles",)),
    "switching_with_loss_factor": ("29:1", ("a loss factor describes steady vibration",)),
    "pressure_over_less_than_a_turn": ("15:18", ("from 0 deg to 270 deg",)),
    "contact_without_time": ("20:38", ("the contact is too stiff to be followed",)),
    "clearance_in_metres": ("20:15", ("a clearance as large as the stroke is no joint",)),
    "torque_order_twice": ("22:27", ("order 1 stands twice in order",)),
    "measurement_without_reference": ("14:15", ("levels without a reference",)),
    "measurement_on_a_line": ("5:1", ("do not see roll about the line y = 0.2 m",)),
    "pump_draws_nothing": ("19:1", ("the pump draws nothing",)),
}
#: file -> errors, where there are more than one
ERRORS = {
    "five_mistakes": 5,
    "variable_bounds": 3,
    "variable_not_a_number": 2,
    "absorber_oil_as_thin_as_petrol": 2,
    "gas_force_unevenly_spaced": 2,
}


def refusal(path: Path, *overrides: str) -> str:
    """Return the message with which a case is refused."""
    with pytest.raises(CaseError) as caught:
        load_checked([path], overrides)
    assert caught.value.exit_code == EXIT_USAGE
    assert caught.value.problems
    return str(caught.value)


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_words(name: str) -> None:
    path = FOLDER / f"{name}.toml"
    place, words = EXPECTED[name]
    message = refusal(path)
    if place:
        assert message.splitlines()[1] == f"  --> {path}:{place}"
    for expected in words:
        assert expected in message
    assert message.count("error: ") == ERRORS.get(name, 1)
    assert re.search(r"\d+ errors? in .*, nothing was run\Z", message)
    assert "Traceback" not in message
    assert "pydantic" not in message


def test_every_file_has_its_words() -> None:
    assert set(EXPECTED) == {path.stem for path in FOLDER.glob("*.toml")}


def test_five_mistakes_with_their_lines() -> None:
    message = refusal(FOLDER / "five_mistakes.toml")
    places = re.findall(r"--> .*five_mistakes\.toml:(\d+):(\d+)", message)
    assert places == [("5", "1"), ("9", "1"), ("10", "1"), ("18", "1"), ("27", "1")]
    for words in ("unknown kind", "wrong dimension", "'rod_lenght'", "out of range", "key 'to'"):
        assert words in message


def test_the_mark_stands_under_the_key() -> None:
    lines = refusal(FOLDER / "misspelt_key_in_inline_table.toml").splitlines()
    excerpt = next(line for line in lines if line.startswith("  14 | "))
    mark = lines[lines.index(excerpt) + 1]
    assert excerpt[mark.index("^") : mark.rindex("^") + 1] == "crank_fase"


def test_a_folder(tmp_path: Path) -> None:
    assert "is a folder, not a case file" in refusal(tmp_path)


def test_a_name_that_is_nearly_right(tmp_path: Path) -> None:
    (tmp_path / "generator.toml").write_text("schema = 1\n")
    message = refusal(tmp_path / "generater.toml")
    assert "does not exist" in message
    assert "did you mean " in message
    assert "generator.toml?" in message


def test_unreadable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "secret.toml"
    path.write_text("schema = 1\n")

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    assert "cannot be read: permission denied" in refusal(path)


def test_fifty_megabytes(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    with path.open("wb") as file:
        file.truncate(50_000_000)
    assert "is 50 MB large, a case has at most 1 MB" in refusal(path)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"title = '\xff\xfe'\n", "is not a text in UTF-8 (line 1)"),
        (b"\x89HDF\r\n\x1a\n\x00\x00", "is not a text in UTF-8"),
        (b"x = " + b"[" * 200_000, "nested beyond reason"),
        (b"a" + b".a" * 200_000 + b" = 1\n", "a key of more than 40 parts"),
        (b"x = " + b"9" * 9_000, "thousands of digits"),
        (b"schema = 1\n[machine]\n[machine]\n", "a table that stands twice"),
        (b"x = {a = 1, a = 2}\n", "a key that stands twice"),
        (b"speed = fast\n", "a value that cannot be read"),
        (b"[[machine]]\nspeed = 1\n", "machine cannot be a list"),
        (b"limit = [1, 2]\n", "limit[0] cannot be a number"),
        (b"schema = 1979-05-27\n", "not a whole number"),
        (b"'' = 1\n", "unknown key ''"),
    ],
)
def test_nasty_bytes(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "nasty.toml"
    path.write_bytes(content)
    assert words in refusal(path)


def test_a_problem_of_an_override_is_shown_there() -> None:
    good = FOLDER.parent.parent / "cases" / "generator.toml"
    message = refusal(good, "machine.speed=3 kg")
    assert "--> --set machine.speed=3 kg" in message
    assert "found '3 kg', a mass" in message


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("machine.speed", "needs key=value"),
        ("=3", "has to start with the name of a table"),
        ("machine..speed=3", "not a key"),
        ("machine.speed=[", "is not TOML"),
        ("machine.speed.x=3", "no table, so it has no key 'x'"),
        ("machine.crank_train.cylinders[9].position=3", "has 3 entries, [0] to [2], so no [9]"),
        ("machine.crank_train.cylinders.position=3", "say which entry"),
        ("machine[0]=3", "machine is no list"),
        ("machine.speed=__import__('os')", "is not TOML"),
    ],
)
def test_overrides_that_cannot_be_applied(override: str, words: str) -> None:
    good = FOLDER.parent.parent / "cases" / "generator.toml"
    with pytest.raises(UsageError, match=re.escape(words)):
        load_case(good, [override])

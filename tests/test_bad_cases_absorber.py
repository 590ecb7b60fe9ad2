"""Claim: an absorber that contradicts itself is refused in words, at its line, once."""

import tomllib
from pathlib import Path

import pytest
from absorber_cases import PENDULUM, RATIOS, RIG, SEVERAL, TUNED, refusal, replaced

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.errors import CaseError

R, T, G, S, P = RATIOS, TUNED, RIG, SEVERAL, PENDULUM
K = 'kind = "absorber"\n'
RATIO_LINES = "stiffness_ratio = 0.08\ndamping_ratio = 0.015\n"

#: name -> (text, line of the problem, words of the message)
FORM: dict[str, tuple[str, int, tuple[str, ...]]] = {
    # each number in one way
    "negative ratio": (
        replaced(R, ("mass_ratio = 0.1", "mass_ratio = -0.1")),
        8,
        ("mass_ratio is out of range", "> 0"),
    ),
    "no mass at all": (replaced(R, ("mass_ratio = 0.1", "mass_ratio = 0")), 8, ("> 0",)),
    "infinite mass": (
        replaced(R, ("mass_ratio = 0.1", "mass_ratio = inf")),
        8,
        ("mass_ratio is not finite",),
    ),
    "negative stiffness": (
        replaced(R, ("stiffness_ratio = 0.08", "stiffness_ratio = -0.08")),
        9,
        ("stiffness_ratio is out of range", ">= 0"),
    ),
    "damping feeds energy": (
        replaced(G, ('inertia = "0.08 kg*m^2"', 'mass_ratio = 0.1\ndamping = "-2 N*m*s/rad"')),
        10,
        ("found '-2 N*m*s/rad'; allowed: >= 0", "feed energy in"),
    ),
    "two masses": (
        replaced(G, ('inertia = "0.08 kg*m^2"', 'inertia = "0.08 kg*m^2"\nmass_ratio = 0.2')),
        9,
        ("inertia and mass_ratio exclude each other",),
    ),
    "two dampers": (
        replaced(
            R, ("damping_ratio = 0.015\n", "damping_ratio = 0.015\nown_damping_ratio = .2\n")
        ).replace(" .2", " 0.2"),
        11,
        ("own_damping_ratio and damping_ratio exclude each other",),
    ),
    "two springs": (
        replaced(G, ('inertia = "0.08 kg*m^2"', "mass_ratio = 0.2\nstiffness_ratio = 0.1")),
        10,
        ("the spring stands twice: [machine.springs] gives it",),
    ),
    "two dampers, one an oil": (
        replaced(G, ('inertia = "0.08 kg*m^2"', "mass_ratio = 0.2\ndamping_ratio = 0.1")),
        10,
        ("the damper stands twice: [machine.oil] gives it",),
    ),
    "no spring": (
        replaced(R, ("stiffness_ratio = 0.08\n", "")),
        7,
        ("has no spring, and no [tuning] finds one", "stiffness_ratio"),
    ),
    "no damper": (replaced(R, ("damping_ratio = 0.015\n", "")), 7, ("has no damper",)),
    "no mass": (replaced(R, ("mass_ratio = 0.1\n", "")), 7, ("has no mass", "mass_ratio")),
    "own ratio without a spring": (
        replaced(R, (RATIO_LINES, "stiffness_ratio = 0\nown_damping_ratio = 0.2\n")),
        10,
        ("without a spring the absorber has no frequency of its own",),
    ),
    "torsion and translation": (
        replaced(R, ("damping_ratio = 0.02", 'inertia = "1 kg*m^2"\nmass = "2 kg"')),
        7,
        ("mass and inertia exclude each other",),
    ),
    "inertia without stiffness": (
        replaced(R, ("damping_ratio = 0.02", 'inertia = "1 kg*m^2"')),
        5,
        ("the primary has units, and no stiffness", "[machine.rod]"),
    ),
    "stiffness without inertia": (
        replaced(R, ("damping_ratio = 0.02", 'linear_stiffness = "9 N/mm"')),
        5,
        ("the primary has units, and no mass",),
    ),
    "units on ratios": (
        replaced(R, ("mass_ratio = 0.1", 'inertia = "1 kg*m^2"')),
        8,
        ("inertia is that of torsion, and the primary is of ratios alone",),
    ),
    "translation on torsion": (
        replaced(G, ('inertia = "0.08 kg*m^2"', 'mass = "8 kg"')),
        9,
        ("mass is that of translation, and the primary is in torsion",),
    ),
    "primary damped twice": (
        replaced(G, ("damping_ratio = 0.01", 'damping_ratio = 0.01\ndamping = "1 N*m*s/rad"')),
        7,
        ("damping and damping_ratio exclude each other",),
    ),
    "primary stiff twice": (
        replaced(G, ('inertia = "0.42', 'stiffness = "1700 N*m/rad"\ninertia = "0.42')),
        7,
        ("stands twice: [machine.rod] and stiffness give it",),
    ),
    "empty primary": (replaced(R, ("damping_ratio = 0.02\n", "")), 5, ("[machine.primary] is e",)),
    "empty secondary": (
        replaced(T, ("mass_ratio = 0.1\n", "")),
        7,
        ("[machine.secondary] is empty", "mass_ratio"),
    ),
    # tables that go together
    "no primary": (
        replaced(R, ("[machine.primary]\ndamping_ratio = 0.02\n", "")),
        3,
        ("[machine] has neither primary nor pendulum",),
    ),
    "no secondary": (
        replaced(T, ("[machine.secondary]\nmass_ratio = 0.1\n", "")),
        3,
        ("[machine] has neither secondary nor secondaries",),
    ),
    "one and several": (
        S + "[machine.secondary]\nmass_ratio = 0.1\n",
        7,
        ("secondaries and secondary exclude each other",),
    ),
    "a crank train": (
        replaced(R, (K, K + 'speed = "1500 rpm"\n')),
        5,
        ("a machine of kind 'absorber' has no speed",),
    ),
    "another kind": (
        replaced(P, ('"absorber"', '"plate"')),
        5,
        ("[machine.pendulum] is for a machine of kind 'absorber'", "found kind = 'plate'"),
    ),
    "oil without gap": (
        G[: G.index("[machine.gap]")] + '[machine.oil]\nviscosities = ["9 cSt", "3 cSt"]\n'
        'density = "900 kg/m^3"\n[tuning]\n',
        29,
        ("[machine.oil] needs [machine.gap]",),
    ),
    "gap without temperature": (
        replaced(G, ('temperature = "40 degC"\n', "")),
        29,
        ("oils need the temperature at which they run", "'60 degC'"),
    ),
    "flywheel on a rod that does not bend": (
        replaced(G, ('span = "1.5 m"\n', "")),
        10,
        ("the rod has no span",),
    ),
    "rod weighed twice": (
        replaced(G, ('density = "7850', 'mass = "5 kg"\ndensity = "7850')),
        18,
        ("density and mass exclude each other",),
    ),
    "length alone": (
        replaced(G, ('shear_modulus = "80 GPa"\ntotal', "total")),
        11,
        ("length needs shear_modulus",),
    ),
    "half a wire": (replaced(G, ("turns = 12\n", "")), 26, ("coil_diameter needs turns",)),
    "wire and rate": (
        replaced(G, ("turns = 12\n", 'turns = 12\nrate = "3 N/mm"\n')),
        25,
        ("wire_diameter and rate exclude each other",),
    ),
    "hooks without radius": (
        replaced(G, ('radius = "130 mm"\n', "")),
        21,
        ("need the radius of their hooks",),
    ),
    "bore film without a bore": (
        replaced(G, ('inner_radius = "70 mm"\n', 'bore_clearance = "1 mm"\n')),
        31,
        ("a disc without a bore",),
    ),
    "parts on ratios": (
        R + "[machine.gap]\nouter_radius = 0.1\nwidth = 0.02\n",
        13,
        ("[machine.gap] has units, and the primary is of ratios alone",),
    ),
    # the tuning
    "a fixed spring": (
        replaced(T, ("mass_ratio = 0.1\n", "mass_ratio = 0.1\nstiffness_ratio = 0.08\n")),
        9,
        ("stiffness_ratio is fixed, and [tuning] finds the spring", "10 | [tuning]"),
    ),
    "a fixed damper": (
        replaced(T, ("mass_ratio = 0.1\n", "mass_ratio = 0.1\ndamping_ratio = 0.08\n")),
        9,
        ("damping_ratio is fixed, and [tuning] finds the damper",),
    ),
    "tuning a pendulum": (
        P + '[tuning]\nnorm = "h2"\n',
        15,
        ("[tuning] needs [machine.primary]", "the tuning of a pendulum is its order"),
    ),
    "an idle bound": (
        T + 'kind = "viscous"\nbounds = { stiffness_ratio = [0, 1] }\n',
        12,
        ("of kind 'viscous' the spring is none",),
    ),
    "bounds backwards": (
        T + "bounds = { damping_ratio = [0.2, 0.1] }\n",
        11,
        ("from a lower value to a higher", "found 0.2 to 0.1"),
    ),
    "chart backwards": (
        T + "chart = { primary_damping = [0], mass_ratio = { from = 1, to = 0.1 } }\n",
        11,
        ("mass_ratio] goes from a lower value to a higher",),
    ),
    "a method twice": (
        replaced(T, ('["den_hartog"]', '["den_hartog", "den_hartog"]')),
        10,
        ("method 'den_hartog' stands twice",),
    ),
    "a method of another norm": (
        replaced(T, ('["den_hartog"]', '["nishihara_asami"]\nnorm = "h2"')),
        10,
        ("for the largest amplitude", "'warburton' with 'h2'"),
    ),
    "an unknown method": (
        replaced(T, ("den_hartog", "denhartog")),
        10,
        ("one of 'den_hartog', 'nishihara_asami'", "did you mean 'den_hartog'?"),
    ),
    "mistuned by all of it": (T + "mistuning = [1.0]\n", 11, ("out of range", "< 1")),
    "warming without oil": (
        T + 'temperatures = { from = "20 degC", to = "100 degC" }\n',
        11,
        ("what warms is an oil, and there is none",),
    ),
    "a mean square by Den Hartog": (
        T + 'norm = "h2"\n',
        10,
        ("the closed form 'den_hartog' is for the largest amplitude",),
    ),
    "a viscous mean square": (
        replaced(T, ('compare = ["den_hartog"]', 'norm = "h2"\nkind = "viscous"')),
        11,
        ("a mean square is tuned with spring and damper both free", "without kind"),
    ),
    "a mean square in bounds": (
        replaced(T, ('compare = ["den_hartog"]', 'norm = "h2"\nbounds = { travel = 9 }')),
        11,
        ("without bounds",),
    ),
    "Lanchester on a moving base": (
        T + 'kind = "lanchester"\nexcitation = "base"\n',
        12,
        ("for a force and the displacement", "'viscous'"),
    ),
    "slopes of several": (S + "sensitivity = true\n", 16, ("without sensitivity",)),
    "a misspelt family": (
        R + "vary = { mass_rato = [0.1] }\n",
        13,
        ("unknown key 'mass_rato'", "did you mean 'mass_ratio'?"),
    ),
    "a family of several": (
        S + "[response.absorber]\nvary = { mass_ratio = [0.1] }\n",
        17,
        ("one of several absorbers cannot vary",),
    ),
    "a mean square of several": (
        replaced(S, ('"h_infinity"', '"h2"')),
        15,
        ("several absorbers are tuned for the largest amplitude, without norm",),
    ),
    # curves
    "frequencies twice": (
        G + '[response.absorber]\nfrequencies = { to = "9 Hz" }\nfrequency_ratios = { to = 2 }\n',
        46,
        ("frequencies and frequency_ratios exclude each other",),
    ),
    "Hz of ratios": (
        replaced(
            R, ("frequency_ratios = { from = 0.5, to = 1.5 }", 'frequencies = { to = "9 Hz"}')
        ),
        12,
        ("has no frequency in Hz",),
    ),
    "curves backwards": (
        replaced(R, ("from = 0.5", "from = 2.5")),
        12,
        ("from a lower value to a higher", "from 2.5 to 1.5"),
    ),
    "two families": (
        R + "vary = { mass_ratio = [0.1], stiffness_ratio = [0] }\n",
        13,
        ("stiffness_ratio and mass_ratio exclude each other",),
    ),
    "no family": (R + "vary = {}\n", 13, ("has neither primary_damping nor mass_ratio",)),
    # pendulums
    "no order": (
        replaced(P, ("order = 2\n", "")),
        5,
        ("missing key 'order' in [machine.pendulum]", "of the excitation"),
    ),
    "two places": (
        replaced(P, ('path_radius = "19', 'arm_radius = "76 mm"\npath_radius = "19')),
        10,
        ("arm_radius and vertex_distance exclude each other",),
    ),
    "an arm on a cycloid": (
        P + 'swing_inertia = "0.001 kg*m^2"\n',
        15,
        ("runs on a circle, without rollers",),
    ),
    # temperatures
    "a scale of temperature": (
        replaced(G, ("40 degC", "40 degF")),
        34,
        ("a scale with a zero of its own", "degC or K"),
    ),
    "another unit": (replaced(G, ("40 degC", "40 mm")), 34, ("wrong dimension", "293.15 K")),
    "no temperature": (replaced(G, ("40 degC", "warm")), 34, ("not a number", "293.15 K")),
    "a temperature of ice": (
        replaced(G, ("40 degC", "-300 degC")),
        34,
        ("temperature is out of range", "found -26.85"),
    ),
    "a list of temperatures": (
        replaced(G, ('"40 degC"', "[40]")),
        34,
        ("temperature cannot be a list", "293.15 K"),
    ),
    "nan temperature": (
        replaced(G, ('"40 degC"', "nan")),
        34,
        ("temperature is not finite", "293.15 K"),
    ),
}


@pytest.mark.parametrize("name", sorted(FORM))
def test_words_and_line(name: str, tmp_path: Path) -> None:
    text, line, words = FORM[name]
    message = refusal(tmp_path, text)
    assert message, "nothing found wrong"
    place = message.splitlines()[1]
    assert place.startswith(f"  --> {tmp_path / 'absorber.toml'}:{line}:"), message
    for expected in words:
        assert expected in message
    assert message.count("error: ") == 1, message
    assert "pydantic" not in message


@pytest.mark.parametrize("text", [R, T, G, S, P], ids=["ratios", "tuned", "rig", "two", "swing"])
def test_the_plain_cases_are_fine(text: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, text) == ""


@pytest.mark.parametrize("scene", ["absorber", "absorber_rig", "pendulum"])
def test_absorbers_of_another_kind(scene: str) -> None:
    data = tomllib.loads(starter(scene))
    data["machine"] = {**data["machine"], "kind": "plate"}
    with pytest.raises(CaseError) as caught:
        validate(data)
    reported = [problem.path for problem in caught.value.problems]
    assert {("machine", part) for part in data["machine"]} - set(reported) == {("machine", "kind")}


def test_the_starters_have_no_problems() -> None:
    for scene in ("absorber", "absorber_rig", "pendulum"):
        assert check_machine(validate(tomllib.loads(starter(scene)))) == []

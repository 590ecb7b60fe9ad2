"""Claim: couplings that no maker's table can mean are refused in words, at their place."""

import tomllib
from pathlib import Path

import pytest
from refused import changed, problems_of, refusal, refusals, said_of
from shipped_cases import CASES

from vibecalc.core.case.search_checks import share_or_size
from vibecalc.errors import UnitError

PATH = CASES["genset_coupling"]
LIMITS = """nominal_torque = "16 kN*m"
maximum_torque = "40 kN*m"
power_loss = "1.2 kW"
"""
PLAIN = f"""stiffness = "80 kN*m/rad"
relative_damping = 1.13
{LIMITS}"""
COUPLINGS = {
    "plain": PLAIN,
    "slow": f"""{PLAIN}[machine.shaft_line.shafts.coupling.over_frequency]
frequency = ["0 Hz", "9 Hz"]
stiffness_factor = [1, 2]
""",
    "warm": f"""{PLAIN}temperature = "65 degC"
[machine.shaft_line.shafts.coupling.over_temperature]
temperature = ["20 degC", "50 degC", "130 degC"]
stiffness_factor = [1.0, 0.9, 0.65]
""",
}
TRANSIENT = """[response.torsion.transient]
kind = "run_up"
from = "600 rpm"
to = "700 rpm"
duration = "1 s"
"""
_KEYS = 'name = "{}"\nstiffness = "52 MN*m/rad"\ndamping = "4 kN*m*s/rad"\n'


def text_of(coupling: str) -> str:
    """The shipped case, its coupling last in the text."""
    text = PATH.read_text(encoding="utf-8")
    head, rest = text.split("shafts = [", 1)
    asked = rest.split("[response.torsion]")[1].split("[accuracy]")[0]
    asked = "".join(line for line in asked.splitlines(keepends=True) if "speeds" not in line)
    crank = "".join(
        f"[[machine.shaft_line.shafts]]\n{_KEYS.format(name)}"
        for name in ("a", "b", "c", "d", "e", "f")
    )
    stations = "".join(
        f'  {{ name = "{n}", inertia = 9.0, cylinder = "{n}" }},\n' for n in "123456"
    )
    stations += (
        '  { name = "flywheel", inertia = 300.0 },\n  { name = "generator", inertia = 200.0 },\n'
    )
    head = head.replace('stations = "genset_stations.csv"', f"stations = [\n{stations}]")
    return (
        f"{head}\n[response.torsion]\n{asked}\n{crank}[[machine.shaft_line.shafts]]\n"
        f'name = "elastic coupling"\n[machine.shaft_line.shafts.coupling]\n{COUPLINGS[coupling]}'
    )


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("coupling"))
def test_words_and_place(case: str, change: str, place: str, words: list[str]) -> None:
    found = problems_of(
        tomllib.loads(changed(text_of(case), change.replace("TRANSIENT", TRANSIENT)))
    )
    assert found, "nothing found wrong"
    said = [(".".join(map(str, one.path)), said_of(one)) for one in found]
    whole = f"machine.shaft_line.shafts.6.coupling{place}" if place.startswith(".") else place
    at = [text for key, text in said if key == whole.removesuffix(".")]
    assert any(all(word in text for word in words) for text in at), said


RISING = text_of("warm").replace(
    'temperature = "65 degC"', 'ambient_temperature = "20 degC"\ntemperature_rise = "45 K"', 1
)
RISE = "machine.shaft_line.shafts[6].coupling.temperature_rise"
AIR = "machine.shaft_line.shafts[6].coupling.ambient_temperature"
QUANTITY = 'quantity = "response/torsion/coupling/temperature"\nwhere = { coupling = 6 }\n'
STUDY = f"[optimisation]\nobjective = {{ {QUANTITY.replace(chr(10), ', ', 1).strip()} }}\n"


@pytest.mark.parametrize(
    ("study", "place"),
    [
        (
            f'{STUDY}variables = [{{ key = "{RISE}", min = "20 K", max = "60 degC" }}]',
            "optimisation.variables.0.max",
        ),
        (
            f'{STUDY}variables = [{{ key = "{RISE}", choices = ["20 K", "30 degC"] }}]',
            "optimisation.variables.0.choices.1",
        ),
        (
            f'{STUDY}variables = [{{ key = "{AIR}", min = "20 degC", max = "60 degC", '
            f'followed_by = [{{ key = "{AIR}", offset = "5 degC" }}] }}]',
            "optimisation.variables.0.followed_by.0.offset",
        ),
        (
            f'[[find]]\nname = "a"\n{QUANTITY}target = 300\n'
            f'key = "{RISE}"\nmin = "20 K"\nmax = "60 degC"',
            "find.0.max",
        ),
    ],
)
def test_a_rise_is_no_temperature_of_a_scale_in_studies_either(study: str, place: str) -> None:
    assert problems_of(tomllib.loads(RISING)) == []
    problems = problems_of(tomllib.loads(f"{RISING}{study}\n"))
    found = {".".join(map(str, one.path)): said_of(one) for one in problems}
    assert place in found, found
    assert "degC" in found[place]


def test_a_change_of_a_temperature_is_none_of_a_scale(tmp_path: Path) -> None:
    study = f'[[find]]\nname = "a"\n{QUANTITY}key = "{RISE}"\nmin = 20\nmax = 60\n'
    said = refusal(tmp_path, "case", f'{RISING}{study}change = "5 degC"\n')
    assert "does not fit response/torsion/coupling/temperature" in said and "found 5 degC" in said
    with pytest.raises(UnitError, match="a scale with a zero of its own"):
        share_or_size("5 degC", "K")  # of a tolerance


ENTRY = '["type a"]\nsource = "invented"\n' + PLAIN
TAKEN = '{ catalogue = "couplings.toml", type = "type a" }'


@pytest.mark.parametrize(
    ("taken", "catalogue", "words"),
    [
        (TAKEN.replace("type a", "type b"), ENTRY, ["no such type", "did you mean 'type a'?"]),
        (
            TAKEN.replace("couplings", "coupling"),
            ENTRY,
            ["the file does not exist", "'couplings.toml'"],
        ),
        (TAKEN.replace("couplings", "../couplings"), ENTRY, ["in the folder of its case"]),
        (TAKEN, "[", ["the file is not TOML"]),
        (TAKEN, "a = 1\n", ["the catalogue has no tables"]),
        (TAKEN, ENTRY + 'catalogue = "x.toml"\n', ["a catalogue of its own"]),
        (TAKEN, ENTRY.replace("80 kN*m/rad", "80 kN"), ["wrong dimension"]),
        (TAKEN, ENTRY.replace("stiffness", "stifness"), ["did you mean 'stiffness'?"]),
    ],
)
def test_catalogues(taken: str, catalogue: str, words: list[str], tmp_path: Path) -> None:
    (tmp_path / "couplings.toml").write_text(catalogue, encoding="utf-8")
    text = text_of("plain").split("[machine.shaft_line.shafts.coupling]")[0]
    said = refusal(tmp_path, "case", f"{text}coupling = {taken}\n")
    for word in words:
        assert word in said, said
    assert "Traceback" not in said


def test_what_stands_in_the_case_replaces_what_the_catalogue_says(tmp_path: Path) -> None:
    from vibecalc.core.case.load import load_case

    (tmp_path / "couplings.toml").write_text(ENTRY, encoding="utf-8")
    text = text_of("plain").split("[machine.shaft_line.shafts.coupling]")[0]
    taken = TAKEN.replace(" }", ', power_loss = "2 kW" }')
    (tmp_path / "case.toml").write_text(f"{text}coupling = {taken}\n", encoding="utf-8")
    loaded = load_case(tmp_path / "case.toml")
    found = loaded.resolved["machine"]["shaft_line"]["shafts"][6]["coupling"]
    assert found["power_loss"] == 2000.0
    assert found["stiffness"] == 80e3
    assert found["type"] == "type a"
    assert "catalogue" not in found

"""Claim: an absorber that contradicts itself, or cannot be built or tuned, is refused in words."""

import tomllib
from pathlib import Path

import pytest
from absorber_cases import FLOOR, PENDULUM, RATIOS, RIG, SEVERAL, TUNED, refusal, replaced
from refused import changed, refusals

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import load_case, validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.errors import CaseError

CASES = {
    "ratios": RATIOS, "tuned": TUNED, "rig": RIG, "several": SEVERAL, "pendulum": PENDULUM,
    "floor": FLOOR,
}  # fmt: skip
STARTERS = ("absorber", "absorber_rig", "pendulum")


@pytest.mark.parametrize(("case", "change", "line", "words"), refusals("absorber"))
def test_words_and_line(
    case: str, change: str, line: str, words: list[str], tmp_path: Path
) -> None:
    """What is wrong with the form has one message, at its line."""
    message = refusal(tmp_path, changed(CASES[case], change))
    assert message, "nothing found wrong"
    for expected in words:
        assert expected in message
    assert "pydantic" not in message
    if line != "-":
        place = message.splitlines()[1]
        assert place.startswith(f"  --> absorber.toml:{line}:"), message
        assert message.count("error: ") == 1, message


@pytest.mark.parametrize("case", CASES)
def test_the_plain_cases_are_fine(case: str, tmp_path: Path) -> None:
    assert refusal(tmp_path, CASES[case]) == ""


@pytest.mark.parametrize("scene", STARTERS)
def test_starters_are_fine_and_no_plates(scene: str) -> None:
    data = tomllib.loads(starter(scene))
    assert check_machine(validate(data)) == []
    data["machine"] = {**data["machine"], "kind": "plate"}
    with pytest.raises(CaseError) as caught:
        validate(data)
    reported = [problem.path for problem in caught.value.problems]
    assert {("machine", part) for part in data["machine"]} - set(reported) == {("machine", "kind")}


def test_a_longer_ring_is_reported_once(tmp_path: Path) -> None:
    text = SEVERAL.replace('name = "near"\n', 'name = "near"\non = "third"\n')
    text = text.replace("[tuning]", '[[machine.secondaries]]\nname = "third"\non = "far"\n'
                        "mass_ratio = 0.1\n[[machine.secondaries]]\nname = \"leaf\"\n"
                        'on = "far"\nmass_ratio = 0.1\n[tuning]')  # fmt: skip
    message = refusal(tmp_path, text)
    assert "'near' on 'third' on 'far' on 'near'" in message
    assert message.count("error: ") == 1


def test_catalogues_from_files(tmp_path: Path) -> None:
    files = {
        "springs": "# by rate\npart, rate [N/mm]\n17, 2.0\n18, 3.5\n",
        "oils": "part, viscosity_40 [cSt], viscosity_100 [cSt], density [kg/m^3]\n"
        "220, 220, 19.4, 890\n460, 460, 31, 902\n",
    }
    names = 'spring_catalogue = "springs.csv"\noil_catalogue = "oils.csv"\n'
    text = replaced(RIG, ('kind = "absorber"\n', 'kind = "absorber"\n' + names))
    assert refusal(tmp_path, text, **files) == ""
    loaded = load_case(tmp_path / "absorber.toml")
    machine = loaded.case.machine
    assert machine.spring_catalogue is not None and machine.oil_catalogue is not None
    assert machine.spring_catalogue.part == (17, 18)
    assert machine.spring_catalogue.rate == (2000.0, 3500.0)
    assert machine.oil_catalogue.viscosity_100[1] == pytest.approx(31e-6, rel=1e-15)
    worse = {**files, "oils": files["oils"].replace("460, 460, 31", "460, 460, 461")}
    assert "thinner at the higher temperature" in refusal(tmp_path, text, **worse)
    worse = {**files, "springs": files["springs"].replace("18,", "18.5,")}
    assert "column part: not a whole number" in refusal(tmp_path, text, **worse)
    inline = replaced(text, ('"springs.csv"', "{ part = [1, 2], rate = [9.0] }"))
    assert "not of one length" in refusal(tmp_path, inline, **files)


def test_a_stock_oil_may_be_unknown_at_the_temperature() -> None:
    """Such an oil is no choice there, and the others are."""
    text = replaced(
        RIG,
        ('"40 degC"', '"150 degC"'),
        ('["100 cSt", "11.4 cSt"]', '["9 cSt", "2.1 cSt"]'),
    )
    assert check_machine(validate(tomllib.loads(text))) == []

"""Claim: an absorber that contradicts itself, or cannot be built or tuned, is refused in words."""

import tomllib
from pathlib import Path

import pytest
from absorber_cases import FLOOR, PENDULUM, RATIOS, RIG, SEVERAL, TUNED, refusal, replaced
from refused import changed, refusals

from vibecalc.core.case.load import load_case, validate
from vibecalc.core.run.machine_checks import check_machine

CASES = {
    "ratios": RATIOS, "tuned": TUNED, "rig": RIG, "several": SEVERAL, "pendulum": PENDULUM,
    "floor": FLOOR,
}  # fmt: skip


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
    assert "differ in length" in refusal(tmp_path, inline, **files)


def test_a_stock_oil_may_be_unknown_at_the_temperature() -> None:
    """Such an oil is no choice there, and the others are."""
    text = replaced(
        RIG,
        ('"40 degC"', '"150 degC"'),
        ('["100 cSt", "11.4 cSt"]', '["9 cSt", "2.1 cSt"]'),
    )
    assert check_machine(validate(tomllib.loads(text))) == []

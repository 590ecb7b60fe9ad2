"""Claim: an absorber that cannot be built or tuned is refused in words, at its line.

The form of these files is fine; what is wrong with them is their physics.
"""

from pathlib import Path

import pytest
from absorber_cases import PENDULUM, RATIOS, RIG, SEVERAL, TUNED, refusal, replaced

from vibecalc.core.case.load import load_case
from vibecalc.core.run.machine_checks import check_machine

FOLDER = Path(__file__).parent / "bad_cases"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (replaced(RATIOS, ("damping_ratio = 0.02", "damping_ratio = 1e7")), "1e+07; allowed: 0"),
        (replaced(RATIOS, ("mass_ratio = 0.1", "mass_ratio = 1e-12")), "too small"),
        (TUNED + "bounds = { stiffness_ratio = [0, 1e12] }\n", "found 1e+12"),
        (TUNED + "bounds = { damping_ratio = [1e-15, 1] }\n", "found 1e-15"),
        (
            TUNED + "chart = { primary_damping = [0, 1e9], mass_ratio = { from = 0.1, to = 1 } }\n",
            "found 1e+09",
        ),
        (
            TUNED + "chart = { primary_damping = [0], mass_ratio = { from = 0.1, to = 1e9 } }\n",
            "found 1e+09",
        ),
        (
            TUNED
            + 'kind = "undamped_spring"\n'
            + "chart = { primary_damping = [0.1, 0], mass_ratio = { from = 0.1, to = 1 } }\n",
            "there is no optimum",
        ),
        (RATIOS + "vary = { secondary_damping = [0, 1e8] }\n", "found 1e+08"),
        (
            replaced(RATIOS, ("stiffness_ratio = 0.08", "stiffness_ratio = 0"))
            + "vary = { own_damping = [0.1] }\n",
            "no frequency of its own",
        ),
        (replaced(RIG, ('"24 mm"', '"24 mm"\nbore = "25 mm"')), "the bore is as wide as the rod"),
        (replaced(RIG, ("diametral_inertia", "polar_inertia")), "at most twice the diametral"),
        (
            replaced(RIG, ('clearance = "0.6 mm"', 'clearance = "0.6 mm"\nbore_clearance = 0.075'))
            .replace('width = "18 mm"', 'width = "90 mm"'),
            "as wide as the bore itself",
        ),
        (
            replaced(RIG, ('"0.6 mm"', '"0.6 mm"\nside_clearance = "18 mm"')),
            "found 0.018 m; allowed: < 0.018 m",
        ),
        (replaced(RIG, ('"460 cSt", "31 cSt"', "460, 31")), "are in m^2/s: '86 cSt'"),
        (
            replaced(RIG, ('density = "902', 'temperatures = [20, 313.15]\ndensity = "902')),
            "found 20 K",
        ),
        (replaced(SEVERAL, ('on = "near"', 'on = "far"')), "an absorber cannot carry itself"),
        (replaced(PENDULUM, ('"cycloidal"', '"circular"'), ('"60 deg"', "4")), "goes round"),
        (
            replaced(
                PENDULUM,
                ('path_radius = "19 mm"\n', ""),
                ('path = "cycloidal"', 'swing_inertia = "9 kg*m^2"'),
            ),
            "no arm tunes it to this order",
        ),
    ],
)  # fmt: skip
def test_words(text: str, words: str, tmp_path: Path) -> None:
    message = refusal(tmp_path, text)
    assert words in message
    assert message.count("error: ") >= 1


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
    import tomllib

    from vibecalc.core.case.load import validate

    assert check_machine(validate(tomllib.loads(text))) == []

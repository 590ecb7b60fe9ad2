"""Claim: reports and pictures of absorbers show computed numbers, and end in what to buy."""

from pathlib import Path

import pytest
from absorber_cases import TUNED
from shipped_cases import result_of

from vibecalc.core.report.text import render_report
from vibecalc.core.report.writing import show
from vibecalc.core.study.execute import execute, load_checked


def _text(tmp_path: Path, text: str, *settings: str) -> str:
    path = tmp_path / "case.toml"
    path.write_text(text, encoding="utf-8")
    (loaded,) = load_checked([path], settings)
    return " ".join(render_report(execute(loaded), full=True).split())


def _tuned(tmp_path: Path, table: str, damping: str = "0.02") -> str:
    text = TUNED.replace('compare = ["den_hartog"]', table)
    return _text(tmp_path, text, f"machine.primary.damping_ratio={damping}")


def test_mean_squares_are_not_called_peaks(tmp_path: Path) -> None:
    table = 'norm = "h2"\nmistuning = [0.01]\ncompare = ["warburton", "numerical"]'
    text = _tuned(tmp_path, table)
    assert "higher mean square, %" in text and "higher peak" not in text
    assert "true peak mean square" in text and "above the" not in text
    row = text.split("warburton ")[1].split()
    assert row[2] == "-" and float(row[3]) > 4.0


def test_a_threshold_of_zero_is_no_threshold(tmp_path: Path) -> None:
    text = _tuned(tmp_path, 'excitation = "base"\nresponse = "acceleration"', "0.0")
    assert "With any damping of the primary it grows without bound." in text
    assert "damping of the primary of 0 on" not in text


def test_a_spring_alone_that_does_not_help(tmp_path: Path) -> None:
    text = _tuned(tmp_path, 'kind = "undamped_spring"')
    assert "No spring without a damper lowers the largest amplitude" in text
    assert "force; spring and damper do." in text
    assert "No absorber" not in text and "peak that holds it" not in text


def test_where_none_helps_nothing_is_bought() -> None:
    text = render_report(
        result_of(
            "absorber_rig_a",
            "machine.primary.damping_ratio=0.9",
            "tuning.temperatures.points=2",
            "response.absorber.frequencies.points=11",
        )
    )
    part = text.split("What to buy:")[1].split("\n\n")[0]
    assert part.split() == ["-", "Buy", "nothing:", "no", "absorber", "lowers", "the", "peak."]
    for absent in ("higher peak", "slope by", "the best pairs", "antiresonance"):
        assert absent not in text


def test_two_absorbers_above_the_threshold() -> None:
    text = render_report(result_of("absorber_two", "machine.primary.damping_ratio=0.8"))
    assert "None of these absorbers helps" in text
    assert "a factor" not in text and "higher peak" not in text
    assert "None of these absorbers" not in render_report(result_of("absorber_two"))


def test_viscosities_of_stock_and_of_the_wanted_oil_compare() -> None:
    record, text = (
        result_of("absorber_rig_a").record,
        render_report(result_of("absorber_rig_a"), full=True),
    )
    # 386 and 155 cSt at 40 and 100 degC, density 975 kg/m^3 at 15: 970.4 at 20
    thick = record["hardware/oil/kinematic_viscosity"]
    place = list(thick.axes[0].values).index("silicone 500")
    row = text.split("\n  silicone 500")[1].split("\n")[0].split()
    assert row[0] == show(1e6 * float(thick.values[place]))
    assert float(row[1]) / float(row[0]) == pytest.approx(0.975 * (1.0 - 5.0 * 0.00094), rel=1e-3)
    assert f"({row[1]} mPa s, {row[0]} cSt)" in " ".join(text.split())
    assert "As the oil 'silicone 500' from stock warms, with the springs '2.8 N/mm':" in text

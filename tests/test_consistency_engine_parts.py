"""Claim: the arrays of a shaft line and of its cylinders say what the case says.

The truth is worked out here from dimensions and angles; what the whole line does is held in
`test_consistency_random_lines.py`.
"""

import math
import tomllib

import numpy as np
import pytest
from engine_cases import ENGINE, GEARED, replaced

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.excitation.model import build_firing, firing_angle
from vibecalc.schema import Case
from vibecalc.torsion.line import damping_matrix
from vibecalc.torsion.model import build_shaft_line

DEGREE = math.pi / 180.0


def case_of(text: str, *pairs: tuple[str, str]) -> Case:
    return validate(tomllib.loads(replaced(text, *pairs)))


def test_dampings_shafts_and_stresses_of_a_line_in_a_row() -> None:
    case = case_of(
        ENGINE,
        ('{ stiffness = "1e6 N*m/rad" },', '{ section = { outer_diameter = "60 mm", inner_diameter = "20 mm", length = "0.2 m", shear_modulus = "81 GPa" } },'),  # noqa: E501
        ('damping = "5 N*m*s/rad" },', "damping_ratio = 0.03, loss_factor = 0.1 },"),
    )  # fmt: skip
    line = build_shaft_line(case)
    polar = math.pi * (0.06**4 - 0.02**4) / 32.0
    assert line.line.stiffness[1] == pytest.approx(81e9 * polar / 0.2, rel=1e-14)
    assert line.section_modulus[1] == pytest.approx(polar / 0.03, rel=1e-14)
    assert line.section_modulus[0] == pytest.approx(math.pi * 0.07**3 / 16.0, rel=1e-14)
    assert line.section_modulus[2] == 0.0
    cone = '{ section = { outer_diameter = "60 mm", end_outer_diameter = "40 mm", length = 1 } },'
    taper = build_shaft_line(case_of(ENGINE, ('{ stiffness = "1e6 N*m/rad" },', cone)))
    mean = 19.0 / 3.0 / (6.0**3 * 4.0**3) * 4.0 * 1e8  # of 1 / D^4 along it, in 1/m^4
    assert taper.line.stiffness[1] == pytest.approx(80e9 * math.pi / 32.0 / mean, rel=1e-13)
    assert taper.section_modulus[1] == pytest.approx(math.pi * 0.04**3 / 16.0, rel=1e-14)
    # two inertias of 0.1 and 2 kg m^2 alone, on this spring and dashpot: ratio of their one mode
    pair, k, c = 0.1 * 2.0 / 2.1, line.line.stiffness[2], line.line.damping[2]
    assert c / (2.0 * math.sqrt(k * pair)) == pytest.approx(0.03, rel=1e-14)
    assert line.line.loss_factor.tolist() == [0, 0, 0.1, 0]
    assert damping_matrix(line.line)[0, -1] == -30.0
    assert [one.ring for one in line.dampers] == [4] and line.freedom_names[4] == "ring"


def test_a_throw_gives_what_its_parts_weigh() -> None:
    throw = 'throw = { journal_diameter = "70 mm", journal_length = "40 mm", pin_diameter = "60 mm", pin_length = "45 mm", web_thickness = "20 mm", web_width = "90 mm", beyond_journal = "40 mm", beyond_pin = "35 mm", formula = "source" }'  # noqa: E501
    case = case_of(ENGINE, ('inertia = "0.1 kg*m^2", cylinder = "2"', throw + ', cylinder = "2"'),
                   ('stiffness = "1e6 N*m/rad" },', throw + " },"))  # fmt: skip
    line = build_shaft_line(case)
    (caution,) = [
        text for text in machine_warnings(case) if "throw stiffness by the formulas" in text
    ]
    assert caution.startswith(f"{line.section_names[1]}: ") and "+-11 % about the middle" in caution
    heavy, radius = 7850.0, 0.06
    journal = heavy * math.pi / 32.0 * 0.07**4 * 0.04
    pin = heavy * math.pi / 4.0 * 0.06**2 * 0.045 * (radius**2 + 0.06**2 / 8.0)
    top, low, wide = radius + 0.035, 0.04, 0.09
    web = heavy * 0.02 * (wide * (top**3 + low**3) / 3.0 + wide**3 * (top + low) / 12.0)
    angle = np.arange(3600) * DEGREE / 10.0
    slide = np.sin(angle) + 0.3 * np.sin(angle) * np.cos(angle) / np.sqrt(
        1.0 - 0.09 * np.sin(angle) ** 2
    )
    piston = 2.0 * radius**2 * float(np.mean(slide**2))
    assert line.line.inertia[1] == pytest.approx(journal + pin + 2 * web + piston, rel=1e-12)
    flexible = 0.04 / 0.07**4 + 0.045 / 0.06**4 + 0.93 * radius / (0.02 * wide**3)
    assert line.line.stiffness[1] == pytest.approx(80e9 * math.pi / 32.0 / flexible, rel=1e-14)


def test_throws_stand_as_the_firing_has_them() -> None:
    plain = case_of(ENGINE)
    phases = [c.crank_phase / DEGREE for c in plain.machine.crank_train.cylinders]
    np.testing.assert_allclose(phases, [0.0, 240.0, 120.0], atol=1e-12)
    np.testing.assert_allclose(build_firing(plain).angle / DEGREE, [0, 480, 240], atol=1e-12)
    # a vee: two cylinders on each pin, banks 90 degrees apart, firing 90 and 270 degrees apart
    vee = case_of(
        ENGINE,
        ('{ name = "1" }, { name = "2" }, { name = "3" }',
         '{ name = "1", bank_angle = "-45 deg" }, { name = "2", bank_angle = "45 deg" }, '
         '{ name = "3", bank_angle = "-45 deg" }'),
        ('["1", "3", "2"]', '["1", "2", "3"]\nfiring_intervals = ["90 deg", "270 deg", "360 deg"]'),
    )  # fmt: skip
    phases = [c.crank_phase / DEGREE for c in vee.machine.crank_train.cylinders]
    np.testing.assert_allclose(phases, [315.0, 315.0, 315.0], atol=1e-9)
    # phases that are given turn the whole order, which starts where its first cylinder is at the
    # top: crank angles of the shaft line count from there, those of the shaking from phase zero
    turned = case_of(
        ENGINE,
        ('{ name = "1" }, { name = "2" }, { name = "3" }',
         '{ name = "1", crank_phase = "90 deg" }, { name = "2", crank_phase = "330 deg" }, '
         '{ name = "3", crank_phase = "210 deg" }'),
    )  # fmt: skip
    firing, crank = build_firing(turned), firing_angle(turned.machine)
    np.testing.assert_allclose(crank / DEGREE, [270, 30, 510], atol=1e-9)
    np.testing.assert_array_equal(firing.angle, build_firing(plain).angle)
    assert firing.first == pytest.approx(270 * DEGREE)
    phases = np.array([c.crank_phase for c in turned.machine.crank_train.cylinders])
    np.testing.assert_allclose(np.exp(1j * crank), np.exp(-1j * phases), atol=1e-9)
    # two strokes: the throws say it
    np.testing.assert_allclose(build_firing(case_of(GEARED)).angle / DEGREE, [0, 180], atol=1e-12)

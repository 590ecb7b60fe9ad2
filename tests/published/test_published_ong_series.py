"""Claim: coefficients of Ong's series of the piston's motion, equations 2.10 to 2.12."""

import pytest
from shipped_cases import result_of

from vibecalc.core.results.select import scalar
from vibecalc.units import convert


def test_equations_2_10_to_2_12() -> None:
    r, ell = 0.5, 2.375
    printed = {
        1: r,
        2: r**2 * (512 * ell**6 + 128 * ell**4 * r**2 + 60 * ell**2 * r**4 + 35 * r**6) / 512,
        4: -(r**4) * (64 * ell**4 + 48 * ell**2 * r**2 + 35 * r**4) / 256,
        6: 9 * r**6 * (4 * ell**2 + 5 * r**2) / 512,
        8: -5 * r**8 / 256,
    }
    record = result_of("compressor", "kinematics.series=truncated", "kinematics.terms=4").record
    for order, value in printed.items():
        expected = value if order == 1 else value / ell**7
        for path, scale in (("acceleration", 361.0**2), ("position", -1.0 / order**2)):
            found = scalar(record[f"kinematics/{path}_harmonics"], {"order": order})
            ours = -convert(complex(found).real, "m", "in")
            assert ours / scale == pytest.approx(expected, rel=1e-13), (path, order)

"""Claim: textbook engines have the free forces and couples of textbooks, and weights remove them.

In units of m r w^2 (forces) and m r w^2 a (couples), order 2 times the ratio l of crank radius to
rod length; a is the spacing of the cylinders. A piston gives its body m r w^2 (cos v + l cos 2v)
outwards, v being the angle of its throw from its cylinder: a cylinder counts with exp(i n v) along
its axis. A vector that swings has the largest length of its size; one that turns on a circle has
the radius as its length at all times.

- I3, throws at 0, 240, 120 deg, z = -1, 0, 1: -1 + exp(i n 120 deg) has the size 2 sin 60 deg =
  sqrt 3 for n = 1 and n = 2. Forces are sums of cube roots of one, zero.
- I4, 0, 180, 180, 0: 1 - 1 - 1 + 1 = 0 for n = 1, 4 for n = 2; z is odd and throws even: no couple.
- I5, firing order 1-2-4-5-3, throws at 0, 216, 144, 72, 288 deg: with z = -2 .. 2 the sum of
  z exp(i n v) is -2 - e(216 n) + e(72 n) + 2 e(288 n), whose size is 0.449 and 4.98.
- V2 at 90 deg, one pin: vectors exp(-i n b) along the axes at b = +-45 deg. n = 1: half of them
  turns, (1 + 1) / 2 = 1, against the crank cos 2b = 0: a circle of radius 1. n = 2:
  exp(-+i 90 deg) along axes +-45 deg is across only, 2 sin 45 deg = sqrt 2.
- V6, angle A = 2 b of the banks, pins of a throw d apart, each bank an I3 of size sqrt 3: of
  order n what turns with the crank is sqrt 3 |cos(n (d / 2 - b) + b)|, what turns against it sqrt 3
  |cos(n (d / 2 - b) - b)|; the largest length is their sum. It fires evenly where d - A is a
  multiple of 120 deg. A = 60, d = -60: 3/2 and 0, then 0 and 3/2. A = 90, d = -30:
  sqrt 3 (cos 15 + sin 15) = 3 / sqrt 2 for both orders.
- V8, pins at 0, 90, 270, 180 deg, each of which is a V2 at 90 deg: z = -3/2, -1/2, 1/2, 3/2 give
  -3/2 - i/2 - i/2 - 3/2, which turns with the size sqrt 10. Order 2: the axes' sums are the same
  at all throws but for signs +, -, -, +, which cancel with z as with 1.
- Flat four, cylinders e = 0.4 a apart in each pair: order 2 is -1 outwards for each, and opposed
  axes leave 2 e. Radial with five rods on one pin: 5/2 turns with the crank, sums of fifth roots of
  one are all others.

C. F. Taylor, The Internal-Combustion Engine in Theory and Practice, vol. 2, 1968, has such tables.
"""

import re
import tomllib
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from long_but import long_but

from vibecalc.core.case.load import load_case, resolve, validate
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Result
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked

ROOT = Path(__file__).resolve().parents[2]
GALLERY = ROOT / "cases" / "gallery"
#: N, N m, ratio of crank radius to rod length
FORCE, COUPLE, RATIO = 250.0, 25.0, 0.25


def e(degrees: float) -> complex:
    return complex(np.exp(1j * np.radians(degrees)))


def five(order: int) -> float:
    angles = (0, 216, 144, 72, 288)
    return abs(sum(z * e(order * v) for z, v in zip(range(-2, 3), angles, strict=True)))


R3 = np.sqrt(3.0)
#: force of orders 1 and 2, couple of orders 1 and 2; the orders that the weights of the case remove
FREE = {
    "i3": ((0, 0, R3, R3), (1,)),
    "i4": ((0, 4, 0, 0), (2,)),
    "i5": ((0, 0, five(1), five(2)), (1, 2)),
    "v2_90": ((1, np.sqrt(2), 0, 0), (1, 2)),
    "v6_60": ((0, 0, 1.5, 1.5), (1, 2)),
    "v6_90": ((0, 0, 3 / np.sqrt(2), 3 / np.sqrt(2)), (1,)),
    "v8": ((0, 0, np.sqrt(10), 0), (1,)),
    "flat_4": ((0, 0, 0, 0.8), (2,)),
    "r5": ((2.5, 0, 0, 0), (1,)),
}
#: what the optimiser finds, in deg: cos 2b = 0 of the V2, cos(d / 2 + 60 deg) = 0 of the V6
SOUGHT = {
    "v2_bank": ("cylinders[0].bank_angle", 45.0),
    "v6_60_pins": ("cylinders[1].crank_phase", 60.0),
}
SCALES = (FORCE, FORCE * RATIO, COUPLE, COUPLE * RATIO)


@cache
def result_of(name: str) -> Result:
    (loaded,) = load_checked([GALLERY / f"{name}.toml"], ())
    return execute(loaded)


def test_the_gallery_is_all_there() -> None:
    assert {path.stem for path in GALLERY.glob("*.toml")} == {*FREE, *SOUGHT}
    assert (five(1), five(2)) == pytest.approx((0.449, 4.98), abs=5e-4)


@pytest.mark.parametrize("name", FREE)
def test_free_forces_and_couples_are_those_of_textbooks(name: str) -> None:
    record, (sizes, removed) = result_of(name).record, FREE[name]
    found = {
        when: [record[f"balance/{when}/{what}"].values[n] for what in ("force", "couple")
               for n in (0, 1)]
        for when in ("before", "after")
    }  # fmt: skip
    for i, (size, scale) in enumerate(zip(sizes, SCALES, strict=True)):
        reach = scale * max(1.0, max(sizes))
        assert found["before"][i] == pytest.approx(scale * size, abs=1e-12 * reach, rel=1e-12)
        gone = 1 + i % 2 in removed
        left = 0.0 if gone else scale * size
        assert found["after"][i] == pytest.approx(left, abs=1e-12 * reach, rel=1e-12)
    assert float(record["balance/gap"].values) <= 1e-12 * float(
        record["balance/residual_before"].values
    )


def test_the_table_of_the_page_is_this() -> None:
    page = (ROOT / "docs" / "theory_balance.md").read_text(encoding="utf-8")
    lines = re.findall(
        r"^\|[^|]*\| `(\w+)` \| (\w+) (\d) \|[^|]*\| (.*?) \| (.*?) \| (.*?) \|", page, re.M
    )
    shown = {(name, what, int(order)): numbers for name, what, order, *numbers in lines}
    expected = {}
    for name, (sizes, _) in FREE.items():
        record = result_of(name).record
        for i, (size, scale) in enumerate(zip(sizes, SCALES, strict=True)):
            what, order = ("force", "couple")[i // 2], 1 + i % 2
            values = [record[f"balance/{when}/{what}"].values[order - 1] / scale
                      for when in ("before", "after")]  # fmt: skip
            if size:
                left = f"{values[1]:.4f}" if values[1] > 1e-12 else "0"
                expected[name, what, order] = [f"{size:.4f}", f"{values[0]:.4f}", left]
    assert shown == expected


@pytest.mark.parametrize("name", ["i5", "v6_90", "v2_90"])
def test_weights_as_the_report_writes_them_do_it_in_a_case(name: str) -> None:
    case = resolve(load_case(GALLERY / f"{name}.toml").case)
    lines = render_report(result_of(name), full=True).splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("  To add these weights"))
    written = []
    for line in lines[first + 1 :]:
        if line and not re.match(r"  (\[|\]|  \{|\w+ = )", line):
            break
        written.append(line)
    weights = tomllib.loads("\n".join(written))["machine"]["crank_train"]
    del case["balance"]
    loads = []
    for more in ({}, weights):
        case["machine"]["crank_train"] |= more
        record = run_case(validate(case))
        force, couple = (record[f"excitation/{what}"].values for what in ("force", "couple"))
        loads.append(np.concatenate([force, couple[:, 1:]], axis=1))  # without the torque
    before, left = loads
    for order in FREE[name][1]:
        assert np.max(np.abs(left[order - 1])) <= 1e-10 * np.max(np.abs(before))


@pytest.mark.parametrize("name", long_but(SOUGHT, "v6_60_pins"))
def test_bank_angle_and_split_of_pins_are_sought_by_the_optimiser(name: str) -> None:
    record, (key, degrees) = result_of(name).record, SOUGHT[name]
    found = record[f"optimisation/variable/machine.crank_train.{key}"]
    assert np.degrees(found.values) == pytest.approx(degrees, abs=1e-5)
    assert float(record["balance/residual"].values) <= 1e-5

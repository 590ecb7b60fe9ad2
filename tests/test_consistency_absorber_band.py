"""Claim: motions in units, and tunings within a band, are those of full matrices solved here."""

import itertools
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

from vibecalc.core.case.load import validate
from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.core.study.execute import execute, load_checked

GIVEN = {"mass": 25.0, "linear_stiffness": 54_000.0, "linear_damping": 380.0}
BASE = """
schema = 1
title = "in units"
[machine]
kind = "absorber"
primary = { mass = "500 kg", natural_frequency = "8 Hz", damping_ratio = 0.02 }
secondary = { mass = "25 kg" }
[tuning]
band = { from = "7 Hz", to = "9 Hz" }
[response.absorber]
force = "200 N"
frequencies = { from = "4 Hz", to = "12 Hz", points = 41 }
"""


def made(text: str, **changes: Any) -> Record:
    """A run of the case with tables of [response.absorber] and [machine] changed."""
    case = tomllib.loads(text)
    if "machine__secondary" in changes and "tuning" not in changes:
        del case["tuning"]
    for path, value in changes.items():
        *above, key = path.split("__")
        table = case
        for part in above:
            table = table.setdefault(part, {})
        table[key] = value
    return run_case(validate(case))


def of(result: Record, path: str) -> Any:
    return np.asarray(result[path].values)


# ----------------------------------------------------------------------------
# The tests' own system: physical matrices in kg, N/m, N s/m, each frequency solved by itself.
# ----------------------------------------------------------------------------

M1, F1, Z1, M2 = 500.0, 8.0, 0.02, 25.0
W1 = 2.0 * np.pi * F1
K1, C1 = M1 * W1**2, 2.0 * Z1 * M1 * W1


def solved(
    w: np.ndarray, k: float, c: float, force: Any, ground: Any = 0.0, f: float = 1.0
) -> np.ndarray:
    """Absolute motion (n, 2) in m under a force in N and a motion of the ground in m at each w."""
    stiff = np.array([[f**2 * K1 + k, -k], [-k, k]])
    drag = np.array([[f * C1 + c, -c], [-c, c]])
    mass = np.diag([M1, M2])
    z = stiff + 1j * w[:, None, None] * drag - np.square(w)[:, None, None] * mass
    load = force + (f**2 * K1 + 1j * w * f * C1) * ground
    right = np.stack([load, 0.0 * load], axis=1) + 0j
    return np.linalg.solve(z, right[..., None])[..., 0]


@pytest.mark.parametrize(
    ("key", "size"),
    [("force", 200.0), ("unbalance", 0.02), ("base_displacement", 1e-3),
     ("base_acceleration", 0.3)],
)  # fmt: skip
def test_motions_and_forces_in_units(key: str, size: float) -> None:
    """Every curve of every amplitude, with and without, and the largest between its samples."""
    asked = {key: size, "frequencies": {"from": "4 Hz", "to": "12 Hz", "points": 41}}
    result = made(BASE, response__absorber=asked, machine__secondary=GIVEN)
    k, c = GIVEN["linear_stiffness"], GIVEN["linear_damping"]

    def motions(w: np.ndarray, absorber: bool) -> dict[str, np.ndarray]:
        one = np.ones(len(w))
        force = {"force": size * one, "unbalance": size * np.square(w)}.get(key, 0.0 * one)
        ground = {"base_displacement": size * one, "base_acceleration": -size / np.square(w)}.get(
            key, 0.0 * one
        )
        if absorber:
            x = solved(w, k, c, force, ground)
        else:
            load = force + (K1 + 1j * w * C1) * ground
            x = (load / (K1 + 1j * w * C1 - np.square(w) * M1))[:, None] * [[1.0, 0.0]]
        travel = x[:, 1] - x[:, 0]
        return {
            "displacement": x[:, 0],
            "velocity": 1j * w * x[:, 0],
            "acceleration": -np.square(w) * x[:, 0],
            "deflection": x[:, 0] - ground,
            "transmitted_force": (K1 + 1j * w * C1) * (x[:, 0] - ground),
            "travel": travel,
            "spring_force": k * travel,
            "damper_force": 1j * w * c * travel,
        }

    root = "response/absorber/motion/"
    hertz = result[root + "travel"].axes[0].values
    coarse, fine = (2.0 * np.pi * x for x in (hertz, np.linspace(4.0, 12.0, 8001)))
    names = {path.removeprefix(root) for path in result if path.startswith(root)}
    names = {name for name in names if "/" not in name}
    assert len(names) == {"force": 7, "unbalance": 7, "base_displacement": 8}.get(key, 6)
    for name in names:
        alone = name in ("travel", "spring_force", "damper_force")
        for absorber in [True] if alone else [True, False]:
            below = "" if absorber else "without/"
            row, top = of(result, root + below + name), of(result, f"{root}{below}largest/{name}")
            expected = motions(coarse, absorber)[name]
            np.testing.assert_allclose(row, expected, rtol=0, atol=1e-9 * np.max(np.abs(expected)))
            dense = float(np.max(np.abs(motions(fine, absorber)[name])))
            height = float(top)
            assert dense <= height * (1.0 + 1e-9) and height <= dense * (1.0 + 1e-4), name


def test_the_same_in_torsion_and_by_stiffness() -> None:
    """A frequency stands for a stiffness; a torque in N m turns what a force in N moves."""
    torsion = {"inertia": 500.0, "natural_frequency": "8 Hz", "damping_ratio": 0.02}
    same = {"inertia": 25.0, "stiffness": 54_000.0, "damping": 380.0}
    asked = {"torque": 200.0, "frequencies": {"from": "4 Hz", "to": "12 Hz", "points": 41}}
    turned = made(BASE, machine__primary=torsion, machine__secondary=same,
                  response__absorber=asked)  # fmt: skip
    plain = made(BASE, machine__secondary=GIVEN)
    by_spring = {"mass": M1, "linear_stiffness": K1, "damping_ratio": 0.02}
    stiff = made(BASE, machine__primary=by_spring, machine__secondary=GIVEN)
    for root, other in (("displacement", "angle"), ("spring_force", "spring_torque")):
        path = "response/absorber/motion/"
        one = of(plain, path + root)
        np.testing.assert_allclose(of(turned, path + other), one, rtol=1e-9)
        np.testing.assert_allclose(of(stiff, path + root), one, rtol=1e-9)


# ----------------------------------------------------------------------------
# Tunings within a band.
# ----------------------------------------------------------------------------


@pytest.mark.long
def test_tolerances_are_paid_for_once_and_bring_more() -> None:
    """The robust tuning is worse with exact parts and better in the worst case; corners by hand."""
    shares = {"natural_frequency": "5 %", "damping": "20 %"}
    result = made(BASE, tuning={"band": {"from": "5 Hz", "to": "12 Hz"}, "tolerances": shares})
    root = "tuning/tolerances/"
    worst, nominal = (float(of(result, root + x)) for x in ("worst_peak", "nominal_peak"))
    assert float(of(result, root + "exact/nominal_peak")) < nominal < worst
    assert worst < float(of(result, root + "exact/worst_peak"))
    k, z = (
        float(of(result, f"tuning/{x}"))
        for x in ("stiffness_ratio", "damping_over_primary_critical")
    )
    x = np.linspace(5.0, 12.0, 6001) / F1
    tops = []
    for f, d in itertools.product((0.95, 1.0, 1.05), (0.8, 1.0, 1.2)):
        force = K1 * np.ones(len(x))
        tops.append(np.max(np.abs(solved(x * W1, k * K1, z * d * 2.0 * M1 * W1, force,
                                         f=f)[:, 0])))  # fmt: skip
    assert max(tops) == pytest.approx(worst, rel=1e-5)
    assert float(of(result, root + "inside_peak")) <= worst


def test_modes_of_a_case_are_tuned_within_the_band() -> None:
    """Three modes, force and reading elsewhere: a dense scan, and slopes by differences."""
    rows = [
        (5.2, 2e4, 0.015, 1.0, 1.0),
        (8.1, 1.8e4, 0.02, 0.4, -0.7),
        (6.1, 2.1e4, 0.01, 0.3, 0.6),
    ]
    names = ("natural_frequency", "modal_mass", "damping_ratio", "shape_at_absorber",
             "shape_at_response")  # fmt: skip
    modes = [dict(zip(names, (f"{row[0]} Hz", *row[1:]), strict=True)) for row in rows]
    result = made(BASE, machine__primary={"modes": modes}, machine__secondary={"mass": 400.0},
                  tuning={"band": {"from": "4.5 Hz", "to": "7 Hz"}})  # fmt: skip
    k, c = (float(of(result, f"tuning/linear_{x}")) for x in ("stiffness", "damping"))

    def response(hz: np.ndarray, k: float, c: float) -> np.ndarray:
        """Receptances of the bare modes, and the force of the absorber on them."""
        w = 2.0 * np.pi * hz
        alpha = {(a, b): sum(r[a] * r[b] / (r[1] * ((2 * np.pi * r[0]) ** 2 - w**2
                 + 2j * r[2] * 2 * np.pi * r[0] * w)) for r in rows)
                 for a, b in ((3, 3), (3, 4), (4, 4))}  # fmt: skip
        g = k + 1j * w * c
        pull = -400.0 * w**2 * g / (g - 400.0 * w**2)
        return np.abs(alpha[4, 4] - alpha[3, 4] ** 2 * pull / (1.0 + pull * alpha[3, 3]))

    hz = np.linspace(4.5, 7.0, 20001)
    first = rows[0][1] * (2.0 * np.pi * rows[0][0]) ** 2
    top = first * float(np.max(response(hz, k, c)))
    assert top == pytest.approx(float(of(result, "tuning/peak")), rel=1e-6)
    shown = of(result, "response/absorber/motion/displacement")
    grid = np.linspace(4.0, 12.0, 41)
    np.testing.assert_allclose(np.abs(shown), 200.0 * response(grid, k, c), rtol=1e-8)
    for near in itertools.product((0.98, 1.0, 1.02), (0.9, 1.0, 1.1)):
        other = first * float(np.max(response(hz, k * near[0], c * near[1])))
        assert other >= top * (1.0 - 1e-6)


def test_a_machine_of_constant_speed_rests_where_its_absorber_swings() -> None:
    """Without damping the force goes through the spring; over a spread of speed by a dense scan."""
    tuning = {"frequency": "8.4 Hz", "band": {"from": "8.3 Hz", "to": "8.5 Hz"}}
    ends = {"from": "8.4 Hz", "to": "8.6 Hz", "points": 3}
    result = made(BASE, tuning=tuning, response__absorber={"force": 200.0, "frequencies": ends})
    root = "response/absorber/motion/"
    assert abs(of(result, root + "displacement")[0]) < 1e-15
    assert abs(of(result, root + "spring_force")[0]) == pytest.approx(200.0, rel=1e-10)
    w = np.linspace(8.3, 8.5, 2001) * 2.0 * np.pi
    k = M2 * (2.0 * np.pi * 8.4) ** 2
    assert float(of(result, "tuning/linear_stiffness")) == pytest.approx(k, rel=1e-13)
    scan = np.max(np.abs(solved(w, k, 0.0, K1 + 0.0 * w)[:, 0]))
    assert float(of(result, "tuning/peak")) == pytest.approx(scan, rel=1e-9)


def test_a_frequency_as_given_is_no_optimum_and_stands_next_to_it(tmp_path: Path) -> None:
    """Within a wide band it does more harm than good, which says nothing about absorbers."""
    band = {"from": "7 Hz", "to": "9 Hz"}
    stock = [{"name": "A", "rate": 6e3, "parallel": 9}]
    case = tomllib.loads(BASE)
    case["machine"] |= {"springs": {"count": 4}, "stock_springs": stock}
    case["tuning"] = {"band": band, "frequency": "8.4 Hz"}
    path = tmp_path / "given.toml"
    path.write_text(tomli_w.dumps(case), encoding="utf-8")
    result = execute(load_checked([path])[0])
    record = result.record
    assert float(of(record, "tuning/peak")) > float(of(record, "tuning/peak_alone"))
    assert not {"tuning/helps", "tuning/band/residual", "tuning/active/weight"} & set(record)
    assert not any("does better" in one for one in record.warnings)
    free = made(BASE)
    for name in ("stiffness_ratio", "damping_over_primary_critical", "peak"):
        assert float(of(record, f"tuning/optimum/{name}")) == float(of(free, f"tuning/{name}"))
    text = " ".join(render_report(result, full=True).split())
    assert "nothing:" not in text and "No absorber" not in text
    assert "given frequency, 8.400 Hz: 27.42, more than the 25.01 without the absorber" in text
    assert "Optimum for the band: peak 5.267" in text
    assert "15.4 % below this tuning" in text


def test_only_a_bound_that_is_there_holds_a_tuning() -> None:
    band = {"from": "7 Hz", "to": "9 Hz"}
    for bounds, said in (
        ({"damping_over_primary_critical": [0.0, 0.9]}, []),
        ({"damping_over_primary_critical": [0.02, 0.9]}, ["damping ratio, 0.02"]),
    ):
        result = made(BASE, tuning={"band": band, "bounds": bounds})
        held = [one for one in result.warnings if "limited by" in one]
        assert len(held) == len(said)
        assert all(words in one for words, one in zip(said, held, strict=True))

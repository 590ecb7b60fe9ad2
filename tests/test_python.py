"""Claim: what a command does is had from Python, with the same words, files and refusals."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drawn import coarse
from fuzzing import command
from shipped_cases import CASES, ROOT

import vibecalc
from vibecalc.api import _checked

GENERATOR = CASES["generator"]
GOLDEN = ROOT / "tests" / "golden"
PEAK = "isolation/couple_over_lever/steady_peak"


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    coarse(monkeypatch)


def swept(damping: float = 60.0) -> vibecalc.Result:
    speeds = {"machine.speed": "2000 rpm:4900 rpm:3", "machine.mounts.each.damping": [40, damping]}
    return vibecalc.sweep(GENERATOR, "two.sweep.h5", grid=speeds, jobs=1, keep=PEAK)


def measured() -> vibecalc.Result:
    return vibecalc.accuracy(GENERATOR, stages="kinematics", longest=0.1)


def optimum() -> vibecalc.Result:
    return vibecalc.read(GOLDEN / "generator_mount_stock.h5")


@pytest.mark.parametrize(
    ("made", "name", "words", "picture"),
    [
        (swept, "two.sweep.h5", "6 of 6 points are computed", "two_sweep_line.png"),
        (measured, "generator.accuracy.h5", "Speed against error", "generator.accuracy.png"),
        (optimum, "generator_mount_stock.h5", "Optimisation", "stock_combinations.png"),
    ],
)
def test_every_kind_of_result_has_its_own_report_and_pictures(
    made: Any, name: str, words: str, picture: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.setattr("vibecalc.core.accuracy.topic._ENOUGH", 0.0)
    result = made()
    path = vibecalc.write(result, Path("kept") / name)
    text = vibecalc.report(result)
    assert words in text and text == vibecalc.report(path) == command("report", str(path)).out
    assert path.with_suffix(".txt").read_text(encoding="utf-8") == text
    assert vibecalc.diff(result, path).same
    one = [] if made is not optimum else ["combinations"]
    drawn = vibecalc.plot(result, "drawn", only=one, dpi=50)
    said = command("plot", str(path), "-o", "said", "--dpi", "50", *(f"--only={n}" for n in one))
    assert [one.name for one in drawn] == [Path(line).name for line in said.out.split()]
    assert any(one.name.endswith(picture) for one in drawn)
    for file in drawn:
        assert file.read_bytes() == (Path("said") / file.name).read_bytes()


def test_a_page_is_that_of_the_file() -> None:
    pytest.importorskip("matplotlib")
    result = vibecalc.read(GOLDEN / "absorber_mass.h5")
    page = vibecalc.report(result, html=True)
    assert page.startswith("<!doctype html>") and "image/svg+xml" in page
    assert vibecalc.report(result).splitlines()[0] in page


def test_a_sweep_that_was_written_anew_is_not_taken_for_what_was_read() -> None:
    result = swept()
    Path("two.sweep.h5").unlink()
    swept(damping=70.0)
    with pytest.raises(vibecalc.ResultError, match="has changed since it was read"):
        vibecalc.report(result)
    Path("two.sweep.h5").unlink()
    with pytest.raises(vibecalc.ResultError, match="there is no result file"):
        vibecalc.write(result, "other.h5")
    assert not Path("other.h5").exists()


def test_keys_are_short_for_set() -> None:
    keys: dict[str, Any] = {"machine.speed": "3000 rpm", "isolation.gravity": 9.8}
    short, said = vibecalc.run(GENERATOR, **keys), vibecalc.run(GENERATOR, set=keys)
    assert short.case == said.case and short.case != vibecalc.read(GOLDEN / "generator.h5").case
    assert vibecalc.check(GENERATOR, **keys) == vibecalc.check(GENERATOR, set=keys)
    with pytest.raises(vibecalc.CaseError, match="sped"):
        vibecalc.check(GENERATOR, sped=3)


SPEED = {"machine.speed": "4900 rmp"}


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda: vibecalc.run("none.toml"), "CaseError", "none.toml does not exist"),
        (lambda: vibecalc.run({}), "CaseError", "missing key 'title'"),
        (lambda: vibecalc.run(GENERATOR, set=SPEED), "CaseError", "speed: unknown unit"),
        (lambda: vibecalc.check(GENERATOR, set={"speed": 3}), "CaseError", "unknown key 'speed'"),
        (lambda: vibecalc.run(GENERATOR, unset="x.y"), "UsageError", "the case has no key"),
        (lambda: vibecalc.sweep(GENERATOR, "s.h5"), "UsageError", "not say what to vary"),
        (lambda: vibecalc.accuracy(GENERATOR, stages="x"), "UsageError", "no stage 'x'"),
        (lambda: vibecalc.accuracy(GENERATOR, longest=0.0), "UsageError", "seconds above 0"),
        (lambda: vibecalc.write(optimum(), "x.txt"), "UsageError", "ends in .h5"),
        (lambda: vibecalc.report("none.h5"), "ResultError", "there is no result file"),
        (lambda: vibecalc.plot(optimum(), formats="bmp"), "UsageError", "found 'bmp'"),
        (lambda: vibecalc.plot(optimum(), only="x"), "UsageError", "no picture of this"),
        (lambda: optimum()["isolation/pitch"], "MissingQuantity", "is a group"),
        (lambda: optimum()["isolation/pitch/inertia"].to("kg"), "UnitError", "wrong dimension"),
    ],
)
def test_what_is_wrong_is_said_in_a_list(call: Any, kind: str, said: str) -> None:
    with pytest.raises(vibecalc.VibecalcError) as caught:
        call()
    assert type(caught.value).__name__ == kind and said in str(caught.value)
    problems = caught.value.problems
    assert problems and all(one.message for one in problems)
    assert not problems[0].place or problems[0].file
    assert caught.value.exit_code == 2


def test_a_problem_has_file_line_key_and_message(tmp_path: Path) -> None:
    path = tmp_path / "slips.toml"
    lines = GENERATOR.read_text(encoding="utf-8").replace("\nspeed = ", "\nsped = ", 1)
    path.write_text(lines + "\n[nonsense]\na = 1\n", encoding="utf-8")
    with pytest.raises(vibecalc.CaseError) as caught:
        vibecalc.run(path)
    found = {one.path[-1]: one for one in caught.value.problems}
    assert set(found) == {"sped", "nonsense"}
    for key, one in found.items():
        assert one.file == str(path) and key in path.read_text().splitlines()[one.line - 1]
    assert found["sped"].hint == "did you mean 'speed'?"


def test_a_quantity_that_is_not_there_is_a_key_error_too() -> None:
    result = optimum()
    assert "isolation/pitch" not in result and result.get("isolation/pitch") is None
    with pytest.raises(KeyError) as caught:
        result["isolation/levr"]
    assert str(caught.value).startswith("there is no 'isolation/levr' in this result; it has iso")


TYPED = """
from pathlib import Path
import numpy as np
import vibecalc

def compare(case: str | Path) -> float:
    try:
        first = vibecalc.run(case, unset=["limit"], set={"machine.speed": "3000 rpm"})
        second = vibecalc.run(dict(first.case), progress=True)
    except vibecalc.CaseError as error:
        for problem in error.problems:
            print(problem.file, problem.line, ".".join(map(str, problem.path)), problem.message)
        raise
    except vibecalc.NumericalFailure as failure:
        print(failure.result, failure.exit_code)
        raise
    quantity: vibecalc.Quantity = first["isolation/pitch/natural_frequency"]
    axis: vibecalc.Axis
    for axis in quantity.axes:
        print(axis.name, axis.values, axis.unit)
    values: np.ndarray = quantity.to("mm")
    print(vibecalc.check(case)["stages"], values, quantity.unit, quantity.error_estimate)
    swept: vibecalc.Result = vibecalc.sweep(case, "x.h5", grid={"a": [1, 2], "b": "1:2:3"}, jobs=2)
    print(swept.to_xarray(), swept.to_pandas(), quantity.to_xarray(), quantity.to_pandas())
    path: Path = vibecalc.write(second, "y.h5")
    text: str = vibecalc.report(path, full=True) + vibecalc.report(vibecalc.read(path), html=True)
    pictures: list[Path] = vibecalc.plot(path, "folder", only="run_up", formats=["svg"], dpi=100)
    print(text, pictures, vibecalc.accuracy(case, stages="kinematics", longest=1.0))
    same: bool = vibecalc.diff(first, path, rules="rules.toml").same
    return float(quantity.values) if same else 0.0
"""


@pytest.mark.long
def test_a_script_that_calls_everything_passes_strict_types(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(TYPED, encoding="utf-8")
    cache = ["--cache-dir", str(ROOT / ".mypy_cache")]
    checked = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", *cache, str(script)],
        capture_output=True, text=True, cwd=ROOT,
    )  # fmt: skip
    assert checked.returncode == 0, checked.stdout


#: the package for a script without types
loose: Any = vibecalc


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: loose.run(None), "needs its file, or its tables as a dict; found None"),
        (lambda: loose.run(optimum()), "run(result.case)"),
        (lambda: loose.run(GENERATOR, set={1: 3}), "set: needs keys with their values"),
        (lambda: loose.run(GENERATOR, unset=3), "needs a text, or a list of texts; found 3"),
        (lambda: loose.sweep(GENERATOR, "s.h5", grid=["machine.speed=1:2:3"]), "grid: needs"),
        (
            lambda: loose.sweep(GENERATOR, "s.h5", grid={"machine.speed": 300}),
            "the axis machine.speed: needs a list of values",
        ),
        (lambda: loose.sweep(GENERATOR, None, grid={}), "needs the name of the file of a sweep"),
        (
            lambda: loose.sweep(GENERATOR, "s.h5", grid={"machine.speed": [3, 4]}, jobs=1.5),
            "found jobs=1.5",
        ),
        (lambda: loose.accuracy(GENERATOR, longest="x"), "longest: needs a number of seconds"),
        (lambda: loose.read(optimum()), "needs the name of a result file; found <vibecalc"),
        (lambda: loose.write("x.h5", "y.h5"), "what is written: needs a result; found 'x.h5'"),
        (lambda: loose.report({}), "needs the name of a result file, or a result; found {}"),
        (lambda: loose.plot(optimum(), dpi="x"), "dpi: needs a number; found 'x', a str"),
        (lambda: loose.diff(optimum(), optimum(), rules={}), "needs the name of a file of rul"),
    ],
)  # fmt: skip
def test_an_argument_of_the_wrong_kind_is_said(call: Any, said: str) -> None:
    with pytest.raises(vibecalc.UsageError) as caught:
        call()
    assert said in str(caught.value)


def test_results_compare_and_show_themselves_in_a_line() -> None:
    result, again = (vibecalc.read(GOLDEN / "generator.h5") for _ in range(2))
    assert result == again and result["isolation/pitch/damping"] in list(again.values())
    curve, other = (
        result["isolation/support_force/run_up"],
        again["isolation/couple_over_lever/run_up"],
    )
    assert curve == again[curve.path] != other and curve.axes != other.axes and curve != 3
    assert repr(curve).startswith("<vibecalc quantity 'isolation/support_force/run_up': [[")
    assert repr(curve).endswith(f"N over mount (4), speed ({len(curve.axes[1].values)})>")
    assert repr(curve.axes[0]) == "<vibecalc axis 'mount': ['1' '2' '3' '4']>"
    assert repr(vibecalc.diff(result, again)) == "<vibecalc comparison: same>"
    found = repr(vibecalc.diff(result, optimum()))
    assert found.endswith("quantities differ>") and len(found) < 80


def test_a_complex_number_leaves_the_others_of_a_table_real() -> None:
    pytest.importorskip("pandas")
    values = vibecalc.read(GOLDEN / "absorber_pendulum.h5").to_pandas()["value"]
    assert values["pendulum/order"] == 2.0 and isinstance(values["pendulum/order"], float)
    assert any(isinstance(one, complex) for one in values)


def test_every_call_stands_in_the_help_of_the_package() -> None:
    calls = [name for name in loose.__all__ if name.islower()]
    assert len(calls) == 11 and all(f"{name}(" in str(vibecalc.__doc__) for name in calls)


SPEED_KEY = "machine.speed"


def pint_values() -> list[Any]:
    pint = pytest.importorskip("pint")
    own = pint.UnitRegistry()
    own.define("blink = 60 s")
    return [
        pint.Quantity(3000, "rpm"), own.Quantity(np.float64(50.0), "Hz"),
        own.Quantity(np.array(0.05), "kHz"), own.Quantity(18000, "deg/s"),
        own.Quantity(3000, "turn/blink"),
    ]  # fmt: skip


def labelled_values() -> list[Any]:
    xarray, pandas = pytest.importorskip("xarray"), pytest.importorskip("pandas")
    return [
        xarray.DataArray(3000.0, attrs={"units": "rpm"}),
        xarray.DataArray(SPEED_IN_SI),
        xarray.DataArray(pint_values()[2]),
        pandas.Series([3000.0], name="rpm").iloc[0] * np.pi / 30.0,
        np.float64(SPEED_IN_SI),
        replace(vibecalc.read(GOLDEN / "generator.h5")["isolation/pitch/natural_frequency"],
                values=np.array(SPEED_IN_SI)),
    ]  # fmt: skip


SPEED_IN_SI = 100.0 * np.pi


@pytest.mark.parametrize("values", [pint_values, labelled_values])
def test_a_value_brings_its_unit_along(values: Any) -> None:
    for value in values():
        for source, keys in ((GENERATOR, {SPEED_KEY: value}), (with_speed(value), {})):
            found = _checked(source, keys, {}, ()).case.machine.speed
            assert found == pytest.approx(SPEED_IN_SI, rel=4e-16), repr(value)


def with_speed(value: Any) -> dict[str, Any]:
    case: Any = dict(vibecalc.read(GOLDEN / "generator.h5").case)
    return {**case, "machine": {**case["machine"], "speed": value}}


def test_arrays_and_axes_bring_their_unit_along() -> None:
    pint = pytest.importorskip("pint")
    stiffness = pint.Quantity([10.0, 10.0, 20.0], "N/mm")
    case: Any = vibecalc.run(
        GENERATOR,
        set={
            "machine.mounts.each.stiffness": stiffness,
            "limit[0].max": pint.Quantity(1.0, "kN"),
            "accuracy.rtol": np.float64(1e-8),
        },
    ).case
    assert case["machine"]["mounts"]["each"]["stiffness"] == [1e4, 1e4, 2e4]
    assert case["accuracy"]["rtol"] == 1e-8 and case["limit"][0]["max"] == "1.0 kN"
    speeds = pint.Quantity(np.array([2000.0, 3000.0]), "rpm")
    for way in ({"grid": {SPEED_KEY: speeds}}, {"zip": {SPEED_KEY: [*speeds]}}):
        found = vibecalc.sweep(GENERATOR, "s.h5", jobs=1, fresh=True, keep=PEAK, **way)[PEAK]
        assert found.axes[0].values == pytest.approx(np.array([2000.0, 3000.0]) * np.pi / 30.0)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (lambda: 50.0 * pint_values()[1]._REGISTRY.Quantity(1.0, "1/s"), "turns or radians?"),
        (lambda: 3.0 * pint_values()[1]._REGISTRY.Quantity(1.0, "mm"), "a length"),
        (lambda: np.array(1j), "complex numbers"),
        (lambda: np.array(3000.0).view(Foreign), 'write it as a text, as "3000 rpm"'),
        (lambda: object(), "cannot be"),
        (lambda: None, "cannot be"),
    ],
)  # fmt: skip
def test_a_value_that_cannot_be_is_refused_at_its_key(value: Any, said: str) -> None:
    for source, keys in ((GENERATOR, {SPEED_KEY: value()}), (with_speed(value()), {})):
        with pytest.raises(vibecalc.CaseError) as caught:
            vibecalc.check(source, set=keys)
        (problem,) = caught.value.problems
        assert problem.path == ("machine", "speed") and said in str(caught.value)
        assert "an angular speed > 0 rad/s" in problem.allowed


class Foreign(np.ndarray):
    """An array with a unit, as those of libraries that are not known here."""

    unit = "rpm"


def test_a_quantity_is_an_array() -> None:
    result = vibecalc.read(GOLDEN / "generator.h5")
    curve, one = (result[f"isolation/{name}"] for name in
                  ("support_force/run_up", "pitch/natural_frequency"))  # fmt: skip
    values = curve.values
    assert np.array_equal(curve, values) and np.asarray(curve) is values
    assert np.asarray(curve, dtype=np.float32).dtype == np.float32
    assert np.array(curve, copy=True) is not values and len(curve) == len(values)
    assert np.array_equal(curve[0, :3], values[0, :3]) and np.array_equal([*curve], values)
    assert np.array_equal(2 * curve - curve / 2, 1.5 * values) and np.sum(curve) == values.sum()
    assert np.array_equal(curve > 10.0, values > 10.0) and abs(curve).max() == values.max()
    assert float(one) == one.values.item() == complex(one) and one and curve
    for call in (float, complex):
        with pytest.raises(TypeError, match="is not one"):
            call(curve)
    with pytest.raises(TypeError, match="is one number and has no length"):
        len(one)
    with pytest.raises(ValueError, match="without a copy"):
        curve.__array__(np.float32, copy=False)


def test_a_quantity_shows_itself_in_a_notebook() -> None:
    result = vibecalc.read(GOLDEN / "generator.h5")
    one = result["isolation/pitch/natural_frequency"]._repr_html_()
    assert "in Hz" in one and f"{float(one_hertz(result)):.3f}" in one
    for quantity in result.values():
        shown = quantity._repr_html_()
        assert quantity.path in shown and len(shown) < 4000
        assert all(axis.name in shown for axis in quantity.axes)


def one_hertz(result: vibecalc.Result) -> Any:
    return result["isolation/pitch/natural_frequency"].to("Hz")


def test_verify_and_parts_of_a_sweep_are_as_on_the_command_line() -> None:
    verdicts = vibecalc.verify(GENERATOR)
    said = command("verify", str(GENERATOR))
    assert verdicts.kept and not verdicts.misses and str(verdicts) == said.out
    missed = vibecalc.verify(GENERATOR, set={"limit[0].max": "1 mN"})
    assert not missed.kept and missed.misses == 1 and "1 missed" in repr(missed)
    axes = {SPEED_KEY: "2000 rpm:4900 rpm:4", "machine.mounts.each.damping": [10, 20, 30, 40]}
    files = [f"part{i}.sweep.h5" for i in (1, 2)]
    for number, file in enumerate(files, 1):
        vibecalc.sweep(GENERATOR, file, zip=axes, jobs=1, timeout="1 min", keep=PEAK,
                       shard=f"{number}/2")  # fmt: skip
    whole = vibecalc.sweep(GENERATOR, "whole.sweep.h5", zip=axes, jobs=1, keep=PEAK)
    assert vibecalc.merge(files, "both.sweep.h5")[PEAK] == whole[PEAK]
    with pytest.raises(vibecalc.UsageError, match="needs I/N with I from 1 to N, as in 2/8"):
        vibecalc.sweep(GENERATOR, "s.h5", zip=axes, shard="3/2")
    with pytest.raises(vibecalc.UsageError, match="a number of seconds above 0, found 0"):
        vibecalc.sweep(GENERATOR, "s.h5", zip=axes, timeout=0)


#: commands and options without a counterpart, and why
ONLY_ON_THE_COMMAND_LINE = {
    "completion": "a shell's",
    "help": "`help(vibecalc.run)`",
    "new": "writes text for an editor",
    "schema": "text for an editor",
    "migrate": "rewrites a file",
    "info": "a result and `to_pandas()` say it",
    "get": "`result[path].to(unit)`",
    "export": "`to_xarray()`, `to_pandas()`",
    "--json": "calls give objects", "--quiet": "calls print nothing",
    "--verbose": "calls print nothing",
    "--output": "`write(result, path)`, or an argument of its own",
    "--if-needed": "`run` keeps no file", "--depfile": "a file for make",
    "--partial": "a call compares two results", "--dry-run": "tells a person how long it takes",
    "--junit": "a file for CI", "--accept": "a person accepts golden files",
    "run --full": "is about JSON", "verify --full": "is about JSON",
}  # fmt: skip
NAMES = {"--format": "formats", "--no-title": "title", "--stage": "stages", "--topic": "topics"}


def test_every_command_and_option_has_its_counterpart() -> None:
    import inspect

    import typer.main

    from vibecalc.cli.commands import app

    group: Any = typer.main.get_command(app)
    for name, one in group.commands.items():
        if name in ONLY_ON_THE_COMMAND_LINE:
            continue
        given = inspect.signature(getattr(vibecalc, name)).parameters
        for option in (long for p in one.params for long in p.opts if long.startswith("--")):
            known = ONLY_ON_THE_COMMAND_LINE.keys() & {option, f"{name} {option}"}
            wanted = NAMES.get(option, option.removeprefix("--").replace("-", "_"))
            assert known or wanted in given or option == "--help", (name, option)

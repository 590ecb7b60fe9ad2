"""Claim: docs/python.md works as printed, and shows what comes out."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from fuzzing import command
from page_run import run_page
from scipy.io import loadmat
from shipped_cases import ROOT

import vibecalc
from vibecalc.errors import EXIT_CODES

PAGE = ROOT / "docs" / "python.md"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "cases").symlink_to(ROOT / "cases")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_page_runs_and_its_files_hold_what_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("dask")
    run_page(PAGE, tmp_path)
    monkeypatch.chdir(tmp_path)
    rows = np.loadtxt("run_up.csv", delimiter=",", skiprows=1)
    curve = vibecalc.read("outputs/generator.h5")["isolation/support_force/run_up"]
    assert Path("run_up.csv").read_text().splitlines()[0] == "speed [rad/s],run_up [N]"
    assert np.array_equal(rows, np.column_stack([curve.axes[1].values, curve.values[0]]))
    assert Path("outputs/from_stdin.h5").is_file()
    exported(vibecalc.read("outputs/generator.h5"), Path("tables"))
    path = "isolation/support_displacement/static"
    sag = command("get", "outputs/generator.h5", path, "--where", "mount=1", "--unit", "mm")
    assert float(sag.out) == pytest.approx(24.525, rel=1e-12)


def test_every_exit_code_is_in_the_table() -> None:
    codes = re.findall(r"^\| (\d+) \|", PAGE.read_text(encoding="utf-8"), re.M)
    assert list(map(int, codes)) == list(EXIT_CODES)


def exported(result: vibecalc.Result, folder: Path) -> None:
    """All numbers of a result, read back from the files of `export` by other libraries."""
    matlab = loadmat(folder / "generator.mat", simplify_cells=True)
    import xarray

    with xarray.open_datatree(folder / "generator.nc", engine="h5netcdf") as tree:
        for path, quantity in result.items():
            groups, place = path.split("/"), matlab
            for group in groups:
                place = place[group]
            assert np.array_equal(np.ravel(place["value"]), np.ravel(quantity.values)), path
            assert (
                "".join(place["unit"]) == quantity.unit
                and place["error"] == quantity.error_estimate
            )
            if np.iscomplexobj(quantity.values):
                halves = tree[f"{path}_real"].values, tree[f"{path}_imaginary"].values
                assert np.array_equal(halves[0] + 1j * halves[1], quantity.values), path
            else:
                assert np.array_equal(tree[path].values, quantity.values), path
            for axis in quantity.axes:
                found = place[axis.name]
                assert list(map(str, np.ravel(found))) == list(map(str, axis.values)), path
    with (folder / "generator.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["quantity"] for row in rows} == {
        path for path in result if path.startswith("isolation/") and not result[path].axes
    }
    assert all(float(row["value"]) == result[row["quantity"]].values for row in rows)
    harmonics = "isolation/support_force/steady_harmonics"
    table = np.loadtxt(
        folder / f"generator_{harmonics.replace('/', '__')}.csv",
        delimiter=",", skiprows=1, usecols=(3, 4),
    )  # fmt: skip
    assert np.array_equal(table @ [1, 1j], result[harmonics].values.ravel())


def test_a_case_of_tables_and_its_result_come_back(folder: Path) -> None:
    result = vibecalc.run("cases/generator.toml")
    again = vibecalc.run(dict(result.case))
    assert list(again) == list(result)
    assert all(np.array_equal(result[path].values, again[path].values) for path in result)
    kept = vibecalc.read(vibecalc.write(result, "outputs/kept.h5"))
    assert vibecalc.diff(result, kept).same and vibecalc.report(kept) == vibecalc.report(result)
    assert Path("outputs/kept.txt").is_file()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["isolation/pitch"], "isolation/pitch is a group in this result; it has isolation/pitch/"),
        (["isolation/pitch/dampin"], "it has isolation/pitch/damping, "),
        (["isolation/support_force/static", "--where", "mount"], "--where needs AXIS=ENTRY"),
        (["isolation/support_force/static", "--where", "mount=7"], "no entry mount = 7; there is"),
        (["isolation/support_force/static", "--where", "order=1"], "has no axis 'order'"),
        (["isolation/support_force/static", "--unit", "mm"], "wrong dimension: found a force"),
    ],
)
def test_what_cannot_be_got_is_said(
    words: list[str], said: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "generator_to_get_from.h5"
    if not path.exists():
        vibecalc.write(vibecalc.run(ROOT / "cases" / "generator.toml"), path)
    outcome = command("get", str(path), *words)
    assert outcome.code == 2 and said in outcome.err, outcome.err

"""Claim: the file of a sweep holds what its points gave, in little memory, however it was cut."""

import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from sweep_blocks import (
    FORCE,
    KEPT,
    MASKED,
    SAG,
    SPREAD,
    Made,
    expected,
    grid_of,
    made,
    outcome,
)
from sweep_runs import objects
from sweep_samples import MODEL, SPEED, STIFFNESS, axis, design_of, scattered, spread

from vibecalc.core.results.layout import DONE, ERRORS, NOT_RUN
from vibecalc.core.results.store import read_result
from vibecalc.core.results.sweep_file import (
    is_sweep,
    open_sweep,
)
from vibecalc.core.study.sweep.assemble import assemble


def written(folder: Path, sweep: Made, name: str = "sweep.h5") -> Path:
    sweep.fill()
    return assemble(folder / name, sweep.head, sweep.journal).path


@pytest.mark.parametrize(("sizes", "size"), [((24,), 5), ((4, 6), 1), ((4, 3, 2), 24)])
def test_every_point_is_where_it_belongs(tmp_path: Path, sizes: tuple[int, ...], size: int) -> None:
    sweep = made(tmp_path, grid_of(*sizes), size)
    path = written(tmp_path, sweep)
    with open_sweep(path) as found:
        assert found.shape == sizes and list(found.quantities) == list(KEPT)
        assert found.read(FORCE).shape == (*sizes, 3, 6)
        for name in found.quantities:
            whole = found.read(name).reshape(24, *found.read(name).shape[len(sizes) :])
            for point in range(24):
                wanted = expected(name, point, whole.shape[1:])
                assert np.array_equal(whole[point], wanted, equal_nan=True)
            assert np.array_equal(found.read(name, 3, 19), whole[3:19], equal_nan=True)
        status = found.status().ravel()
        assert status.tolist() == [outcome(point)[0] for point in range(24)]
        assert np.array_equal(found.status(2, 9), status[2:9])


def test_errors_are_those_of_each_point_and_the_largest(tmp_path: Path) -> None:
    with open_sweep(written(tmp_path, made(tmp_path))) as found:
        sag, spread_one = found.quantities[SAG], found.quantities[SPREAD]
        errors = found.read(f"{ERRORS}/{SAG}").ravel()
        done = [point for point in range(24) if outcome(point)[0] == DONE]
        assert errors[done].tolist() == [1e-12 * point for point in done]
        assert np.isnan(np.delete(errors, done)).all()
        assert sag.error_estimate == 1e-12 * 23 and sag.standard_error is None
        assert found.stored(SAG) == (SAG, f"{ERRORS}/{SAG}")
        assert spread_one.standard_error == 1e-3 * 23
        spread_all = found.read(found.stored(SPREAD)[2])
        assert spread_all.ravel()[done].tolist() == [1e-3 * point for point in done]
        assert found.quantities[FORCE].amplitude == "0-pk"


def test_causes_are_reported_once_with_the_points_they_hit(tmp_path: Path) -> None:
    with open_sweep(written(tmp_path, made(tmp_path))) as found:
        reasons = found.reasons()
        assert list(reasons) == [3, 10, 17]
        assert reasons[3] == reasons[17] == "order 1 meets mode 1"
        assert reasons[10].startswith("Traceback\n  a line with é and  and ")
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert file["sweep/message/text"].shape == (2,)


def test_it_is_read_as_a_result_and_by_xarray(tmp_path: Path) -> None:
    import xarray

    path = written(tmp_path, made(tmp_path))
    result = read_result(path)
    assert list(result.record) == list(KEPT)
    force = result.record[FORCE]
    assert [one.name for one in force.axes][:3] == ["stiffness", "damping", "machine.speed"]
    with open_sweep(path) as found:
        assert np.array_equal(force.values, found.read(FORCE), equal_nan=True)
        assert found.case == result.case and found.head.result.version == result.version
    with xarray.open_dataset(path, engine="h5netcdf", group="isolation") as stage:
        assert stage["sag"].dims == ("stiffness", "damping", "machine.speed")
        assert float(stage["sag"].isel({"stiffness": 0, "damping": 0, "machine.speed": 1})) == 0.1
    assert is_sweep(path) and not is_sweep(tmp_path / "none")


def test_a_sampling_has_one_axis_and_values_of_every_key(tmp_path: Path) -> None:
    design = design_of(
        scattered(STIFFNESS, "uniform", min="5 N/mm", max="50 N/mm"),
        spread(SPEED, "1000 rpm", "4000 rpm"),
        axis(MODEL, "pitch", "rigid_body"),
        sampling="sobol",
        points=20,
        indices=True,
    )
    sweep = made(tmp_path, design, 7)
    with open_sweep(written(tmp_path, sweep)) as found:
        assert found.shape == (100,) and found.head.sampling == "sobol"
        assert found.head.design == design.description()
        (only,) = found.head.axes
        assert only.name == "sample" and [key.key for key in only.keys] == list(design.keys)
        values = design.value_of(np.arange(100))
        assert np.array_equal(np.stack(only.columns, axis=1), values)
        assert set(only.values()[2].tolist()) == {"pitch", "rigid_body"}
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert np.array_equal(file["sample"][()], np.arange(100))


def test_what_cannot_be_stacked_is_left_out_with_its_reason(tmp_path: Path) -> None:
    """Whether the axes differ inside a chunk or only from one chunk to the next."""
    for size in (1, 5):
        sweep = made(tmp_path, size=size, kept=(MASKED, SAG))
        path = written(tmp_path, sweep)
        with open_sweep(path) as found:
            assert list(found.quantities) == [SAG]
            assert "axis speed is not the same" in found.left_out[MASKED]


def test_partial_files_say_what_is_missing(tmp_path: Path) -> None:
    sweep = made(tmp_path)
    sweep.fill(1, 4)
    done = assemble(tmp_path / "part.h5", sweep.head, sweep.journal)
    assert done.missing == ((0, 4), (10, 19)) and done.counts == {DONE: 9, NOT_RUN: 15}
    with open_sweep(done.path) as found:
        status = found.status().ravel()
        assert np.flatnonzero(status != NOT_RUN).tolist() == [5, 6, 7, 8, 9, 20, 21, 22, 23]
        assert np.isnan(found.read(SAG).ravel()[status == NOT_RUN]).all()


def test_equal_input_gives_equal_bytes(tmp_path: Path) -> None:
    one = written(tmp_path, made(tmp_path), "a.h5").read_bytes()
    two = written(tmp_path, made(tmp_path), "b.h5").read_bytes()
    assert one == two
    finer = written(tmp_path, made(tmp_path, size=2), "c.h5")
    assert objects(finer) == objects(tmp_path / "a.h5")


_PROGRAM = """
import resource, sys
from pathlib import Path
import numpy as np
from sweep_blocks import grid_of, made
from vibecalc.core.results.record import Quantity
from vibecalc.core.study.sweep.assemble import assemble
from vibecalc.core.results.sweep_file import columns_of
from vibecalc.core.study.sweep.blocks import Block

folder, rows = Path(sys.argv[1]), int(sys.argv[2])
kept = ("isolation/a", "isolation/b", "isolation/c")
sweep = made(folder, grid_of(rows, 1000), 5000, kept)
sweep.journal.start()
for number in range(sweep.journal.chunks):
    points = sweep.journal.points(number)
    values = np.sqrt(points)
    status = np.zeros(points.size, dtype=np.int8)
    columns = {name: column for path in kept for name, column in
               zip(columns_of(path), (values, np.full(points.size, 1e-9)))}
    described = {path: Quantity(path=path, values=values, unit="N", long_name="a number")
                 for path in kept}
    block = Block(points, status, ("",) * points.size, columns, described)
    sweep.journal.write(number, block)
assert assemble(folder / "big.h5", sweep.head, sweep.journal).counts == {0: rows * 1000}
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def peak_memory(folder: Path, rows: int) -> int:
    """Largest memory, in kB, of a process that assembles a thousand points for each row."""
    environment = {"PYTHONPATH": ":".join(sys.path), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-c", _PROGRAM, str(folder), str(rows)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return int(done.stdout)


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="memory is counted in other units")
def test_memory_does_not_grow_with_the_points(tmp_path: Path) -> None:
    few, many = (peak_memory(tmp_path, rows) for rows in (50, 200))
    size = (tmp_path / "big.h5").stat().st_size / 1024
    assert size > 9_000 and many - few < size / 2

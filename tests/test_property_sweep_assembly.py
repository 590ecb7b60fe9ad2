"""Claim: the file of a sweep holds what its points gave, in little memory, however it was cut."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sweep_blocks import (
    FORCE,
    KEPT,
    MASKED,
    SAG,
    SPREAD,
    Made,
    block_at,
    expected,
    grid_of,
    made,
    outcome,
)
from sweep_runs import objects
from sweep_samples import MODEL, SPEED, STIFFNESS, axis, design_of, scattered, spread

from vibecalc.core.results.layout import DONE, ERRORS, NOT_RUN
from vibecalc.core.results.store import read_result
from vibecalc.core.results.sweep_file import is_sweep, open_sweep
from vibecalc.core.study.sweep.assemble import assemble
from vibecalc.core.study.sweep.journal import Journal, packed
from vibecalc.core.study.sweep.output import lock_path, locked
from vibecalc.errors import UsageError


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


# ----------------------------------------------------------------------------
# A chunk is taken for done if and only if it is whole and of this very sweep.
# ----------------------------------------------------------------------------


@pytest.fixture
def sweep(tmp_path: Path) -> Made:
    whole = made(tmp_path)
    whole.fill()
    return whole


def anew(sweep: Made) -> Journal:
    """The journal as the next command finds it."""
    journal = replace(sweep.journal, places={}, end=0)
    journal.look()
    return journal


@given(where=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
@settings(max_examples=20, deadline=None)
def test_no_flipped_bit_goes_unseen(
    where: float, bit: int, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """The chunks before it stay, and what it leaves is what was written."""
    whole = made(tmp_path_factory.mktemp("flipped"))
    whole.fill()
    content = bytearray(whole.journal.path.read_bytes())
    content[int(where * len(content))] ^= 1 << bit
    whole.journal.path.write_bytes(content)
    journal = anew(whole)
    assert len(journal.places) < whole.journal.chunks
    assert list(journal.places) == list(range(len(journal.places)))
    for number in journal.places:
        assert packed(journal.read(number)) == packed(block_at(journal.points(number)))


def test_no_truncated_chunk_is_finished_and_it_is_written_again(sweep: Made) -> None:
    content = sweep.journal.path.read_bytes()
    second, third = sweep.journal.places[2], sweep.journal.places[3]
    for size in (second + 1, second + 30, second + 60, third - 1):
        sweep.journal.path.write_bytes(content[:size])
        journal = anew(sweep)
        assert sorted(journal.places) == [0, 1]
        assert "damaged or not whole" in journal.look()
    journal.start()
    for number in (2, 3, 4):
        journal.write(number, block_at(journal.points(number)))
    assert journal.path.read_bytes() == content


def test_chunks_of_another_sweep_are_foreign(sweep: Made) -> None:
    """Another identity, another cut, and a chunk under the number of its neighbour."""
    for other in (replace(sweep.journal, identity="0" * 64), replace(sweep.journal, size=4)):
        assert other.foreign()
        assert other.look() == "" and not other.places
    assert not sweep.journal.foreign()
    content = sweep.journal.path.read_bytes()
    first, second, third = (sweep.journal.places[n] for n in range(3))
    renumbered = content[:first] + content[second:third].replace(b"\1", b"\0", 1)
    sweep.journal.path.write_bytes(renumbered)
    assert "damaged or not whole" in anew(sweep).look()


def test_the_lock_keeps_others_out_and_goes(tmp_path: Path) -> None:
    output = tmp_path / "o.h5"
    with locked(output):
        with (
            pytest.raises(UsageError, match=rf"process {os.getpid()} on .* writing"),
            locked(output),
        ):
            pass
        assert lock_path(output).exists()
    assert list(tmp_path.iterdir()) == []


def test_the_lock_of_a_dead_process_falls_with_it(tmp_path: Path) -> None:
    output = tmp_path / "o.h5"
    program = (
        "import os, signal, sys; from pathlib import Path\n"
        "from vibecalc.core.study.sweep.output import locked\n"
        "with locked(Path(sys.argv[1])):\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.Popen([sys.executable, "-c", program, str(output)])
    assert done.wait() == -9 and lock_path(output).exists()
    with locked(output):
        pass
    assert list(tmp_path.iterdir()) == []

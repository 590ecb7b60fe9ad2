"""Claim: what is wrong with a sweep or its files is said in words, and nothing half passes."""

import json
import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
import pytest
from long_but import long_but
from refused import problems_of as of_form
from refused import refusals, said_of
from sample_results import result_of
from shipped_cases import CASES
from sweep_blocks import FORCE, SAG, Made, grid_of, made
from sweep_samples import STIFFNESS, design_of, generator

from vibecalc.core.results.layout import ERRORS, FAILED, STATUS, VERSION_ATTRIBUTE
from vibecalc.core.results.store import write_result
from vibecalc.core.results.sweep_file import open_sweep
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.assemble import assemble, merge
from vibecalc.core.study.sweep.checks import check_design, keep_problems
from vibecalc.core.study.sweep.output import lock_path, locked
from vibecalc.core.study.sweep.prepare import axis_table, sampling_table
from vibecalc.errors import EXIT_USAGE, CaseError, Problem, ResultError, UsageError

GENERATOR = CASES["generator"]


@pytest.fixture
def sweep(tmp_path: Path) -> Made:
    whole = made(tmp_path)
    whole.fill()
    return whole


@contextmanager
def full_disk(size: int) -> Iterator[None]:
    """No file may grow beyond `size` bytes, as if the disk was full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def refused(error: pytest.ExceptionInfo[BaseException]) -> str:
    assert isinstance(error.value, UsageError) and error.value.exit_code == EXIT_USAGE
    assert "\n" not in str(error.value) and "errno" not in str(error.value)
    return str(error.value)


@pytest.mark.parametrize("share", long_but([0.0, 0.01, 0.2, 0.5, 0.9, 0.999], 0.9))
def test_a_full_disk_leaves_the_old_file(sweep: Made, tmp_path: Path, share: float) -> None:
    """HDF5 flushes at many moments, and none of them may end the process."""
    output = assemble(tmp_path / "sweep.h5", sweep.head, sweep.journal).path
    old = output.read_bytes()
    with full_disk(int(share * len(old))), pytest.raises(UsageError) as error:
        assemble(output, sweep.head, sweep.journal, range(5))
    assert "cannot write" in refused(error) and "file too large" in str(error.value)
    assert output.read_bytes() == old
    assert sorted(path.name for path in tmp_path.iterdir()) == ["sweep.h5", "sweep.h5.chunks"]


def test_a_chunk_that_breaks_while_the_file_is_written(sweep: Made, tmp_path: Path) -> None:
    journal = sweep.journal
    content = bytearray(journal.path.read_bytes())
    content[journal.places[4] - 9] ^= 1
    journal.path.write_bytes(content)
    with pytest.raises(ResultError, match="checksum does not fit"):
        assemble(tmp_path / "sweep.h5", sweep.head, journal, range(5))
    assert [one.name for one in tmp_path.iterdir()] == ["sweep.h5.chunks"]
    journal.look()
    assert assemble(tmp_path / "sweep.h5", sweep.head, journal).missing == ((15, 23),)


def test_changed_texts_and_numbers_are_found(sweep: Made, tmp_path: Path) -> None:
    output = assemble(tmp_path / "sweep.h5", sweep.head, sweep.journal).path
    content = output.read_bytes()
    place = content.index(b"order 1 meets mode 1")
    output.write_bytes(content[:place] + b"X" + content[place + 1 :])
    with pytest.raises(ResultError, match="changed since it was written"):
        open_sweep(output)
    number = np.array(0.1 * 23).tobytes()
    assert content.count(number) == 1
    output.write_bytes(content.replace(number, bytes(8)))
    with open_sweep(output) as found:
        for some in ((), (20, 24)):
            with pytest.raises(ResultError, match="damaged") as error:
                found.read(SAG, *some)
            refused(error)


def test_files_of_other_kinds_are_refused(sweep: Made, tmp_path: Path) -> None:
    single = write_result(result_of(), tmp_path / "single.h5")
    with pytest.raises(ResultError, match="the result of a single run, not of a sweep"):
        open_sweep(single)
    with h5py.File(tmp_path / "other.h5", "w"):
        pass
    with pytest.raises(ResultError, match="an HDF5 file, not of a sweep"):
        open_sweep(tmp_path / "other.h5")
    with pytest.raises(ResultError, match="there is no result file"):
        open_sweep(tmp_path / "none.h5")
    later = assemble(tmp_path / "later.h5", sweep.head, sweep.journal).path
    with h5py.File(later, "r+") as file:
        file.attrs[VERSION_ATTRIBUTE] = 2
    with pytest.raises(ResultError, match="layout 2 of a sweep"):
        open_sweep(later)
    lacking = assemble(tmp_path / "lacking.h5", sweep.head, sweep.journal).path
    with h5py.File(lacking, "r+") as file:
        del file[STATUS]
    with pytest.raises(ResultError, match="damaged"):
        open_sweep(lacking)


def test_parts_of_other_sweeps_are_refused(sweep: Made, tmp_path: Path) -> None:
    first = assemble(tmp_path / "first.h5", sweep.head, sweep.journal).path
    for words, other in (
        ("the second is over other points", made(tmp_path / "a", grid_of(4, 3, 3))),
        ("the second is of other quantities", made(tmp_path / "b", kept=(SAG,))),
    ):
        other.fill()
        part = assemble(tmp_path / "part.h5", other.head, other.journal).path
        with pytest.raises(UsageError, match=words) as error:
            merge([first, part], tmp_path / "merged.h5")
        assert "part.h5" in refused(error) and not (tmp_path / "merged.h5").exists()
    with pytest.raises(UsageError, match="no parts"):
        merge([], tmp_path / "merged.h5")


def test_parts_that_do_not_agree_are_refused(sweep: Made, tmp_path: Path) -> None:
    """In a value of one entry, in an error, in a status, and in a message."""
    first = assemble(tmp_path / "first.h5", sweep.head, sweep.journal).path
    original = sweep.journal.read(1)
    whole, error_of_sag = dict(original.columns), f"{ERRORS}/{SAG}"
    values, errors = whole[FORCE].copy(), whole[error_of_sag].copy()
    status = original.status.copy()
    values[2, 1, 1] += 1e-12
    errors[1] *= 2.0
    status[4] = FAILED
    changed, uncertain = whole | {FORCE: values}, whole | {error_of_sag: errors}
    message = ("", "", "", "", "no")
    for point, words, block in (
        (7, FORCE, original._replace(columns=changed)),
        (6, SAG, original._replace(columns=uncertain)),
        (9, "numerical failure no", original._replace(status=status, message=message)),
    ):
        sweep.journal.write(1, block)
        other = assemble(tmp_path / "other.h5", sweep.head, sweep.journal, [1]).path
        with pytest.raises(UsageError, match=f"have point {point} .*{words}") as error:
            merge([first, other], tmp_path / "merged.h5")
        assert "other.h5" in refused(error) and not (tmp_path / "merged.h5").exists()


def test_a_lock_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    lock_path(tmp_path / "o").mkdir()
    with (
        pytest.raises(UsageError, match="cannot make the lock file") as error,
        locked(tmp_path / "o"),
    ):
        pass
    refused(error)


def test_a_full_tmpfs(tmp_path: Path) -> None:
    """No memory map of a file that can run out of room: the system would end the process."""
    folder = tmp_path / "small"
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=60k", "tmpfs", folder],
        check=False,
        capture_output=True,
    )
    arguments = [
        "sweep", GENERATOR, "-q", "-j", "1", "-o", folder / "s.h5",
        "--grid", "machine.mounts.each.stiffness=5 N/mm:50 N/mm:40log",
        "--grid", "machine.speed=2000 rpm:5000 rpm:40",
        "--keep", "isolation/support_force/run_up_peak",
    ]  # fmt: skip

    def limit() -> None:  # where nobody may mount, files of this size are the next best
        if mounted.returncode:
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    try:
        ended = subprocess.run(
            [sys.executable, "-m", "vibecalc", *arguments],
            capture_output=True, text=True, check=False, preexec_fn=limit,
        )  # fmt: skip
        left = [path.suffix for path in folder.rglob("*") if path.is_file()]
    finally:
        if not mounted.returncode:
            subprocess.run(["umount", folder], check=True)
    assert ended.returncode == EXIT_USAGE
    assert "cannot write" in ended.stderr and "Traceback" not in ended.stderr
    assert ("no space left" in ended.stderr) == (not mounted.returncode)
    assert set(left) <= {".chunks"}  # finished chunks, for --resume


# ----------------------------------------------------------------------------
# A sweep that cannot be meant is refused before its first run, in words that help.
# ----------------------------------------------------------------------------


def problems_of(sweep: str) -> list[Problem]:
    """Problems of a sweep over the generator, those of its values included."""
    try:
        keys = json.loads(sweep)
        design = design_of(*keys.pop("axes"), **keys)
    except CaseError as error:
        return list(error.problems)
    return check_design(design, generator().resolved)


@pytest.mark.parametrize(("case", "sweep", "place", "words"), refusals("sweep", "grid"))
def test_sweeps_that_cannot_be_meant(case: str, sweep: str, place: str, words: list[str]) -> None:
    (problem,) = problems_of(sweep)
    keys = place.split(".") if place != "-" else []
    path = ("sweep", *(int(key) if key.isdigit() else key for key in keys))
    assert problem.path[: len(path)] == path
    assert words[0] in said_of(problem)


@pytest.mark.parametrize(("case", "changes", "key", "words"), refusals("sweep", "sampling"))
def test_samplings_that_are_none(case: str, changes: str, key: str, words: list[str]) -> None:
    sweep = {"axes": [{"key": STIFFNESS, "values": [1, 2]}], **json.loads(changes)}
    (problem,) = of_form({**generator().resolved, "sweep": sweep})
    assert problem.path[:2] == ("sweep", key)
    assert words[0] in problem.message


@pytest.mark.parametrize(("case", "sweep", "place", "words"), refusals("sweep", "kept"))
def test_results_that_cannot_be_kept(case: str, sweep: str, place: str, words: list[str]) -> None:
    loaded, keys = generator(), json.loads(sweep)
    design = design_of(*keys["axes"])
    (problem,) = keep_problems(keys["keep"], loaded.case, design, loaded.resolved)
    assert problem.path[:2] == ("sweep", "keep") and words[0] in said_of(problem)


@pytest.mark.parametrize(("case", "text", "place", "words"), refusals("sweep", "text"))
def test_texts_that_are_no_axis_and_no_sampling(
    case: str, text: str, place: str, words: list[str]
) -> None:
    with pytest.raises(UsageError) as caught:
        (axis_table if text.startswith("machine") else sampling_table)(text)
    assert words[0] in str(caught.value)


def test_check_looks_at_the_sweep_too(tmp_path) -> None:  # type: ignore[no-untyped-def]
    case = CASES["generator_mount_design"].read_text(encoding="utf-8")
    swept = """
[sweep]
axes = [{ key = "machine.mounts.each.stiffness", from = "5 N/mm", to = "50 N/mm", points = 3 }]
"""
    (tmp_path / "both.toml").write_text(case + swept, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_checked([tmp_path / "both.toml"])
    (problem,) = caught.value.problems
    assert problem.message == "a key that the sweep sets cannot be searched for as well"
    assert "both.toml:" in str(caught.value)

"""Claim: a damaged, foreign or unwritable result file ends in one sentence, and harms no other."""

import os
import random
import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from sample_results import DIRECTION, MOUNT, ORDER, quantity, result_of, typical

from vibecalc.core.results import files
from vibecalc.core.results.case_hash import case_hash
from vibecalc.core.results.files import fresh_output, write_atomically
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.core.results.store import file_image, read_result, write_result
from vibecalc.errors import ResultError, UsageError


def small() -> Result:
    return result_of(
        quantity("a/force", (MOUNT, DIRECTION, ORDER), is_complex=True, amplitude="0-pk"),
        quantity("a/deep/angle", (ORDER,)),
        quantity("b/one"),
    )


@pytest.fixture
def written(tmp_path: Path) -> Path:
    return write_result(small(), tmp_path / "r.h5")


def leftovers(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"title = 'a case'\n", "is not an HDF5 file (it begins with b'title = ')"),
        (bytes(5000), "is not an HDF5 file"),
        (b"\x89HDF\r\n\x1a\n", "is damaged"),
        (b"\x89HDF\r\n\x1a\n" + bytes(5000), "is damaged"),
    ],
)
def test_files_that_are_no_hdf5(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "r.h5"
    path.write_bytes(content)
    with pytest.raises(ResultError) as caught:
        read_result(path)
    assert words in str(caught.value)
    assert str(path) in str(caught.value)


def test_things_that_are_no_files(tmp_path: Path) -> None:
    for path, words in (
        (tmp_path / "absent.h5", "there is no result file"),
        (tmp_path, "is a folder"),
        (Path("/dev/zero"), "is not a regular file"),
        (tmp_path / "absent.h5" / "below", "there is no result file"),
    ):
        with pytest.raises(ResultError, match=words):
            read_result(path)


def test_hdf5_of_another_program(tmp_path: Path) -> None:
    path = tmp_path / "foreign.h5"
    with h5py.File(path, "w") as file:
        file["values"] = np.arange(10)
    with pytest.raises(ResultError, match="an HDF5 file, but not a result of vibecalc"):
        read_result(path)


def edit(path: Path, change: Any) -> None:
    with h5py.File(path, "r+") as file:
        change(file)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda f: f.attrs.modify("schema_version", 2),
            "has layout 2, this vibecalc reads up to 1",
        ),
        (lambda f: f.attrs.modify("schema_version", 0), "schema_version is 0"),
        (lambda f: f.attrs.create("schema_version", "one"), "is not a whole number"),
        (lambda f: f.attrs.__delitem__("case_toml"), "the attribute case_toml is missing"),
        (lambda f: f.attrs.create("name", 3), "name of / is not a text"),
        (lambda f: f.attrs.create("plan", "{}"), "plan is not a list"),
        (lambda f: f.attrs.create("plan", "["), "is damaged: JSONDecodeError"),
        (lambda f: f.attrs.create("case_toml_resolved", "a = = 1"), "TOMLDecodeError"),
        (
            lambda f: f.attrs.create("case_toml_resolved", 'title = "another"\n'),
            "was changed since it was written: the case in it is not the one that was run",
        ),
        (lambda f: f.attrs.create("case_toml", "# another\n"), "the case in it is not the one"),
        (
            lambda f: f.attrs.create("quantities", '["b/one", "b/one"]'),
            "two results under one path",
        ),
        (lambda f: f.__delitem__("b/one"), "lists b/one but does not have it"),
        (
            lambda f: f["b/one"].attrs.__delitem__("units"),
            "the attribute units of b/one is missing",
        ),
        (lambda f: f["b/one"].attrs.create("units", 3.0), "units of /b/one is not a text"),
        (lambda f: f["b/one"].attrs.create("amplitude", "loud"), "b/one has amplitude 'loud'"),
        (lambda f: f["b/one"].attrs.create("error_estimate", -1.0), "b/one has error -1.0"),
        (lambda f: f["b/one"].attrs.create("error_estimate", np.nan), "b/one has error nan"),
        (lambda f: f["b/one"].attrs.create("error_estimate", "small"), "is not a number"),
        (lambda f: f["a/deep/angle"].dims[0].detach_scale(f["a/order"]), "has 0 scales on axis 0"),
        (lambda f: replace_values(f, "a/order", np.arange(3)), "has 0 scales on axis"),
        (lambda f: replace_values(f, "b/one", np.zeros((), "S3,f8")), "values of type"),
    ],
)
def test_results_that_lack_something(written: Path, change: Any, words: str) -> None:
    edit(written, change)
    with pytest.raises(ResultError) as caught:
        read_result(written)
    assert words in str(caught.value)


def replace_values(file: h5py.File, path: str, values: np.ndarray) -> None:
    kept = dict(file[path].attrs)
    if "REFERENCE_LIST" in kept:
        for name in ("a/force", "a/deep/angle"):
            for dimension in file[name].dims:
                if path.endswith(dimension.label):
                    dimension.detach_scale(file[path])
    del file[path]
    file[path] = values
    for name in ("units", "long_name", "error_estimate"):
        if name in kept:
            file[path].attrs[name] = kept[name]


def test_an_edited_file_is_still_a_result(written: Path) -> None:
    """Texts changed by another program do not match our checksum; the file is read all the same."""
    edit(written, lambda file: file["b/one"].attrs.create("units", "kN"))
    edit(written, lambda file: file["b/one"].write_direct(np.array(7.5)))
    found = read_result(written).record["b/one"]
    assert (found.unit, float(found.values)) == ("kN", 7.5)


def test_every_truncation_is_noticed(written: Path) -> None:
    content = written.read_bytes()
    for part in range(50):
        written.write_bytes(content[: len(content) * part // 50])
        with pytest.raises(ResultError):
            read_result(written)


def test_flipped_bytes_never_escape(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Structure is guarded by checksums: all that can pass are unused bytes."""
    # Files with changed texts are those of an editor, whose other letters nobody can notice.
    monkeypatch.setattr("vibecalc.core.results.store_read.check_heaps", refuse)
    content = file_image(small())
    generator = random.Random(20081)
    path = tmp_path / "flipped.h5"
    noticed = 0
    for _ in range(100):
        damaged = bytearray(content)
        for _ in range(generator.randint(1, 4)):
            damaged[generator.randrange(len(damaged))] ^= 1 << generator.randrange(8)
        path.write_bytes(damaged)
        try:
            found = read_result(path)
        except ResultError:
            noticed += 1
        else:
            assert file_image(found) == content
    assert noticed > 66


def refuse(path: Path) -> None:
    raise ResultError(f"{path} is damaged")


def test_a_heap_that_loops_for_ever_or_crashes(written: Path) -> None:
    """Text heaps with sizes of zero or garbage, on which HDF5 loops or crashes."""
    content = written.read_bytes()
    heap = content.index(b"GCOL")
    for damage in (bytes(16), b"\xff" * 16, b"\x05\x00\x01\x00" + bytes(12)):
        written.write_bytes(content[: heap + 16] + damage + content[heap + 32 :])
        with pytest.raises(ResultError, match="damaged"):
            read_result(written)


def test_modules_in_the_current_folder_are_not_run(written: Path) -> None:
    """Next to a file that was edited with another tool, as with `report`, `diff` and `plot`."""
    with h5py.File(written, "r+") as file:
        file.attrs["name"] = "edited"
    for name in ("h5py", "random", "typing", "numpy"):
        planted = written.parent / f"{name}.py"
        planted.write_text("open('run', 'w').close()\nraise SystemExit(9)\n")
    command = [sys.executable, "-m", "vibecalc", "report", written.name]
    done = subprocess.run(command, cwd=written.parent, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "edited" in done.stdout, done.stderr
    assert not (written.parent / "run").exists()


def test_what_a_killed_process_left_is_cleared_by_the_next(written: Path) -> None:
    """Killed when result and report are both on the disk, before the first has its place."""
    old = leftovers(written.parent)
    code = (
        "import os, signal, sys; from vibecalc.core.results import files\n"
        "files.os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        "files.write_together([(sys.argv[1], b'new'), (sys.argv[2], b'text')])"
    )
    names = [str(written), str(written.with_suffix(".txt"))]
    subprocess.run([sys.executable, "-c", code, *names], check=False)
    assert len(leftovers(written.parent)) == len(old) + 2
    ours = written.parent / files.temporary_name()
    elsewhere = written.parent / ".vibecalc-0-1-a.tmp"
    for path in (ours, elsewhere):
        path.touch()
    write_atomically(written.parent / "other", b"")
    kept = [ours.name, elsewhere.name, "other"]
    assert leftovers(written.parent) == sorted([*old, *kept])


def test_several_files_are_all_written_or_none(tmp_path: Path) -> None:
    (tmp_path / "r.txt").mkdir()
    with pytest.raises(UsageError, match="is a folder"):
        files.write_together([(tmp_path / "r.h5", b"new"), (tmp_path / "r.txt", b"text")])
    assert leftovers(tmp_path) == ["r.txt"]


def test_a_file_size_limit_leaves_the_old_result(written: Path) -> None:
    old = written.read_bytes()
    program = (
        "import sys; from pathlib import Path; from vibecalc.errors import UsageError\n"
        "from sample_results import typical; from vibecalc.core.results.store import write_result\n"
        "try: write_result(typical(), sys.argv[1])\n"
        "except UsageError as error: print(error); sys.exit(error.exit_code)\n"
    )
    path = os.pathsep.join(entry or "." for entry in sys.path)
    done = subprocess.run(
        [sys.executable, "-c", program, str(written)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": path},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000)),
    )
    assert done.returncode == 2, done.stderr
    assert "file too large, the old one is untouched" in done.stdout
    assert written.read_bytes() == old
    assert leftovers(written.parent) == ["r.h5"]


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_ctrl_c_leaves_the_old_result(
    written: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    old = written.read_bytes()

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(files.os, step, interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_result(typical(), written)
    assert written.read_bytes() == old
    assert leftovers(written.parent) == ["r.h5"]


def test_outputs_that_cannot_be_written(tmp_path: Path) -> None:
    a_file = tmp_path / "file"
    a_file.write_text("not a folder")
    for target, words in (
        (a_file / "r.h5", "cannot make the output folder"),
        (a_file / "deep" / "r.h5", "cannot make the output folder"),
        (tmp_path, "is a folder: name a file in it"),
        (Path("/dev/null"), "is not a regular file"),
        (Path("/proc/self/vibecalc/r.h5"), "cannot make the output folder"),
        (Path("/proc/self/r.h5"), "cannot"),
        (tmp_path / ("x" * 300), "file name too long"),
        (Path("a\0b"), "cannot be the name of an output file"),
    ):
        with pytest.raises(UsageError) as caught:
            write_result(small(), target)
        assert words in str(caught.value)
    assert leftovers(tmp_path) == ["file"]
    assert Path("/dev/null").is_char_device()


def test_output_folders_are_made_and_links_kept(tmp_path: Path) -> None:
    path = write_result(small(), tmp_path / "new" / "folder" / "r.h5")
    assert read_result(path).name == "sample"
    link = tmp_path / "link.h5"
    link.symlink_to(path)
    write_result(typical(), link)
    assert link.is_symlink()
    assert len(read_result(path).record) == 60
    assert fresh_output(tmp_path / "other" / "x.txt").parent.is_dir()


def test_a_written_file_is_readable_by_others(tmp_path: Path) -> None:
    mask = os.umask(0o022)
    try:
        path = write_atomically(tmp_path / "r.txt", b"words")
    finally:
        os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o644
    assert path.read_bytes() == b"words"


@pytest.mark.parametrize("text", ["a\0b", "half a surrogate \ud800"])
def test_texts_that_hdf5_cannot_hold(tmp_path: Path, text: str) -> None:
    with pytest.raises(UsageError, match="a text of this result cannot be stored in HDF5"):
        write_result(result_of(quantity("a/b"), name=text), tmp_path / "r.h5")
    assert leftovers(tmp_path) == []


HIDDEN = "\x1b[31m\x07\x9b\u202e\u2066\u200f\ufeff"


def test_what_a_foreign_file_says_is_spelled_out(tmp_path: Path) -> None:
    """In names, units, labels, warnings and the case: whoever prints them prints what is seen."""
    axis = Axis(name="mount", values=np.array([HIDDEN + "1"]), unit="", long_name=HIDDEN)
    case = {"title": f"{HIDDEN[6:]}x"}
    made = replace(
        small(), name=HIDDEN, case_toml_resolved=f'title = "{case["title"]}"\n',
        case_sha256=case_hash(case, "0.1.0"),
    )  # fmt: skip
    made.record.warnings.append(HIDDEN)
    made.record.add(
        Quantity(
            path="a/b", values=np.array([1.0]), unit=HIDDEN, long_name=HIDDEN, axes=(axis,),
            error_estimate=0.0,
        )
    )  # fmt: skip
    found = read_result(write_result(made, tmp_path / "foreign.h5"))
    spelled = "\\x1b[31m\\x07\\x9b\\u202e\\u2066\\u200f\\ufeff"
    title = spelled[spelled.index("\\x9b") :] + "x"
    said = found["a/b"]
    assert (found.name, found.case["title"]) == (spelled, title)
    assert (said.unit, said.long_name, found.record.warnings[-1]) == (spelled,) * 3
    assert (said.axes[0].values[0], said.axes[0].long_name) == (f"{spelled}1", spelled)

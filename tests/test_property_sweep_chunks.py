"""Claim: a chunk is taken for done if and only if it is whole and of this very sweep."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sweep_blocks import Made, block_at, made

from vibecalc.core.study.sweep.blocks import chunk_block, chunk_image
from vibecalc.core.study.sweep.output import lock_path, locked
from vibecalc.errors import ResultError, UsageError

POINTS = np.arange(24)


@pytest.fixture
def sweep(tmp_path: Path) -> Made:
    whole = made(tmp_path)
    whole.fill()
    return whole


def test_a_chunk_comes_back_as_it_was(sweep: Made) -> None:
    for number in range(sweep.chunks.chunks):
        found, made_here = sweep.chunks.read(number), block_at(sweep.chunks.points(number))
        assert chunk_image(found, "a") == chunk_image(made_here, "a")


@given(where=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
@settings(max_examples=40, deadline=None)
def test_no_flipped_bit_goes_unseen(where: float, bit: int) -> None:
    content = bytearray(chunk_image(block_at(POINTS[:3]), "id"))
    content[int(where * len(content))] ^= 1 << bit
    with pytest.raises(ResultError, match="damaged"):
        chunk_block(bytes(content), Path("chunk"), "id")


def test_no_truncated_or_longer_chunk_is_finished(sweep: Made) -> None:
    path = sweep.chunks.path(2)
    whole = path.read_bytes()
    for content in (b"", whole[:1], whole[: len(whole) // 2], whole[:-1], whole + b"\0"):
        path.write_bytes(content)
        found = sweep.chunks.survey()
        assert found.finished == {0, 1, 3, 4}
        assert [name for name, _ in found.damaged] == [path]
        assert "checksum" in found.damaged[0][1]
    sweep.fill(2)
    assert sweep.chunks.finished() == {0, 1, 2, 3, 4}


def test_chunks_of_another_sweep_are_foreign(sweep: Made) -> None:
    """Another identity, another cut, and a chunk under the name of its neighbour."""
    chunks = sweep.chunks
    for other in (replace(chunks, identity="0" * 64), replace(chunks, size=4)):
        found = other.survey()
        assert not found.finished and len(found.foreign) == 5
        other.write(0, block_at(other.points(0)))
        assert other.finished() == {0} and chunks.finished() == {0, 1, 2, 3, 4}
        other.path(0).unlink()
    chunks.path(1).write_bytes(chunks.path(2).read_bytes())
    found = chunks.survey()
    assert found.finished == {0, 2, 3, 4} and "another sweep" in found.damaged[0][1]


def test_files_of_others_are_left_alone(sweep: Made) -> None:
    note, unfinished = sweep.chunks.folder / "note.txt", sweep.chunks.folder / ".vibecalc-1-a.tmp"
    note.write_text("mine")
    unfinished.write_bytes(b"half")
    found = sweep.chunks.survey()
    assert found.unfinished == (unfinished,) and not found.foreign and not found.damaged
    sweep.chunks.clear()
    assert list(sweep.chunks.folder.iterdir()) == [note]
    note.unlink()
    sweep.chunks.clear()
    assert not sweep.chunks.folder.exists()


def test_a_killed_writer_leaves_no_chunk(tmp_path: Path) -> None:
    """The process dies when the file is whole, but not yet at its place."""
    program = (
        "import os, signal, sys; from pathlib import Path; from sweep_blocks import made\n"
        "os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)\n"
        "made(Path(sys.argv[1])).fill(0)\n"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", program, str(tmp_path)], env=environment)
    assert done.returncode == -9
    found = made(tmp_path).chunks.survey()
    assert not found.finished and len(found.unfinished) == 1


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


def test_of_many_who_find_a_dead_lock_one_gets_it(tmp_path: Path) -> None:
    output = tmp_path / "o.h5"
    lock_path(output).write_text("process 4194304 on a host that is no more")
    program = (
        "import sys; from pathlib import Path; from vibecalc.errors import UsageError\n"
        "from vibecalc.core.study.sweep.output import locked\n"
        "print('ready', flush=True); sys.stdin.readline()\n"
        "try:\n"
        "    with locked(Path(sys.argv[1])):\n"
        "        print('mine', flush=True); sys.stdin.readline()\n"
        "except UsageError as error: print(error, flush=True)\n"
    )
    command = [sys.executable, "-c", program, str(output)]
    pipe = subprocess.PIPE
    racers = [subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) for _ in range(2)]
    said = []
    for racer in racers:
        assert racer.stdout is not None and racer.stdout.readline() == "ready\n"
    for racer in racers:
        assert racer.stdin is not None
        racer.stdin.write("go\n")
        racer.stdin.flush()
    for racer in racers:
        assert racer.stdout is not None
        said.append(racer.stdout.readline())
    for racer in racers:
        racer.communicate("end\n")
    assert said.count("mine\n") == 1
    assert sum("is writing" in words for words in said) == 1

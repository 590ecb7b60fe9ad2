"""Claim: a chunk is taken for done if and only if it is whole and of this very sweep."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sweep_blocks import Made, block_at, made

from vibecalc.core.study.sweep.journal import Journal, packed
from vibecalc.core.study.sweep.output import lock_path, locked
from vibecalc.errors import UsageError


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

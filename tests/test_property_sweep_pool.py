"""Claim: processes compute every point once per chunk, whatever becomes of them."""

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from sweep_work import Squares, Start, dies_at_once

from vibecalc.core.results.layout import DIED
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.workers import Workers
from vibecalc.errors import UsageError

CHUNKS = [range(7 * number, 7 * number + 7) for number in range(5)]


def run(
    start: Start, jobs: int = 2, timeout: float | None = None, step: int = 1
) -> tuple[list[Squares], dict[int, Block]]:
    """What came of the points, and those that gave nothing."""
    with Workers(start, jobs=jobs, timeout=timeout, step=step) as workers:
        done = list(workers.run(CHUNKS))
    assert sorted(work.start for work, _ in done) == [0, 7, 14, 21, 28]
    blocks, lost = [], {}
    for work, found in done:
        given_up = [one for one in found if isinstance(one, Block)]
        mine = [one for one in found if isinstance(one, Squares)]
        lost |= {int(one.indices[0]): one for one in given_up}
        points = [
            *(int(one.indices[0]) for one in given_up),
            *(p for one in mine for p in one.points),
        ]
        assert sorted(points) == list(work)
        for one in mine:
            assert (one.squares == np.array(one.points) ** 2).all()
        blocks += mine
    return blocks, lost


@pytest.mark.parametrize("step", [3, pytest.param(100, marks=pytest.mark.long)])
def test_all_points_come_back_from_other_processes_with_one_thread(step: int) -> None:
    blocks, lost = run(Start(), step=step)
    processes = {block.process for block in blocks}
    assert os.getpid() not in processes and len(processes) <= 2
    assert {block.threads for block in blocks} == {"1"}
    assert max(len(block.points) for block in blocks) == min(step, 7)
    assert not lost


@pytest.mark.parametrize("step", [1, pytest.param(7, marks=pytest.mark.long)])
def test_points_that_kill_their_process_are_reported_and_the_rest_is_computed(step: int) -> None:
    start = Start(killing=frozenset({3}), leaving=frozenset({20}))
    _, lost = run(start, jobs=1, step=step)
    assert {point: int(one.status[0]) for point, one in lost.items()} == dict.fromkeys(
        (3, 20), DIED
    )
    assert "SIGKILL" in lost[3].message[0] and "exit code 7" in lost[20].message[0]


def test_a_process_that_dies_once_costs_one_more_try_and_no_point(tmp_path: Path) -> None:
    _, lost = run(Start(once=frozenset({9, 16}), folder=str(tmp_path)), jobs=1)
    assert not lost
    calls = Counter((tmp_path / "calls").read_text(encoding="ascii").split())
    assert calls["9"] == calls["16"] == 2
    assert calls["34"] == 1 and len(calls) == 35


def test_a_mistake_is_raised_with_its_traceback() -> None:
    with pytest.raises(RuntimeError, match="a mistake at") as caught:
        run(Start(raising=frozenset({5})))
    assert "sweep_work.py" in str(caught.value)


def test_processes_that_never_start_are_an_error_and_not_a_loop() -> None:
    with Workers(dies_at_once, jobs=1) as workers, pytest.raises(UsageError, match="exit code 9"):
        list(workers.run(CHUNKS))


def test_processes_end_with_the_sweep_even_if_it_is_killed(tmp_path: Path) -> None:
    import subprocess
    import sys
    import time

    code = f"""
import os, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from sweep_work import Start
from vibecalc.core.study.sweep.workers import Workers
workers = Workers(Start(hanging=frozenset({{7}})), jobs=1)
for _, found in workers.run([range(7), range(7, 9)]):
    print(found[0].process, flush=True)
"""
    sweep = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert sweep.stdout is not None
    process = int(sweep.stdout.readline())
    sweep.kill()
    sweep.wait()
    sweep.stdout.close()
    for _ in range(400):
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return
        if Path(f"/proc/{process}/stat").is_file() and ") Z " in Path(
            f"/proc/{process}/stat"
        ).read_text(encoding="ascii"):
            return  # ended; whoever inherited it has not looked yet
        time.sleep(0.05)
    raise AssertionError("a process outlived its sweep")

"""Claim: a pool computes every point once per chunk, whatever becomes of its processes."""

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from sweep_work import Start, dies_at_once

from vibecalc.core.results.layout import DIED, TIMED_OUT
from vibecalc.core.study.sweep.pool import Batch, ChunkResult, LostPoint, Pool, Work
from vibecalc.errors import UsageError

CHUNKS = [Work(number, range(7 * number, 7 * number + 7)) for number in range(5)]


def run(
    start: Start, jobs: int = 2, timeout: float | None = None, step: int = 1
) -> list[ChunkResult]:
    reported: list[Batch | LostPoint] = []
    with Pool(start, jobs=jobs, timeout=timeout, step=step) as pool:
        done = list(pool.run(CHUNKS, reported.append))
    assert len(reported) == sum(len(one.batches) + len(one.lost) for one in done)
    for one in done:
        points = [point for batch in one.batches for point in batch.points]
        points += [lost.point for lost in one.lost]
        assert sorted(points) == list(one.work.points)
        for batch in one.batches:
            assert batch.points == batch.block.points.tolist()
            assert (batch.block.squares == np.array(batch.points) ** 2).all()
    assert sorted(one.work.number for one in done) == [0, 1, 2, 3, 4]
    return done


def lost(done: list[ChunkResult]) -> dict[int, LostPoint]:
    return {one.point: one for chunk in done for one in chunk.lost}


@pytest.mark.parametrize("step", [3, pytest.param(100, marks=pytest.mark.long)])
def test_all_points_come_back_from_other_processes_with_one_thread(step: int) -> None:
    done = run(Start(), step=step)
    blocks = [batch.block for one in done for batch in one.batches]
    processes = {block.process for block in blocks}
    assert os.getpid() not in processes and len(processes) <= 2
    assert {block.threads for block in blocks} == {"1"}
    assert max(len(batch.points) for one in done for batch in one.batches) == min(step, 7)
    assert not lost(done)


@pytest.mark.parametrize("step", [1, pytest.param(7, marks=pytest.mark.long)])
def test_points_that_kill_their_process_are_reported_and_the_rest_is_computed(step: int) -> None:
    start = Start(killing=frozenset({3, 13}), leaving=frozenset({20}))
    found = lost(run(start, step=step))
    assert {point: one.status for point, one in found.items()} == {3: DIED, 13: DIED, 20: DIED}
    assert "SIGKILL" in found[3].message and "exit code 7" in found[20].message


def test_a_process_that_dies_once_costs_one_more_try_and_no_point(tmp_path: Path) -> None:
    done = run(Start(once=frozenset({9, 16}), folder=str(tmp_path)))
    assert not lost(done)
    calls = Counter((tmp_path / "calls").read_text(encoding="ascii").split())
    assert calls["9"] == calls["16"] == 2
    assert calls["34"] == 1 and len(calls) == 35


@pytest.mark.long
@pytest.mark.parametrize("step", [1, 7])
def test_attached_points_are_given_up_and_their_processes_replaced(step: int) -> None:
    found = lost(run(Start(hanging=frozenset({0, 34})), timeout=0.5, step=step))
    assert {point: one.status for point, one in found.items()} == {0: TIMED_OUT, 34: TIMED_OUT}
    assert found[0].message == "took longer than 0.5 s"


def test_a_mistake_is_raised_with_its_traceback() -> None:
    with pytest.raises(RuntimeError, match="a mistake at") as caught:
        run(Start(raising=frozenset({5})))
    assert "sweep_work.py" in str(caught.value)


def test_processes_that_never_start_are_an_error_and_not_a_loop() -> None:
    with Pool(dies_at_once, jobs=2) as pool, pytest.raises(UsageError, match="exit code 9"):
        list(pool.run(CHUNKS))


def test_leaving_early_ends_all_processes() -> None:
    with Pool(Start(seconds=0.01), jobs=2) as pool:
        first = next(pool.run(CHUNKS))
        process = first.batches[0].block.process
        os.kill(process, 0)
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_processes_end_with_the_sweep_even_if_it_is_killed(tmp_path: Path) -> None:
    import subprocess
    import sys
    import time

    code = f"""
import os, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from sweep_work import Start
from vibecalc.core.study.sweep.pool import Pool, Work
pool = Pool(Start(hanging=frozenset({{7}})), jobs=1)
for done in pool.run([Work(0, range(7)), Work(1, range(7, 9))]):
    print(done.batches[0].block.process, flush=True)
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

"""Claim: processes here or on a cluster compute every point once, whatever becomes of them."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sweep_work import Squares, Start, dies_at_once

from vibecalc.core.results.layout import DIED, TIMED_OUT
from vibecalc.core.study.sweep.blocks import Block
from vibecalc.core.study.sweep.workers import Workers
from vibecalc.errors import UsageError

CHUNKS = [range(7 * number, 7 * number + 7) for number in range(5)]


def run(start: Start, jobs: int = 2, step: int = 1) -> tuple[list[Squares], dict[int, Block]]:
    """What came of the points, and those that gave nothing."""
    with Workers(start, jobs=jobs, step=step) as workers:
        done = list(workers.run(CHUNKS))
    return held(done, CHUNKS)


def held(
    done: list[tuple[range, list[Any]]], chunks: list[range]
) -> tuple[list[Squares], dict[int, Block]]:
    """The same of all chunks, each of which has all its points, right and with one thread."""
    assert sorted(work.start for work, _ in done) == [work.start for work in chunks]
    blocks, lost = [], {}
    for work, found in done:
        given_up = {int(one.indices[0]): one for one in found if isinstance(one, Block)}
        mine = [one for one in found if isinstance(one, Squares)]
        assert sorted([*given_up, *(p for one in mine for p in one.points)]) == list(work)
        for one in mine:
            assert (one.squares == np.array(one.points) ** 2).all() and one.threads == "1"
        blocks += mine
        lost |= given_up
    return blocks, lost


def statuses(lost: dict[int, Block]) -> dict[int, int]:
    return {point: int(one.status[0]) for point, one in lost.items()}


@pytest.mark.parametrize("step", [3, pytest.param(100, marks=pytest.mark.long)])
def test_all_points_come_back_from_other_processes_with_one_thread(step: int) -> None:
    blocks, lost = run(Start(), step=step)
    processes = {block.process for block in blocks}
    assert os.getpid() not in processes and len(processes) <= 2
    assert max(len(block.points) for block in blocks) == min(step, 7)
    assert not lost


@pytest.mark.parametrize("step", [1, pytest.param(7, marks=pytest.mark.long)])
def test_points_that_kill_their_process_are_reported_and_the_rest_is_computed(step: int) -> None:
    start = Start(killing=frozenset({3}), leaving=frozenset({20}))
    _, lost = run(start, jobs=1, step=step)
    assert statuses(lost) == {3: DIED, 20: DIED}
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


# ----------------------------------------------------------------------------
# The same on a dask cluster.
# ----------------------------------------------------------------------------

FIVES = [range(5 * number, 5 * number + 5) for number in range(12)]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """A scheduler here and two workers in processes of their own."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=True,
        dashboard_address=None,
        silence_logs=100,
    ) as local:
        yield local


def test_points_are_shared_out_attached_ones_given_up_and_fatal_ones_reported(
    cluster: Any, tmp_path: Path
) -> None:
    start = Start(hanging=frozenset({4}), killing=frozenset({33}))
    file = tmp_path / "scheduler.json"
    # the part of such a file that a client reads
    file.write_text(json.dumps({"address": cluster.scheduler_address}), encoding="utf-8")
    with Workers(start, cluster=str(file), timeout=0.5) as workers:
        assert workers.threads() == 2
        done = list(workers.run(FIVES))
    blocks, lost = held(done, FIVES)
    assert statuses(lost) == {4: TIMED_OUT, 33: DIED}
    assert len({block.process for block in blocks}) >= 2


@pytest.mark.long
def test_a_worker_killed_in_the_middle_costs_no_point(cluster: Any) -> None:
    from distributed import Client

    with Client(cluster.scheduler_address, set_as_default=False) as client:
        victim = next(iter(client.run(os.getpid).values()))
    done = []
    with Workers(Start(seconds=0.02), cluster=cluster.scheduler_address) as workers:
        for one in workers.run(FIVES):
            done.append(one)
            if len(done) == 3:
                os.kill(victim, signal.SIGKILL)
    assert not held(done, FIVES)[1]


def test_a_scheduler_that_is_not_there_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("vibecalc.core.study.sweep.workers._ANSWER_WITHIN", 0.2)
    with pytest.raises(UsageError, match="no dask scheduler answers at tcp:"):
        Workers(Start(), cluster="tcp://127.0.0.1:9")
    with pytest.raises(UsageError, match=r"there is no scheduler file nowhere\.json"):
        Workers(Start(), cluster="nowhere.json")


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(UsageError, match=r"vibecalc\[cluster\]"):
        Workers(Start(), cluster="tcp://127.0.0.1:9")

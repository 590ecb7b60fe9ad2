"""Claim: a dask cluster gives what one machine gives, also when a worker is lost in the middle."""

import json
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sweep_work import Squares, Start

from vibecalc.core.results.layout import DIED, TIMED_OUT
from vibecalc.core.study.sweep.workers import Workers
from vibecalc.errors import UsageError

CHUNKS = [range(5 * number, 5 * number + 5) for number in range(12)]


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


def check(done: list[tuple[range, list[Any]]], lost: dict[int, int]) -> set[int]:
    assert sorted(work.start for work, _ in done) == [work.start for work in CHUNKS]
    processes, given_up = set(), {}
    for work, found in done:
        points = []
        for one in found:
            if not isinstance(one, Squares):
                points.append(int(one.indices[0]))
                given_up[points[-1]] = int(one.status[0])
                continue
            points += one.points.tolist()
            assert (one.squares == one.points**2).all()
            assert one.threads == "1"
            processes.add(one.process)
        assert sorted(points) == list(work)
    assert given_up == lost
    return processes


def test_points_are_shared_out_attached_ones_given_up_and_fatal_ones_reported(
    cluster: Any, tmp_path: Path
) -> None:
    start = Start(hanging=frozenset({4}), killing=frozenset({33}))
    file = tmp_path / "scheduler.json"
    # the part of such a file that a client reads
    file.write_text(json.dumps({"address": cluster.scheduler_address}), encoding="utf-8")
    with Workers(start, cluster=str(file), timeout=0.5) as workers:
        assert workers.threads() == 2
        done = list(workers.run(CHUNKS))
    assert len(check(done, {4: TIMED_OUT, 33: DIED})) >= 2


@pytest.mark.long
def test_a_worker_killed_in_the_middle_costs_no_point(cluster: Any) -> None:
    from distributed import Client

    with Client(cluster.scheduler_address, set_as_default=False) as client:
        victim = next(iter(client.run(os.getpid).values()))
    done = []
    with Workers(Start(seconds=0.02), cluster=cluster.scheduler_address) as workers:
        for one in workers.run(CHUNKS):
            done.append(one)
            if len(done) == 3:
                os.kill(victim, signal.SIGKILL)
    check(done, {})


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

"""Claim: a sweep that is killed loses what was not renamed; resumed, its file is the same."""

import json
import random
import signal
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from long_but import long_but
from sweep_runs import GENERATOR, GRID, finished_chunks, killed, objects, started

from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep import stacked_file
from vibecalc.core.study.sweep.prepare import Options, prepare, sweep_settings
from vibecalc.core.study.sweep.run import sweep
from vibecalc.errors import Interrupted

POINTS = 96


def finish(*arguments: object) -> tuple[int, str, str]:
    sweep = started(*arguments)
    out, err = sweep.communicate(timeout=120)
    return sweep.returncode, out, err


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, float]:
    """A whole sweep and the seconds it took."""
    output = tmp_path_factory.mktemp("whole") / "whole.h5"
    begun = time.monotonic()
    code, _, err = finish(GENERATOR, *GRID, "-j", 2, "-q", "-o", output)
    assert (code, err) == (0, "")
    return output, time.monotonic() - begun


def survives(output: Path, whole: Path, seconds: float, moments: int, seed: int) -> None:
    """Kill a sweep at random moments, resume it each time; start anew when it was finished."""
    draw = random.Random(seed)
    expected, kept = objects(whole), {}
    for _ in range(moments):
        sweep = started(GENERATOR, *GRID, "-j", 2, "-q", "--resume", "-o", output)
        time.sleep(draw.uniform(0.0, seconds))
        err = killed(sweep)
        if output.exists():
            assert objects(output) == expected
            output.unlink()
            kept = finished_chunks(output)
            continue
        found = finished_chunks(output)
        assert kept.items() <= found.items(), "a finished chunk was lost or computed again"
        kept = found
        assert "Traceback" not in err
    before = len(kept) * POINTS // 16
    code, out, err = finish(GENERATOR, *GRID, "-j", 2, "--json", "--resume", "-o", output)
    assert code == 0, err
    assert json.loads(out)["taken_up"] == before
    assert objects(output) == expected
    assert not finished_chunks(output)
    names = {path.name for path in output.parent.iterdir()}
    assert names == {output.name, output.with_suffix(".txt").name}


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize(("moments", "seed"), [(3, 1), (200, 2)])
def test_a_sweep_killed_at_many_moments_ends_as_if_never_killed(
    uninterrupted: tuple[Path, float], tmp_path: Path, moments: int, seed: int
) -> None:
    survives(tmp_path / "killed.h5", *uninterrupted, moments, seed)


@pytest.mark.long
@pytest.mark.parametrize(
    "how", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.long)]
)
def test_an_interrupted_sweep_says_how_to_go_on(
    uninterrupted: tuple[Path, float], tmp_path: Path, how: signal.Signals
) -> None:
    output = tmp_path / "stopped.h5"
    sweep = started(GENERATOR, *GRID, "-j", 2, "-q", "-o", output)
    while len(finished_chunks(output)) < 3:
        assert sweep.poll() is None
        time.sleep(0.002)
    err = killed(sweep, how)
    finished = len(finished_chunks(output))
    assert sweep.returncode == 130, err
    assert f"{finished} of 16 chunks are finished" in err and "--resume" in err
    assert not output.exists() and not output.with_name("stopped.h5.lock").exists()

    code, _, err = finish(GENERATOR, *GRID, "-q", "-o", output)
    assert code == 2
    assert f"{finished} of 16 chunks" in err and "--resume" in err and "--fresh" in err
    assert len(finished_chunks(output)) == finished

    code, out, _ = finish(GENERATOR, *GRID, "-q", "--json", "--resume", "-o", output)
    assert code == 0
    assert json.loads(out)["taken_up"] == finished * POINTS // 16
    assert objects(output) == objects(uninterrupted[0])


@pytest.mark.parametrize("moment", long_but(range(4), 0, 3))
def test_ctrl_c_while_the_file_is_put_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: int
) -> None:
    """Within a write of HDF5, which does not survive an exception from outside."""
    calls: list[int] = []
    write = stacked_file._StackedWriter.block

    def interrupted(self: Any, block: Any) -> None:
        if len(calls) == moment:
            signal.raise_signal(signal.SIGINT)
        calls.append(1)
        write(self, block)

    monkeypatch.setattr(stacked_file._StackedWriter, "block", interrupted)
    axes = ("machine.mounts.each.stiffness=5 N/mm:50 N/mm:4",)
    settings = sweep_settings(axes, (), None, ("isolation/pitch/inertia",))
    (loaded,) = load_checked([GENERATOR], settings)
    prepared = replace(
        prepare(loaded, 1), strategy=prepare(loaded, 1).strategy._replace(chunk_size=1)
    )
    said: list[str] = []
    options = Options(output=tmp_path / "s.h5", jobs=1, note=said.append)
    with pytest.raises(Interrupted, match="4 of 4 chunks are finished and stay"):
        sweep(prepared, options)
    assert not (tmp_path / "s.h5").exists() and len(finished_chunks(tmp_path / "s.h5")) == 4
    done = sweep(prepared, replace(options, resume=True))
    assert done.taken_up == 4 and not done.failed and not said
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler

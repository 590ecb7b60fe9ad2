"""Claim: `sweep` and `merge` do what docs/sweeps.md says, with the exit codes it gives."""

import json
import os
import signal
import time
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzzing import command
from shipped_cases import CASES
from sweep_runs import GENERATOR, GRID, finished_chunks, objects

from vibecalc.core.results.layout import DIED, DONE, TIMED_OUT
from vibecalc.core.results.store import read_result
from vibecalc.core.results.sweep_file import open_sweep
from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.prepare import Options, PreparedSweep, prepare, sweep_settings
from vibecalc.core.study.sweep.run import sweep

CASE = str(GENERATOR)
PEAK = "isolation/couple_over_lever/steady_peak"
RUN_UP = "isolation/couple_over_lever/run_up_peak"
STIFFNESS = "machine.mounts.each.stiffness"
SMALL = (
    "--grid", f"{STIFFNESS}=5 N/mm,10 N/mm,20 N/mm",
    "--grid", "machine.speed=3000 rpm,4900 rpm",
    "--keep", PEAK,
    "--keep", "isolation/support_force/steady_peak",
)  # fmt: skip


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_each_point_has_the_numbers_of_its_own_run() -> None:
    outcome = command("sweep", CASE, *SMALL)
    assert outcome.code == 0, outcome.err
    assert "wrote outputs/generator.sweep.h5 and generator.sweep.txt" in outcome.out
    assert outcome.out.startswith(Path("outputs/generator.sweep.txt").read_text(encoding="utf-8"))
    with open_sweep("outputs/generator.sweep.h5") as found:
        assert found.shape == (3, 2)
        peaks = found.read(PEAK)
        forces = found.read("isolation/support_force/steady_peak")
    assert forces * 4 == pytest.approx(np.stack([peaks] * 4, axis=-1), rel=1e-9)
    for point, stiffness, speed in (((0, 1), 5, 4900), ((2, 0), 20, 3000)):
        settings = ("--set", f"{STIFFNESS}={stiffness} N/mm", "--set", f"machine.speed={speed} rpm")
        (run,) = json.loads(command("run", CASE, "--json", "-q", *settings).out)
        assert peaks[point] == pytest.approx(run["quantities"][PEAK]["value"], rel=1e-12)


def test_json_is_one_object_and_nothing_else_on_stdout() -> None:
    outcome = command("sweep", CASE, *SMALL, "--json", "-o", "small.h5")
    assert (outcome.code, outcome.err) == (0, "")
    found = json.loads(outcome.out)
    assert found["points"] == 6 and found["shape"] == [3, 2] and found["result"] == "small.h5"
    assert found["statuses"] == {"done": 6} and found["failures"] == []
    assert found["quantities"][PEAK] == {"unit": "N", "axes": []}
    kept = {row["quantity"]: (row["kept"], row["broken"]) for row in found["limits"]}
    assert sum(kept[PEAK]) == 6


def test_a_dry_run_says_all_and_writes_nothing(tmp_path: Path) -> None:
    many = (
        "--grid",
        f"{STIFFNESS}=5 N/mm:50 N/mm:40",
        "--grid",
        "isolation.run_up.to=3000 rpm:4900 rpm:50",
    )
    outcome = command("sweep", CASE, *many, "--dry-run", "--shard", "2/3")
    assert outcome.code == 0, outcome.err
    for words in ("2000, a grid of 40 x 50", "pool", "5, 125 points each", "order (2), N", "about"):
        assert words in outcome.out, outcome.out
    found = json.loads(command("sweep", CASE, *SMALL, "--dry-run", "--json").out)
    assert found["points"] == 6 and found["strategy"] == "array" and found["chunks"] == 1
    assert {row["quantity"]: row["axes"] for row in found["kept"]} == {
        PEAK: {},
        "isolation/support_force/steady_peak": {"mount": 4},
    }
    assert found["seconds"] > 0 and found["bytes"] > 6 * 5 * 8
    assert not list(tmp_path.iterdir())


def undamped(tmp_path: Path) -> Path:
    text = GENERATOR.read_text(encoding="utf-8").replace(', damping = "50 N*s/m"', "")
    path = tmp_path / "undamped.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("keep", [PEAK, pytest.param(RUN_UP, marks=pytest.mark.long)])
def test_failed_points_are_counted_by_cause_and_the_exit_code_is_4(
    tmp_path: Path, keep: str
) -> None:
    frequency = (12 * 4 * 0.4**2 * 10000 / (100 * (0.35**2 + 0.8**2))) ** 0.5
    rods = "machine.crank_train.rod_length=0.05,0.2"
    speeds = f"machine.speed={frequency!r},300,{frequency / 2!r}"
    outcome = command(
        "sweep", str(undamped(tmp_path)), "--grid", rods, "--grid", speeds, "--keep", keep,
        "--json", "-o", "failed.h5", "-j", "2", cap=60,
    )  # fmt: skip
    assert outcome.code == 4, outcome.err
    assert "Traceback" not in outcome.err
    found = json.loads(outcome.out)
    causes = {row["status"]: row["points"] for row in found["failures"]}
    assert causes["input refused"] == 3
    assert causes["numerical failure"] == 2 and found["statuses"]["done"] == 1
    assert "3 points: input refused" in outcome.err and "rod_length" in outcome.err
    assert not Path("failed.h5.chunks").exists()
    assert command("report", "failed.h5").out == Path("failed.txt").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "not say what to vary"),
        (("--grid", "machine.sped=1,2"), "did you mean 'speed'?"),
        ((*SMALL, "--keep", "isolation/couple_over_lever/stedy_peak"), "steady_peak"),
        ((*SMALL, "--shard", "4/3"), "I from 1 to N"),
        ((*SMALL, "--timeout", "0"), "above 0"),
        ((*SMALL, "-o", "sweep.txt"), "ends in .h5"),
        ((*SMALL, "--cluster", "nowhere.json"), "nowhere.json"),
    ],
)
def test_what_cannot_be_swept_is_said_before_anything_is_written(
    options: tuple[str, ...], words: str, tmp_path: Path
) -> None:
    pytest.importorskip("distributed") if "--cluster" in options else None
    outcome = command("sweep", CASE, *options)
    assert outcome.code == 2, outcome.out
    assert words in outcome.err and "Traceback" not in outcome.err
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_a_file_that_is_not_this_sweep_is_not_replaced() -> None:
    assert command("sweep", CASE, *SMALL, "-q", "-o", "one.h5").code == 0
    before = Path("one.h5").read_bytes()
    other = ("--grid", "machine.speed=1000 rpm,2000 rpm", "-q", "-o", "one.h5")
    for resume in ((), ("--resume",)):
        outcome = command("sweep", CASE, *other, *resume)
        assert outcome.code == 2
        assert "other points" in outcome.err and "--fresh" in outcome.err
        outcome = command("sweep", CASE, *SMALL, "--set", "machine.body.mass=99", *resume,
                          "-o", "one.h5")  # fmt: skip
        assert outcome.code == 2 and "another case" in outcome.err
    assert Path("one.h5").read_bytes() == before
    assert command("sweep", CASE, *other, "--fresh").code == 0
    assert Path("one.h5").read_bytes() != before
    assert command("run", CASE, "-q", "-o", "run.h5").code == 0
    outcome = command("sweep", CASE, *SMALL, "-q", "-o", "run.h5")
    assert outcome.code == 2 and "not of a sweep" in outcome.err


def test_resuming_what_is_complete_computes_nothing() -> None:
    assert command("sweep", CASE, *SMALL, "-q", "-o", "one.h5").code == 0
    before = Path("one.h5").stat().st_ino
    outcome = command("sweep", CASE, *SMALL, "-q", "--resume", "-o", "one.h5")
    assert outcome.code == 0 and "complete" in outcome.err
    assert Path("one.h5").stat().st_ino == before


@dataclass(frozen=True, kw_only=True)
class Nasty(PreparedSweep):
    """A sweep some of whose points hang or kill their process."""

    hanging: int
    killing: int

    def start(self) -> Any:
        """As it should be, but for two points."""
        return partial(nasty, super().start(), self.hanging, self.killing)


def nasty(start: Any, hanging: int, killing: int) -> Any:
    return partial(_evaluate_nastily, start(), hanging, killing)


def _evaluate_nastily(evaluate: Any, hanging: int, killing: int, points: np.ndarray) -> Any:
    if killing in points:
        os.kill(os.getpid(), signal.SIGSEGV)
    if hanging in points:
        time.sleep(600)
    return evaluate(points)


@pytest.mark.long
def test_attached_and_fatal_points_are_marked_and_only_they_are_tried_again(tmp_path: Path) -> None:
    options = sweep_settings(GRID[1:4:2], (), None, GRID[5::2])
    (loaded,) = load_checked([GENERATOR], options)
    good = prepare(loaded, 2)
    bad = Nasty(**{name: getattr(good, name) for name in good.__dataclass_fields__},
                hanging=13, killing=50)  # fmt: skip
    said: list[str] = []
    wanted = Options(output=tmp_path / "bad.h5", jobs=2, timeout=3.0, note=said.append)
    made = sweep(bad, wanted)
    assert made.counts == {DONE: 94, TIMED_OUT: 1, DIED: 1} and made.failed == 2
    with open_sweep(wanted.output) as found:
        assert found.status().ravel()[[13, 50]].tolist() == [TIMED_OUT, DIED]
        words = found.reasons()
        assert words[13] == "took longer than 3 s" and "SIGSEGV" in words[50]
        assert np.isnan(found.read(RUN_UP)).sum() == 2
    assert "--resume" in said[0]

    made = sweep(good, replace(wanted, resume=True))
    assert made.counts == {DONE: 96} and made.taken_up == 96 - 12
    whole = replace(wanted, output=tmp_path / "good.h5", timeout=None)
    assert sweep(good, whole).counts == {DONE: 96}
    assert objects(wanted.output) == objects(whole.output)
    assert not finished_chunks(wanted.output)


GENSET = CASES["genset_points"]
ORDER = "machine.crank_train.firing_order"


@pytest.mark.long
def test_lists_tables_and_quoted_texts_are_values(tmp_path: Path) -> None:
    """Each is what `--set` gives: throws follow the order of firing, labels are short and whole."""
    rms = "points/velocity_rms"
    output = str(tmp_path / "orders.h5")
    outcome = command("sweep", str(GENSET), "-o", output, "-j", "1", "--keep", rms, "--grid",
                      f"{ORDER}=[1,3,2],[1,2,3]",
                      "--grid", 'point[0].position[1]="0 m","0.1 m"', cap=60)  # fmt: skip
    assert outcome.code == 0, outcome.err
    found = read_result(Path(output))[rms]
    assert found.axes[0].values.tolist() == ["[1,3,2]", "[1,2,3]"]
    assert "firing order = [1,3,2]" in " ".join(outcome.out.split())
    one = str(tmp_path / "one.h5")
    settings = ("--set", f'{ORDER}=["1", "2", "3"]', "--set", "point[0].position[1]=0.1 m")
    code = command("run", str(GENSET), "-o", one, "-q", *settings, cap=60).code
    assert code in (0, 1)
    single = read_result(Path(one))[rms].values
    assert np.allclose(found.values[1, 1], single, rtol=1e-9, atol=0.0)

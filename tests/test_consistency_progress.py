"""Claim: a long run says on a terminal what it is at, a short one and a pipe are left alone."""

import io
import sys
import time

import pytest

from vibecalc.core.study import variables as progress


class _Screen(io.StringIO):
    def __init__(self, is_terminal: bool) -> None:
        super().__init__()
        self.is_terminal = is_terminal

    def isatty(self) -> bool:
        return self.is_terminal


def _shown(monkeypatch: pytest.MonkeyPatch, screen: _Screen, seconds: float, wanted: bool) -> str:
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(progress, "_QUIET", 0.02)
    monkeypatch.setattr(progress, "_STEP", 0.01)
    with progress.telling(wanted) as tell:
        tell("start-up")
        time.sleep(seconds)
    return screen.getvalue()


def test_a_long_run_names_its_stage_and_wipes_the_line(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = _shown(monkeypatch, _Screen(True), 0.2, wanted=True)
    assert "\rcomputing: start-up, 0 s" in shown
    assert shown.endswith("\r")
    assert shown.split("\r")[-2].strip() == ""


@pytest.mark.parametrize(
    ("is_terminal", "seconds", "wanted"),
    [(True, 0.0, True), (False, 0.1, True), (True, 0.1, False)],
)
def test_nothing_is_said_elsewhere(
    monkeypatch: pytest.MonkeyPatch, is_terminal: bool, seconds: float, wanted: bool
) -> None:
    assert _shown(monkeypatch, _Screen(is_terminal), seconds, wanted) == ""

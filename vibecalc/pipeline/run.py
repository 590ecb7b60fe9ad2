"""One run: the planned stages in their order, each timed, into one record."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.errors import NumericalFailure
from vibecalc.parts.machine import build_machine
from vibecalc.pipeline.plan import needed_stages
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stage_cache import StageCache
from vibecalc.pipeline.stage_plan import StagePlan
from vibecalc.pipeline.tolerance import tolerance_warning
from vibecalc.results.named import named
from vibecalc.results.record import Record

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def run_case(
    case: "Case",
    *,
    timings: dict[str, float] | None = None,
    wanted: frozenset[str] | None = None,
    cache: StageCache | None = None,
    tell: Callable[[str], None] | None = None,
) -> Record:
    """Run the stages that `case` asks for and keep their results; see `run_scene`."""
    return run_scene(case, timings=timings, wanted=wanted, cache=cache, tell=tell).record


def run_scene(
    case: "Case",
    *,
    timings: dict[str, float] | None = None,
    wanted: frozenset[str] | None = None,
    cache: StageCache | None = None,
    tell: Callable[[str], None] | None = None,
) -> Scene:
    """Run the stages that `case` asks for, with what they handed on to each other.

    Parameters
    ----------
    case : a case whose form, physics and targets have been checked.
    timings : filled with seconds per stage.
    wanted : result paths to compute, for studies that run a case many times; None is all.
    cache : outcomes of stages of earlier runs, taken where nothing that a stage reads has changed;
        the results are the same to the last bit.
    tell : called with the name of each stage as it begins.

    Raises
    ------
    NumericalFailure : when a quantity has no trustworthy value.
    """
    started = time.perf_counter()
    cached = None if cache is None else cache.at(case, wanted)
    parts = cached.parts() if cached else build_machine(case)
    scene = Scene(case=case, parts=parts, wanted=wanted)
    clock = timings if timings is not None else {}
    if wanted is None:
        for warning in machine_warnings(case):
            scene.warn(warning)
    clock["machine"] = time.perf_counter() - started
    for stage in needed_stages(case, wanted):
        started = time.perf_counter()
        if tell is not None:
            tell(stage.stage)
        if cached is None:
            _run_stage(stage, scene)
        else:
            cached.run(stage, scene, _run_stage)
        clock[stage.stage] = time.perf_counter() - started
    if wanted is None:
        missed = tolerance_warning(scene.record, case.accuracy.rtol)
        if missed is not None:
            scene.warn(missed)
    return scene


def _run_stage(stage: StagePlan, scene: Scene) -> None:
    """Run one adapter; an overflow or an undefined operation on the way is a failure, not a NaN."""
    adapter = named(stage.adapter)
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise", under="ignore"):
            adapter(scene)
    except (FloatingPointError, OverflowError) as error:
        raise NumericalFailure(
            f"the stage {stage.stage!r} left the range of double precision ({error}): "
            "some masses, lengths, stiffnesses or speeds of the case are too far apart"
        ) from error

"""A case with `[sweep]` made ready: its points, what is kept, how it is computed, what it is."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from vibecalc.case.load import LoadedCase, raise_with_location
from vibecalc.errors import UsageError
from vibecalc.study.sweep.chunks import ChunkFolder, parts_folder
from vibecalc.study.sweep.design import Design, make_design
from vibecalc.study.sweep.early import sweep_problems
from vibecalc.study.sweep.identity import Identity, identify
from vibecalc.study.sweep.keep import kept_paths
from vibecalc.study.sweep.strategy import Strategy, choose, start


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A sweep that can start."""

    loaded: LoadedCase
    design: Design
    keep: tuple[str, ...]
    identity: Identity
    strategy: Strategy

    def chunks(self, output: Path) -> ChunkFolder:
        """The folder for the chunks of the sweep that becomes `output`."""
        return ChunkFolder(
            folder=parts_folder(output),
            identity=self.identity.sweep,
            count=self.design.count,
            size=self.strategy.chunk_size,
        )

    def start(self) -> Callable[[], Callable[[Any], Any]]:
        """What a process starts with."""
        return partial(start, self.loaded, self.design, self.keep, self.strategy.kind)

    @property
    def is_short(self) -> bool:
        """Whether it is over before processes have started."""
        return choose(self.loaded.case, self.design, self.keep).kind != "pool"

    @property
    def step(self) -> int:
        """Points in one call."""
        return self.strategy.chunk_size if self.strategy.kind == "array" else 1


def prepare(loaded: LoadedCase, jobs: int) -> Prepared:
    """Check the sweep of a case that may use so many processes.

    CaseError, with the places in the file, for all problems found.
    """
    case, resolved = loaded.case, loaded.resolved
    if case.sweep is None or not case.sweep.axes:
        raise UsageError(
            f"{loaded.path} says not what to vary: it needs a table [sweep] with axes, or give "
            "them here, as in --grid 'machine.speed=2000 rpm:4000 rpm:21'"
        )
    raise_with_location(loaded, sweep_problems(loaded))
    design = make_design(case.sweep, resolved)
    keep = kept_paths(case.sweep.keep, case, design, resolved)
    return Prepared(
        loaded=loaded,
        design=design,
        keep=keep,
        identity=identify(resolved, design, keep),
        strategy=choose(case, design, keep, jobs),
    )

"""Pictures of a result, written as PNG files. matplotlib is imported here, when it is asked for."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Result
from vibecalc.core.run.stage import subjects, subjects_of
from vibecalc.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Pictures of studies; each subject names its own. A picture is `draw(result) -> Figure | None`.
OF_STUDIES: dict[str, str] = {
    "pareto": "vibecalc.core.report.pictures:draw_pareto",
    "optimisation": "vibecalc.core.report.pictures:draw_start_and_optimum",
}

#: The same for sweeps; each has `picture(sweep) -> Figure | None`.
SWEEP_PICTURES: dict[str, str] = {
    "sweep_line": "vibecalc.core.report.sweep.picture_lines:draw_sweep_line",
    "sweep_map": "vibecalc.core.report.sweep.picture_maps:draw_sweep_map",
    "sweep_sample": "vibecalc.core.report.sweep.picture_maps:draw_sweep_sample",
}

#: A font that matplotlib brings along, so that the same result gives the same picture anywhere.
STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.8,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
}
_RESOLUTION = 130


def draw(result: Result, folder: Path, stem: str = "") -> list[Path]:
    """Draw every picture that the result has the numbers for.

    Files are `<stem>_<picture>.png` in `folder`, which is made if it is missing; `stem` is the name
    of the case if nothing else is said. Equal results give equal bytes with one version of
    matplotlib.

    Raises
    ------
    UsageError
        matplotlib is not installed, or the folder cannot be written.
    """
    stem = stem or result.name
    return _drawn(stem, ((name, make(result, name)) for name in pictures_of(result)), folder)


def draw_sweep(sweep: SweepView, folder: Path, stem: str = "") -> list[Path]:
    """The same for a sweep: lines over one axis, maps over two, histograms of samples.

    `stem` takes the place of the name of the case, for several sweeps of one case.
    """
    stem = (stem or sweep.name).removesuffix("_sweep")
    return _drawn(stem, ((name, make_sweep(sweep, name)) for name in SWEEP_PICTURES), folder)


def draw_files(paths: Sequence[Path], folder: Path | None) -> Iterator[tuple[Path, list[Path]]]:
    """Draw files beside themselves or into `folder`; yields each with its pictures, maybe none.

    Raises UsageError, before anything is drawn, where two files would write the same pictures.
    """
    homes = [(folder or path.parent, path.stem.removesuffix(".sweep")) for path in paths]
    for number, (path, home) in enumerate(zip(paths, homes, strict=True)):
        if home in homes[:number]:
            raise UsageError(
                f"the pictures of {paths[homes.index(home)]} and {path} would have the same names "
                f"in {home[0]}; draw them into two folders, with -o"
            )
    for path, (target, _) in zip(paths, homes, strict=True):
        yield path, draw_file(path, target)


def draw_file(path: Path, folder: Path) -> list[Path]:
    """Draw a file, be it of a run or of a sweep; also ResultError if it cannot be read."""
    from vibecalc.core.results.sweep_file import is_sweep, open_sweep

    if is_sweep(path):
        from vibecalc.core.report.sweep.view import view_of

        with open_sweep(path) as opened:
            return draw_sweep(view_of(opened), folder, path.stem.removesuffix(".sweep"))
    from vibecalc.core.results.layout import is_accuracy
    from vibecalc.core.results.store import read_result

    result = read_result(path)
    if is_accuracy(result):
        return draw_accuracy(result, folder / f"{path.stem}.png")
    return draw(result, folder, path.stem)


def draw_accuracy(result: Result, path: Path) -> list[Path]:
    """The one picture of a measurement of methods, if it has any; UsageError as for the others."""
    from vibecalc.core.report.pictures import draw_accuracy as picture

    matplotlib = _matplotlib()
    with matplotlib.rc_context(STYLE):
        figure = picture(result)
        if figure is None:
            return []
        _save(figure, path)
    return [path]


def _drawn(case: str, figures: Iterable[tuple[str, "Figure | None"]], folder: Path) -> list[Path]:
    matplotlib = _matplotlib()
    written = []
    with matplotlib.rc_context(STYLE):
        for name, figure in figures:
            if figure is None:
                continue
            path = Path(folder) / f"{case}_{name}.png"
            _save(figure, path)
            written.append(path)
    return written


def _save(figure: "Figure", path: Path) -> None:
    from vibecalc.core.results.files import write_atomically

    image = BytesIO()
    figure.savefig(image, format="png", dpi=_RESOLUTION, metadata={"Software": None})
    write_atomically(path, image.getvalue())


def every_picture() -> dict[str, str]:
    """Pictures of all subjects and of studies by name."""
    found: dict[str, str] = {}
    for subject in subjects().values():
        found |= subject.pictures
    return found | OF_STUDIES


def pictures_of(result: Result) -> dict[str, str]:
    """Pictures by name of the subjects that a result has quantities of, and of studies."""
    found: dict[str, str] = {}
    for subject in subjects_of(result.record):
        found |= subject.pictures
    return found | OF_STUDIES


def make(result: Result, name: str) -> "Figure | None":
    """One figure by its name in `every_picture`, None if the result lacks the numbers for it."""
    picture: Callable[[Result], Figure | None] = named(every_picture()[name])
    return picture(result)


def make_sweep(sweep: SweepView, name: str) -> "Figure | None":
    """One figure of a sweep by its name in `SWEEP_PICTURES`, None if it does not suit the sweep."""
    picture: Callable[[SweepView], Figure | None] = named(SWEEP_PICTURES[name])
    return picture(sweep)


def _matplotlib() -> Any:
    try:
        import matplotlib
        import matplotlib.figure
    except ImportError as error:
        raise UsageError(
            "pictures need matplotlib, which is not installed; "
            "install it with: pip install 'vibecalc[plot]'"
        ) from error
    return matplotlib

"""Pictures of a result, written as PNG files. matplotlib is imported here, when it is asked for."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibecalc.errors import UsageError
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: File name -> module of `pictures/`; each has `picture(result) -> Figure | None`.
PICTURES: dict[str, str] = {
    "force_over_cycle": "force_over_cycle",
    "run_up": "run_up",
    "transmissibility": "transmissibility",
    "modal_energy": "modal_energy",
    "piston_motion": "piston_motion",
    "optimisation": "start_and_optimum",
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


def draw(result: Result, folder: Path) -> list[Path]:
    """Draw every picture that the result has the numbers for.

    Files are `<case>_<picture>.png` in `folder`, which is made if it is missing. Equal results
    give equal bytes with one version of matplotlib.

    Raises
    ------
    UsageError
        matplotlib is not installed, or the folder cannot be written.
    """
    matplotlib = _matplotlib()
    written = []
    with matplotlib.rc_context(STYLE):
        for name in PICTURES:
            figure = make(result, name)
            if figure is None:
                continue
            path = Path(folder) / f"{result.name}_{name}.png"
            try:
                path.parent.mkdir(parents=True, exist_ok=True)
                figure.savefig(path, dpi=_RESOLUTION, metadata={"Software": None})
            except OSError as error:
                raise UsageError(f"cannot write the picture {path}: {error.strerror}") from error
            written.append(path)
    return written


def make(result: Result, name: str) -> "Figure | None":
    """One figure by its name in `PICTURES`, None if the result lacks the numbers for it."""
    module = import_module(f"vibecalc.report.pictures.{PICTURES[name]}")
    picture: Callable[[Result], Figure | None] = module.picture
    return picture(result)


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

"""Pictures of a result, written as PNG files. matplotlib is imported here, when it is asked for."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibecalc.errors import UsageError
from vibecalc.report.sweep.view import SweepView
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
    "piston_acceleration": "piston_acceleration",
    "mode_shapes": "mode_shapes",
    "energy_by_order": "energy_by_order",
    "operations": "operations",
    "response_run_up": "response_run_up",
    "switching": "switching",
    "impact_clearance": "impact_clearance",
    "impact_time": "impact_time",
    "impact_spectrum": "impact_spectrum",
    "dominance": "dominance",
    "motor_force": "motor_force",
    "roll_levels": "roll_levels",
    "roll_cycle": "roll_cycle",
    "roll_sensitivity": "roll_sensitivity",
    "roll_control": "roll_control",
    "roll_motor_gain": "roll_motor_gain",
    "roll_locus": "roll_locus",
    "roll_start_up": "roll_start_up",
    "motor_curve": "dynamic_motor",
    "engine_mounts": "engine_mounts",
    "measured_levels": "measured_levels",
    "plate_map": "plate_map",
    "absorber_curves": "absorber_curves",
    "absorber_surface": "absorber_surface",
    "absorber_map": "absorber_map",
    "absorber_chart": "absorber_chart",
    "absorber_warming": "absorber_warming",
    "pendulum": "pendulum",
    "torsion_excitation": "torsion_excitation",
    "torsion_shapes": "torsion_shapes",
    "torsion_campbell": "torsion_campbell",
    "torsion_speeds": "torsion_speeds",
    "torsion_orders": "torsion_orders",
    "torsion_vectors": "torsion_vectors",
    "torsion_transient": "torsion_transient",
    "torsion_waterfall": "torsion_waterfall",
    "torsion_dampers": "torsion_dampers",
    "torsion_variable_inertia": "torsion_variable_inertia",
    "damper_map": "damper_map",
    "damper_response": "damper_response",
    "pareto": "pareto",
    "optimisation": "start_and_optimum",
}

#: The same for sweeps; each has `picture(sweep) -> Figure | None`.
SWEEP_PICTURES = ("sweep_line", "sweep_map", "sweep_sample")

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
    return _drawn(stem, ((name, make(result, name)) for name in PICTURES), folder)


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
    from vibecalc.results.sweep_file import is_sweep, open_sweep

    if is_sweep(path):
        from vibecalc.report.sweep.opened import view_of

        with open_sweep(path) as opened:
            return draw_sweep(view_of(opened), folder, path.stem.removesuffix(".sweep"))
    from vibecalc.results.accuracy_layout import is_accuracy
    from vibecalc.results.store import read_result

    result = read_result(path)
    if is_accuracy(result):
        return draw_accuracy(result, folder / f"{path.stem}.png")
    return draw(result, folder, path.stem)


def draw_accuracy(result: Result, path: Path) -> list[Path]:
    """The one picture of a measurement of methods, if it has any; UsageError as for the others."""
    from vibecalc.report.pictures.accuracy import picture

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
    from vibecalc.results.files import write_atomically

    image = BytesIO()
    figure.savefig(image, format="png", dpi=_RESOLUTION, metadata={"Software": None})
    write_atomically(path, image.getvalue())


def make(result: Result, name: str) -> "Figure | None":
    """One figure by its name in `PICTURES`, None if the result lacks the numbers for it."""
    module = import_module(f"vibecalc.report.pictures.{PICTURES[name]}")
    picture: Callable[[Result], Figure | None] = module.picture
    return picture(result)


def make_sweep(sweep: SweepView, name: str) -> "Figure | None":
    """One figure of a sweep by its name in `SWEEP_PICTURES`, None if it does not suit the sweep."""
    module = import_module(f"vibecalc.report.pictures.{name}")
    picture: Callable[[SweepView], Figure | None] = module.picture
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

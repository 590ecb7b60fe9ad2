"""Pictures of a result as files: which there are and how they are written; that of methods."""

import math
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import partial
from io import BytesIO
from itertools import dropwhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.accuracy import TopicView, topics_of
from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, TOTAL, TYPE, canvas, panels_of
from vibecalc.core.report.curves import Curve, Curves, Mark, Panel, operating, usual_ends
from vibecalc.core.report.defects import failed_parts, survived
from vibecalc.core.report.sections import labels
from vibecalc.core.report.sweep.view import SweepView, view_of
from vibecalc.core.report.writing import fold
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.layout import is_accuracy
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Entry, Result
from vibecalc.core.results.sweep_file import SweepResult, opened
from vibecalc.core.results.trials import Trial
from vibecalc.core.run.stage import subjects, subjects_of
from vibecalc.errors import UsageError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Pictures of a result, written as files. matplotlib is imported here, when it is asked for.
# ----------------------------------------------------------------------------

#: Pictures of studies; each subject names its own. A picture is a function of the result, or a
#: `Curves`, which is called like one: `picture(result) -> Figure | None`.
OF_STUDIES: dict[str, str] = {
    "pareto": "vibecalc.core.report.study_pictures:draw_front",
    "optimisation": "vibecalc.core.report.study_pictures:draw_start_and_optimum",
    "combinations": "vibecalc.core.report.study_pictures:draw_combinations",
    "robust": "vibecalc.core.report.study_pictures:draw_robust",
    "fit": "vibecalc.core.report.fit_pictures:draw_fit",
}

#: The same for sweeps; each has `picture(sweep) -> Figure | None`.
SWEEP_PICTURES: dict[str, str] = {
    "sweep_line": "vibecalc.core.report.sweep.picture_lines:draw_sweep_line",
    "sweep_map": "vibecalc.core.report.sweep.picture_maps:draw_sweep_map",
    "sweep_sample": "vibecalc.core.report.sweep.picture_maps:draw_sweep_sample",
}

#: The one picture of a measurement of methods, which bears the name of its file alone.
OF_METHODS = {"accuracy": "vibecalc.core.report.plots:draw_accuracy"}

#: A font that matplotlib brings along, so that the same result gives the same picture anywhere.
STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "text.hinting": "none",  # as drawn by their designers; hints move them, and cost a third
    "font.size": TYPE,
    "axes.titlesize": 9.0,
    "axes.labelsize": TYPE,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.3,
    "lines.markersize": 5.0,
    "legend.fancybox": False,  # a plate, so that words are readable over lines
    "legend.edgecolor": "none",
    "legend.framealpha": 0.85,
    "axes.titley": 1.0,  # where titles stand anyway: else it is looked for, with all ticks, again
    "svg.hashsalt": "vibecalc",
    "pdf.fonttype": 42,
}
#: what is drawn: a file, or what was computed or read
Source = Path | Result

_RESOLUTION = 200
_DPI = (50, 1200)
#: formats, and what a file would say of the time and the versions that made it
_SILENT: dict[str, dict[str, None]] = {
    "png": {},
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


@dataclass(frozen=True)
class Look:
    """How pictures are written: formats, dots in an inch of png, which, and with a title or not."""

    formats: tuple[str, ...] = ("png",)
    dpi: int | None = None
    #: names of pictures; all without one
    only: tuple[str, ...] = ()
    title: bool = True


def look_of(formats: str, dpi: int | None, only: Sequence[str], title: bool) -> Look:
    """What is asked for on the command line; UsageError for what is not to be had."""
    names = tuple(dict.fromkeys(name.strip().lower() for name in formats.split(",")))
    for name in names:
        if name not in _SILENT:
            raise UsageError(
                f"--format {formats}: pictures are written as {', '.join(_SILENT)}, found {name!r}"
            )
    if dpi is not None and not _DPI[0] <= dpi <= _DPI[1]:
        raise UsageError(f"--dpi needs a number from {_DPI[0]} to {_DPI[1]}, found {dpi}")
    pictures = (name.strip() for given in only for name in given.split(","))
    return Look(names, dpi, tuple(dict.fromkeys(pictures)), title)


def draw_files(
    sources: Sequence[Source], folder: Path | None, look: Look = Look()
) -> Iterator[tuple[Source, list[Path]]]:
    """Draw files next to themselves or into `folder`; yields each with its pictures, maybe none.

    Results that are no files go into the folder of theirs, or the current one.

    Raises UsageError, before anything is written, where two files would write the same pictures or
    none has a picture that is asked for.
    """
    paths = (source if isinstance(source, Path) else source.swept for source in sources)
    homes = [(folder or (path.parent if path else Path()), _stem(source))
             for source, path in zip(sources, paths, strict=True)]  # fmt: skip
    for number, (source, home) in enumerate(zip(sources, homes, strict=True)):
        if home in homes[:number]:
            raise UsageError(
                f"the pictures of {sources[homes.index(home)]} and {source} would have the same "
                f"names in {home[0]}; draw them into two folders, with -o"
            )
    if look.only:
        _refuse_unknown(sources, look)
    written: set[Path] = set()
    for source, (target, _) in zip(sources, homes, strict=True):
        yield source, draw_file(source, target, look, written)


def draw_file(
    of: Source, folder: Path, look: Look = Look(), written: set[Path] | None = None
) -> list[Path]:
    """Draw a file or a result, be it of a run, a sweep or methods, all that it has numbers for.

    Files are `<stem>_<picture>.png` in `folder`, which is made if it is missing; `stem` is that of
    the file, or the name of the case; words of it are not repeated, but for the last one. Equal
    results give equal bytes with one version of matplotlib. `written` are pictures of the same
    call, which are not overwritten.

    Raises
    ------
    UsageError
        matplotlib is not installed, or the folder cannot be written.
    ResultError
        The file cannot be read.
    """
    names, made = _figures(of, look)
    stem = _stem(of).removesuffix("_sweep") if names is SWEEP_PICTURES else _stem(of)
    files: list[Path] = []
    before = set() if written is None else written
    for name, figure in made:
        if not look.title:
            figure.suptitle("").set_in_layout(False)
        for form in look.formats:
            path = Path(folder) / f"{_file_name(stem, name, names)}.{form}"
            if path in before:
                raise UsageError(
                    f"two results have a picture {path.name}; draw them into two folders, with -o"
                )
            save = partial(_save, figure, path, form, look.dpi or _RESOLUTION)
            if survived(f"the picture {name}", save) is not None:
                before.add(path)
                files.append(path)
    return files


def _stem(of: Source) -> str:
    """What the names of pictures begin with."""
    if isinstance(of, Path):
        return of.stem.removesuffix(".sweep")
    if of.swept is not None:
        return _stem(of.swept)
    return f"{of.name}.accuracy" if is_accuracy(of) else of.name


def _figures(of: Source, look: Look) -> tuple[Iterable[str], list[tuple[str, "Figure"]]]:
    """Names of the pictures that a file or result may have, and those that it has of them."""
    with opened(of) as found:
        if isinstance(found, SweepResult):
            return SWEEP_PICTURES, list(_made(SWEEP_PICTURES, view_of(found), look))
        names = OF_METHODS if is_accuracy(found) else pictures_of(found)
        return names, list(_made(names, found, look))


def vector_pictures(of: Source) -> Iterator[tuple[str, bytes]]:
    """Title of every picture of a file or result, and the picture as SVG without it."""
    for name, figure in _figures(of, Look())[1]:
        made = survived(f"the picture {name}", partial(as_vector, figure))
        if made is not None:
            yield made


def vector_picture(maker: Callable[[], "Figure | None"]) -> tuple[str, bytes] | None:
    """The same of one picture, None where there is none."""
    with _matplotlib().rc_context(STYLE):
        figure = maker()
    return None if figure is None else as_vector(figure)


def as_vector(figure: "Figure") -> tuple[str, bytes]:
    """Title of a picture, and the picture as SVG without it."""
    title = " ".join(figure.get_suptitle().split())
    figure.suptitle("").set_in_layout(False)
    return title, _image(figure, "svg", _RESOLUTION)


def _made(names: Iterable[str], of: Any, look: Look) -> Iterator[tuple[str, "Figure"]]:
    for name in (one for one in names if not look.only or one in look.only):
        with _matplotlib().rc_context(STYLE):
            figure = survived(f"the picture {name}", partial(make, of, name))
        if figure is not None:
            yield name, figure


def _refuse_unknown(sources: Sequence[Source], look: Look) -> None:
    every = replace(look, only=())
    found = {name for source in sources for name, _ in _figures(source, look)[1]}
    missing = [name for name in look.only if name not in found]
    if not missing or failed_parts():  # one that fails is there, and drawing says why it is not
        return
    has = dict.fromkeys(name for source in sources for name, _ in _figures(source, every)[1])
    near = get_close_matches(missing[0][:60], has, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    none = f"{sources[0]} has no" if len(sources) == 1 else "none of the results has a"
    there = f"there are: {', '.join(has) or 'none'}"
    raise UsageError(f"--only {missing[0]}: {none} picture of this name{hint}; {there}")


def _file_name(stem: str, name: str, names: Iterable[str]) -> str:
    """`roll_levels` for `roll_levels` of `roll`, `gear_test_time` for `test_time` of `gear_test`.

    A name keeps its last word, and all of them if another would lose its difference to it.
    """
    if name in OF_METHODS:
        return stem
    said = stem.split("_")

    def short(one: str) -> str:
        *first, last = one.split("_")
        return "_".join([*dropwhile(said.__contains__, first), last])

    every = [short(one) for one in (name, *names)]
    alone = every.count(every[0]) == 1 + (name in names)
    return f"{stem}_{every[0] if alone else name}"


def _save(figure: "Figure", path: Path, form: str, dpi: int) -> Path:
    from vibecalc.core.results.files import write_atomically

    write_atomically(path, _image(figure, form, dpi))
    return path


def _image(figure: "Figure", form: str, dpi: int) -> bytes:
    from vibecalc.core.report.paper import lay_out

    with _matplotlib().rc_context(STYLE):
        lay_out(figure, dpi)
        if form == "png":
            return png(figure, dpi)
        image = BytesIO()
        figure.savefig(image, format=form, dpi=dpi, metadata=_SILENT[form])
        return image.getvalue()


#: from 1, quick, to 9, small: 6 takes twice the time of 3 for a tenth of the size
_PACKED = 3


def png(figure: "Figure", dpi: int) -> bytes:
    """A figure as a png file (ISO/IEC 15948): rows of red, green, blue, which nothing filters.

    Curves on white paper are smaller so, and packed in a third of the time, than with the filters
    that Pillow tries on every row.
    """
    canvas: Any = figure.canvas
    canvas.draw()
    colours = np.asarray(canvas.buffer_rgba())[..., :3]
    high, wide, _ = colours.shape
    rows = np.zeros((high, 1 + 3 * wide), np.uint8)  # each begins with its filter: none
    rows[:, 1:].reshape(high, wide, 3)[...] = colours
    dots = round(dpi / 0.0254)
    chunks = (
        (b"IHDR", struct.pack(">IIBBBBB", wide, high, 8, 2, 0, 0, 0)),
        (b"pHYs", struct.pack(">IIB", dots, dots, 1)),
        (b"IDAT", zlib.compress(rows.data, _PACKED)),
        (b"IEND", b""),
    )
    image = b"\x89PNG\r\n\x1a\n"
    for name, data in chunks:
        check = struct.pack(">I", zlib.crc32(name + data))
        image += struct.pack(">I", len(data)) + name + data + check
    return image


def named_curves() -> dict[str, Curves]:
    """A picture for each `curve` of the catalogue: a panel for each of its results."""
    panels: dict[str, list[Panel]] = {}
    for one in CATALOGUE.values():
        if one.curve:
            panels.setdefault(one.curve, []).append(_panel_of(one))
    return {name: Curves(name.replace("_", " "), tuple(each)) for name, each in panels.items()}


def _panel_of(one: Entry) -> Panel:
    label = one.name or one.path.rpartition("/")[2].replace("_", " ")
    parts: tuple[Mark, ...] = (Curve(one.path, partial(_each, one.path)),)
    parts += (operating,) if one.axes[-1] == "speed" else ()
    beside = {"loc": "upper left", "bbox_to_anchor": (1.005, 1.0)}
    return Panel(label, parts, one.long_name, ends=usual_ends, legend=beside)


def _each(path: str, result: Result) -> str:
    """Where to write the names of the entries: numbers stand with what they count."""
    quantity = result.record[path]
    numbers = len(quantity.axes) > 1 and all(map(str.isdigit, labels(quantity.axes[0])))
    return "{each}" if numbers else "{}"


def every_picture() -> dict[str, str | Curves]:
    """Pictures of all subjects, of curves that the catalogue names, and of studies by name."""
    found: dict[str, str | Curves] = {}
    for subject in subjects().values():
        found |= subject.pictures
    return found | named_curves() | OF_STUDIES


def pictures_of(result: Result) -> dict[str, str | Curves]:
    """Those of the subjects and curves that a result has quantities of, and of studies."""
    there = {CATALOGUE[path].curve for path in result.record if path in CATALOGUE}
    there |= {name for one in subjects_of(result.record) for name in one.pictures}
    every = every_picture()
    return {name: every[name] for name in every if name in there or name in OF_STUDIES}


def make(of: Result | SweepView, name: str) -> "Figure | None":
    """One figure of a result or a sweep by its name, None if it lacks the numbers for it."""
    picture = (every_picture() | SWEEP_PICTURES | OF_METHODS)[name]
    draw: Callable[..., Figure | None] = named(picture) if isinstance(picture, str) else picture
    return draw(of)


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


# ----------------------------------------------------------------------------
# Error against seconds: a panel for each topic, a line for each method.
# ----------------------------------------------------------------------------

_ACROSS = 2
#: more methods than these are named next to the panel
_INSIDE = 5
_MARKERS = ("o", "s", "^", "D", "v", "P")
#: more methods than `COLOURS` are distinguished in a topic
_MANY = (*COLOURS, "#332288", "#AA4499", "#882255", "#999933", "#117733", "#661100")


def draw_accuracy(result: Result) -> "Figure | None":
    """Log-log panels of worst relative error over seconds, None for a result of another kind.

    The front in seconds is filled, what vibecalc takes is ringed, failed settings are crosses on
    the upper edge, at the seconds that the failure took.
    """
    if not is_accuracy(result):
        return None
    topics = topics_of(result)
    across = min(_ACROSS, len(topics))
    widest = max(len(topic.methods) for topic in topics)
    legend = 0.0 if widest <= _INSIDE or across == 1 else 0.21 * widest
    high = 1.2 + (3.6 + legend) * -(-len(topics) // across)
    figure = canvas(result, "accuracy and time of the methods", high)
    panels = panels_of(figure, len(topics), across)
    for axes, topic in zip(panels, topics, strict=True):
        _panel(axes, topic, nearby=across == 1)
    ring, dot = {"mfc": "none", "color": TOTAL, "ls": "none"}, {"color": QUIET, "ls": "none"}
    figure.legend(
        loc="outside lower center", ncols=2,
        handles=[*panels[0].plot([], [], "o", label="fastest of its accuracy", **dot),
                 *panels[0].plot([], [], "o", ms=10, mew=1.4, label="default of vibecalc", **ring),
                 *panels[0].plot([], [], "v", label="at the bottom: zero error", **dot),
                 *panels[0].plot([], [], ":", color=LIMIT, label="error of the reference itself")],
    )  # fmt: skip
    return figure


def _panel(axes: "Axes", topic: TopicView, nearby: bool) -> None:
    timed = [trial for trial in topic.trials if 0.0 < trial.seconds < math.inf]
    done = [trial for trial in timed if trial.done]
    low, top = _span([_height(one) for one in done if one.worst_relative > 0.0] or [1.0], 2.0)
    axes.set(
        xscale="log", yscale="log", xlabel="seconds", ylabel="worst relative error",
        xlim=_span([trial.seconds for trial in timed] or [1.0], 1.0), ylim=(low, top),
        title="\n".join(fold(f"{topic.words['stage']}: {topic.words['name']}", 44)),
    )  # fmt: skip
    axes.minorticks_off()

    def dots(trials: Iterable[Trial], height: float | None = None, **style: Any) -> None:
        """Each at its error, or all at one height."""
        points = [(one.seconds, _height(one) if height is None else height)
                  for one in trials]  # fmt: skip
        if points or "label" in style:  # an empty line that is not clipped takes room at the corner
            axes.plot(*zip(*points, strict=True) if points else ([], []), **{"ls": "none", **style})

    for place, method in enumerate(topic.methods):
        own = [trial for trial in timed if trial.method == method["method"]]
        measured = [trial for trial in own if trial.done]
        alone: dict[str, Any] = {"color": _MANY[place % len(_MANY)]}
        style = {"marker": _MARKERS[place % len(_MARKERS)], "ms": 5, **alone}
        line = "-" if place < len(COLOURS) else "--"
        dots(measured, ls=line, lw=1.2, mfc="white", label=method["method"], **style)
        dots((one for one in measured if one.front_in_seconds), **style)
        exact = (one for one in measured if one.worst_relative == 0.0)
        dots(exact, low, marker="v", ms=6, clip_on=False, **alone)
        failed = (one for one in own if not one.done)
        dots(failed, top, marker="x", ms=7, clip_on=False, **alone)
    default = (one for one in done if one.is_default)
    dots(default, marker="o", color=TOTAL, mfc="none", ms=12, mew=1.4)
    if topic.agreement > low:
        axes.axhline(topic.agreement, color=LIMIT, linestyle=":", linewidth=1.0)
    inside: dict[str, Any] = {"loc": "best"}
    if len(topic.methods) > _INSIDE:
        inside = {"loc": "center left", "bbox_to_anchor": (1.01, 0.5)}
        inside = inside if nearby else {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2)}
    axes.legend(**inside)


def _height(trial: Trial) -> float:
    """The error, a gap where there is none."""
    return (trial.worst_relative or math.nan) if math.isfinite(trial.worst_relative) else 1.0


def _span(values: Sequence[float], decades: float) -> tuple[float, float]:
    """Ends of an axis around the values, at least so many decades apart."""
    low, high = math.log10(min(values)) - 0.3, math.log10(max(values)) + 0.3
    more = max(0.5 * (decades - (high - low)), 0.0)
    return 10.0 ** (low - more), 10.0 ** (high + more)

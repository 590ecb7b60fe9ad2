"""What is said of each golden result: its report, what `check --json` prints, titles of pictures.

    python tests/snapshots/said.py [NAME...]

writes `NAME.txt`, `NAME.check.json` and `NAME.pictures.txt` next to this file, of all golden files
without a name. All of it comes from the golden file and the case; nothing is computed again, so
that the words are the same wherever they are made.
"""

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibecalc.core.report import plots
from vibecalc.core.report.check import check_rows, plan_object
from vibecalc.core.report.sweep.text import report_file
from vibecalc.core.report.sweep.view import view_of
from vibecalc.core.results.store import read_result
from vibecalc.core.results.sweep_file import is_sweep, open_sweep
from vibecalc.core.study.execute import load_checked

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
GOLDEN = ROOT / "tests" / "golden"
NAMES = tuple(path.stem for path in sorted(GOLDEN.glob("*.h5")))


def report(name: str) -> str:
    """The report of a golden file; it has no provenance."""
    return report_file(GOLDEN / f"{name}.h5")


def check(name: str) -> str:
    """What `check --json` prints of the case of a golden file, without its hash."""
    path = ROOT / "cases" / f"{name.removesuffix('.sweep')}.toml"
    (loaded,) = load_checked([path])
    said = plan_object(loaded, *check_rows(loaded.case))
    said["case"] = path.name
    del said["sha256"]  # it follows the version of the program; test_golden.py holds it
    return json.dumps(_short(said), indent=1, ensure_ascii=False) + "\n"


def pictures(name: str) -> str:
    """Name, size, titles, labels and legend of each picture of a golden file, else its words."""
    import matplotlib

    with matplotlib.rc_context(plots.STYLE):
        return "".join(f"{line}\n" for line in _pictures(GOLDEN / f"{name}.h5"))


PARTS: dict[str, Callable[[str], str]] = {
    ".txt": report,
    ".check.json": check,
    ".pictures.txt": pictures,
}


def _pictures(path: Path) -> Iterator[str]:
    if is_sweep(path):
        with open_sweep(path) as opened:
            view = view_of(opened)
            for name in plots.SWEEP_PICTURES:
                yield from _picture(name, plots.make(view, name))
        return
    result = read_result(path)
    for name in plots.pictures_of(result):
        yield from _picture(name, plots.make(result, name))


def _picture(name: str, figure: "Figure | None") -> Iterator[str]:
    if figure is None:
        return
    wide, high = figure.get_size_inches()
    title = getattr(figure, "_suptitle", None)
    yield f"{name} {wide:g} x {high:g}" + ("" if title is None else f" {_line(title.get_text())}")
    for axes in figure.axes:
        yield f"  {_words(axes)}"


def _words(axes: "Axes") -> str:
    legend = axes.get_legend()
    names = [] if legend is None else [_line(text.get_text()) for text in legend.get_texts()]
    titles = [axes.get_title(loc=place) for place in ("left", "center", "right")]
    # what has neither says by words in the picture what is drawn
    told = [] if any(titles) or names else [text.get_text() for text in axes.texts]
    words = [*titles, axes.get_xlabel(), axes.get_ylabel(), *names, *map(_line, told)]
    return " | ".join(_line(word) for word in words if word) or "(no words)"


def _line(text: str) -> str:
    return " / ".join(text.split("\n"))


def _short(value: Any) -> Any:
    """Numbers to four digits, which no rounding of a sum moves."""
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, dict):
        return {key: _short(one) for key, one in value.items()}
    return [_short(one) for one in value] if isinstance(value, list | tuple) else value


def main(names: list[str]) -> int:
    for name in names or NAMES:
        for ending, text_of in PARTS.items():
            (HERE / f"{name}{ending}").write_text(text_of(name), encoding="utf-8")
    known = {f"{name}{ending}" for name in NAMES for ending in PARTS}
    for path in HERE.iterdir():
        if path.suffix in (".txt", ".json") and path.name not in known:
            path.unlink()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

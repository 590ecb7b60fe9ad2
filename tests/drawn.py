"""Pictures as tests look at them: a figure, its words and lines, whether its parts keep apart."""

from typing import Any

import pytest

from vibecalc.core.report.plots import STYLE, make
from vibecalc.core.results.record import Result


def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is not their looks: pictures of few points, with no room made for their words."""
    monkeypatch.setattr("vibecalc.core.report.plots._RESOLUTION", 20)
    room = "matplotlib.layout_engine.ConstrainedLayoutEngine.execute"
    monkeypatch.setattr(room, lambda _engine, _figure: None)


def figure(result: Result, name: str) -> Any:
    """The picture of a name, which the result has to have."""
    import matplotlib

    with matplotlib.rc_context(STYLE):
        made = make(result, name)
    assert made is not None
    return made


def words(axes: Any) -> str:
    """All that is written into axes."""
    return " ".join(text.get_text() for text in axes.texts)


def lines(axes: Any) -> dict[str, Any]:
    """Lines of axes by their labels."""
    return {line.get_label(): line for line in axes.get_lines()}


def assert_apart(made: Any) -> None:
    """Axes with their letters lie on the page and not on each other, as files are laid out."""
    from vibecalc.core.report.paper import lay_out

    lay_out(made, 200)
    made.canvas.draw()
    renderer = made.canvas.get_renderer()
    width = made.bbox.width
    assert abs(width - 1260.0) < 1.0
    boxes = [axes.get_tightbbox(renderer) for axes in made.axes if axes.get_visible()]
    for i, box in enumerate(boxes):
        assert box.x0 >= -2.0 and box.x1 <= width + 2.0
        for other in boxes[i + 1 :]:
            assert not (
                min(box.x1, other.x1) - max(box.x0, other.x0) > 1.0
                and min(box.y1, other.y1) - max(box.y0, other.y0) > 1.0
            )

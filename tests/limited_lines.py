"""Shaft lines with limits, as texts that are run."""

from pathlib import Path

from vibecalc.core.results.record import Result
from vibecalc.core.study.execute import execute, load_checked

CRANK = (
    'crank = { pin_diameter = "70 mm", journal_diameter = "80 mm", web_thickness = "25 mm", '
    'web_width = "110 mm", pin_fillet = "4 mm", journal_fillet = "4 mm" }'
)


def ran(text: str, tmp_path: Path) -> Result:
    path = tmp_path / "line.toml"
    path.write_text(text, encoding="utf-8")
    (loaded,) = load_checked([path])
    return execute(loaded)

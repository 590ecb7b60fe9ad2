"""The cells of docs/tutorial_python.ipynb, run as a notebook runs them.

    python tests/notebook.py

runs them and stores what they print and draw in the notebook.
"""

import base64
import contextlib
import io
import json
import os
import tempfile
from pathlib import Path
from typing import Any

import matplotlib

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOK = ROOT / "docs" / "tutorial_python.ipynb"


def read() -> dict[str, Any]:
    """The notebook as it is stored."""
    notebook: dict[str, Any] = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    return notebook


def cells() -> list[dict[str, Any]]:
    """Its cells of code."""
    return [cell for cell in read()["cells"] if cell["cell_type"] == "code"]


def run(cell: dict[str, Any], names: dict[str, object]) -> list[dict[str, Any]]:
    """Outputs of a cell: what it prints, and the figures that it leaves open."""
    from matplotlib import pyplot

    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec("".join(cell["source"]), names)
    outputs: list[dict[str, Any]] = []
    if out.getvalue():
        lines = out.getvalue().splitlines(keepends=True)
        outputs.append({"name": "stdout", "output_type": "stream", "text": lines})
    for number in pyplot.get_fignums():
        image = io.BytesIO()
        figure = pyplot.figure(number)
        figure.savefig(image, format="png", metadata={"Software": None})
        data = {
            "image/png": base64.b64encode(image.getvalue()).decode(),
            "text/plain": [f"<Figure with {len(figure.axes)} Axes>"],
        }
        outputs.append({"data": data, "metadata": {}, "output_type": "display_data"})
        pyplot.close(figure)
    return outputs


@contextlib.contextmanager
def in_folder(folder: Path) -> Any:
    """A folder that looks to the cells as `docs` does."""
    (folder / "cases").symlink_to(ROOT / "cases")
    (folder / "docs").mkdir()
    with contextlib.chdir(folder / "docs"):
        yield


def store() -> None:
    """Run all cells and write the notebook with what comes out."""
    notebook = read()
    names: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder, in_folder(Path(folder)):
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                cell["outputs"], cell["execution_count"] = run(cell, names), None
    text = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
    NOTEBOOK.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    os.environ["MPLBACKEND"] = "agg"
    matplotlib.use("agg")
    store()

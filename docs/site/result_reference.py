"""The reference of results, from the catalogue: path, unit, axes, amplitude, what it is."""

from importlib import import_module

from page_parts import cell, code, table, toctree

from vibecalc.core.results.catalogue import AXES, CATALOGUE, OWNER
from vibecalc.subjects import SUBJECTS

_HEADS = ("path, and what it is", "axes", "unit", "amplitude")
#: folders of subjects whose names are not the words of the field
_TITLES = {
    "body": "Body of parts",
    "balance": "Balance",
    "roll": "Roll: rotor, pistons and shell",
    "response": "Response of the body",
    "torsion": "Torsional vibration of shaft lines",
    "points": "Vibration at named points",
    "isolation": "Body on its mounts",
    "impact": "Impacts in joints with play",
    "absorber": "Absorbers, their hardware, pendulums",
    "bearings": "Bearing loads",
}


def pages() -> dict[str, str]:
    """Markdown of every page by its name; `index` leads to the others."""
    made = {subject: _page(subject) for subject in SUBJECTS if subject in OWNER.values()}
    made["index"] = _index(list(made))
    return made


def _page(subject: str) -> str:
    title = _TITLES.get(subject, subject.replace("_", " ").capitalize())
    about = " ".join((import_module(f"vibecalc.{subject}").__doc__ or "").split())
    rows = [
        [
            f"{code(path)}<br>{cell(one.long_name)}",
            ", ".join(map(code, one.axes)),
            code(one.unit),
            one.amplitude or "",
        ]
        for path, one in CATALOGUE.items()
        if OWNER[path] == subject
    ]
    return f"# {title}\n\n{about} {_HOW}\n\n{table(_HEADS, rows)}\n"


_HOW = (
    "The path is the name of a result in files, limits, references and on the command line "
    "(`vibecalc get RESULT.h5 PATH`); numbers in files are in this unit."
)


def _index(names: list[str]) -> str:
    axes = table(
        ("axis", "unit", "what its entries are"),
        ([code(name), code(unit), cell(words)] for name, (unit, words) in sorted(AXES.items())),
    )
    return f"""# List of results

Every result that a run may give, by subject: its path, unit, axes and kind of amplitude (`0-pk`:
zero to peak; `rms`; none where it is no oscillation). Which of them a file holds follows from the
tables of its case: `vibecalc info RESULT.h5` lists them. Results of studies stand with these:
[searches, fits, optimisation](../../searches.md).

{toctree(names)}

## Axes

Results with axes are arrays; an entry is picked by `where = {{ mount = "1" }}` in a case and by
`--where mount=1` in `vibecalc get`.

{axes}
"""

"""Claim: imports go down the floors of docs/architecture.md, and files keep their size."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "vibecalc"

FLOORS = {
    "errors": 0, "units": 0, "unit_table": 0, "numerics": 0,
    "case": 1, "kinematics": 1, "excitation": 1, "response": 1, "isolation": 1, "optimisation": 1,
    "measurement": 1, "hardware": 1,
    "machine": 2, "results": 2,
    "pipeline": 3,
    "study": 4,
    "report": 5, "accuracy": 5,
    "cli": 6, "cli_sweep": 6, "cli_accuracy": 6, "__main__": 6,
}  # fmt: skip
STAGES = (
    "kinematics", "excitation", "response", "isolation", "optimisation", "measurement", "hardware",
)  # fmt: skip
FILES = sorted(PACKAGE.rglob("*.py"))
HEAVY = {"numpy", "scipy", "h5py", "pint", "matplotlib", "pydantic", "rich"}


def room_of(path: Path) -> str:
    relative = path.relative_to(PACKAGE)
    return relative.parts[0].removesuffix(".py")


def imported_modules(path: Path, top_level_only: bool = False) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = tree.body if top_level_only else ast.walk(tree)
    names: set[str] = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def rooms_imported(path: Path) -> set[str]:
    parts = (name.split(".") for name in imported_modules(path))
    return {p[1] for p in parts if p[0] == "vibecalc" and len(p) > 1 and p[1] in FLOORS}


def allowed(room: str, other: str) -> bool:
    if room == other:
        return True
    if FLOORS[other] != FLOORS[room]:
        return FLOORS[other] < FLOORS[room]
    if room in STAGES and other in STAGES:
        return STAGES.index(other) < STAGES.index(room)
    # floor 2 and 5 do not look sideways; the door of floor 6 opens on its commands
    commands = (("cli", "cli_sweep"), ("cli", "cli_accuracy"))
    return FLOORS[room] == 0 or room == "__main__" or (room, other) in commands


def test_every_room_has_a_floor() -> None:
    rooms = {room_of(path) for path in FILES} - {"__init__"}
    assert rooms == set(FLOORS)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_go_down_only(path: Path) -> None:
    room = room_of(path)
    if room == "__init__":
        assert not imported_modules(path)
        return
    wrong = sorted(other for other in rooms_imported(path) if not allowed(room, other))
    assert not wrong, f"{path.relative_to(PACKAGE)} (floor {FLOORS[room]}) imports {wrong}"


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_files_stay_small(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 300


def test_package_inits_hold_a_docstring_only() -> None:
    for path in PACKAGE.rglob("__init__.py"):
        body = ast.parse(path.read_text(encoding="utf-8")).body
        assert ast.get_docstring(ast.Module(body, [])), path
        assert all(isinstance(node, ast.Assign) for node in body[1:]), path


def test_heavy_modules_are_not_imported_at_the_top_of_light_rooms() -> None:
    for path in FILES:
        if room_of(path) in ("errors", "units", "cli", "cli_sweep", "cli_accuracy", "__main__"):
            roots = {name.split(".")[0] for name in imported_modules(path, top_level_only=True)}
            assert not roots & HEAVY, path
    for path in FILES:
        roots = {name.split(".")[0] for name in imported_modules(path, top_level_only=True)}
        assert not roots & {"scipy", "pint", "matplotlib"}, path


def test_architecture_document_names_every_room() -> None:
    text = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    missing = [room for room in FLOORS if f"`{room}/`" not in text and f"`{room}.py`" not in text]
    assert not missing

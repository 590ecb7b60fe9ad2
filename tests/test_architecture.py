"""Claim: imports go as docs/architecture.md says, in no circle; the frame names no subject."""

import ast
import re
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

import vibecalc
from vibecalc.subjects import SUBJECTS

PACKAGE = Path(__file__).resolve().parents[1] / "vibecalc"
FILES = sorted(PACKAGE.rglob("*.py"))
#: what each room may import besides itself; "subjects" are the folders of SUBJECTS
LOW = {"errors", "interrupts", "units", "unit_table", "numerics", "subjects.py"}
FRAME = LOW | {"core/case", "core/results", "core/run"}
CASE = {"schema", "kinds"}  # the root tables of a case and the kinds of machine
ALLOWED = {
    "errors": set(), "interrupts": set(), "unit_table": set(), "units": {"errors", "unit_table"},
    "unit_patterns": {"errors", "unit_table", "units"},
    "numerics": {"errors"}, "subjects.py": set(),
    "core/results": LOW,
    "core/case": FRAME | CASE,
    "core/run": FRAME | CASE | {"parts"},
    "parts": FRAME | CASE,
    "kinds": FRAME | CASE,
    "schema": FRAME | {"parts", "subjects"},
    "json_schema": FRAME | CASE | {"parts", "subjects", "unit_patterns"},
    "core/report": FRAME | CASE | {"core/study"},
    "core/study": FRAME | CASE | {"parts"},
    "core/accuracy": FRAME | CASE | {"core/study"},
    "cli": FRAME | {"core/report", "core/study", "core/accuracy", "json_schema"},
    "api": FRAME | {"core/report", "core/study", "core/accuracy", "cli"},
    "__main__": {"errors", "interrupts", "cli"},
}  # fmt: skip
#: of a subject: the frame with its views, the parts, and the subjects that its physics stands on
OF_A_SUBJECT = FRAME | CASE | {"parts", "core/report", "core/accuracy"}
STANDS_ON = {
    "body": set(),
    "kinematics": set(),
    "absorber": set(),
    "measurement": set(),
    "excitation": {"kinematics"},
    "impact": {"kinematics", "excitation", "response"},
    "roll": {"kinematics", "excitation"},
    "torsion": {"kinematics", "excitation"},
    # [response] holds the tables of roll, absorber and shaft line
    "response": {"kinematics", "excitation", "roll", "absorber", "torsion"},
    "isolation": {"kinematics", "excitation", "response", "torsion"},
    "points": {"kinematics", "excitation", "response", "isolation", "foundation"},
    "foundation": {"kinematics", "excitation", "isolation", "response"},
    "base_motion": {"isolation", "foundation", "points"},
    "balance": {"kinematics", "excitation"},
    "bearings": {"kinematics", "excitation"},
}
HEAVY = {"numpy", "scipy", "h5py", "pint", "matplotlib", "pydantic", "rich"}
#: a chapter can be read in one sitting
LONGEST = 700


def room_of(module: str) -> str:
    parts = module.split(".")[1:] or ["errors"]
    if parts[0] == "core":
        return "/".join(parts[:2]) if len(parts) > 1 else "errors"
    return "subjects.py" if parts[0] == "subjects" else parts[0]


#: a line that may begin an import, with what stands in its brackets; words in a text do not parse
IMPORT = re.compile(r"^([ \t]*)((?:import|from) [^\n(#]*(?:\([^)]*\))?)", re.MULTILINE)


@cache
def import_statements(path: Path) -> list[tuple[bool, ast.stmt]]:
    """Imports of a file, and whether each stands at its top level; a tree of it all takes long."""
    found = []
    for indent, words in IMPORT.findall(path.read_text(encoding="utf-8")):
        with suppress(SyntaxError):
            found.append((not indent, ast.parse(words).body[0]))
    return found


def imported(path: Path, top_level_only: bool = False) -> Iterator[str]:
    """Modules that a file imports, also those for type checkers; packages only by name."""
    for top_level, node in import_statements(path):
        if top_level_only and not top_level:
            continue
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            inside = [f"{node.module}.{alias.name}" for alias in node.names]
            yield from (one if one in MODULES else str(node.module) for one in inside)


def module_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path): path for path in FILES}


@cache
def edges() -> dict[str, set[str]]:
    """The modules of ours that each imports."""
    return {
        name: {one for one in imported(path) if one in MODULES} for name, path in MODULES.items()
    }


def test_rooms_import_what_they_may() -> None:
    wrong = []
    for name, others in edges().items():
        room = room_of(name)
        if room in SUBJECTS:
            allowed = OF_A_SUBJECT | STANDS_ON[room]
        else:
            allowed = set(ALLOWED[room])
            if "subjects" in allowed:
                allowed |= set(SUBJECTS)
        for other in others - {"vibecalc"}:
            if room_of(other) not in allowed | {room}:
                wrong.append(f"{name} imports {other}")
    assert not wrong, "\n".join(wrong)


def test_nothing_is_imported_in_a_circle() -> None:
    left = {name: set(others) - {name} for name, others in edges().items()}
    while True:
        ends = {name for name, others in left.items() if not others}
        if not ends:
            break
        left = {name: others - ends for name, others in left.items() if name not in ends}
    assert not left, sorted(left)


def test_subjects_stand_on_each_other_in_no_circle() -> None:
    assert set(STANDS_ON) == set(SUBJECTS)
    placed: set[str] = set()
    while len(placed) < len(STANDS_ON):
        fresh = {name for name, others in STANDS_ON.items() if others <= placed} - placed
        assert fresh, set(STANDS_ON) - placed
        placed |= fresh


def test_the_frame_names_no_subject() -> None:
    """Its only list is `subjects.py`; what a case may be is said by the root tables."""
    word = re.compile(rf"vibecalc[./]({'|'.join(SUBJECTS)})\b")
    for path in (PACKAGE / "core").rglob("*.py"):
        assert not word.search(path.read_text(encoding="utf-8")), path


def test_kernels_import_no_case_no_scene_and_no_report() -> None:
    for name, others in edges().items():
        parts = name.split(".")[1:] or [""]
        if parts[0] == "numerics" or (parts[0] in SUBJECTS and parts[1:2] and parts[1] in KERNELS):
            assert not {
                one for one in others if one.startswith(("vibecalc.core", "vibecalc.schema"))
            }


#: kernels: arrays in, arrays out
KERNELS = {
    "forced", "modes", "elimination", "holzer", "damped_modes", "poles", "network",
    "slider_crank", "harmonics",
    "minimax", "peaks", "transfer", "squared_magnitude", "rigid_body", "rows", "gas_force",
    "rod_angle", "truncated_series", "closed_forms", "modal", "band", "synthesis",
}  # fmt: skip


def test_chapters_can_be_read_in_one_sitting() -> None:
    for path in FILES:
        assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST, path


def test_package_inits_hold_a_docstring_only() -> None:
    for path in PACKAGE.rglob("__init__.py"):
        body = ast.parse(path.read_text(encoding="utf-8")).body
        assert ast.get_docstring(ast.Module(body, [])), path
        kinds = (ast.Assign, ast.FunctionDef) if path.parent == PACKAGE else ast.Assign
        assert all(isinstance(node, kinds) for node in body[1:]), path


def test_what_the_package_offers_is_there_and_typed() -> None:
    stub = (PACKAGE / "__init__.pyi").read_text(encoding="utf-8")
    assert sorted(re.findall(r" as (\w+)$", stub, re.M)) == sorted(vibecalc.__all__)
    for name in vibecalc.__all__:
        assert getattr(vibecalc, name).__name__ == name
    assert (PACKAGE / "py.typed").is_file()


def test_heavy_libraries_are_imported_where_they_are_used() -> None:
    for path in FILES:
        roots = {name.split(".")[0] for name in imported(path, top_level_only=True)}
        # what a figure is made of, imported where one is made
        own = {"matplotlib"} if path.name == "paper.py" else set()
        assert not roots & {"scipy", "pint", "matplotlib"} - own, path
        if room_of(module_of(path)) in ("errors", "units", "cli", "__main__"):
            assert not roots & HEAVY, path


def test_the_document_names_every_room() -> None:
    text = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    rooms = {room_of(name) for name in MODULES} - {"__main__", "__init__"}
    missing = [room for room in rooms if room.removesuffix(".py").split("/")[-1] not in text]
    assert not missing

"""The gallery: every shipped case with what it is and one or two pictures of its results.

Results are the golden files of tests/golden, which hold whole results; those of sweeps are in
outputs/, where `make sweep` has put them. What is missing is run.
"""

import re
import tomllib
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from page_parts import cell, code

ROOT = Path(__file__).resolve().parents[2]
CASES = (*sorted((ROOT / "cases").glob("*.toml")), *sorted((ROOT / "cases/gallery").glob("*.toml")))
#: pictures from those that only few cases have to those that many have: the first two are shown
TELLING = (
    *("pareto", "combinations", "robust", "fit", "optimisation"),
    *("damper_map", "damper_response", "worst_condition", "torsion_waterfall", "counted_cycles"),
    *(
        "torsion_variable_inertia",
        "torsion_as_published",
        "torsion_couplings",
        "cyclic_irregularity",
        "gear_torque",
    ),
    *("torsion_twists", "torsion_transient", "damping_over_speed", "torsion_curves"),
    *("engine_mounts", "torsion_campbell", "torsion_limits", "torsion_speeds", "torsion_vectors"),
    *("main_bearing_polar", "crank_pin_polar", "bearing_loads_over_speed", "torsion_shapes"),
    *("absorber_map", "absorber_surface", "absorber_chart", "absorber_warming", "pendulum"),
    *("absorber_motion", "absorber_curves", "plate_map", "record_orders", "measured_levels"),
    *("roll_locus", "roll_motor_gain", "roll_control", "roll_start_up", "motor_curve"),
    *("roll_sensitivity", "roll_levels", "roll_cycle", "impact_time", "impact_spectrum"),
    *("switching", "operations", "response_run_up", "energy_by_order", "base_spectrum"),
    *("base_transmissibility", "foundation", "points_run_up", "points_by_order", "mounts"),
    *("efficiency", "modal_energy", "run_up", "force_over_cycle", "transmissibility"),
    *("balance_orders", "balance_weights", "pistons_on_slave_rods", "motor_force"),
    *("turning_force", "shaking", "piston_motion"),
)
#: subject of a case by the first word of its name
_PARTS = {
    "generator": "Generator sets on mounts",
    "genset": "Generator sets on mounts",
    "four": "Balance of crank trains",
    "balance": "Balance of crank trains",
    "radial": "Balance of crank trains",
    "gallery": "Balance of crank trains",
    "engine": "Shaft lines: torsional vibration",
    "marine": "Shaft lines: torsional vibration",
    "absorber": "Absorbers and pendulums",
    "compressor": "Compressors on springs",
    "roll": "Roll of a compressor and its motor",
    "pump": "Pumps and their drives",
}
_DPI = 90


def result_of(case: Path) -> Path | None:
    """The file that holds the result of a case; None where there is none."""
    if case.stem.endswith("_sweep"):
        path = ROOT / "outputs" / f"{case.stem}.sweep.h5"
    else:
        path = ROOT / "tests" / "golden" / f"{case.stem}.h5"
    return path if path.is_file() and case.parent.name == "cases" else None


def draw(case: Path, target: Path) -> list[Path]:
    """The pictures of a case in `target`; drawn where they are older than result or program."""
    name, result = _name(case), result_of(case)
    there = sorted(target.glob(f"{name}--*.png"))
    sources = (result or case, *(ROOT / "vibecalc").rglob("*.py"), Path(__file__))
    newest = max(path.stat().st_mtime for path in sources)
    if there and min(path.stat().st_mtime for path in there) > newest:
        return there
    for path in there:
        path.unlink()
    folder = target / name
    drawn = [path.rename(target / f"{name}--{path.name}") for path in _draw(case, result, folder)]
    if folder.is_dir():
        for left in folder.iterdir():
            left.unlink()
        folder.rmdir()
    return drawn


def _draw(case: Path, path: Path | None, folder: Path) -> list[Path]:
    import vibecalc

    if case.stem.endswith("_sweep"):
        path = path or ROOT / "outputs" / f"{case.stem}.sweep.h5"
        if not path.is_file():
            vibecalc.sweep(case, path, jobs=1)
        return vibecalc.plot(path, folder, dpi=_DPI)[:2]
    result = vibecalc.run(case) if path is None else vibecalc.read(path)
    return vibecalc.plot(result, folder, only=list(_two(result)), dpi=_DPI)


def _two(result: object) -> Iterator[str]:
    """The two most telling pictures of a result."""
    import matplotlib

    from vibecalc.core.report.plots import STYLE, make, pictures_of

    shown = 0
    names = pictures_of(result)  # type: ignore[arg-type]
    with matplotlib.rc_context(STYLE):
        for name in dict.fromkeys((*TELLING, *names)):
            if shown < 2 and name in names and make(result, name) is not None:  # type: ignore[arg-type]
                shown += 1
                yield name


def _name(case: Path) -> str:
    return case.stem if case.parent.name == "cases" else f"{case.parent.name}_{case.stem}"


def page(target: Path, workers: int = 2) -> str:
    """Draw what is missing into `target`, and Markdown that shows it."""
    target.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(workers) as pool:
        drawn = list(pool.map(draw, CASES, [target] * len(CASES)))
    sections: dict[str, list[str]] = {part: [] for part in _PARTS.values()}
    for case, pictures in zip(CASES, drawn, strict=True):
        sections.setdefault(part_of(case), []).append(
            entry(case, [f"{target.name}/{path.name}" for path in pictures])
        )
    chapters = (f"## {part}\n\n" + "\n\n".join(entries) for part, entries in sections.items())
    return _HEAD + "\n\n".join(chapters) + "\n"


_HEAD = """# Gallery

Every case that is shipped in `cases/`, with pictures of its results. `vibecalc run cases/NAME.toml`
(of a sweep: `vibecalc sweep`) computes one, `vibecalc plot outputs/NAME.h5` draws all of its
pictures. A click on a picture enlarges it.

"""


def part_of(case: Path) -> str:
    """The chapter of the gallery that a case stands in."""
    word = "gallery" if case.parent.name == "gallery" else case.stem.split("_")[0]
    return _PARTS.get(word, "Other machines")


def entry(case: Path, pictures: list[str]) -> str:
    """A case: its title, the comment at its head, its pictures."""
    text = case.read_text(encoding="utf-8")
    title = tomllib.loads(text)["title"]
    path = case.relative_to(ROOT)
    images = " ".join(f'![{cell(title)}]({name}){{width="49%"}}' for name in pictures)
    words = f"{about(text)}\n\n" if about(text) else ""
    return f"### {cell(title)}\n\n{code(str(path))}\n\n{words}{images}"


def about(text: str) -> str:
    """The first sentence of the comment at the head of a case."""
    head = re.match(r"(?:#.*\n)+", text)
    lines = [line.removeprefix("#").strip() for line in head[0].splitlines()] if head else []
    words = " ".join(line for line in lines if not line.startswith(":schema"))
    return cell(re.split(r"(?<=[a-z)\d])\. ", words)[0])

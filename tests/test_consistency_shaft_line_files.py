"""Claim: a shaft line comes out of CSV files and of openTorsion's JSON as it went in.

CSV files as programs for spreadsheets write them give the case of the tables written out, and the
files that are written give it back bit for bit. What openTorsion reads in the JSON has the natural
frequencies of the case to 1e-12 and its receptance with all damping, by its own matrices.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzzing import command
from long_but import long_but

from vibecalc.core.case.load import LoadedCase, load_case
from vibecalc.errors import UsageError
from vibecalc.torsion.adapters.exchange import case_of_assembly, export_shaft_line
from vibecalc.torsion.model import build_shaft_line
from vibecalc.torsion.modes import natural_modes

CASES = Path(__file__).resolve().parents[1] / "cases"
HEAD = """\
schema = 1
title = "a line"

[machine]
kind = "engine"
cycle = "four_stroke"
speed = "1500 rpm"

[machine.crank_train]
crank_radius = "100 mm"
rod_length = "400 mm"
reciprocating_mass = "1 kg"
bore = "100 mm"
firing_order = ["1", "2"]
gas_pressure = { crank_angle = ["0 deg", "360 deg", "720 deg"], pressure = [0.0, 0.0, 0.0] }
cylinders = [{ name = "1" }, { name = "2" }]

[response.torsion]

[machine.shaft_line]
"""
WRITTEN_OUT = """\
stations = [
  { name = "crank, both", inertia = "1.5 kg*m^2", cylinders = ["1", "2"] },
  { name = "pinion", inertia = "250 g*m^2" },
  { name = "wheel", inertia = "4.75 kg*m^2" },
  { name = "screw", inertia = "12 kg*m^2", absolute_damping = "30 N*m*s/rad" },
]
shafts = [
  { between = ["crank, both", "pinion"], stiffness = "1.25 MN*m/rad", loss_factor = 0.1 },
  { between = ["wheel", "screw"], section = { outer_diameter = "100 mm", inner_diameter = \
"40 mm", length = "1.5 m" } },
]
gears = [{ name = "reduction", between = ["pinion", "wheel"], teeth = [20, 61], reverses = false }]
"""
FILES = 'stations = "s.csv"\nshafts = "k.csv"\ngears = "g.csv"\n'


def loaded(folder: Path, text: str) -> LoadedCase:
    path = folder / "case.toml"
    path.write_text(HEAD + text, encoding="utf-8")
    return load_case(path)


def frequencies(case: LoadedCase) -> np.ndarray:
    """Natural frequencies above zero, ascending, rad/s."""
    found = natural_modes(build_shaft_line(case.case).line).frequency
    return np.asarray(found[found > 0.0])


#: looks of the three files that mean WRITTEN_OUT
LOOKS = {
    "plain": (
        "name, inertia, cylinders, absolute_damping\n"
        '"crank, both", 1.5, 1; 2,\npinion, 0.25, ,\nwheel, 4.75, ,\nscrew, 12, , 30\n',
        "between, stiffness, loss_factor, section.outer_diameter, section.inner_diameter, "
        'section.length\n"crank, both; pinion", 1.25e6, 0.1, , ,\n'
        "wheel; screw, , , 0.1, 0.04, 1.5\n",
        "name, between, teeth, reverses\nreduction, pinion; wheel, 20; 61, false\n",
    ),
    "of a spreadsheet": (
        "\ufeffsep=;\r\n"
        '"# from the drawing; second sheet";;;;\r\n'
        "Name;Inertia (g m²);Cylinders;Absolute damping [kN·m·s/rad];\r\n"
        'crank, both;1500,0;"1;2";;\r\npinion;2,5e2;;;\r\n;;;;\r\nwheel;4750;;;\r\n'
        "screw;12000;;0,030;\r\n;;;;\r\n",
        "Length (mm);loss factor [-];From;To;Stiffness (MNm/rad);"
        "Outer diameter [cm];inner-diameter (mm)\r\n"
        ";0,1;crank, both;pinion;1,25;;\r\n1500;;wheel;screw;;10;40\r\n",
        "teeth to;Name;from;to;teeth from;reverses\r\n61;reduction;pinion;wheel;20;No\r\n",
    ),
    "of tabs": (
        "cylinders\tname\tinertia [kg m^2]\tabsolute_damping [Nms/rad]\n"
        "1;2\tcrank, both\t1,5\n\tpinion\t0,25\n\twheel\t4,75\n\tscrew\t12\t30\n",
        "from\tto\tstiffness [N*m/rad]\tloss_factor [%]\tlength [m]\touter_diameter [m]\t"
        "inner_diameter [m]\ncrank, both\tpinion\t1250000\t10\t\t\t\n"
        "wheel\tscrew\t\t\t1,5\t0,1\t0,04\n",
        "name\tbetween\tteeth_from\tteeth_to\treverses\nreduction\tpinion;wheel\t20,0\t61\t0\n",
    ),
}


@pytest.mark.parametrize("look", LOOKS)
def test_a_spreadsheet_gives_the_case_written_out(look: str, tmp_path: Path) -> None:
    for name, text in zip("skg", LOOKS[look], strict=True):
        width = text.replace("\r", "").split("\n")[0].count("\t")
        lines = [line + "\t" * (width - line.count("\t")) for line in text.split("\n")]
        (tmp_path / f"{name}.csv").write_bytes("\n".join(lines).rstrip("\t").encode())
    found, wanted = loaded(tmp_path, FILES), loaded(tmp_path, WRITTEN_OUT)
    line, other = (one.resolved["machine"]["shaft_line"] for one in (found, wanted))
    for key in ("stations", "shafts", "gears"):
        assert [_rounded(row) for row in line[key]] == [_rounded(row) for row in other[key]]
    assert frequencies(found) == pytest.approx(frequencies(wanted), rel=1e-14)


def test_units_in_cells_and_commas_in_names(tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text(
        'name;inertia;cylinders\n"1,2 of the crank";1,5 kg m^2;"1;2"\n1,3 and 4;0.5 kg m^2;\n'
    )
    (tmp_path / "k.csv").write_text("stiffness\n1e5\n")
    line = loaded(tmp_path, FILES.partition("gears")[0]).case.machine.shaft_line
    assert [(one.name, one.inertia) for one in line.stations] == [
        *(("1,2 of the crank", 1.5), ("1,3 and 4", 0.5)),
    ]


def _rounded(row: Any) -> Any:
    """Numbers of a table to twelve digits: units convert."""
    if isinstance(row, dict):
        return {key: _rounded(value) for key, value in row.items()}
    return float(f"{row:.12g}") if isinstance(row, float) else row


SHIPPED = sorted(
    path.stem
    for path in CASES.glob("engine*.toml")
    if "[machine.shaft_line" in path.read_text(encoding="utf-8")
)


def with_files(case: LoadedCase, folder: Path) -> LoadedCase:
    """A case again, with the CSV files that were written of it."""
    paths, _ = export_shaft_line(case, folder)
    changes = [f'machine.shaft_line.{path.stem.split("_")[-1]}="{path.name}"' for path in paths]
    again = folder / f"{case.name}.toml"
    again.write_text(case.text, encoding="utf-8")
    for other in CASES.glob("*.csv"):
        (folder / other.name).write_bytes(other.read_bytes())
    return load_case(again, changes)


@pytest.mark.parametrize("name", long_but(SHIPPED, *SHIPPED[::3]))
def test_csv_files_of_shipped_cases_give_them_back(name: str, tmp_path: Path) -> None:
    case = load_case(CASES / f"{name}.toml")
    assert with_files(case, tmp_path).resolved == case.resolved


def opened(file: dict[str, Any]) -> np.ndarray:
    """Natural frequencies by openTorsion."""
    import opentorsion as ot

    square = np.sort(ot.Assembly.from_tors(file).undamped_modal_analysis()[0].real)
    return np.asarray(np.sqrt(square[square > 1e-9 * square[-1]]))


def held(case: LoadedCase, folder: Path) -> None:
    """The JSON of a case is that of its line, to openTorsion and back."""
    (path,), _ = export_shaft_line(case, folder / "line.json")
    file, found = json.loads(path.read_text(encoding="utf-8")), frequencies(case)
    assert opened(file) == pytest.approx(found, rel=1e-12)
    back = folder / "back.toml"
    back.write_text(case_of_assembly(path), encoding="utf-8")
    assert frequencies(load_case(back)) == pytest.approx(found, rel=1e-13)


@pytest.mark.parametrize("name", long_but(SHIPPED, *SHIPPED[1::3]))
def test_an_assembly_of_shipped_cases_has_their_frequencies(name: str, tmp_path: Path) -> None:
    case = load_case(CASES / f"{name}.toml")
    if any(damper.kind == "pendulum" for damper in case.case.machine.shaft_line.dampers):
        with pytest.raises(UsageError, match="no word for pendulums"):
            export_shaft_line(case, tmp_path / "line.json")
        return
    held(case, tmp_path)


def same_receptance(case: LoadedCase, file: dict[str, Any], name: str = "") -> None:
    """Angle over torque, of its own shaft and with all damping, at the first node of a file."""
    import opentorsion as ot

    shaft, assembly = build_shaft_line(case.case), ot.Assembly.from_tors(file)
    first = shaft.station_names.index(name or file["components"][0]["elements"][0]["name"])
    place, line = shaft.freedom[first], shaft.line
    carry = assembly.T(assembly.E())[0] if assembly.gear_elements else np.eye(assembly.dofs)[0]
    ends = np.eye(len(line.inertia))
    k, c = np.diag(line.ground_stiffness), np.diag(line.absolute_damping)
    for a, b, stiff, damp in zip(
        line.first, line.second, line.stiffness, line.damping, strict=True
    ):
        twist = ends[a] - ends[b]
        k, c = k + stiff * np.outer(twist, twist), c + damp * np.outer(twist, twist)
    for w in (11.0, 93.0, 240.0, 500.0):
        mine = np.linalg.inv(k + 1j * w * c - w**2 * np.diag(line.inertia))[place, place]
        full = assembly.K + 1j * w * assembly.C - w**2 * assembly.M
        other = carry @ np.linalg.solve(full, carry)
        assert abs(other / (shaft.station_ratio[first] ** 2 * mine) - 1.0) < 1e-10


def random_line(draw: np.random.Generator) -> str:
    """A tree of stations: shafts, gears with teeth inside and out, elastic teeth, rings."""
    count = int(draw.integers(3, 12))
    stations = [f'{{ name = "s{n}", inertia = {draw.uniform(0.5, 3.0)!r} }}' for n in range(count)]
    stations[0] = stations[0].replace("}", ', cylinders = ["1", "2"] }')
    shafts, gears = [], []
    for n in range(1, count):
        ends = [f"s{n}", f"s{int(draw.integers(0, n))}"]
        if draw.random() < 0.5:
            ends.reverse()
        both = f'between = ["{ends[0]}", "{ends[1]}"]'
        if n == 1 or draw.random() < 0.6:
            shafts.append(f"{{ {both}, stiffness = {draw.uniform(1e4, 9e4)!r}, damping = 3.0 }}")
            continue
        teeth = f"[{draw.integers(17, 80)}, {draw.integers(17, 80)}]"
        size = f"teeth = {teeth}" if draw.random() < 0.5 else f"ratio = {draw.uniform(0.4, 3.0)!r}"
        elastic = ", mesh_stiffness = 1e7, pitch_radius = 0.08" if draw.random() < 0.4 else ""
        inside = ", reverses = false" if draw.random() < 0.3 else ""
        gears.append(f"{{ {both}, {size}{elastic}{inside} }}")
    ring = "inertia = 0.4, damping = 5.0"
    rings = [
        f'{{ name = "ring 0", on = "s0", kind = "viscous", {ring} }}',
        f'{{ name = "ring 1", on = "s1", kind = "spring", {ring}, stiffness = 2e4 }}',
    ]
    lists = {"stations": stations, "shafts": shafts, "gears": gears, "dampers": rings}
    return "".join(f"{key} = [\n{','.join(rows)}\n]\n" for key, rows in lists.items() if rows)


@pytest.mark.parametrize("seed", long_but(range(25), *range(8)))
def test_random_trees_come_back(seed: int, tmp_path: Path) -> None:
    case = loaded(tmp_path, random_line(np.random.default_rng(seed)))
    held(case, tmp_path)
    file = json.loads((tmp_path / "line.json").read_text(encoding="utf-8"))
    same_receptance(case, file)
    again = loaded(tmp_path, random_line(np.random.default_rng(seed)))
    export_shaft_line(again, tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "line.json").read_bytes()
    folder = tmp_path / "csv"
    assert with_files(case, folder).resolved == case.resolved


def component(name: str, *elements: tuple[str, str, dict[str, Any]]) -> dict[str, Any]:
    """Of elements by their name, type and numbers."""
    listed = [{"name": own, "type": kind, **numbers} for own, kind, numbers in elements]
    return {"name": name, "elements": listed}


#: four components on a gearbox, with numbers of our own
GEARBOX: dict[str, Any] = {
    "name": "turbine train",
    "components": [
        component(
            "turbine",
            ("rotor", "Disk", {"inertia": 3.5, "damping": 0.25}),
            ("shaft", "ShaftDiscrete", {"stiffness": 2.5e5, "damping": 4}),
            ("pinion", "GearElement", {"inertia": 0.2, "diameter": 80}),
            ("wheel", "GearElement", {"inertia": 2.5, "diameter": 320, "parent": "pinion"}),
            ("pump wheel", "GearElement", {"inertia": 0.1, "diameter": 100, "parent": "pinion"}),
        ),
        component("coupling", ("rubber", "ShaftDiscrete", {"stiffness": 9e4, "damping": 30})),
        component("generator", ("rotor", "Disk", {"inertia": 40, "damping": 1.5})),
        component(
            "pump",
            ("quill", "ShaftDiscrete", {"stiffness": 2e4, "damping": 0}),
            ("impeller", "Disk", {"inertia": 0.3, "damping": 0.5}),
        ),
    ],
    "structure": [
        ["turbine.wheel", "coupling.rubber"],
        ["coupling.rubber", "generator.rotor"],
        ["turbine.pump wheel", "pump.quill"],
    ],
}


def case_of(folder: Path, file: dict[str, Any]) -> LoadedCase:
    (folder / "line.json").write_text(json.dumps(file), encoding="utf-8")
    path = folder / "line.toml"
    path.write_text(case_of_assembly(folder / "line.json"), encoding="utf-8")
    return load_case(path)


def test_components_on_a_gearbox(tmp_path: Path) -> None:
    case = case_of(tmp_path, GEARBOX)
    shaft = build_shaft_line(case.case)
    assert frequencies(case) == pytest.approx(opened(GEARBOX), rel=1e-12)
    assert shaft.station_names == (
        *("turbine, rotor", "turbine, pinion", "turbine, wheel", "generator"),
        *("turbine, pump wheel", "pump, impeller"),
    )
    assert shaft.station_ratio == pytest.approx([1.0, 1.0, -0.25, -0.25, -0.8, -0.8], rel=1e-15)
    same_receptance(case, GEARBOX, "turbine, rotor")


def test_round_shafts_are_cut_into_pieces(tmp_path: Path) -> None:
    def train(pieces: int) -> dict[str, Any]:
        shaft = {"type": "ShaftContinuous", "innerDiameter": 40, "outerDiameter": 90, "damping": 0}
        cut = [{"name": f"p{n}", "length": 4000 / pieces, **shaft} for n in range(pieces)]
        ends = [{"name": f"d{n}", "type": "Disk", "inertia": 2 + n, "damping": 0} for n in (0, 1)]
        return {
            "components": [{"name": "x", "elements": [ends[0], *cut, ends[1]]}],
            "structure": [],
        }

    exact = opened(train(120))[:3]
    off = [abs(frequencies(case_of(tmp_path, train(n)))[:3] / exact - 1.0).max() for n in (8, 32)]
    assert off[1] < off[0] / 12.0  # with the square of the length of a piece
    assert off[1] < 3e-3
    text = (tmp_path / "line.toml").read_text(encoding="utf-8")
    assert "half to each end" in " ".join(text.replace("\n# ", " ").split())
    inertia = 8000.0 * np.pi * (0.09**4 - 0.04**4) / 32.0 * 4.0
    line = load_case(tmp_path / "line.toml").case.machine.shaft_line
    assert sum(station.inertia for station in line.stations) == pytest.approx(5.0 + inertia)
    assert line.shafts[0].section.shear_modulus == 80e9


def test_what_is_not_carried_is_said(tmp_path: Path) -> None:
    case = load_case(CASES / "engine_geared.toml")
    _, left = export_shaft_line(case, tmp_path)
    assert left == ["balanced_by", "absorbed_torques"]
    _, left = export_shaft_line(case, tmp_path / "a.json")
    assert left == [
        *("stations: cylinder", "shafts: diameter", "shafts: loss_factor"),
        *("shafts: tensile_strength", "balanced_by", "absorbed_torques"),
    ]
    with pytest.raises(UsageError, match="exists already"):
        export_shaft_line(case, tmp_path / "a.json")
    file = json.loads(json.dumps(GEARBOX))
    file["components"][0]["elements"][0] |= {"excitation": {"values": [[1, 2]]}, "colour": "red"}
    case_of(tmp_path, file)
    assert "# Not carried: colour, excitation." in (tmp_path / "line.toml").read_text()


def test_the_command_line(tmp_path: Path) -> None:
    (tmp_path / "line.json").write_text(json.dumps(GEARBOX), encoding="utf-8")
    file, case = str(tmp_path / "line.json"), str(tmp_path / "line.toml")
    assert command("new", "--from", file).out == case_of_assembly(Path(file))
    assert command("new", "--from", file, "-o", case).code == 0
    assert "exists already" in command("new", "--from", file, "-o", case).err
    assert command("new", "engine", "--from", file).code == 2
    outcome = command("run", case, "-q", "-o", f"{tmp_path}/line.h5")
    assert outcome.code == 0, outcome.err
    outcome = command("export", case, "-o", str(tmp_path / "files"))
    assert outcome.code == 0
    assert len(outcome.out.splitlines()) == 3
    assert "excitations" in outcome.err
    outcome = command("export", case, "-o", str(tmp_path / "again.json"))
    assert outcome.err == "not exported: excitations\n"
    assert command("export", case, "-o", str(tmp_path / "again.json")).code == 2
    assert command("new", "--from", case).code == 2

"""Claim: what a search picks from lists and stocks is the best of all combinations."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from stock_cases import BASE, DISTANCE, PICKED

from vibecalc.core.report.text import render_report
from vibecalc.core.results.record import Result
from vibecalc.core.study import choices as choices_module
from vibecalc.core.study import combine as combine_module
from vibecalc.core.study.choices import Choice, Option
from vibecalc.core.study.combine import combine
from vibecalc.core.study.execute import execute, load_checked
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem

MASSES, STIFFNESSES, DAMPINGS = (110.0, 120.0, 150.0), (60e3, 90e3, 140e3), (80.0, 150.0)
GRAVITY = 9.80665


def run(folder: Path, text: str, *settings: str, **files: str) -> Result:
    for name, content in files.items():
        (folder / name.replace("_", ".")).write_text(content, encoding="utf-8")
    path = folder / "case.toml"
    path.write_text(text, encoding="utf-8")
    return execute(load_checked([path], settings)[0])


def test_the_best_of_all_combinations(tmp_path: Path) -> None:
    """Each combination as a case of its own; the sag M g / (4 k) says which are allowed."""
    alone = BASE
    found: dict[tuple[float, ...], float] = {}
    for mass, damping, stiffness in product(MASSES, DAMPINGS, STIFFNESSES):
        if mass * GRAVITY / (4.0 * stiffness) <= 4e-3:
            one = run(
                tmp_path,
                alone,
                f"machine.body.mass={mass}",
                f"machine.mounts.each.damping={damping}",
                f"machine.mounts.each.stiffness={stiffness}",
            )
            force = one.record["isolation/support_force/steady_peak"].values
            found[mass, damping, stiffness] = float(np.max(force))
    best = min(found, key=lambda one: found[one])
    result = run(tmp_path, BASE + PICKED)
    record = result.record
    picked = tuple(
        float(record[f"optimisation/{name}"].values)
        for name in ("variable/machine.body.mass", "variable/machine.mounts.each.damping")
    )
    assert (*picked, STIFFNESSES[int(record["optimisation/choice/mount"].values) - 1]) == best
    assert float(record["optimisation/objective"].values) == pytest.approx(found[best], rel=1e-12)
    assert float(record["optimisation/combinations/examined"].values) == 18
    assert float(record["optimisation/combinations/kept"].values) == len(found)
    objective = record["optimisation/combinations/objective"].values
    assert np.allclose(objective[: len(found)], sorted(found.values()), rtol=1e-12)
    assert np.all(np.isinf(objective[len(found) :]))
    text = render_report(result, full=True)
    assert "all 18 combinations examined (18 points in total)" in text
    assert "middle" in text


def test_variables_between_bounds_are_at_their_best_in_each(tmp_path: Path) -> None:
    """Couple / (2 (2 x)) is what a mount carries rigidly: far above resonance mounts go inwards,
    and the stiffness that keeps the sag is the softest of the stock, from a CSV next to the case.
    """
    text = BASE + PICKED.split("variables")[0] + f"variables = [ {DISTANCE} ]\n"
    text += '[[optimisation.stock]]\nname = "mount"\ntable = "machine.mounts.each"\n'
    text += 'catalogue = "mounts.csv"\n[[limit]]' + PICKED.split("[[limit]]")[1]
    file = "mount;stiffness [kN/m];damping [N*s/m]\nM 60;60;80\nM 75;75,0;80\nM 90;90;90\n"
    record = run(tmp_path, text, mounts_csv=file).record
    assert float(record["optimisation/choice/mount"].values) == 2.0  # 120 g / (4 k) <= 4 mm
    distance = float(record["optimisation/variable/machine.mounts.positions[2][0]"].values)
    for other in (0.95, 1.05):
        moved = distance * other
        if 0.2 <= moved <= 0.6:
            alone = run(
                tmp_path, BASE,
                *(f"machine.mounts.positions[{i}][0]={(-1) ** (i < 2) * moved}" for i in range(4)),
                "machine.mounts.each.stiffness=75e3", "machine.mounts.each.damping=80",
            )  # fmt: skip
            force = float(np.max(alone.record["isolation/support_force/steady_peak"].values))
            assert force > float(record["optimisation/objective"].values)


def test_catalogue_of_toml_and_names(tmp_path: Path) -> None:
    """A name of a list: model pitch or rigid_body; a stock as TOML."""
    text = BASE + PICKED.split("variables")[0]
    text += 'variables = [{ key = "isolation.up", choices = ["z", "y"] }]\n'
    text += '[[optimisation.stock]]\nname = "mount"\ntable = "machine.mounts.each"\n'
    text += 'catalogue = "mounts.toml"\n'
    file = '[A]\nstiffness = "60 kN/m"\n[B]\nstiffness = "50 kN/m"\n'
    record = run(tmp_path, text, mounts_toml=file).record
    assert float(record["optimisation/choice/mount"].values) == 2.0
    assert float(record["optimisation/combinations/examined"].values) == 4
    assert record["optimisation/choice/isolation.up"].values in (1, 2)


class Squares:
    """A binding of no case: the distance of picked numbers and a variable from a place."""

    lower, upper, period = np.zeros(1), np.ones(1), np.zeros(1)
    choices = tuple(
        Choice(name, f"choice/{name}", tuple(Option(str(i), {}) for i in range(16)), True)
        for name in "abc"
    )

    def __init__(self, picked: tuple[int, ...] = ()) -> None:
        self.picked = picked

    def with_picked(self, picked: tuple[int, ...]) -> "Squares":
        return Squares(picked)

    def margin_names(self) -> tuple[str, ...]:
        return ("sum at least 28",)

    def evaluate(self, x: np.ndarray) -> tuple[float, np.ndarray]:
        away = np.array(self.picked) - (4, 9.4, 12) - np.array([0, 1, 1]) * x[0]
        return float(1.0 + away @ away), np.array([sum(self.picked) / 28.0 - 1.0])


def test_many_combinations(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 4096 combinations the best that keeps its limit, known by trying all of them in numpy."""
    from vibecalc.core.case.study_tables import Objective, Optimisation, Variable

    study = Optimisation(
        objective=Objective(quantity="none"),
        starts=1,
        variables=(Variable(key="x", min=0, max=1),),
    )
    for module in (choices_module, combine_module):
        monkeypatch.setattr(module, "MOST_RUNS", 3000)

    def search(binding: Squares, further: np.ndarray):  # type: ignore[no-untyped-def]
        return minimise(
            Problem(binding.evaluate, binding.lower, binding.upper), starts=0, further=further
        )

    found = combine(Squares(), study, search)  # type: ignore[arg-type]
    grid = np.moveaxis(np.indices((16, 16, 16)), 0, -1).reshape(-1, 3)
    away = grid - (4, 9.4, 12)
    best = np.clip((away[:, 1] + away[:, 2]) / 2.0, 0.0, 1.0)
    values = 1.0 + away[:, 0] ** 2 + (away[:, 1] - best) ** 2 + (away[:, 2] - best) ** 2
    values[grid.sum(axis=1) < 28] = np.inf
    assert found.best.picked == tuple(grid[np.argmin(values)])
    assert found.best.end.objective == pytest.approx(np.min(values), rel=1e-9)
    assert len(found.examined) < 200 and "is not shown" in found.notes[0]


def test_the_front_of_a_stock(tmp_path: Path) -> None:
    """Without variables between bounds the front is what no other combination beats."""
    asked = """second_objective = { quantity = "isolation/support_displacement/static" }
further_objectives = [ { quantity = "isolation/pitch/natural_frequency", sense = "max" } ]
variables ="""
    text = BASE + PICKED.replace("variables =", asked).split("[[limit]]")[0]
    result = run(tmp_path, text)
    record = result.record
    names = ("objective", "second_objective", "third_objective")
    found = np.array([record[f"optimisation/front/{name}"].values for name in names]).T
    sags = {round(mass * GRAVITY / (4 * k), 12) for mass, k in product(MASSES, STIFFNESSES)}
    assert {round(float(sag), 12) for sag in found[:, 1]} <= sags
    signed = found * (1, 1, -1)
    for one in signed:
        assert not any(np.all(other <= one) and np.any(other < one) for other in signed)
    assert np.min(found[:, 1]) == pytest.approx(110.0 * GRAVITY / (4 * 140e3), rel=1e-12)
    said = render_report(result, full=True)
    assert "no objective improves without another getting worse" in said and "soft" in said


def test_no_combination_keeps_the_limits(tmp_path: Path) -> None:
    result = run(tmp_path, BASE + PICKED.replace("4 mm", "1 mm"))
    assert result.record.failure
    assert "hard" in result.record.warnings[0] and "110 kg, 80 N*s/m" in result.record.warnings[0]
    assert float(result.record["optimisation/combinations/kept"].values) == 0

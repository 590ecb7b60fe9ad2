"""Rings hung on a line that is solved without them, and studies that ask for largest torques alone,
against lines solved as a whole and whole runs."""

from pathlib import Path

import numpy as np
import pytest
from long_but import long_but
from torsion_lines import ring_on

from vibecalc.core.case.load import load_case
from vibecalc.core.case.raw import NOT_COMPUTED
from vibecalc.core.run.run import StageCache, checked_case, run_case
from vibecalc.torsion.forced import forced
from vibecalc.torsion.hung import bare_line, hung, ring_stiffness, torque_under
from vibecalc.torsion.line import Line, complex_stiffness

ROOT = "response/torsion"
CASES = Path(__file__).parents[1] / "cases"
RING = "machine.shaft_line.dampers[0]"


@pytest.mark.parametrize("seed", long_but(range(12), *range(6)))
def test_a_ring_hung_on_a_bare_line(seed: int) -> None:
    """Angles and torques are those of the whole line, within the errors that both state."""
    random = np.random.default_rng(seed)
    n = int(random.integers(2, 9))
    parents = np.array([random.integers(0, i) for i in range(1, n)])
    damped = seed % 3
    line = Line(
        10.0 ** random.uniform(-1, 2, n),
        10.0 ** random.uniform(-1, 2, n) * (damped > 0),
        np.where(random.random(n) < 0.2, 1e4, 0.0),
        parents,
        np.arange(1, n),
        10.0 ** random.uniform(4, 7, n - 1),
        10.0 ** random.uniform(0, 2, n - 1) * (damped > 1),
        np.full(n - 1, 0.01 * (damped > 1)),
    )
    freedom, k = int(random.integers(0, n)), int(random.integers(1, n + 1))
    stations = random.permutation(n)[:k]
    speed, order = random.uniform(20.0, 200.0, 40), np.arange(1, 9) * 0.5
    w = speed[:, None] * order
    load = random.normal(size=(*w.shape, k)) + 1j * random.normal(size=(*w.shape, k))
    bare = bare_line(line, w, load, stations, freedom)
    for values in ((3.0, 1e4, 30.0, 0.0), (0.1, 1e6, 0.0, 0.05), (50.0, 0.0, 800.0, 0.0)):
        whole = ring_on(line, freedom, values)
        pull, turn = ring_stiffness(whole, n - 1, w)
        found = hung(bare, pull)
        true = forced(whole, w, load, stations=stations.tolist())
        assert np.all(np.isfinite(found.error))
        off = np.abs(found.angle - true.angle[..., freedom])
        assert np.all(off <= found.error + true.error)
        twist = true.angle[..., whole.first] - true.angle[..., whole.second]
        torque = np.moveaxis(complex_stiffness(whole, w) * twist, -1, 0)
        stiff = np.abs(np.moveaxis(complex_stiffness(whole, w), -1, 0))
        room = 2.0 * stiff * (found.error + true.error)
        under = np.empty_like(torque[:-1])
        torque_under(bare, found.pull, under)
        assert np.all(np.abs(under - torque[:-1]) <= room[:-1])
        assert np.all(np.abs(found.pull - torque[-1]) <= room[-1] + np.abs(pull) * found.error)
        ring = turn * found.angle
        assert np.all(np.abs(ring - twist[..., -1]) <= np.abs(turn) * found.error + 2 * true.error)


def test_a_ring_where_the_bare_line_has_no_response() -> None:
    """On a resonance of the bare line, which nothing damps, no answer is claimed."""
    line = Line(*(np.array(one) for one in (
        [1.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0], [1], [1e4], [0.0], [0.0],
    )))  # fmt: skip
    w = np.array([[np.sqrt(2e4), 50.0]])
    bare = bare_line(line, w, np.ones((1, 2, 1), complex), np.array([0]), 0)
    pull, _ = ring_stiffness(ring_on(line, 0, (1.0, 100.0, 3.0, 0.0)), 1, w)
    found = hung(bare, pull)
    assert not found.error[0, 0] <= 1e-6 * abs(found.angle[0, 0])
    assert found.error[0, 1] <= 1e-12 * abs(found.angle[0, 1])


#: what a study of dampers asks for
WANTED = frozenset(
    f"{ROOT}/{name}"
    for name in (
        *("largest/torque_half_range", "largest/twist_half_range", "largest/speed"),
        *("largest/mode", "largest/order", "reduction", "speeds/heat"),
    )
)


@pytest.mark.parametrize("name", long_but(["engine_damped", "engine_two_stroke"], "engine_damped"))
def test_largest_torques_alone_are_those_of_a_whole_run(name: str) -> None:
    """Over other dampers, the first of them solved as a whole, the others hung on the bare line."""
    loaded = load_case(CASES / f"{name}.toml")
    resolved = {key: part for key, part in loaded.resolved.items() if key not in NOT_COMPUTED}
    ring, cache = loaded.case.machine.shaft_line.dampers[0], StageCache()  # type: ignore[union-attr]
    for factor in (1.0, 2.5):
        settings = {f"{RING}.damping": factor * ring.damping}
        if ring.stiffness:
            settings[f"{RING}.stiffness"] = factor * ring.stiffness
        settings["response.torsion.speeds.points"] = 151
        case = checked_case(resolved, settings, cache)
        alone = run_case(case, wanted=WANTED, cache=cache)
        # who asks for a curve gets all that a whole run computes for it
        whole = run_case(case, wanted=WANTED | {f"{ROOT}/speeds/torque_half_range"})
        for path in WANTED:
            one, other = alone[path], whole[path]
            room = one.error_estimate + other.error_estimate
            assert np.all(np.abs(one.values - other.values) <= room), path

"""Claim: whatever acts on a body is in all its results, or a message says what is not."""

import copy

import numpy as np
import pytest
from engine_cases import replaced
from engine_mounted import SEPARATE, loaded_of, mounted
from shipped_cases import table_of

from vibecalc.core.case.load import validate
from vibecalc.core.results.renamed import PATHS
from vibecalc.core.run.machine_checks import machine_warnings
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case
from vibecalc.errors import CaseError

FORCE = "isolation/support_force"


def test_causes_add_up_order_by_order_and_are_named() -> None:
    record = run_case(mounted(SEPARATE))
    alone = ('model = "rigid_body"', 'model = "rigid_body"\nloads = ["shaking"]')
    shaken = run_case(mounted(replaced(SEPARATE, alone)))
    causes = record[f"{FORCE}/by_cause"]
    assert [*causes.axes[1].values] == ["torque of the cylinders", "shaking"]
    # without gas the inertia torque is part of the shaking: with it, of the torque
    assert np.all(causes.values.sum(axis=1) >= record[f"{FORCE}/steady_peak"].values * (1 - 1e-6))
    assert f"{FORCE}/by_cause" not in shaken
    assert np.all(shaken[f"{FORCE}/steady_peak"].values < record[f"{FORCE}/steady_peak"].values)


def test_the_torque_alone_is_refused_with_where_it_is() -> None:
    alone = ('model = "rigid_body"', 'model = "rigid_body"\nloads = ["torque"]')
    with pytest.raises(CaseError, match="the shaking always acts") as told:
        mounted(replaced(SEPARATE, alone))
    assert "isolation/support_force/by_cause" in str(told.value)


def test_paths_of_before_name_the_same_results() -> None:
    for old, new in PATHS.items():
        if not new.startswith(("isolation/body/", "isolation/support_force/")):
            continue
        name = "genset_on_deck" if old.startswith("foundation") else "pump"
        table = copy.deepcopy(table_of(name))
        table["limit"] = [{"quantity": old, "max": 1e9}]
        case = validate(table)
        assert case.limit[0].quantity == new
        assert new in planned_quantities(case)


def test_what_pitch_leaves_out_has_a_size() -> None:
    """One cylinder away from the centre: its force moves the body up and down, too."""
    table = copy.deepcopy(table_of("generator"))
    table["machine"]["crank_train"]["cylinders"] = [{"name": "1"}]
    table["machine"]["crank_train"]["origin"] = [-0.2, 0.0, 0.0]
    for key in ("reference", "limit"):
        table.pop(key, None)
    record = run_case(validate(table))
    force = float(np.max(record["excitation/force_peak"].values))
    assert force > 100.0
    assert record["isolation/pitch/force_left_out"].values == pytest.approx(force, rel=1e-9)
    whole = run_case(validate(table_of("generator")))
    left = whole["isolation/pitch/force_left_out"]
    assert float(left.values) <= left.error_estimate + 1e-9 * force


def test_gas_that_only_loads_the_bearings_is_said() -> None:
    words = "the gas torque does not act on the body on its mounts"
    bearings = (
        '[isolation]\nmodel = "rigid_body"\n',
        '[isolation]\nmodel = "rigid_body"\n[bearing_loads]\nmain_bearings = '
        '[{ name = "a", position = "-0.3 m" }, { name = "b", position = "0.3 m" }]\n',
    )
    still = ('"separate"', '"cancels_torque"')
    both = mounted(replaced(SEPARATE, bearings, still))
    assert any(one.startswith(words) for one in machine_warnings(both))
    turned = mounted(replaced(SEPARATE, bearings))
    assert not any(words in one for one in machine_warnings(turned))


ISOLATED = '[isolation]\nmodel = "rigid_body"\n'


def test_operations_say_that_they_are_of_the_shaking_alone() -> None:
    words = "[response] operations and switching contain the shaking only"
    operations = 'operations = [{ name = "all", working = ["1", "2", "3"] }]\n'
    asked = mounted(SEPARATE.replace(ISOLATED, f"[response]\n{operations}"))
    assert sum(one.startswith(words) for one in machine_warnings(asked)) == 1
    shaken = SEPARATE.replace(ISOLATED, f'[response]\nloads = ["shaking"]\n{operations}')
    assert not any(one.startswith(words) for one in machine_warnings(mounted(shaken)))
    assert not any(words in one for one in machine_warnings(mounted(SEPARATE)))


def test_half_orders_of_the_mounts_can_be_named() -> None:
    """And orders beyond those that are kept cannot."""
    where = 'where = {{ mount = "1", direction = "z", order = {} }}'
    limit = '[[limit]]\nquantity = "{}"\n' + where + "\nmax = 1e9\n"
    few = ('driven_machine = "separate"\n', 'driven_machine = "separate"\norders = 4\n')
    text = replaced(SEPARATE, few)
    for order, fine in ((0.5, True), (4, True), (4.5, False)):
        path = f"{FORCE}/steady_harmonics"
        if fine:
            loaded_of(text + limit.format(path, order))
            continue
        with pytest.raises(CaseError, match="asks for an order"):
            loaded_of(text + limit.format(path, order))


def test_gas_that_reaches_nothing_is_said() -> None:
    words = "the gas has no effect"
    still = replaced(SEPARATE, ('"separate"', '"cancels_torque"'))
    assert any(words in one for one in machine_warnings(mounted(still)))
    assert not any(words in one for one in machine_warnings(mounted(SEPARATE)))

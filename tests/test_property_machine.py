"""Claim: masses, inertias and stiffnesses are those of the points and springs they stand for."""

import math

import numpy as np
import pytest
from crank_trains import generator
from hypothesis import given, settings
from hypothesis import strategies as st

from vibecalc.core.run.machine_checks import check_machine
from vibecalc.isolation.model import PitchParts, build_pitch
from vibecalc.parts.body import build_body, build_frame
from vibecalc.parts.crank_train import build_crank_train, build_rotating_masses
from vibecalc.parts.machine import build_machine
from vibecalc.parts.mounts import build_mounts, rotation
from vibecalc.schema import Case

places = st.tuples(*[st.floats(-1.0, 1.0)] * 3)
angles = st.tuples(*[st.floats(-3.2, 3.2)] * 3)
edges = st.fixed_dictionaries({e: st.floats(0.05, 1.0) for e in ("length", "width", "height")})


def block_points(mass: float, box: dict[str, float], centre: np.ndarray) -> list[tuple]:  # type: ignore[type-arg]
    """Eight equal points at 1 / sqrt(3) of the half edges: same mass, centre and inertia."""
    half = np.array([box["length"], box["width"], box["height"]]) / (2 * math.sqrt(3))
    signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T
    return [(mass / 8, centre + sign * half) for sign in signs]


def kinetic_matrix(points: list[tuple]) -> np.ndarray:  # type: ignore[type-arg]
    """Mass matrix of points in the order x y z rx ry rz, from v = v0 + w x r."""
    matrix = np.zeros((6, 6))
    for mass, place in points:
        motion = np.hstack([np.eye(3), np.array([np.cross(w, place) for w in np.eye(3)]).T])
        matrix += mass * motion.T @ motion
    return matrix


def body_of(case: Case):  # type: ignore[no-untyped-def]
    assert case.machine.body is not None
    return build_body(case.machine.body)


@given(edges, edges, places, st.floats(0.0, 200.0))
@settings(max_examples=50, deadline=None, derandomize=True)
def test_mass_matrix_is_the_sum_over_points(
    box: dict[str, float], plate: dict[str, float], place: tuple[float, ...], added: float
) -> None:
    block = {"mass": added, "box": plate, "position": place}
    body = body_of(generator(machine__body={"mass": 100.0, "box": box, "inertia_block": block}))
    points = block_points(100.0, box, np.zeros(3)) + block_points(added, plate, np.array(place))
    matrix = kinetic_matrix(points)
    assert np.abs(body.mass_matrix - matrix).max() < 1e-12
    assert np.array_equal(body.mass_matrix, body.mass_matrix.T)
    assert body.mass == pytest.approx(100.0 + added, rel=1e-15)
    centre = sum(mass * where for mass, where in points) / body.mass
    assert np.abs(body.centre - centre).max() < 1e-14
    around = kinetic_matrix([(mass, where - centre) for mass, where in points])
    assert np.abs(body.inertia - around[3:, 3:]).max() < 1e-12
    assert np.linalg.eigvalsh(body.mass_matrix)[0] > 0


def test_products_of_inertia_are_sums_of_m_x_y() -> None:
    points = [(2.0, np.array([0.3, 0.2, 0.1])), (3.0, np.array([-0.1, 0.4, -0.2]))]
    points += [(mass, -place) for mass, place in points]
    points += [(mass / 2, place[[2, 0, 1]] * s) for mass, place in points[:2] for s in (1, -1)]
    x = np.array([place for _, place in points])
    m = np.array([mass for mass, _ in points])
    moments = [float(m @ (x[:, i] ** 2 + x[:, j] ** 2)) for i, j in ((1, 2), (0, 2), (0, 1))]
    products = [float(m @ (x[:, i] * x[:, j])) for i, j in ((0, 1), (0, 2), (1, 2))]
    case = generator(
        machine__body={"mass": float(m.sum()), "inertia": moments, "inertia_products": products}
    )
    assert check_machine(case) == []
    assert np.abs(body_of(case).mass_matrix - kinetic_matrix(points)).max() < 1e-14


def test_inertia_of_the_generator_is_that_of_the_source() -> None:
    body = body_of(generator())
    assert body.inertia[1, 1] == pytest.approx(100 / 12 * (0.35**2 + 0.8**2), rel=1e-15)
    assert not body.centre.any()


@given(angles, st.tuples(*[st.floats(0.0, 1e6)] * 3))
@settings(max_examples=50, deadline=None, derandomize=True)
def test_a_turned_mount_keeps_its_principal_stiffnesses(
    turn: tuple[float, ...], principal: tuple[float, ...]
) -> None:
    mount = {"name": "m", "position": [0.1, 0.2, 0.3], "orientation": turn, "loss_factor": 0.1}
    mount["stiffness"] = principal
    mounts = generator(machine__mounts={"individual": [mount]}).machine.mounts
    assert mounts is not None
    built = build_mounts(mounts)
    stiffness = built.stiffness[0]
    assert np.array_equal(stiffness, stiffness.T)
    found = np.linalg.eigvalsh(stiffness)
    assert found == pytest.approx(sorted(principal), abs=1e-14 * max(max(principal), 1e-300) * 10)
    # Its own x axis, turned about the body's x, then y, then z, feels its first stiffness.
    own = np.eye(3)[0]
    (_, b, c) = turn
    own = np.array([math.cos(b), 0.0, -math.sin(b)])
    own = np.array([math.cos(c) * own[0], math.sin(c) * own[0], own[2]])
    assert own @ stiffness @ own == pytest.approx(principal[0], abs=1e-13 * max(principal) + 1e-300)
    assert np.array_equal(built.structural[0], 0.1 * stiffness)
    assert not built.damping.any()


def test_order_of_the_rotations() -> None:
    quarter = math.pi / 2
    # About x: y to z. Then about z: x to y. The mount's y axis ends along z, its x axis along y.
    turn = rotation(quarter, 0.0, quarter)
    assert turn @ [0, 1, 0] == pytest.approx([0, 0, 1], abs=1e-15)
    assert turn @ [1, 0, 0] == pytest.approx([0, 1, 0], abs=1e-15)
    assert np.linalg.det(rotation(0.3, -1.0, 2.0)) == pytest.approx(1.0, rel=1e-14)


def test_individual_mounts_take_from_each_what_they_do_not_say() -> None:
    each = {"stiffness": 1e4, "damping": [1.0, 2.0, 3.0], "loss_factor": 0.2}
    entries = [
        {"name": "plain", "position": [0.4, 0.0, 0.0]},
        {"name": "own", "position": [-0.4, 0.0, 0.0], "stiffness": 5e3, "loss_factor": 0.0},
    ]
    mounts = generator(machine__mounts={"each": each, "individual": entries}).machine.mounts
    assert mounts is not None
    built = build_mounts(mounts)
    assert built.names == ("plain", "own")
    assert np.array_equal(built.stiffness, [1e4 * np.eye(3), 5e3 * np.eye(3)])
    assert np.array_equal(built.damping, [np.diag([1.0, 2.0, 3.0])] * 2)
    assert np.array_equal(built.structural, [2e3 * np.eye(3), np.zeros((3, 3))])


def test_frame_is_right_handed_and_a_quarter_turn_leads_to_minus_across() -> None:
    for axis in "xyz":
        for stroke in set("xyz") - {axis}:
            frame = build_frame(axis, stroke)
            assert np.array_equal(frame.across, np.cross(frame.stroke, frame.axis))
            assert np.array_equal(np.cross(frame.axis, frame.stroke), -frame.across)
            assert np.array_equal(np.cross(frame.across, frame.stroke), frame.axis)


ROD = {"mass": 0.5, "crank_pin_to_mass_centre": 0.06}


def test_rod_is_two_points_that_keep_its_mass_centre() -> None:
    train = generator(
        machine__crank_train__reciprocating_mass=None,
        machine__crank_train__piston_mass=0.3,
        machine__crank_train__pin_mass=0.05,
        machine__crank_train__rod=ROD,
        machine__crank_train__rotating_mass=0.2,
    ).machine.crank_train
    built = build_crank_train(train)
    moving = built.reciprocating_mass - 0.35  # share of the rod at the wrist pin, 0.2 m away
    assert moving * 0.2 == pytest.approx([0.5 * 0.06] * 3, rel=1e-13)
    assert moving + built.rotating_mass - 0.2 == pytest.approx([0.5] * 3, rel=1e-15)
    share = generator(
        machine__crank_train__reciprocating_mass=None,
        machine__crank_train__piston_mass=0.35,
        machine__crank_train__rod={"mass": 0.5, "reciprocating_fraction": 0.3},
        machine__crank_train__rotating_mass=0.2,
    ).machine.crank_train
    same = build_crank_train(share)
    assert same.reciprocating_mass == pytest.approx(built.reciprocating_mass, rel=1e-15)
    assert same.rotating_mass == pytest.approx(built.rotating_mass, rel=1e-15)


def test_cylinders_override_the_masses_of_the_train() -> None:
    train = generator(
        machine__crank_train__cylinders=[
            {"name": "a", "reciprocating_mass": 0.7},
            {"name": "b", "position": 0.1, "rotating_mass": 0.3},
        ],
        machine__crank_train__rotating_mass=0.1,
    ).machine.crank_train
    built = build_crank_train(train)
    assert built.reciprocating_mass.tolist() == [0.7, 0.4]
    assert built.rotating_mass.tolist() == [0.1, 0.3]
    assert built.names == ("a", "b")


def test_everything_that_turns_is_in_one_list() -> None:
    case = generator(
        machine__crank_train__axis="y",
        machine__crank_train__rotating_mass=0.1,
        machine__crank_train__counterweights=[{"unbalance": 0.02, "phase": 3.0, "position": 0.1}],
        machine__crank_train__balance_shafts=[
            {"name": "s", "unbalance": 0.01, "speed_ratio": -2, "position": [0.1, 0.2, 0.3]}
        ],
        isolation__lever=0.4,
    )
    turning = build_rotating_masses(case.machine.crank_train)
    assert turning.names == ("throw 1", "throw 2", "throw 3", "counterweight", "s")
    assert turning.unbalance == pytest.approx([0.006] * 3 + [0.02, 0.01], rel=1e-15)
    assert turning.speed_ratio.tolist() == [1, 1, 1, 1, -2]
    assert turning.position[[0, 3, 4]].tolist() == [[0, -0.3, 0], [0, 0.1, 0], [0.1, 0.2, 0.3]]
    none = build_rotating_masses(generator().machine.crank_train)
    assert none.names == ()
    assert none.position.shape == (0, 3)


def pitch_of(case: Case) -> PitchParts:
    machine = case.machine
    assert machine.body is not None
    assert machine.mounts is not None
    return build_pitch(machine.body, machine.mounts, machine.crank_train)


def test_pitch_parts_are_projections() -> None:
    pitch = pitch_of(generator())
    assert pitch.lever == 0.4
    assert float(pitch.stiffness @ pitch.position**2) == pytest.approx(6400.0, rel=1e-15)
    assert float(pitch.damping @ pitch.position**2) == pytest.approx(32.0, rel=1e-15)
    assert math.sqrt(6400.0 / pitch.inertia) == pytest.approx(31.7366, abs=5e-5)
    assert pitch.across.tolist() == [0.0, 1.0, 0.0]
    bare = build_machine(generator(machine__mounts=None, isolation=None))
    assert bare.mounts is None
    assert bare.body is not None


def test_pitch_counts_from_the_mass_centre_with_the_block() -> None:
    block = {"mass": 25.0, "box": {"length": 0.4, "width": 0.4, "height": 0.1}}
    block["position"] = [0.1, 0.0, -0.3]
    pitch = pitch_of(generator(machine__body__inertia_block=block))
    assert pitch.position == pytest.approx([-0.42, -0.42, 0.38, 0.38], rel=1e-14)
    assert pitch.lever is None
    own = 100 / 12 * (0.35**2 + 0.8**2) + 25 / 12 * (0.4**2 + 0.1**2)
    assert pitch.inertia == pytest.approx(own + 20 * (0.1**2 + 0.3**2), rel=1e-14)

"""Adapter: a shaft line and its engine to modes, excitation, vibration at operating speed."""

from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.critical import emit_critical
from vibecalc.pipeline.stages.torsion.excitation import emit_excitation
from vibecalc.pipeline.stages.torsion.healthy import emit_healthy
from vibecalc.pipeline.stages.torsion.modes import emit_modes
from vibecalc.pipeline.stages.torsion.setup import Setup, build_setup
from vibecalc.pipeline.stages.torsion.steady import emit_steady


def run(scene: Scene) -> None:
    """Emit what holds at the operating speed, and hand the line on to its other stages.

    Raises NumericalFailure where an order meets a natural frequency that nothing damps.
    """
    setup = build_setup(scene.case)
    scene.handed_on["torsion"] = setup[1:]
    emit_modes(scene, setup)
    emit_excitation(scene, setup)
    emit_steady(scene, setup)
    emit_critical(scene, setup)
    if setup.torsion.misfire:
        emit_healthy(scene, setup)


def setup_of(scene: Scene) -> Setup:
    """What this stage has left for those after it."""
    response = scene.case.response
    assert response is not None and response.torsion is not None
    # with the table as this case has it: the line may be one that another case has left
    return Setup(response.torsion, *scene.handed_on["torsion"])

"""Topics of the control: the load on the rotor, the closed loop, its poles and its delay margin."""

from vibecalc.accuracy.topic import Topic
from vibecalc.accuracy.yardsticks.control_load import load_topic
from vibecalc.accuracy.yardsticks.control_loop import harmonics_topic, loop_setup
from vibecalc.accuracy.yardsticks.control_margin import margin_topic
from vibecalc.accuracy.yardsticks.control_poles import poles_topic
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.control_setup import setup
from vibecalc.response.roll_control.margins import margins


def topics(scene: Scene) -> list[Topic]:
    """What [response.control] asks; none without it. A loop that is not stable has its load only.

    With a delay the poles are left out: there are infinitely many.
    """
    response = scene.case.response
    if response is None or response.control is None:
        return []
    given = setup(scene.case)
    found = [load_topic(given)]
    closed = loop_setup(given)
    if bool(margins(closed.loop).stable):
        found.append(harmonics_topic(closed))
        margin = margin_topic(closed)
        found += [] if margin is None else [margin]
    if not float(closed.loop.delay) > 0.0:
        found.append(poles_topic(closed))
    return found

"""Maps of a plate, and its quietest places."""

import numpy as np

from vibecalc.measurement.quiet_places import Rectangle, amplitude_map, grid, quietest
from vibecalc.measurement.rigid_plate import point_row
from vibecalc.numerics.rounding import EPSILON
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.measured_motion import Found


def emit_plate(scene: Scene, found: list[Found], orders: dict[str, np.ndarray]) -> None:
    """Emit amplitudes over the plate and the places of least amplitude, if its edges are known."""
    table = scene.case.measurement
    if table is None or table.plate is None:
        return
    plate = Rectangle(*table.plate.x, *table.plate.y)
    motions = np.stack([one.motion for one in found])
    x, y = grid(plate, table.plate.points)
    corners = point_row(np.array(plate[:2])[:, None], np.array(plate[2:])[None, :])
    errors = [float(np.max(one.signal(corners.reshape(-1, 3)).error)) for one in found]
    axes = {**orders, "plate_y": y, "plate_x": x}
    amplitudes = amplitude_map(motions, x, y)
    scene.emit("measurement/map/amplitude", amplitudes, max(errors), axes)
    total = np.linalg.norm(amplitudes, axis=0)
    scene.emit("measurement/map/all_orders", total, float(np.linalg.norm(errors)), axes)
    quiet = [
        quietest(motion[None], plate, error) for motion, error in zip(motions, errors, strict=True)
    ]
    apart = max(place.error for place in quiet)
    for key in ("x", "y"):
        values = [getattr(place, key) for place in quiet]
        scene.emit(f"measurement/quiet/{key}", values, apart, orders)
    least = [place.amplitude for place in quiet]
    there = [
        float(one.signal(point_row(place.x, place.y)).error)
        for one, place in zip(found, quiet, strict=True)
    ]
    scene.emit("measurement/quiet/amplitude", least, max(there), orders)
    all_orders = quietest(motions, plate, float(np.linalg.norm(errors)))
    scene.emit("measurement/quiet/all_orders_x", all_orders.x, all_orders.error)
    scene.emit("measurement/quiet/all_orders_y", all_orders.y, all_orders.error)
    row = point_row(all_orders.x, all_orders.y)
    doubt = float(np.linalg.norm([float(one.signal(row).error) for one in found]))
    doubt += 8.0 * EPSILON * all_orders.amplitude
    scene.emit("measurement/quiet/all_orders_amplitude", all_orders.amplitude, doubt)

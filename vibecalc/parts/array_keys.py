"""Numbers of crank train, body and mounts that may be arrays over the points of a sweep.

`[]` is any entry of a list. The builders of the parts take arrays for each of them.
"""

_TRAIN, _BODY = "machine.crank_train", "machine.body"
_BLOCK, _PART, _MOUNTS = f"{_BODY}.inertia_block", f"{_BODY}.parts[]", "machine.mounts"
_MOUNT = ("stiffness", "stiffness[]", "damping", "damping[]", "loss_factor")

#: what changes masses and motion of the crank train
MOVING_KEYS = frozenset(
    [
        *(f"{_TRAIN}.{name}" for name in ("crank_radius", "rod_length", "wrist_pin_offset")),
        *(f"{_TRAIN}.{name}_mass" for name in ("reciprocating", "piston", "pin", "rotating")),
        *(f"{_TRAIN}.rod.{name}" for name in ("mass", "inertia", "reciprocating_fraction")),
        f"{_TRAIN}.rod.crank_pin_to_mass_centre",
        *(f"{_TRAIN}.cylinders[].{name}_mass" for name in ("reciprocating", "rotating")),
    ]
)
#: what places that, and weights that turn
PLACING_KEYS = frozenset(
    [
        f"{_TRAIN}.origin[]",
        *(f"{_TRAIN}.cylinders[].{name}" for name in ("position", "crank_phase", "bank_angle")),
        *(f"{_TRAIN}.counterweights[].{name}" for name in ("unbalance", "phase", "position")),
        *(f"{_TRAIN}.balance_shafts[].{name}" for name in ("unbalance", "phase", "position[]")),
    ]
)
#: the rigid body; products of inertia only beside moments that a case gives
BODY_KEYS = frozenset(
    [
        f"{_BODY}.mass",
        f"{_BODY}.inertia[]",
        f"{_BODY}.centre[]",
        f"{_PART}.mass",
        f"{_PART}.inertia[]",
        f"{_PART}.centre[]",
        f"{_BLOCK}.mass",
        f"{_BLOCK}.position[]",
        *(
            f"{table}.box.{edge}"
            for table in (_BODY, _BLOCK, _PART)
            for edge in ("length", "width", "height")
        ),
    ]
)
INERTIA_PRODUCTS = frozenset([f"{_BODY}.inertia_products[]"])
MOUNT_KEYS = frozenset(
    [
        f"{_MOUNTS}.datum[]",
        f"{_MOUNTS}.positions[][]",
        f"{_MOUNTS}.individual[].position[]",
        *(f"{_MOUNTS}.{table}.{name}" for table in ("each", "individual[]") for name in _MOUNT),
    ]
)

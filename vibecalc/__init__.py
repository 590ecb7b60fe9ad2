"""vibecalc: vibration of machines with pistons, from a text case to an HDF5 result and a report.

Calls
-----
run(case)                        a case once, to its optimum, or with its searches
check(case)                      what a run would do and need
sweep(case, "x.sweep.h5", grid)  many points into a file
merge(parts, "x.sweep.h5")       parts of a sweep into one file
verify(case)                     a run held to its references and limits
accuracy(case)                   the methods of a case, seconds against error
read("x.h5"), write(result, "x.h5")
report(result), plot(result, "folder"), diff(golden, result)

`help(vibecalc.run)` tells more of each, `docs/python.md` shows them at work.

Conventions
-----------
Inside, everything is SI and radians. A steady oscillation of order n at crank speed `w` is the
complex amplitude X with x(t) = Re(X exp(i n w t)), 0-to-peak, so a positive phase leads. Running
speed and excitation frequency are separate arguments.

The crankshaft lies along `axis` (x), a cylinder at bank angle zero along `stroke` (z), and
`across = stroke x axis` (y). The crank turns right-handed about `axis`. Crank angle zero is the
top dead centre of a cylinder at bank angle zero with crank phase zero; `crank_phase` is the angle
by which a throw leads, `bank_angle` the tilt of a cylinder in the sense of rotation. Piston
position counts from the crank axis outwards; forces and couples are those *on the body*, couples
about its reference point; mount forces are those *on the ground*.

`docs/conventions.md` has the same with pictures and the remaining choices.
"""

__version__ = "0.3.0"

#: what Python users call, and where it is; imported as soon as it is asked for
_HOMES = {
    "api": (
        *("accuracy", "check", "diff", "merge", "plot", "read", "report", "run", "sweep"),
        *("verify", "write"),
    ),
    "core.results.record": ("Axis", "Quantity", "Result"),
    "errors": (
        *("CaseError", "MissingQuantity", "NumericalFailure", "Problem", "ResultError"),
        *("UnitError", "UsageError", "VibecalcError"),
    ),
}
__all__ = [name for names in _HOMES.values() for name in names]


def __getattr__(name: str) -> object:
    for home, names in _HOMES.items():
        if name in names:
            from importlib import import_module

            return getattr(import_module(f"vibecalc.{home}"), name)
    raise AttributeError(f"module 'vibecalc' has no attribute {name!r}")

"""Singular values of an upper bidiagonal matrix by LAPACK's differential qd algorithm, alone.

`numpy.linalg.svd` ends in the same routine, after a reduction of the full matrix that costs three
times as much and changes nothing in a bidiagonal one. scipy offers the routine to Cython; its
capsules can be called as they are.
"""

import ctypes
from collections.abc import Callable
from functools import cache

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray

#: from this size on the saving is worth the import of scipy
WORTH_WHILE = 64


@cache
def _dlasq1() -> Callable[..., None]:
    """dlasq1(n, diagonal, above, work, info), all by reference, of scipy's LAPACK."""
    from scipy.linalg import cython_lapack

    capsule = cython_lapack.__pyx_capi__["dlasq1"]
    name = ctypes.pythonapi.PyCapsule_GetName
    name.restype, name.argtypes = ctypes.c_char_p, [ctypes.py_object]
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    signature = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 5)
    return signature(pointer(capsule, name(capsule)))


def bidiagonal_singular_values(factor: FloatArray) -> FloatArray:
    """Singular values (n,), descending, of an upper bidiagonal matrix (n, n).

    Raises `NumericalFailure` if the iteration does not end.
    """
    count = len(factor)
    if count < WORTH_WHILE:
        return np.asarray(np.linalg.svd(factor, compute_uv=False), dtype=np.float64)
    diagonal = factor.diagonal().copy()
    above = np.append(factor.diagonal(1), 0.0)
    work = np.empty(4 * count)
    size, info = ctypes.c_int(count), ctypes.c_int(0)
    _dlasq1()(
        ctypes.byref(size),
        diagonal.ctypes.data,
        above.ctypes.data,
        work.ctypes.data,
        ctypes.byref(info),
    )
    if info.value:
        raise NumericalFailure("the singular values of the shaft line's factor did not converge")
    return diagonal

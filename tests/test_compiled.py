import subprocess
import sys
from pathlib import Path

import numpy as np
from numba import carray, types

from trackctl.compiled import borrowing_kernel, inlined, kernel, linked

DOUBLES = types.CPointer(types.float64)


@kernel
def doubled(value: float) -> float:
    return 2.0 * value


@inlined
def raised(value: float) -> float:
    return value + 1.0


@borrowing_kernel
def both(value: float) -> float:
    return raised(doubled(value))


def test_what_kernels_call_can_be_called_from_python_too():
    assert both(3.0) == 7.0
    assert doubled(3.0) == 6.0
    assert raised(3.0) == 4.0
    assert doubled(value=both(3.0)) == 14.0


def test_a_kernel_keeps_its_name_and_text():
    assert both.__name__ == "both"
    assert both.__module__ == __name__


@linked(types.void(types.float64, DOUBLES))
def linked_double(value, result):
    carray(result, 1)[0] = doubled(value)


@kernel
def doubled_by_address(value: float) -> float:
    result = np.empty(1)
    linked_double(value, result.ctypes)
    return result[0]


@linked(types.void(types.float64, DOUBLES))
def linked_chain(value, result):
    carray(result, 1)[0] = raised(doubled_by_address(value))


@kernel
def chained_by_address(value: float) -> float:
    result = np.empty(1)
    linked_chain(value, result.ctypes)
    return result[0]


def test_kernels_call_by_address_what_calls_by_address_itself():
    assert chained_by_address(3.0) == 7.0


def test_a_kernel_from_the_cache_finds_what_it_calls_by_address():
    code = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); import test_compiled as t; "
    code += "print(t.chained_by_address(4.0))"
    for _ in range(2):
        assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "9.0\n"

from trackctl.compiled import borrowing_kernel, inlined, kernel


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

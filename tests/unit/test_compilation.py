"""The bar that moves while the kernels are compiled: a mark a kernel, whatever its signatures."""

import io
import sys

import numba
from numba.core import event
from numba.core.dispatcher import Dispatcher
from tqdm import tqdm

from millprint.dem import advance, threads
from millprint.dem.compilation import CompiledKernels, count_kernels


def made_up(module: str):
    """A function that is not compiled yet, of a module that does not exist."""

    @numba.njit
    def half(x):
        return x / 2

    half.py_func.__module__ = module
    return half


def test_the_bar_moves_once_a_kernel_whatever_its_signatures():
    ours, numbas = made_up("millprint.dem.made_up"), made_up("numba.np.made_up")
    with tqdm(total=5, file=io.StringIO()) as bar, event.install_listener("numba:compile", CompiledKernels(bar)):
        assert (ours(1), ours(3.0), ours(2), numbas(1)) == (0.5, 1.5, 1.0, 0.5)
        assert len(ours.signatures) == 2
        assert bar.n == 1


def test_the_bar_leaves_out_the_kernels_of_threads():
    def of(module) -> int:
        found = [value for value in vars(module).values() if isinstance(value, Dispatcher)]
        return sum(kernel.py_func.__module__ == module.__name__ for kernel in found)

    names = [name for name in sys.modules if name.startswith(("millprint.dem.", "millprint.mill."))]
    values = {value for name in names for value in vars(sys.modules[name]).values() if isinstance(value, Dispatcher)}
    assert len(values) - count_kernels() == of(threads) > 0
    assert count_kernels() > of(advance) > 0

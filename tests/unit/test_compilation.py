"""The bar that moves while the kernels are compiled: a mark a kernel, whatever its signatures."""

import io
import sys
from types import ModuleType

import numba
from numba.core import event
from tqdm import tqdm

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


def test_the_bar_counts_a_kernel_once_and_leaves_out_threads_and_other_packages(monkeypatch):
    before = count_kernels()
    kernel, of_threads = made_up("millprint.dem.made_up"), made_up("millprint.dem.threads")
    for name in ("millprint.dem.made_up", "millprint.mill.also_imports_it", "millprint.view.made_up"):
        module = ModuleType(name)
        module.half, module.of_threads, module.number = kernel, of_threads, 1
        if name.startswith("millprint.view."):
            module.quarter = made_up(name)
        monkeypatch.setitem(sys.modules, name, module)
    assert count_kernels() == before + 1

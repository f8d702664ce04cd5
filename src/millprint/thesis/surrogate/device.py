"""What a network is trained and asked on: a graphics card, or threads of the processor."""

import torch
from llvmlite import binding


def choose_device(threads: int) -> torch.device:
    """A GPU when there is one, otherwise `threads` threads of the processor."""
    torch.set_num_threads(threads)
    if torch.cuda.is_available():
        return torch.device("cuda")
    choose_products()
    return torch.device("cpu")


def choose_products() -> None:
    """Let oneDNN multiply matrices on processors of AMD, where MKL uses vectors of half the width (AVX-512).

    torch gives products to oneDNN only if their factors may be rounded to bfloat16. Where the processor has no fast
    products of these, nothing is rounded; where it has, MKL goes on: with rounded factors trainings end with larger
    losses.
    """
    torch.set_float32_matmul_precision("medium")
    if not (binding.get_host_cpu_name().startswith("znver") and has_single_products()):
        torch.set_float32_matmul_precision("highest")


def has_single_products() -> bool:
    """Whether products of matrices are as exact as sums in single precision; with rounded factors they are 2e-3 off."""
    factor = torch.linspace(1, 2, 256**2).view(256, 256)
    exact = factor.double() @ factor.double()
    return bool((factor @ factor - exact).abs().max() < 1e-5 * exact.max())

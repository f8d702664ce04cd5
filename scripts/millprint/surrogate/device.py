"""What tensors are computed on."""

import torch


def choose_device(threads: int) -> torch.device:
    """A GPU when there is one, otherwise `threads` threads of the processor."""
    torch.set_num_threads(threads)
    return torch.device("cuda" if torch.cuda.is_available() else "cpu")

"""Several processes that train one network: each takes some of a batch's styles, and gradients are averaged.

`torchrun` starts the processes and tells each its rank; a process started otherwise is a team of its own.
"""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import torch
from torch import Tensor, distributed, nn
from torch.nn.parallel import DistributedDataParallel

from stylephase.errors import InputError


@dataclass(frozen=True)
class Team:
    """This process's `rank` among `size` processes; rank 0 leads and is the one that writes."""

    rank: int = 0
    size: int = 1

    @property
    def leads(self) -> bool:
        """Whether this process writes files and speaks to the user."""
        return self.rank == 0

    def check(self, styles: int) -> None:
        """Raise InputError where a batch of so many styles cannot be shared out evenly."""
        if styles % self.size:
            raise InputError(f"{styles} styles a step cannot be shared evenly by {self.size} processes")

    def share(self, rows: Tensor) -> Tensor:
        """The part of a batch for this process; rows come style by style, so it is a part of the styles."""
        return rows if self.size == 1 else rows.chunk(self.size)[self.rank]

    def together(self, module: nn.Module) -> Callable[..., Tensor]:
        """The module, called in a way that averages gradients over the team on the way back."""
        # A step leaves out the adapters of styles that it does not meet.
        return module if self.size == 1 else DistributedDataParallel(module, find_unused_parameters=True)

    def mean(self, values: Tensor) -> Tensor:
        """The mean over the team, which all processes receive."""
        if self.size > 1:
            distributed.all_reduce(values)
        return values / self.size

    def wait(self) -> None:
        """Wait for all others to come here."""
        if self.size > 1:
            distributed.barrier()


@contextmanager
def find_team() -> Iterator[Team]:
    """The team that `torchrun` has started, joined for as long as the context lasts; otherwise a team of one."""
    size = int(os.environ.get("WORLD_SIZE", "1"))
    if size == 1:
        yield Team()
        return
    distributed.init_process_group("gloo")
    try:
        yield Team(distributed.get_rank(), size)
    finally:
        distributed.destroy_process_group()


def seed_apart(team: Team, seed: int, step: int) -> None:
    """Give every process but the first a dropout of its own; the first goes on as a process alone would."""
    if not team.leads:
        torch.manual_seed((seed * team.size + team.rank) * 1_000_003 + step)

"""Several processes learn what one learns from the same batches: the loss curves agree, and one process writes."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import tiny_training as tiny
import torch

from stylephase.errors import InputError
from stylephase.training.team import Team, find_team

# Without dropout, which each process draws for itself.
SCRIPT = """
import sys
from pathlib import Path
import tiny_training as tiny
from stylephase.training.team import find_team

with find_team() as team:
    run = tiny.still(sys.argv[1], team)
    run.resume(Path(sys.argv[2]))
    run.run(Path(sys.argv[2]), tiny.ignore)
"""


def together(model: str, out: Path, processes: int) -> list[dict]:
    """The log of a run of two processes that `torchrun` starts."""
    script = out.parent / "run.py"
    script.write_text(SCRIPT)
    launch = [sys.executable, "-m", "torch.distributed.run", "--standalone", f"--nproc-per-node={processes}"]
    path = ":".join(entry for entry in sys.path if entry)
    done = subprocess.run(
        [*launch, str(script), model, str(out)],
        env={"PYTHONPATH": path, "PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": "1", "HOME": str(out.parent)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads((out / "log.json").read_text())


@pytest.mark.parametrize("model", ["lpn-film", "pfnn-resad"])
def test_two_processes_have_the_loss_curve_of_one_with_the_same_batches(tmp_path, model):
    (tmp_path / "one").mkdir()
    alone = tiny.still(model, Team())
    alone.run(tmp_path / "one", tiny.ignore)
    pair = together(model, tmp_path / "two", 2)
    for key in ("mse", "bll", "validation_mse"):
        np.testing.assert_allclose([e[key] for e in pair], [e[key] for e in alone.log], rtol=2e-4)
    assert alone.log[-1]["mse"] < 0.98 * alone.log[0]["mse"]


def test_a_batch_that_cannot_be_shared_evenly_is_refused():
    Team(0, 4).check(8)
    with pytest.raises(InputError, match="8 styles a step cannot be shared evenly by 3 processes"):
        Team(0, 3).check(8)


def test_shares_are_whole_styles_in_order_and_make_the_batch_again():
    rows = torch.arange(24).repeat_interleave(2).view(-1, 1)
    parts = [Team(rank, 4).share(rows) for rank in range(4)]
    assert torch.equal(torch.cat(parts), rows) and {len(part) for part in parts} == {12}


def test_a_process_that_nobody_started_as_one_of_several_is_alone():
    with find_team() as team:
        assert (team.rank, team.size, team.leads) == (0, 1, True)
        values = torch.ones(2)
        assert torch.equal(team.mean(values), values)

"""Which weights a step of training changes."""

import numpy as np
import pytest
import tiny_training as tiny

from stylephase.evaluation.cycling import changed_by_step


@pytest.mark.parametrize("in_turn", [True, False])
def test_a_step_changes_what_is_shared_and_one_adapter(in_turn):
    """In turn where the 2018 paper has it; drawn styles come in no order, which the check must notice."""
    run = tiny.trainer(
        model="pfnn-cp", shared_l1=0.01, style_l1=0.01, styles_per_step=1, steps_per_code=1, in_turn=in_turn
    )
    changed, count = changed_by_step(run, 12), len(run.styles)
    assert changed[:, 0].all() and (changed[:, 1:].sum(axis=1) == 1).all()
    assert np.array_equal(changed[:, 1:], np.eye(count, dtype=bool)[np.arange(12) % count]) == in_turn

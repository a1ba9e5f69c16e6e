"""Learning from one's own files, as notebook 15 does: nobody's files are lost by it."""

import pytest
import tiny_walker as tiny

from stylephase.errors import InputError
from stylephase.motion.bvh import write_bvh
from stylephase.report.own_motion import inspected, learn_and_drive


def test_files_in_the_folder_to_work_in_are_refused_and_stay(tmp_path):
    own = tmp_path / "work" / "mine" / "walk.bvh"
    write_bvh(own, tiny.take().clip)
    with pytest.raises(InputError, match="name another folder"):
        learn_and_drive(inspected(own.parent), tmp_path / "work", steps=1)
    assert own.is_file()

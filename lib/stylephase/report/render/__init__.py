"""Pictures of motion: strips and grids of frames, and movies."""

import warnings

# pyvista brings a progress bar that misses, in a notebook, a widget that nothing here needs, and says so for ever.
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import tqdm.auto  # noqa: F401

from stylephase.report.render.crowd import crowd
from stylephase.report.render.motion import Motion, facing_angles, ground_path
from stylephase.report.render.movies import movie
from stylephase.report.render.strips import Layout, grid, strip

__all__ = ["Layout", "Motion", "crowd", "facing_angles", "grid", "ground_path", "movie", "strip"]

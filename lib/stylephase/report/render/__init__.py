"""Pictures of motion: strips and grids of frames, and movies."""

from stylephase.report.render.motion import Motion, facing_angles, ground_path
from stylephase.report.render.movies import movie
from stylephase.report.render.strips import Layout, grid, strip

__all__ = ["Layout", "Motion", "facing_angles", "grid", "ground_path", "movie", "strip"]

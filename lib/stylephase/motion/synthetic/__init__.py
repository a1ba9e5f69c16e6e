"""The synthetic walker: the embedded data set, with known phases and contacts, in the layout of 100STYLE."""

from stylephase.motion.synthetic.body import SKELETON
from stylephase.motion.synthetic.path import GAITS, Plan, steady
from stylephase.motion.synthetic.styles import STYLES, Arm, WalkStyle, find_style
from stylephase.motion.synthetic.take import Truth, walk
from stylephase.motion.synthetic.write import generate

__all__ = [
    "GAITS",
    "SKELETON",
    "STYLES",
    "Arm",
    "Plan",
    "Truth",
    "WalkStyle",
    "find_style",
    "generate",
    "steady",
    "walk",
]

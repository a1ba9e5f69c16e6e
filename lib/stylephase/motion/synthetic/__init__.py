"""The synthetic walker: the embedded data set, with known phases and contacts, in the layout of 100STYLE."""

from stylephase.motion.synthetic.path import GAITS, Plan, steady
from stylephase.motion.synthetic.styles import STYLES, Arm, WalkStyle, find_style
from stylephase.motion.synthetic.take import Truth, walk

__all__ = ["GAITS", "STYLES", "Arm", "Plan", "Truth", "WalkStyle", "find_style", "steady", "walk"]

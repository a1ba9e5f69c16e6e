# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Your own motion capture
#
# Beyond [M18] and [M22]. Time: preset quick a minute, real examples some minutes.
#
# A folder of BVH files goes in, a character that walks like them comes out. Set `folder` to yours: a sub-folder for
# each style, or file names that begin with the style and an underscore. Left empty, examples show what to expect: the
# synthetic walker under Mixamo's names, and real capture on three other skeletons.

# %% tags=["parameters"]
dataset: str = "synthetic"  # synthetic, or any other name for examples of real capture
preset: str = "quick"  # only noted in the record
figures_folder: str = "build/figures"  # folder for pictures and numbers
folder: str = ""  # folder of BVH files of your own; left out: examples
work: str = "build/own"  # folder for copies, weights and BVH files
steps: int = 1200  # steps of a training

# %%
import shutil
from pathlib import Path

import numpy as np
from IPython.display import Image, Markdown, display

from stylephase.data.catalogue import load_catalogue
from stylephase.evaluation.inspection import HEADS, rows_of
from stylephase.report import own_motion
from stylephase.report.manifest import ROOT
from stylephase.report.png import write_png
from stylephase.report.recorder import Recorder
from stylephase.report.render import Layout, grid
from stylephase.report.show import table

figures, working = ROOT / figures_folder, ROOT / work


def examples() -> dict[str, Path]:
    """Folders as people have them, by the kind of skeleton."""
    if folder:
        return {"yours": Path(folder)}
    shutil.rmtree(working / "examples", ignore_errors=True)
    found = {"mixamo": own_motion.write_walker(working / "examples" / "mixamo")}
    if dataset != "synthetic":
        chosen = {"xsens": ("100style", ["FW"]), "bandai-namco": ("bandai-namco", ["walk"]), "cmu": ("pfnn", ["any"])}
        for kind, (name, gaits) in chosen.items():
            some = ["set1-old", "set1-proud", "set2-elderly", "set2-exhausted"] if name == "bandai-namco" else None
            found[kind] = own_motion.write_takes(load_catalogue(name, some), working / "examples" / kind, gaits)
    return found


folders = examples()
Markdown(f"Folders: {', '.join(folders)}.")

# %% [markdown]
# ## What is in the files?
#
# As `stylephase inspect FOLDER` tells: joints by name, unit from the length of the legs, gait from where the hips face
# and go, steps and contacts, and how much of each limb's movement a sinusoid of its phase explains (left hand, right
# hand, left foot, right foot).

# %%
reports = {kind: own_motion.inspected(path) for kind, path in folders.items()}
for kind, report in reports.items():
    known = next((take for take in report.takes if take.effectors), None)
    told = f"**{kind}**: no file shows hands and feet."
    if known:
        told = f"**{kind}**: {known.joints} joints, unit {known.unit}, legs of {known.legs:.2f} m; hands and feet are "
        told += ", ".join((known.effectors or {}).values()) + "."
    display(Markdown(told), table(HEADS, *rows_of(report.takes)))

# %% [markdown]
# ## Learn and walk
#
# Where weights of this project know the skeleton, they learn each style from one clip of it (with a style network at
# hand: all files as one style, by fine-tuning). Else a small network learns all styles anew. Then each style walks for
# twelve seconds at the speed of its data, led and finished as in notebook 09, and the last six are judged; the first
# style's walk is written as BVH and read back.

# %%
driven = {kind: own_motion.learn_and_drive(report, working / kind, steps) for kind, report in reports.items()}
heads = ("skeleton", "style", "speed m/s", "of the data", "steps", "alternate", "bones off %", "hips m", "of the data")
rows = [
    (
        kind,
        walk.style,
        f"{walk.speed:.2f}",
        f"{walk.data_speed:.2f}",
        walk.steps.count,
        "yes" if walk.steps.alternation >= 0.9 else "no",
        f"{walk.bones.median:.1f}",
        f"{walk.hips:.2f}",
        f"{walk.data_hips:.2f}",
    )
    for kind, character in driven.items()
    for walk in character.walks
]
table(heads, *rows)

# %%
table(
    ("skeleton", "learned", "BVH read back is off by, mm"),
    *((kind, character.how, f"{character.round_trip:.4f}") for kind, character in driven.items()),
)

# %%
pictures = [motion for character in driven.values() for motion in character.motions.values()]
alt = "Strips of walks: for each skeleton a take of the data above the learned character."
write_png(figures / "15_your_own_mocap-walks.png", grid(pictures, Layout(frames=8, scale=60)), alt=alt)
Image(figures / "15_your_own_mocap-walks.png", alt=alt)

# %% [markdown]
# ## With more time
#
# `stylephase train --model lpn-film --data own:FOLDER --preset cpu --out build/mine` trains the paper's network on your
# folder in about half an hour of one processor; `stylephase rollout --weights build/mine --style NAME --path points.txt
# --out walk.bvh` walks it along a path; notebook [09](09_play.ipynb) drives it with the keys. If some are of no use,
# `stylephase inspect FOLDER --keep build/usable` puts the others, cut to where nothing jumps, into a folder first.

# %% [markdown]
# ## The record

# %%
params = {"folder": bool(folder), "steps": steps}
recorder = Recorder("15_your_own_mocap", dataset=dataset, preset=preset, params=params)
walks = [walk for character in driven.values() for walk in character.walks]
NEAR = np.log(1.25)
worst = max(character.round_trip for character in driven.values())
off = [abs(np.log(walk.speed / walk.data_speed)) if walk.finite and walk.speed > 0 else np.inf for walk in walks]
steps_alternate = [walk.finite and walk.steps.alternation >= 0.9 for walk in walks]
kinds = [kind for kind, character in driven.items() for _ in character.walks]
if not folder:
    good = {kind for kind, o, so in zip(kinds, off, steps_alternate, strict=True) if o <= NEAR and so}
    note = "; ".join(f"{kind}: {character.how}" for kind, character in driven.items())
    note += f"; with a style near its data's speed and alternating feet: {', '.join(sorted(good)) or 'none'}"
    recorder.claim("ours-own-skeletons", value=len(good), n=len(folders), dataset="own", note=note)
    well = [o <= NEAR and so for o, so in zip(off, steps_alternate, strict=True)]
    bad = [
        f"{kind} {w.style} at {w.speed:.2f}, data {w.data_speed:.2f} m/s" + ", without alternating steps" * (not so)
        for kind, w, fine, so in zip(kinds, walks, well, steps_alternate, strict=True)
        if not fine
    ]
    note = "mixamo is the synthetic walker under Mixamo's names" + f"; not so: {'; '.join(bad)}" * bool(bad)
    recorder.claim("ours-own-walks", value=float(np.mean(well)), n=len(walks), note=note)
recorder.claim("ours-own-bvh", value=worst, n=len(driven))
recorder.number("files", {kind: [len(r.usable), len(r.takes)] for kind, r in reports.items()}, "usable, all")
recorder.write(figures_folder)

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
# # Steering the character
#
# Paper: [M22], Section 4.4 and Figure 1. Time: preset quick half a minute, preset cpu some minutes.
#
# A trained network, a keyboard and a triangle of three styles make a character that one can drive. Open this notebook
# in JupyterLab, run it, and click the picture of the last but one section: W, A, S, D move, Q and E turn, Shift runs.
# Before that, the same is done by scripted keys, so that it can be measured.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set the network was trained on
preset: str = "quick"  # preset of the training
figures_folder: str = "build/figures"  # folder for pictures and numbers
runs_folder: str = "build/runs"  # folder of the trained runs
model: str = "lpn-film"  # model of the run
seconds: float = 10.0  # how long each style wanders; 3600 for the hour
crowd_weights: str = ""  # weights of the crowd, release for the authors' network, else those of the run

# %%
from functools import partial

import numpy as np
from IPython.display import Image, Markdown, Video

from stylephase.data.catalogue import load_catalogue
from stylephase.evaluation.robustness import as_json, endure, table
from stylephase.evaluation.rollouts import codes_of, start_of, walking_speed
from stylephase.features.store import VectorStore
from stylephase.models.released import load_weights
from stylephase.report import played
from stylephase.report.manifest import ROOT
from stylephase.report.png import write_png
from stylephase.report.recorder import Recorder
from stylephase.report.render import Layout, crowd, grid, movie
from stylephase.report.walks import pick
from stylephase.runtime.keyboard import RELEASE_KEYS, KeySettings
from stylephase.runtime.player import Player
from stylephase.runtime.speeds import speed_curves
from stylephase.runtime.viewer import Viewer

name = dataset.replace(":", "-").replace("/", "-")
run = sorted((ROOT / runs_folder).glob(f"{name}-{preset}-{model}-seed*/evaluation.json"))[0].parent
bundle, figures = load_weights(str(run)), ROOT / figures_folder
store = VectorStore(load_catalogue(dataset, bundle.styles), bundle.about["phases"])
styles = [store.load(style) for style in bundle.styles]
corners = tuple((pick(bundle.styles) * 3)[:3])
Markdown(f"{len(styles)} styles of `{bundle.about['data']}` ({bundle.about['origin']}, {bundle.about['licence']})")

# %% [markdown]
# ## A speed in metres per second
#
# > The user's control is blended with the predicted trajectory ([M22] 4.4).
#
# The wish is outweighed by the network's own path, so more has to be asked for than is wanted. How fast each style
# walks at each of a dozen gains is measured once; a wanted speed is read off that curve. Asked for: the speed at which
# the data of each style walks.

# %%
start, codes = start_of(styles, bundle.body), codes_of(bundle, styles)
curves = speed_curves(bundle, bundle.styles, start)
wanted = np.array([walking_speed(style) for style in styles])
gains = np.array([curves[style].gain(speed) for style, speed in zip(bundle.styles, wanted, strict=True)])
reached = played.speeds_at(bundle, codes, start, gains)
within = np.abs(reached / wanted - 1) <= 0.1
Markdown(played.speed_table(bundle.styles, wanted, gains, reached))

# %%
Markdown(f"{within.sum()} of {len(within)} styles come within 10 % of the speed of their data.")

# %% [markdown]
# ## Keys
#
# A script holds W for four seconds, W and Q for two, D for three, Shift and W for three, then nothing. The wish
# follows the keys by a quarter a frame, as in the release. Look at the turn, the side steps, the run.

# %%
player = Player(bundle, corners, speed=float(np.median(wanted)), curves=curves)
player.mix((0.0, 0.0))
script = [("w", 4), ("wq", 2), ("d", 3), (["w", "shift"], 3), ("", 2)]
states = played.scripted(player, script)
motion = played.motion_of(states, bundle.body, corners[0])
shown = motion.frames(0, min(len(motion), 720))
alt = "The character walks, turns left, side-steps, runs and stops, as the keys say; one picture every second."
write_png(figures / "09_play-keys.png", grid([shown], Layout(frames=12, scale=70)), alt=alt)
Image(figures / "09_play-keys.png", alt=alt)

# %%
movie(figures / "09_play.mp4", motion.frames(120, min(len(motion), 600)), fps=30, size=(256, 224))
Video(str(figures / "09_play.mp4"), embed=True)

# %% [markdown]
# With W held the character should walk straight. The release asks it, while no key turns, for the facing that it has:
# its own sway then turns it off its way. Here the facing last asked for stays.

# %%
hold = partial(played.heading_drift, bundle, codes, start, gains, seconds=min(seconds, 30.0))
drifts = {"ours": hold(KeySettings()), "as released": hold(RELEASE_KEYS)}
lines = [f"{rule}: {np.median(d):.0f}° median, {d.max():.0f}° at most" for rule, d in drifts.items()]
Markdown(f"Off the first heading after {min(seconds, 30.0):.0f} s of W: " + "; ".join(lines) + ".")

# %% [markdown]
# ## Three styles at once
#
# > Barycentric coordinates weigh three styles ([M22] 4.4).
#
# The point goes round the triangle once in twelve seconds while the character walks. The largest acceleration of any
# joint is compared with the largest in walks of each of the three styles alone: a jump would show.

# %%
round_trip = played.round_trip(player, corners, 12.0)
alone = [played.corner_walk(player, corner, 4.0) for corner in range(3)]
jolts = {"mixing": played.jolt(round_trip), "one style": max(map(played.jolt, alone))}
motion = played.motion_of(round_trip, bundle.body, "three styles")
alt = "A walk whose style goes round a triangle of three styles in twelve seconds, one picture a second."
write_png(figures / "09_play-mixture.png", grid([motion], Layout(frames=12, scale=70)), alt=alt)
Image(figures / "09_play-mixture.png", alt=alt)

# %%
Markdown(" ".join(f"Largest acceleration, {which}: {value:.0f} m/s²." for which, value in jolts.items()))

# %% [markdown]
# ## A style as one vector
#
# > A style can be stored as one vector, from one clip or as an average ([M22] 4.4).
#
# One clip of four seconds is enough to walk on: from its code the character follows a random path. The stored code of
# the style, an average over clips, does the same beside it.

# %%
single = played.one_clip_codes(bundle, styles)
alone = endure(bundle, bundle.styles, single, start, gains, seconds)
Markdown(
    f"From the code of one clip {sum(not e.broken for e in alone)} of {len(alone)} styles walk for {seconds:.0f} s."
)

# %% [markdown]
# ## Random input
#
# Each style follows a random path of its own; its speed changes every few seconds, with stops. What no person does
# counts as broken: hips out of height, bones of wrong lengths, far off the path, too fast, not a number. The same
# check on the network with its weights shaken must find it broken.

# %%
found = endure(bundle, bundle.styles, codes, start, gains, seconds)
shaken = endure(played.shaken(bundle), bundle.styles, codes, start, gains, min(seconds, 10.0))
Markdown(table(found))

# %%
Markdown(
    f"Plausible for all of {seconds:.0f} s: {sum(not e.broken for e in found)} of {len(found)} styles; "
    f"with shaken weights {sum(not e.broken for e in shaken)} of {len(shaken)}."
)

# %% [markdown]
# ## A crowd
#
# [M22] Figure 1 shows many styles of one network. Each character here has a style of its own; all are made in one
# batch. With `crowd_weights` set to `release` it is the authors' network and its hundred styles.

# %%
many = load_weights(crowd_weights) if crowd_weights else bundle
walkers = played.crowd_motions(many, start=None if crowd_weights else start, gains=gains)
columns = int(np.ceil(np.sqrt(4 * len(walkers))))
alt = f"{len(walkers)} characters in {len(walkers)} styles, each in a pose of its walk."
write_png(figures / "09_play-crowd.png", crowd(walkers, columns=columns), alt=alt)
Image(figures / "09_play-crowd.png", alt=alt)

# %% [markdown]
# ## Drive it
#
# Click the picture and use the keys; drag the point of the triangle, choose styles, draw a path on the ground. Without
# a kernel the recorded run of above is all that there is.

# %%
Viewer(player, recording=played.recording(states))

# %% [markdown]
# ## The record

# %%
params = {"model": model, "runs_folder": runs_folder, "seconds": seconds, "crowd_weights": crowd_weights}
recorder = Recorder("09_play", dataset=dataset, preset=preset, params=params, data_files=[run / "evaluation.json"])
played.record(recorder, walkers=len(walkers), alone=alone, jolts=jolts, released=bool(crowd_weights), dataset=dataset)
recorder.number("speeds within 10 %", int(within.sum()), f"of {len(within)} styles")
recorder.number("heading drift, ours", float(drifts["ours"].max()), "degrees at most")
recorder.number("heading drift, as released", float(drifts["as released"].max()), "degrees at most")
recorder.number("plausible to the end", sum(not e.broken for e in found), f"of {len(found)} styles, {seconds:g} s each")
recorder.number("plausible to the end, shaken weights", sum(not e.broken for e in shaken), f"of {len(shaken)} styles")
recorder.number("endurance", as_json(found))
recorder.write(figures_folder)

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
# Paper: [M22], Section 4.4 and Figure 1. Time: preset quick a minute, preset cpu with an hour of random input 50
# minutes on a machine in use.
#
# A trained network, a keyboard and a triangle of three styles make a character that one can drive: run the first cells
# and drive a zombie. Then the same is done by scripted keys, so that it can be measured.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set the network was trained on
preset: str = "quick"  # preset of the training
figures_folder: str = "build/figures"  # folder for pictures and numbers
runs_folder: str = "build/runs"  # folder of the trained runs
model: str = "lpn-film"  # model of the run
weights: str = ""  # folder of weights, such as data/pretrained/bandai-namco, instead of a run
seconds: float = 10.0  # how long each style wanders; 3600 for the hour
crowd_weights: str = ""  # weights of the crowd, release for the authors' network, else those of the run

# %%
from dataclasses import replace
from functools import partial

import numpy as np
from IPython.display import Image, Markdown, Video

from stylephase.data.catalogue import load_catalogue
from stylephase.evaluation.bench.character import difference, frame_costs, one_frame
from stylephase.evaluation.bench.crowds import crowd_rows
from stylephase.evaluation.crowd import crowd_of, endure_from_one_clip, recognised, released_crowd
from stylephase.evaluation.looks import (
    arms_of,
    half_way,
    looks_of,
    mixing_accelerations,
    recorded_accelerations,
    ring,
    ways_of_finishing,
)
from stylephase.evaluation.robustness import as_json, endure, shaken
from stylephase.evaluation.robustness import table as endured_table
from stylephase.evaluation.rollouts import codes_of, walking_speed
from stylephase.evaluation.runs import run_name, with_style_network
from stylephase.evaluation.starts import walked_starts
from stylephase.evaluation.steered import (
    NEAR,
    after_standing,
    changed_speeds,
    drift,
    forward_speeds,
    reached_speeds,
    trajectory_blend,
    ways_aside,
)
from stylephase.evaluation.style import style_space
from stylephase.features.store import VectorStore, for_gate
from stylephase.models.released import load_weights
from stylephase.report import played, played_claims
from stylephase.report.manifest import ROOT
from stylephase.report.png import write_png
from stylephase.report.recorder import QUICK, Recorder
from stylephase.report.render import Layout, crowd, grid, movie
from stylephase.report.show import figure, table
from stylephase.report.walks import pick
from stylephase.runtime.graph import FastNetwork, to_onnx
from stylephase.runtime.keyboard import RELEASE_KEYS, KeySettings
from stylephase.runtime.mixtures import CORNERS
from stylephase.runtime.pace import at_pace
from stylephase.runtime.plans import Steady
from stylephase.runtime.player import Player
from stylephase.runtime.viewer import Viewer
from stylephase.runtime.walkers import NetworkWalker

# %% [markdown]
# ## A zombie, at once
#
# Weights that lie with the code, of 91 of the paper's styles (trained on motion that the authors' network generated):
# neither data nor training are needed. Run the cells as far as this one, for while more are running the kernel cannot
# answer, and click the picture: W, A, S, D move, Q and E turn, Shift runs; drag the point of the triangle to mix the
# three styles. Without a kernel a recorded walk is played.

# %%
zombie = Player(load_weights(str(ROOT / "data/pretrained/lpn-rollouts")), ("Zombie", "Old", "HighKnees"))
zombie.mix(CORNERS[0])
walk = played.scripted(zombie, [("w", 6)])
Viewer(zombie, recording=played.recording(walk))

# %% [markdown]
# ## The network that is measured

# %%
name = run_name(dataset, preset, model)
runs = sorted((ROOT / runs_folder).glob(f"{name}-seed*/evaluation.json"))
folder = ROOT / weights if weights else runs[0].parent
bundle, figures = load_weights(str(folder)), ROOT / figures_folder
store = VectorStore(load_catalogue(dataset, bundle.styles), bundle.about["phases"])
styles = [for_gate(store.load(style), bundle.layout) for style in bundle.styles]
corners = tuple((pick(bundle.styles) * 3)[:3])
# Weights that are passed on bring their starts along; those of a run get them here, as `stylephase export` makes them.
bundle = bundle if bundle.starts else replace(bundle, starts=walked_starts(bundle, styles))
Markdown(f"{len(styles)} styles of `{bundle.about['data']}` ({bundle.about['origin']}, {bundle.about['licence']})")

# %% [markdown]
# ## A speed in metres per second
#
# > The user's control is blended with the predicted trajectory ([M22] 4.4).
#
# How fast each style goes at each of a dozen gains is measured once; a wanted speed is read off that curve, and the
# last second of walking corrects it. Asked for: the speed at which the data of each style walks. The release's way, a
# speed taken for a gain, must do worse. Characters begin at the moment of their own walk that is kept with the weights.

# %%
walker, codes = NetworkWalker(bundle), codes_of(bundle, styles)
start, curves = walker.start(codes), walker.curves(bundle.styles, grounded=True)
wanted = np.array([walking_speed(style) for style in styles])
gains = np.array([curves[style].gain(speed) for style, speed in zip(bundle.styles, wanted, strict=True)])
led = reached_speeds(bundle, codes, start, at_pace(Steady(gains), wanted))
as_gain = reached_speeds(bundle, codes, start, Steady(wanted))
Markdown(played.speed_table(bundle.styles, wanted, gains, led))

# %%
within, by_gain = (int((np.abs(v / wanted - 1) <= NEAR).sum()) for v in (led, as_gain))
Markdown(f"Within 10 % of the speed of their data: {within} of {len(wanted)} styles; with the gain alone {by_gain}.")

# %% [markdown]
# Who has stood for three seconds may shuffle on, and who takes on another style may keep the way of walking that it is
# in; both are pushed until they walk. Without that lead it shows.

# %%
waiting = after_standing(Steady(gains), 3.0)
stood = reached_speeds(bundle, codes, start, at_pace(waiting, wanted), seconds=24.0)
unled = reached_speeds(bundle, codes, start, waiting, seconds=24.0)
changed = changed_speeds(bundle, codes, start, gains, wanted)
cases = {"after standing": (stood, wanted), "after standing, not led": (unled, wanted)}
cases |= {"after a change of style": (changed, np.roll(wanted, -1))}
later = {case: int((np.abs(v / asked - 1) <= NEAR).sum()) for case, (v, asked) in cases.items()}
Markdown("; ".join(f"{case}: {count} of {len(wanted)} styles within 10 %" for case, count in later.items()))

# %% [markdown]
# Styles also have faster gaits. Which of their speeds, means over whole takes, are reached?

# %%
asked = [(s, gait, speed) for s in styles for gait, speed in forward_speeds(s).items()]
speeds = np.array([speed for *_, speed in asked])
paced = [curves[s.style].reached(speed) for s, _, speed in asked]
plan = at_pace(Steady(np.array([curves[s.style].gain(speed) for s, _, speed in asked])), np.array(paced))
many = [s for s, *_ in asked]
each = codes_of(bundle, many)
gaits = reached_speeds(bundle, each, walker.start(each), plan)
missed = [
    f"{s.style} {gait} {v:.2f}: {r:.2f}" for (s, gait, v), r in zip(asked, gaits, strict=True) if abs(r / v - 1) > 0.1
]
by_gait = played.reached_by_gait([gait for _, gait, _ in asked], gaits / speeds)
Markdown(
    f"{len(asked) - len(missed)} of {len(asked)} speeds of gaits are reached; not these (m/s): {'; '.join(missed)}"
)

# %% [markdown]
# Some takes go aside or backward: each character is asked to go at their angle and speed, facing ahead. Led straight
# ahead at that speed it must not pass.

# %%
sideways = ways_aside(bundle, styles, curves)
Markdown(played.aside_table(sideways) if sideways else "These data have no such takes.")

# %% [markdown]
# ## The user's path and the network's
#
# > The user's control is blended with the predicted trajectory ([M22] 4.4).
#
# With the network's output held fixed, the wish is moved by one metre a second, then the predicted path by one metre.
# How far does each point of the path that the network sees next follow? Both must count everywhere, the wish the more
# the further ahead. With the wish left out nobody turns when asked to.

# %%
blend = trajectory_blend(bundle, codes, start, gains)
shares = [f"{u:.2f} and {n:.2f}" for u, n in zip(blend.user, blend.network, strict=True)]
Markdown(
    f"Shares of the wish and of the network, point by point: {'; '.join(shares)}. Turns of 90° end "
    f"{blend.turned.mean():.0f}° off, with the wish left out {blend.unheard.mean():.0f}°."
)

# %% [markdown]
# ## Feet that stay, bones that hold
#
# > Inverse kinematics driven by the predicted contacts reduces foot sliding ([M22] 4.4).
#
# The same walks as the network gives them; grounded, so that the body moves as its standing foot lets it; and finished:
# feet in contact held, hands brought to where they are predicted, bones constant. Two wrong locks must be found out:
# feet that are held while the other one stands, and a lock without softness. Accelerations are told against recorded
# walks of the same style and length.

# %%
ways = ways_of_finishing(bundle, codes, start, gains, wanted, 15.0)
looks = {which: looks_of(run, bundle.body) for which, run in ways.items()}
recorded = recorded_accelerations(store, bundle.styles, 12.0)
Markdown(played.looks_table(looks, recorded))

# %% [markdown]
# ## Arms of styles in between
#
# > Interpolated styles give wrong arm rotations now and then; inverse kinematics along each arm mends them
# > ([M22] 4.4).
#
# How far are the hands, by the predicted rotations alone, from where they are predicted, in each style and half-way
# between two? And with arms that are led there?

# %%
pairs = ring(bundle.styles)
pure = arms_of(ways["grounded"], bundle.body)
gain_of = dict(zip(bundle.styles, gains.tolist(), strict=True))
speed_of = dict(zip(bundle.styles, wanted.tolist(), strict=True))
half = arms_of(half_way(bundle, gain_of, speed_of, pairs, 15.0), bundle.body)
at = {style: k for k, style in enumerate(bundle.styles)}
more_wrong = half.wrong - np.array([(pure.wrong[at[a]] + pure.wrong[at[b]]) / 2 for a, b in pairs])
Markdown(
    f"Hands by rotations alone are {1000 * pure.by_rotations.mean():.0f} mm off in pure styles and "
    f"{1000 * half.by_rotations.mean():.0f} mm in between; led ones {1000 * half.led.mean():.1f} mm."
)

# %% [markdown]
# ## What a frame costs
#
# One character on one thread, by the processor's clock; with weights of 8 bits the first frame differs by so much.

# %%
fast = {"ONNX": FastNetwork(to_onnx(bundle)), "8 bits": FastNetwork(to_onnx(bundle, quantised=True))}
one = walker.start(bundle.code(corners[0])[None])
costs = frame_costs(bundle, bundle.code(corners[0]), one, fast)
two = [one_frame(bundle, codes, start, gains, fast=network) for network in (None, fast["8 bits"])]
bits = difference(*two, bundle.body)
Markdown("; ".join(f"{part}: {ms:.2f} ms" for part, ms in costs.items()) + f"; 8 bits differ by {bits:.2f} mm a joint")

# %% [markdown]
# ## Keys
#
# The wish follows the keys by a quarter a frame, as in the release. Look at the turn, the run, and what D does:
# Bandai-Namco's takes to the side are diagonals, so a character of these data goes diagonally ahead.

# %%
player = Player(bundle, corners, speed=float(np.median(wanted)), curves=curves)
player.mix((0.0, 0.0))
script = [("w", 4), ("wq", 2), ("d", 3), (["w", "shift"], 3), ("", 2)]
states, held = played.scripted(player, script), played.held_at_each(script)
motion = played.motion_of(states, bundle.body, corners[0])
alt = "The character walks, turns left, goes diagonally ahead, runs and stops; one pose about every second."
captions = tuple(held[int(k)] for k in np.linspace(0, len(held) - 1, 14))
picture = grid([motion], Layout(frames=14, scale=60, view="three-quarter", captions=captions))
write_png(figures / "09_play-keys.png", picture, alt=alt)
Image(figures / "09_play-keys.png", alt=alt)

# %%
alt = "The same way from above, coloured by the keys that are held, with strokes where the character faces."
figure(played.track_plot(states, held), figures / "09_play-track.png", alt)

# %%
movie(figures / "09_play.mp4", motion.frames(120, min(len(motion), 600)), fps=30, size=(256, 224))
Video(str(figures / "09_play.mp4"), embed=True)

# %% [markdown]
# With W held the character should walk straight. The release asks it, while no key turns, for the facing that it has:
# its own sway then turns it off its way. Here the facing last asked for stays. Who faces ahead may still walk aside, so
# the player turns the wish against that; where it leads to speeds alone it shows.

# %%
hold = partial(drift, bundle, codes, start, gains, seconds=min(seconds, 30.0))
drifts = {"ours": hold(wanted, KeySettings()), "led to speeds alone": hold(wanted, KeySettings(), straightens=False)}
drifts |= {"keys as released": hold(wanted, RELEASE_KEYS)}
lines = [
    f"{rule}: heading {np.median(d.degrees):.0f}° off in the median, {d.degrees.max():.0f}° at most; "
    f"{np.median(d.metres):.1f} m beside the way in the median, {d.metres.max():.1f} m at most"
    for rule, d in drifts.items()
]
Markdown(f"After {min(seconds, 30.0):.0f} s of W. " + ". ".join(lines) + ".")

# %% [markdown]
# ## Three styles at once
#
# > Barycentric coordinates weigh three styles ([M22] 4.4).
#
# The point goes round the triangle once in twelve seconds. The largest acceleration of any joint is compared with that
# of mixtures that are held: corners and middles of the sides. A mixture thrown from corner to corner must show.

# %%
triples = played.triples(bundle.styles, most=1 if preset == QUICK else 7)
threes = [Player(bundle, three, speed=float(np.median(wanted)), curves=curves) for three in triples]
mixed = [mixing_accelerations(each, 12.0) for each in threes]
mixing = np.array([[found[which] for which in ("changing", "held", "jumping")] for found in mixed])
round_trip = played.round_trip(player, corners, 12.0)
motion = played.motion_of(round_trip, bundle.body, "three styles")
alt = f"A walk whose style goes in twelve seconds from {corners[0]} to {corners[1]}, {corners[2]} and back."
captions = tuple(["" if k % 4 else corners[k // 4 % 3] for k in range(13)])
write_png(figures / "09_play-mixture.png", grid([motion], Layout(frames=13, scale=70, captions=captions)), alt=alt)
Image(figures / "09_play-mixture.png", alt=alt)

# %%
ratios = np.exp(np.log(mixing / mixing[:, [1]]).mean(axis=0))
Markdown(
    f"Largest acceleration against held mixtures: {ratios[0]:.2f} times while the mixture moves, "
    f"{ratios[2]:.2f} times where it jumps ({len(triples)} triangles)."
)

# %% [markdown]
# ## A style as one vector
#
# > A style can be stored as one vector, from one clip or as an average ([M22] 4.4).
#
# The character follows a random path from the stored mean of codes, and where the network that makes codes is at hand,
# from the code of one clip of four seconds too. Its walk must be nearest to recorded ones of its style, and dealt each
# other's codes the characters must not be recognised.

# %%
lines = [curves[style] for style in bundle.styles]
wander = partial(endure, bundle, bundle.styles, gains=gains, seconds=seconds, curves=lines)
alone = wander(codes, start, seconds=min(seconds, 30.0), fast=fast["ONNX"], seed=1)
space = style_space(styles, bundle.body.layout)
known = recognised(bundle, codes, start, gains, space)
maker = bundle if bundle.makes_codes else with_style_network(ROOT / runs_folder, name)
one_clip = maker and endure_from_one_clip(maker, styles, wanted, min(seconds, 60.0), space)
held = {"stored means": (alone, known)} | ({"one clip": (one_clip.endured, one_clip.recognised)} if one_clip else {})
table(
    ("codes", "stay plausible", "nearest to their own", "with each other's codes", "of"),
    *((s, sum(not e.broken for e in found), r.right, r.dealt, r.count) for s, (found, r) in held.items()),
)

# %% [markdown]
# ## Random input
#
# Each style follows a random path; its speed changes every few seconds, with stops. What no person does counts as
# broken: hips out of height, bones of wrong lengths, far off the path, too fast, not a number. With its weights shaken
# the network must be found broken.

# %%
found = wander(codes, start, fast=fast["ONNX"])
broken = endure(shaken(bundle), bundle.styles, codes, start, gains, min(seconds, 10.0))
Markdown(endured_table(found))

# %%
Markdown(
    f"Plausible for all of {seconds:.0f} s: {sum(not e.broken for e in found)} of {len(found)} styles; "
    f"with shaken weights {sum(not e.broken for e in broken)} of {len(broken)}."
)

# %% [markdown]
# ## A crowd
#
# [M22] Figure 1 shows many styles of one network; here each has a way of its own, all in one batch (with
# `crowd_weights` set to `release`, the authors' hundred). Can they be told apart? Two more walks of each, on other
# ways, say what its style is like; dealt each other's codes the characters must not be recognised.

# %%
whose = load_weights(crowd_weights) if crowd_weights else bundle
shown = released_crowd(whose) if crowd_weights else crowd_of(bundle, start, gains=gains)
motions = played.crowd_motions(shown, whose)
columns = int(np.ceil(np.sqrt(4 * len(motions))))
alt = f"{len(motions)} characters in {len(motions)} styles, each in a pose of its walk."
write_png(figures / "09_play-crowd.png", crowd(motions, columns=columns), alt=alt)
Image(figures / "09_play-crowd.png", alt=alt)

# %%
Markdown(f"{shown.right} of {shown.count} are nearest to other walks of their own style; dealt anew {shown.dealt}.")

# %% [markdown]
# And are they the styles of the data? As above, of the network that is measured:

# %%
Markdown(f"{known.right} of {known.count} are nearest to their own style; dealt anew {known.dealt}.")

# %%
rates = crowd_rows()
Markdown("\n".join(f"* {row.name}: {row.ours:.0f}, {row.ratio:.1f} times one by itself" for row in rates))

# %% [markdown]
# ## Drive it
#
# As the zombie above; styles can be chosen too, and a path drawn on the ground. Without a kernel the scripted run is
# played.

# %%
Viewer(player, recording=played.recording(states))

# %% [markdown]
# ## The record

# %%
params = {"model": model, "runs_folder": runs_folder, "weights": weights}
params |= {"seconds": seconds, "crowd_weights": crowd_weights}
kept = "weights.safetensors" if weights else "evaluation.json"
recorder = Recorder("09_play", dataset=dataset, preset=preset, params=params, data_files=[folder / kept])
result = played_claims.Found(
    dataset=dataset,
    recorded=recorded,
    looks=looks,
    pure=pure,
    half=half,
    more_wrong=played_claims.effect(more_wrong),
    mixing=mixing,
    costs=costs,
    wanted=wanted,
    led=led,
    gaits=by_gait,
    aside=sideways,
    endured=found,
    alone=alone,
    one_clip=one_clip,
    blend=blend,
    recognised=known,
    crowd=shown,
    released=bool(crowd_weights),
    seconds=seconds,
)
played_claims.record(recorder, result)
recorder.number("speeds within 10 %", within, f"of {len(wanted)} styles")
recorder.number("speeds within 10 %, gain alone", by_gain, f"of {len(wanted)} styles")
for case, count in later.items():
    recorder.number(f"speeds within 10 %, {case}", count, f"of {len(wanted)} styles")
recorder.number("speeds of gaits within 10 %", len(asked) - len(missed), f"of {len(asked)}")
for which, seen in looks.items():
    recorder.number(f"slide in contact, {which}", [float(np.median(seen.skate)), float(seen.skate.max())], "m/s")
    ratio = seen.acceleration / recorded
    recorder.number(f"largest acceleration, {which}", [float(np.median(ratio)), float(ratio.max())], "of the recorded")
    recorder.number(f"bones off, {which}", float(seen.bones.max()), "mm")
recorder.number("costs", costs, "ms a frame")
recorder.number("8 bits differ", bits, "mm a joint")
recorder.number("acceleration while mixing, jumping", [float(ratios[0]), float(ratios[2])], "of held mixtures")
for rule, found_drift in drifts.items():
    ends = [[float(np.median(part)), float(part.max())] for part in (found_drift.degrees, found_drift.metres)]
    recorder.number(f"heading drift, {rule}", ends[0], "degrees, median and most")
    recorder.number(f"beside the way, {rule}", ends[1], "m, median and most")
recorder.number("told apart in the crowd of many styles", [shown.right, shown.dealt], f"of {shown.count}, dealt anew")
recorder.number("plausible to the end", sum(not e.broken for e in found), f"of {len(found)} styles, {seconds:g} s each")
recorder.number("plausible to the end, shaken weights", sum(not e.broken for e in broken), f"of {len(broken)} styles")
recorder.number("endurance", as_json(found))
recorder.number("recognised in a crowd, dealt anew", known.dealt, f"of {known.count} styles")
recorder.number("characters a second", {row.name: row.ratio for row in rates}, "times one by itself")
recorder.write(figures_folder)

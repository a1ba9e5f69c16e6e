# %% [markdown]
# # Data and skeleton
#
# Paper: [M22], Section 3, Table 1 and Figure 2. Time, with every preset: 1 minute on the synthetic walker,
# 3 minutes on `bandai-namco`, whose thousand files are all read.
#
# Whose motion is learned from, how much of it is there, on which skeleton, and what of it does the network see? The
# paper's own data, 100STYLE, are public; only their table of contents travels with this project.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set to look at
preset: str = "quick"  # preset of the run, without effect here
figures_folder: str = "build/figures"  # folder for pictures and numbers
shown: list[str] = []  # six pairs style/gait to draw, chosen for the data set where left empty

# %%
import numpy as np
from IPython.display import Image, Markdown
from matplotlib.figure import Figure
from tqdm import tqdm

from stylephase.data.archive import where
from stylephase.data.catalogue import cut_frames, load_catalogue, load_clip, usable
from stylephase.data.layouts import Entry, hash_content, published_entries
from stylephase.data.registry import DATA, datasets
from stylephase.data.split import PARTS, frames_by_part, split
from stylephase.errors import InputError
from stylephase.features.body import body_of
from stylephase.features.layout import CLIP_FRAMES, FPS, INPUT_SAMPLES, feature_joints, layout_of
from stylephase.features.vectors import vectors
from stylephase.motion.clip import Clip, Pose, forward_kinematics
from stylephase.motion.contacts import foot_contacts
from stylephase.motion.root import root_of, turn, zero_pose
from stylephase.motion.synthetic import SKELETON
from stylephase.report import palette, plots
from stylephase.report.manifest import ROOT
from stylephase.report.png import write_png
from stylephase.report.recorder import Recorder
from stylephase.report.render import Layout, Motion, grid
from stylephase.report.show import table

figures = ROOT / figures_folder
catalogue = load_catalogue(dataset)
about = catalogue.dataset
recorder = Recorder(
    "01_data_and_skeleton",
    dataset=dataset,
    preset=preset,
    params={"shown": shown},
    data_files=[DATA / "100style.csv", DATA / "registry.toml"],
)


# %% [markdown]
# ## Real, synthetic, generated
#
# Each result names its data. *Real capture* is a person in a suit. *Synthetic* is a formula that walks: its phases and
# contacts are known exactly, but it is easier to learn than a person. What a network has generated is never mixed with
# either.

# %%
table(
    ("name", "title", "origin", "licence", "source"),
    *((f"`{d.name}`", d.title, d.origin, d.licence, d.source) for d in datasets().values()),
)

# %% [markdown]
# ## This data set
#
# Every file is read, without T-poses and the way to the start where the data set marks them. Takes of less than 70
# frames are too short to have a second of past and future.

# %%
lengths = []
for entry in tqdm(catalogue.entries, desc="takes", unit="file"):
    clip = load_clip(entry, about, fps=FPS)
    start, stop = cut_frames(entry, about, clip)
    lengths.append(stop - start)
moving = [(entry, length) for entry, length in zip(catalogue.entries, lengths, strict=True) if not entry.idle]
too_short = [entry.path.name for entry, length in moving if not usable(length)]
table(
    (f"`{dataset}`", about.origin),
    ("licence", about.licence),
    ("credit", about.credit),
    ("styles, takes", f"{len(catalogue.styles)}, {len(catalogue.entries)}"),
    ("gaits", ", ".join(catalogue.gaits)),
    ("minutes at 60 frames a second", f"{sum(lengths) / FPS / 60:.1f}"),
    ("too short to learn from", ", ".join(too_short) or "none"),
)

# %% [markdown]
# ## Frames to learn from, and frames kept back
#
# Of each style and gait a tenth of the files, or of each file where there are few, is for validation and a tenth for
# the test, with half a second between two parts of one file.

# %%
entries, counts = [entry for entry, _ in moving], [length for _, length in moving]
segments = split(entries, counts, seed=0)
parts = frames_by_part(segments, entries)
COLOURS = dict(zip(PARTS, (palette.BODY, *palette.SEQUENCE[1:3]), strict=True))
with plots.style():
    axes = Figure(figsize=(7.2, 0.22 * len(parts) + 1.2)).subplots()
    left = np.zeros(len(parts))
    for part in PARTS:
        minutes = np.array([of_style[part] for of_style in parts.values()]) / FPS / 60
        axes.barh(list(parts), minutes, left=left, color=COLOURS[part], label=part, height=0.7)
        left += minutes
    axes.set(xlabel="duration (min)", ylabel="style")
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.figure.legend(loc="outside upper right", ncols=3)
alt = f"Minutes of each style of {dataset} for training, validation and test, as stacked bars."
plots.save_figure(axes.figure, figures / "01_data_and_skeleton-split.png", alt=alt)
Image(figures / "01_data_and_skeleton-split.png", alt=alt)

# %% [markdown]
# What to look for: styles of which there is little; their results are the weak ones. Check: no frame is given twice,
# and each style can be tested.

# %%
given = sum(len(segment) for segment in segments)
frames_given = {(segment.entry, frame) for segment in segments for frame in range(segment.start, segment.stop)}
assert len(frames_given) == given <= sum(counts)
untested = [style for style, of_style in parts.items() if not of_style["test"]]
shares = {part: sum(of_style[part] for of_style in parts.values()) / sum(counts) for part in PARTS}
shown_shares = ", ".join(f"{part} {share:.1%}" for part, share in shares.items())
Markdown(
    f"{shown_shares}, lost {1 - given / sum(counts):.1%}; styles without test frames: {', '.join(untested) or 'none'}"
)

# %% [markdown]
# ## Table 1 of the paper
#
# > How much there is of each gait in 100STYLE, in frames, minutes and per cent ([M22] Table 1).
#
# It follows from the published cuts: a take has as many frames as its stop lies after its start.

# %%
GAITS = {
    "backwards-run": "BR",
    "backwards-walk": "BW",
    "forwards-run": "FR",
    "forwards-walk": "FW",
    "sidestep-run": "SR",
    "sidestep-walk": "SW",
    "idling": "ID",
    "transitions": "TR",
    "total": "",
}
published = published_entries()
frames = {row: sum(e.stop - e.start for e in published if e.gait.startswith(gait)) for row, gait in GAITS.items()}
ours = {row: (n, n / FPS / 60, 100 * n / frames["total"]) for row, n in frames.items()}
paper = {row: recorder.catalogue.claims[f"m22-table1-{row}"].paper_value for row in GAITS}
table(
    ("gait", "frames", "paper", "minutes", "paper", "share %", "paper"),
    *(
        (row, f"{ours[row][0]:,}", f"{p[0]:,}", f"{ours[row][1]:.1f}", p[1], f"{ours[row][2]:.2f}", p[2])
        for row, p in paper.items()
    ),
)

# %% [markdown]
# Check: every frame count agrees exactly; the paper's minutes and shares are rounded loosely.

# %%
assert all(ours[row][0] == paper[row][0] for row in GAITS)
apart = {row: np.abs(np.subtract(ours[row], paper[row])) for row in GAITS}
names = sorted({entry.style for entry in published})
of_style = {name: {entry.gait for entry in published if entry.style == name} for name in names}
complete = [name for name, gaits in of_style.items() if {"ID", "FW", "BW", "SW", "FR", "BR", "SR"} <= gaits]
flags = {entry.style: (entry.symmetric, entry.stochastic) for entry in published}
symmetric, stochastic = (sum(flag[k] for flag in flags.values()) for k in (0, 1))
table(
    ("100STYLE as published", ""),
    ("styles", len(names)),
    ("of them with standing, and walking and running forwards, backwards and sideways", len(complete)),
    ("stochastic", stochastic),
    ("asymmetric", len(names) - symmetric),
)

# %% [markdown]
# ## The skeleton, and what its joints are for
#
# Joints get their roles from their names and the tree; where a file's joint frames run along the bones, orientations
# are measured against the rest pose drawn here. Left is blue, right is orange.

# %%
body = body_of(catalogue)
skeleton, roles = body.skeleton, body.skeleton.roles
places = np.zeros((len(skeleton), 3))
for joint, parent in list(enumerate(skeleton.parents))[1:]:
    places[joint] = places[parent] + body.rest[parent].T @ skeleton.offsets[joint]
places[:, 1] -= places[:, 1].min() - 0.02
resting = Motion(skeleton, places[None])
ends = tuple(skeleton.names[j] for j in roles.effectors)
views = [grid([resting], Layout(frames=1, view=view, scale=190, highlights=ends)) for view in ("front", "side")]
height = max(len(view) for view in views)
drawn = np.concatenate([np.pad(v, ((height - len(v), 0), (0, 0), (0, 0)), constant_values=255) for v in views], axis=1)
alt = f"The body of {dataset} at rest, from the front and from its right, with rings at hands and feet."
write_png(figures / "01_data_and_skeleton-body.png", drawn, alt=alt)
Image(figures / "01_data_and_skeleton-body.png", alt=alt)

# %% [markdown]
# The same from the front. Rings are the end effectors, which have phases of their own; squares sense contact with the
# floor; pale joints are end sites that the network does not see.

# %%
seen = feature_joints(skeleton)
SIDES = {"l": palette.LEFT, "r": palette.RIGHT, "m": palette.INK}
sides = np.where(np.abs(places[:, 0]) < 0.02, "m", np.where(places[:, 0] > 0, "l", "r"))
bones = places - places[list(skeleton.parents)]
flat = {j for j, bone in enumerate(bones) if abs(bone[0]) > abs(bone[1]) and j not in roles.thighs}
slanted = {j for j in flat | {skeleton.parents[j] for j in flat} if sides[j] == "l"}
with plots.style():
    axes = Figure(figsize=(7.2, 6.2)).subplots()
    for joint, parent in list(enumerate(skeleton.parents))[1:]:
        axes.plot(*places[[parent, joint], :2].T, color=palette.GROUND_LINE, linewidth=2, zorder=1)
    for joint, (x, y, _) in enumerate(places):
        axes.scatter(x, y, s=28, color=SIDES[sides[joint]], alpha=1.0 if joint in seen else 0.3, zorder=3)
        if sides[joint] != "r" and joint in seen:
            name, middle = skeleton.names[joint].split(":")[-1], sides[joint] == "m"
            how = {"rotation": 40, "va": "bottom"} if joint in slanted else {"va": "center"}
            how |= {"ha": "right"} if middle else {}
            axes.text(x - 0.03 if middle else x + 0.03, y + 0.012 * (joint in slanted), name, fontsize=7.5, **how)
    for joints, marker, label in ((roles.effectors, "o", "end effector"), (roles.toe_sensors, "s", "contact sensor")):
        chosen = places[list(joints)]
        rings = {"s": 130, "facecolors": "none", "edgecolors": palette.HIGHLIGHT, "linewidths": 1.4}
        axes.scatter(chosen[:, 0], chosen[:, 1], marker=marker, label=label, **rings)
    axes.set(aspect="equal", xlabel="x (m), left is positive", ylabel="y (m)")
    reach = max(1.15 * np.abs(places[:, 0]).max(), 0.6)
    axes.set_xlim(-reach, reach)
    axes.figure.legend(loc="outside upper right", ncols=2)
alt = f"The {len(skeleton)} joints of {dataset} from the front, named on the left side, end effectors ringed."
plots.save_figure(axes.figure, figures / "01_data_and_skeleton-joints.png", alt=alt)
Image(figures / "01_data_and_skeleton-joints.png", alt=alt)

# %%
pairs = {"thighs": roles.thighs, "toes": roles.toes, "hands": roles.hands, "contact sensors": roles.toe_sensors}
table(
    ("role", "left", "right"),
    *((role, *(skeleton.names[j] for j in pair)) for role, pair in pairs.items()),
    ("joints, and of them seen by the network", len(skeleton), len(seen)),
)

# %% [markdown]
# ## What the network sees of a frame
#
# > The trajectory of a second either way, and position, two axes and velocity of every joint, all in the frame of the
# > root; the next frame's phases and foot contacts beside its pose in the output ([M22] 3.2).

# %%
layouts = {"100STYLE": layout_of(SKELETON), dataset: body.layout}
SLICES = ("x_trajectory", "x_pose", "y_trajectory", "y_pose", "y_phases", "y_phase_updates", "y_contacts")
rows = [
    (f"`{name}`", *(getattr(of, name).stop - getattr(of, name).start for of in layouts.values())) for name in SLICES
]
table(
    ("part", *layouts),
    ("joints", *(of.joints for of in layouts.values())),
    *rows,
    ("**input x**", *(of.inputs for of in layouts.values())),
    ("**phases p**", *(of.gate_inputs for of in layouts.values())),
    ("**output y**", *(of.outputs for of in layouts.values())),
    ("**style clip**", *(f"{CLIP_FRAMES} x {of.pose}" for of in layouts.values())),
)

# %% [markdown]
# Check: with the joints of 100STYLE these are the paper's 348, 342, and 240 by 300.

# %%
widths = (layouts["100STYLE"].inputs, layouts["100STYLE"].outputs, CLIP_FRAMES, layouts["100STYLE"].pose)
assert widths == (348, 342, 240, 300)

# %% [markdown]
# ## Nothing is lost, and nothing of the world is kept
#
# Three checks on one take. From its vectors, in single precision, the joints come back where they were. Turning and
# moving the whole take changes no vector. Mirrored vectors are a person who does the same on the other side.

# %%
candidates = [entry for entry, length in moving if usable(length)]
example = min(candidates, key=lambda entry: entry.gait not in ("FW", "walk"))


def cut_clip(entry: Entry) -> Clip:
    whole = load_clip(entry, about, fps=FPS, skeleton=skeleton)
    return whole.frames(*cut_frames(entry, about, whole))


clip = cut_clip(example)
pose = forward_kinematics(clip)
root, layout = root_of(pose, skeleton), body.layout


def vectors_of(pose: Pose) -> np.ndarray:
    still, flying = np.zeros((len(clip), 8)), np.zeros((len(clip), 2), dtype=bool)
    return vectors(pose, skeleton, body.rest, FPS, still, flying).x


def drawn_from(x: np.ndarray) -> np.ndarray:
    position, forward, up, _ = np.moveaxis(x[:, layout.x_pose].reshape(len(x), layout.joints, 4, 3), 2, 0)
    axes = np.stack([np.cross(up, forward), up, forward], axis=-1) @ np.swapaxes(body.rest[list(seen)], 1, 2)
    joints = np.zeros((len(x), len(skeleton), 3))
    joints[:, seen] = position
    for site in set(range(len(skeleton))) - set(seen):
        parent = skeleton.parents[site]
        joints[:, site] = joints[:, parent] + axes[:, seen.index(parent)] @ skeleton.offsets[site]
    return joints


x = vectors_of(pose).astype(np.float32)
origins = np.insert(root.positions[:-1], 1, 0.0, axis=1)
again = np.einsum("tij,tkj->tki", root.matrices[:-1], drawn_from(x.astype(float))) + origins[:, None]
lost = float(np.linalg.norm(again - pose.positions[:-1], axis=-1).max())
world = turn(np.array(2.0))
moved = Pose(pose.positions @ world.T + np.array([30.0, 0.0, -8.0]), world @ pose.rotations)
changed = float(np.abs(vectors_of(moved) - vectors_of(pose)).max())
assert lost < 1e-5 and changed < 1e-9
Markdown(f"`{example.path.name}`: joints come back to {1e6 * lost:.1f} µm; a moved take changes no value by over 1e-9")

# %%
source, sign, _ = layout.mirror_x
middle = slice(len(x) // 2 - 45, len(x) // 2 + 45)
three = {"data": pose.positions[:-1], "from its\nvectors": again, "mirrored\nvectors": drawn_from(x[:, source] * sign)}
rows = [Motion(skeleton, positions[middle], label=label) for label, positions in three.items()]
alt = "One take as captured, as drawn from its vectors, and as drawn from its mirrored vectors."
write_png(figures / "01_data_and_skeleton-vectors.png", grid(rows, Layout(frames=8, scale=80)), alt=alt)
Image(figures / "01_data_and_skeleton-vectors.png", alt=alt)

# %% [markdown]
# What to look for: the first two rows are the same; in the third, blue and orange have changed places.

# %% [markdown]
# ## Figure 2: six styles
#
# > Six styles of 100STYLE; one of them is stochastic, one asymmetric, one moves its arms in cycles of their own ([M22]
# > Fig. 2).
#
# Six of this data set, over one and a half seconds.

# %%
SIX = {
    "synthetic": "KneesUp/BW GlancingBack/FW DraggedLeft/FW LowCrouch/FR HopOnRight/BW OffbeatArms/SR",
    "bandai-namco": "set1-giant/walk-back set1-musical/walk set2-elderly/walk set1-childish/run "
    "set1-chimpira/walk-back set1-not-confident/walk-left",
}
spread = np.linspace(0, len(candidates) - 1, 6).round().astype(int)
usual = [f"{candidates[k].style}/{candidates[k].gait}" for k in spread]
six = shown or SIX.get(dataset, " ".join(usual)).split()


def take_of(pair: str) -> Entry:
    style, _, gait = pair.rpartition("/")
    usable_ones = [entry for entry in catalogue.of(style, gait) if entry in candidates]
    if not usable_ones:
        raise InputError(f"no take {pair} in {dataset} that is long enough")
    return usable_ones[0]


def one_of_six(entry: Entry) -> Motion:
    positions = forward_kinematics(cut_clip(entry)).positions
    contacts = foot_contacts(positions[:, list(roles.toe_sensors[::-1])], FPS, about.contact)
    whole = Motion(skeleton, positions, contacts, label=f"{entry.style}\n{entry.gait}")
    first = max(min(len(whole) // 3, len(whole) - 90), 0)
    return whole.frames(first, min(first + 90, len(whole)))


alt = f"Six rows of frames of {dataset}: {', '.join(six)}."
rows = [one_of_six(take_of(pair)) for pair in six]
write_png(figures / "01_data_and_skeleton-fig2.png", grid(rows, Layout(frames=8, scale=70)), alt=alt)
Image(figures / "01_data_and_skeleton-fig2.png", alt=alt)

# %% [markdown]
# ## What a few seconds of the paper's own data say
#
# Some facts about the capture can be read off any file of 100STYLE: here the style Neutral.

# %%
original = datasets()["100style"]
at_hand = where(original) in ("cache", "mirror")
takes = []
for entry in load_catalogue(original.name, ["Neutral"]).entries if at_hand else ():
    clip = load_clip(entry, original, fps=original.fps)
    places = forward_kinematics(clip).positions
    left_hand, right_hand = (places[:, j] for j in clip.skeleton.roles.hands)
    apart_hands = np.linalg.norm(left_hand - right_hand, axis=1)
    inside = slice(*cut_frames(entry, original, clip))
    takes.append(
        (entry.gait, apart_hands[: inside.start].max(), apart_hands[inside].max(), np.ptp(places[:, 0], axis=0))
    )
if at_hand:
    body_height = float(np.ptp(zero_pose(clip.skeleton)[:, 1]))
    area = np.max([extent for *_, extent in takes], axis=0)[[0, 2]]
table(
    ("take of Neutral", "hands apart before the cut, at most (m)", "inside it", "hips went x, z (m)"),
    *((gait, f"{before:.2f}", f"{after:.2f}", f"{e[0]:.2f}, {e[2]:.2f}") for gait, before, after, e in takes),
)

# %% [markdown]
# What to look for: before the cut, in the T-pose, the hands are as far apart as the body is tall; inside it they never
# are.

# %% [markdown]
# ## What cannot be told here
#
# That Drunk never repeats itself, that Drag Right Leg differs between its sides and that the arms of Wild Arms keep
# their own time are statements about takes that are not at hand. The size of the capture area is a fact about a room.

# %% [markdown]
# ## The record


# %%
for row in GAITS:
    rounded = [ours[row][0], round(ours[row][1], 1), round(ours[row][2], 2)]
    close = apart[row][0] == 0 and apart[row][1] < 2 and apart[row][2] <= 0.1
    loose = apart[row][1] > 0.5 or apart[row][2] > 0.05
    note = "the frames agree exactly; the paper rounds minutes and shares loosely" if loose else ""
    about = {"tolerance": "frames 0, min 2, % 0.1", "n": len(published), "dataset": "100style"}
    recorder.claim(f"m22-table1-{row}", close, note, value=rounded, **about)
recorder.claim("m22-data-frames", value=frames["total"], n=len(published), dataset="100style")
listed = {"n": len(names), "dataset": "100style"}
recorder.claim("m22-data-styles", len(names) == 100, value=len(names), **listed)
recorder.claim("m22-data-gaits-per-style", len(complete) == 100, value=len(complete), **listed)

net = layouts["100STYLE"]
for identifier, value, printed in (
    ("m22-features-input", net.inputs, 348),
    ("m22-features-output", net.outputs, 342),
    ("m22-features-clip", [CLIP_FRAMES, net.pose], [240, 300]),
    ("m22-features-trajectory-points", len(INPUT_SAMPLES), 12),
    ("m22-features-phase", net.gate_inputs, 8),
):
    recorder.claim(identifier, value == printed, value=value)
recorder.claim("m22-features-local-frame", changed < 1e-9, value=changed, n=len(x), tolerance=1e-9)
ours_mirrored = sum(any(entry.symmetric for entry in catalogue.of(style)) for style in catalogue.styles)
note = f"as the list marks 100STYLE; of {dataset}, {ours_mirrored} of {len(catalogue.styles)} styles are mirrored"
recorder.claim("m22-features-mirrored", 0 < symmetric < len(names), note, value=symmetric, n=len(names))

# %%
if at_hand:
    short, takes_of = "excerpt of the style Neutral", {"n": len(takes), "dataset": "100style"}
    joints, used = len(clip.skeleton), len(feature_joints(clip.skeleton))
    recorder.claim("m22-data-frame-rate", clip.fps == 60, short, value=clip.fps, **takes_of)
    recorder.claim("m22-data-joints", joints == 28, short, value=joints, **takes_of)
    recorder.claim("m22-features-joints", used == 25, short, value=used, **takes_of)
    tall = "top of the head's end site over the toes' in the T-pose, without soles and hair"
    fits = abs(body_height - 1.82) < 0.05
    recorder.claim("m22-data-actor-height", fits, tall, value=round(body_height, 3), tolerance=0.05, dataset="100style")
    cut = all(before > 1.5 > 1 > after for _, before, after, _ in takes)
    recorder.claim(
        "m22-features-t-poses-cut", cut, f"T-poses lie outside the cuts in the {short}", value=cut, **takes_of
    )
else:
    for identifier in (
        "data-frame-rate",
        "data-joints",
        "features-joints",
        "data-actor-height",
        "features-t-poses-cut",
    ):
        recorder.not_testable(f"m22-{identifier}", "a file of 100STYLE: put its archive into STYLEPHASE_MIRROR")
hips = f"; in the excerpt the hips stay within {area[0]:.1f} by {area[1]:.1f} m" if at_hand else ""
recorder.not_testable("m22-data-capture-area", f"the room, or all takes of 100STYLE{hips}")
difficult = (
    f"the takes; the list marks {stochastic} styles stochastic, {len(names) - symmetric} asymmetric, none aperiodic"
)
recorder.not_testable("m22-data-difficulties", difficult)
recorder.not_testable("m22-fig2-drunk-stochastic", "takes of Drunk; the list marks it stochastic")
recorder.not_testable("m22-fig2-drag-leg-asymmetric", "takes of DragRightLeg; the list marks it asymmetric")
recorder.not_testable("m22-fig2-wild-arms-own-cycles", "takes of WildArms")
recorder.not_testable("m22-fig2-six-styles", f"takes of these six styles; drawn are six of {dataset}")

# %%
recorder.number("styles", len(catalogue.styles), "styles")
recorder.number("takes", len(catalogue.entries), "files")
recorder.number("duration", round(sum(lengths) / FPS / 60, 2), "min")
recorder.number("takes too short", len(too_short), "files")
for part, share in shares.items():
    recorder.number(f"share of {part}", round(share, 4))
recorder.number("joints", len(skeleton), "joints")
recorder.number("joints in the vectors", layout.joints, "joints")
recorder.number("widths of x and y", [layout.inputs, layout.outputs], "values")
recorder.number("largest error of a joint drawn from its vector", lost, "m")
recorder.number("hash of the motion files", hash_content(catalogue.entries))
recorder.write(figures_folder)

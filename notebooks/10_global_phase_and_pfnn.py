# %% [markdown]
# # Global phase and PFNN
#
# Paper: [M18], Sections 3.1 and 5.1. Time: 1 minute with every preset, on `pfnn` as on the synthetic walker.
#
# The weights of the network of 2018 change with one number, the phase: 0 where the right foot comes down, pi where the
# left one does. How do the weights follow it, and how well is it read without a person who looks at every step? With
# the data set `pfnn` this is asked of hand-labelled takes and trained weights (Holden, Komura and Saito 2017, for
# academic and non-commercial use).

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set to look at; pfnn for hand labels and trained weights
preset: str = "quick"  # preset of the run, without effect here
figures_folder: str = "build/figures"  # folder for pictures and numbers

# %%
import numpy as np
import torch
from IPython.display import Markdown
from matplotlib.figure import Figure

from stylephase.data.archive import fetch
from stylephase.data.catalogue import load_catalogue, load_clip
from stylephase.data.registry import DATA, datasets, released_weights
from stylephase.evaluation.budget.rows import built, parameters
from stylephase.evaluation.labels import (
    footfalls,
    label_delays,
    landing_delays,
    read_labelled,
    score_phase,
    scored_frames,
    stance_shares,
    steady_phase,
)
from stylephase.models import holden
from stylephase.models.pfnn import adapters
from stylephase.models.released_pfnn import load_pfnn
from stylephase.models.spline import POINTS, catmull_rom
from stylephase.models.synthesis import NetworkSettings
from stylephase.models.zoo import WIDTHS_2018, Widths, build_synthesis
from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import forward_kinematics, velocities
from stylephase.motion.contacts import ContactRule, foot_contacts
from stylephase.motion.root import root_of
from stylephase.motion.synthetic import STYLES, find_style, walk
from stylephase.phase.circular import distance
from stylephase.phase.global_phase import fitted_phase, global_phase
from stylephase.report import palette, plots
from stylephase.report.manifest import ROOT
from stylephase.report.recorder import Recorder
from stylephase.report.show import figure, table

TURN = 2 * np.pi
figures = ROOT / figures_folder
labelled = dataset == "pfnn"
recorder = Recorder(
    "10_global_phase_and_pfnn", dataset=dataset, preset=preset, params={}, data_files=[DATA / "registry.toml"]
)
LEFT_OUT = Markdown(f"*Left out on `{dataset}`: this part needs the data set `pfnn`.*")


# %% [markdown]
# ## 3.1 Weights as a function of the phase
#
# > The weights at a phase are blended from four control points by a cyclic cubic Catmull-Rom spline ([M18] Eq. 1).
#
# Equation 1 as it stands, beside the library's `catmull_rom`, which blends for many phases by one product.


# %%
def equation_1(p: float, a: np.ndarray) -> np.ndarray:
    d = 4 * p / (2 * np.pi) % 1
    k = [(int(np.floor(4 * p / (2 * np.pi))) + n - 1) % 4 for n in range(4)]
    value = a[k[1]] + d * (a[k[2]] / 2 - a[k[0]] / 2)
    value = value + d**2 * (a[k[0]] - 5 / 2 * a[k[1]] + 2 * a[k[2]] - a[k[3]] / 2)
    return value + d**3 * (3 / 2 * a[k[1]] - 3 / 2 * a[k[2]] + a[k[3]] / 2 - a[k[0]] / 2)


phases = np.linspace(0, TURN, 401)
coefficients = catmull_rom(torch.tensor(phases)).numpy()
assert np.allclose(coefficients, [equation_1(p, np.eye(4)) for p in phases], atol=1e-12)
assert np.allclose(coefficients.sum(axis=1), 1) and np.allclose(coefficients[::100], np.eye(4)[[0, 1, 2, 3, 0]])

with plots.style():
    axes = Figure(figsize=(7.2, 2.7)).subplots()
    for k, (column, colour) in enumerate(zip(coefficients.T, palette.SEQUENCE, strict=False)):
        axes.plot(phases, column, color=colour)
        place, side = (k * np.pi / 2, 1.04), "center" if k else "left"
        axes.annotate(f"point {k}", place, color=colour, ha=side, weight="bold")
    axes.annotate("point 0", (TURN, 1.04), color=palette.SEQUENCE[0], ha="right", weight="bold")
    axes.set(xlabel="phase (rad)", ylabel="coefficient (no unit)", ylim=(-0.16, 1.18), xlim=(0, TURN))
    axes.set_xticks(np.arange(5) * np.pi / 2, ["0\nright foot down", "π/2", "π\nleft foot down", "3π/2", "2π"])
figure(
    axes,
    figures / "10_global_phase_and_pfnn-spline.png",
    "The four coefficients of Equation 1 against the phase: each is 1 at its own quarter of the cycle.",
)

# %% [markdown]
# What to look for: at each quarter one control point speaks alone; between two of them the neighbours take a little
# away, which keeps the slope continuous.
#
# Does a trained network obey it? Holden's release holds its weights at fifty phases. From four control points fitted to
# all of them, some of the fifty should come back. The null model blends in straight lines.

# %%
INDICES = (0, 7, 13, 29, 41)
PARTS = ("b0", "b1", "b2", "W2")


def straight(phase: float) -> np.ndarray:
    start, share = int(4 * phase / TURN), 4 * phase / TURN % 1
    return (1 - share) * np.eye(4)[start % 4] + share * np.eye(4)[(start + 1) % 4]


def residual(part: str, index: int, coefficients: np.ndarray) -> float:
    points = np.load(weights / f"{part}.npy").astype(float)
    return float(np.abs(np.tensordot(coefficients, points, 1) - np.load(weights / f"raw_{part}_{index:03d}.npy")).max())


residuals, shown = {}, LEFT_OUT
if labelled:
    weights = fetch(released_weights()["pfnn-release"])
    for index in INDICES:
        p = TURN * index / 50
        for how, blend in (
            ("spline", catmull_rom(torch.tensor([p], dtype=torch.float64)).numpy()[0]),
            ("lines", straight(p)),
        ):
            residuals[how, index] = [residual(part, index, blend) for part in PARTS]
    worst = {how: max(max(residuals[how, index]) for index in INDICES) for how in ("spline", "lines")}
    assert worst["spline"] <= 3e-6 and worst["lines"] > 0.01
    shown = table(
        ("largest residual", *(f"phase {index} of 50" for index in INDICES)),
        *(
            (f"{part}, {how}", *(f"{residuals[key, index][row]:.1e}" for index in INDICES))
            for row, part in enumerate(PARTS)
            for key, how in (("spline", "Equation 1"), ("lines", "straight lines"))
        ),
    )
shown

# %% [markdown]
# What to look for: Equation 1 leaves the rounding of single precision in every part; straight lines are right only at
# phase 0, which is a control point.
#
# ## 5.1 The phase
#
# > A frame's phase is 0 at the contact of the right foot, pi at that of the left foot, and interpolated between.
# > Approximate contacts are taken from the speed of the feet and cleaned by hand ([M18] 5.1).
#
# `global_phase` does so from contacts, without cleaning by hand: gaps below 1/12 s are closed, contacts below 1/10 s
# dropped. `fitted_phase` follows the release of the 2022 paper and needs no contacts: in each second a sinusoid is
# fitted that is high while the right foot swings and low while the left one does.
#
# ### A walker whose phase is known
#
# Each style of the synthetic walker goes the way `TR1`, with stops, starts and changes of speed. Distances are
# circular, in cycles, after one offset for each take; the null model goes at the take's mean rate.

# %%
WALKER = datasets()["synthetic"].contact


def walker_phases(name: str) -> tuple[dict[str, np.ndarray], np.ndarray]:
    clip, truth = walk(find_style(name), "TR1")
    toes = forward_kinematics(clip).positions[:, list(clip.skeleton.roles.toe_sensors[::-1])]
    speeds = np.linalg.norm(velocities(toes, clip.fps), axis=-1)
    read = {"from contacts": global_phase(foot_contacts(toes, clip.fps, WALKER), clip.fps)}
    read |= {f"fitted, {s} s": fitted_phase(speeds, clip.fps, interval_seconds=s) for s in (1, 2)}
    known = np.isfinite(truth.global_phase)
    return read | {"constant rate": steady_phase(np.nan_to_num(truth.global_phase), known)}, truth.global_phase


walker = {}
for name in (style.name for style in STYLES if style.name != "HopOnRight"):
    read, truth = walker_phases(name)
    walker[name] = {how: score_phase(phase, truth, np.isfinite(truth)) for how, phase in read.items()}
HOWS = tuple(walker["Plain"])
MARKS = dict(zip(HOWS, ("o", "^", "s", "x"), strict=True))
COLOURS = dict(zip(HOWS, (palette.SEQUENCE[0], palette.SEQUENCE[1], palette.SEQUENCE[2], palette.QUIET), strict=True))
with plots.style():
    axes = Figure(figsize=(7.2, 4.2)).subplots()
    for k, how in enumerate(HOWS):
        values, rows = [walker[name][how].median for name in walker], np.arange(len(walker)) + 0.16 * (k - 1.5)
        axes.scatter(values, rows, color=COLOURS[how], marker=MARKS[how], s=34, label=how)
    axes.set_yticks(range(len(walker)), list(walker))
    axes.axvline(0.07, color=palette.HIGHLIGHT, linestyle="--", linewidth=1.2, label="bound")
    axes.set(xlabel="distance from the walker's own phase, median (cycles)", ylabel="style", xlim=(0, None))
    axes.invert_yaxis()
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=5)
figure(
    axes,
    figures / "10_global_phase_and_pfnn-walker.png",
    "Median distance from the walker's own global phase for each style and four ways to read it.",
)

# %%
largest = {how: max(walker[name][how].median for name in walker) for how in HOWS}
smallest_null = min(walker[name]["constant rate"].median for name in walker)
assert largest["from contacts"] <= 0.07 < smallest_null
table(
    ("way", "median of the styles", "largest median", "largest ninth decile"),
    *(
        (
            how,
            f"{np.median([walker[name][how].median for name in walker]):.3f}",
            f"{largest[how]:.3f}",
            f"{max(walker[name][how].ninth_decile for name in walker):.3f}",
        )
        for how in HOWS
    ),
)

# %% [markdown]
# What to look for: contacts give the phase within 0.04 cycles in every style, in the median. The fitted phase blurs
# every stop. `HopOnRight` has no such phase and is left out.
#
# ### Against labels made by hand
#
# Two takes of Holden's. The labels skip steps, so only half cycles of at most a second are counted. The mirrored copy
# of one take (`NewCaptures10`) was labelled anew, so that two sets of labels of one motion can be compared.

# %%
rule = datasets()["pfnn"].contact
RULES = {
    "from contacts": rule,
    "from contacts, below 0.15 m/s": ContactRule(0.15, rule.height),
    "from contacts, below 0.5 m/s": ContactRule(0.5, rule.height),
    "from contacts, within 3 cm of the floor": ContactRule(rule.speed, 0.03),
}
takes, phases_of, scores, halves, shown = {}, {}, {}, {}, LEFT_OUT


def read_phases(take) -> dict[str, np.ndarray]:
    """Each way of reading the take's phase, and the null model at the labels' own mean rate."""
    read = {how: global_phase(foot_contacts(take.toes, take.fps, of), take.fps) for how, of in RULES.items()}
    read |= {f"fitted, {s} s": fitted_phase(take.speeds, take.fps, interval_seconds=s) for s in (1, 2)}
    return read | {"constant rate": steady_phase(take.own, scored_frames(take.own, take.fps))}


if labelled:
    catalogue = load_catalogue(dataset)
    for entry in catalogue.entries:
        take = read_labelled(entry, catalogue.dataset)
        short = take.name.removesuffix("_000")
        takes[short], phases_of[short] = take, read_phases(take)
        counted = scored_frames(take.own, take.fps)
        scores[short] = {how: score_phase(phase, take.own, counted) for how, phase in phases_of[short].items()}
        halves[short] = len(footfalls(take.own, take.fps))
    shown = table(
        ("median / ninth decile (cycles), offset in brackets", *(f"{n}, {halves[n]} half cycles" for n in takes)),
        *(
            (
                how,
                *(f"{s.median:.3f} / {s.ninth_decile:.3f} ({s.offset:+.2f})" for s in (scores[n][how] for n in takes)),
            )
            for how in next(iter(scores.values()))
        ),
    )
    for name in takes:
        own, null = scores[name]["from contacts"], scores[name]["constant rate"]
        assert own.median <= 0.07 and own.ninth_decile <= 0.15 < null.ninth_decile
shown

# %% [markdown]
# What to look for: contacts stay below the bounds, 0.07 for the median and 0.15 for the ninth decile; a constant rate,
# although it knows the labels' mean rate, does not. `NewCaptures10` leads over rough ground, so this data set's rule
# asks for speed alone. That speed was chosen with these takes in view; half and nearly twice of it serve as well. The
# fitted phase is worse where single steps stand between rests.
#
# Some seconds of that take:

# %%
shown = LEFT_OUT
if labelled:
    name, start, stop = "NewCaptures10", 860, 1480
    take, part = takes[name], slice(860, 1480)
    seconds = np.arange(start, stop) / take.fps
    contacts = foot_contacts(take.toes, take.fps, rule)[part]
    with plots.style():
        above, below = Figure(figsize=(7.2, 4.4)).subplots(2, 1, sharex=True)
        for foot, (side, colour) in enumerate((("right toe", palette.RIGHT), ("left toe", palette.LEFT))):
            above.plot(seconds, take.speeds[part, foot], color=colour, label=side)
            standing = np.where(contacts[:, foot], -0.25 - 0.22 * foot, np.nan)
            above.plot(seconds, standing, color=colour, linewidth=4, solid_capstyle="butt")
        lines = (
            ("label", take.own, palette.INK, "-", 2.4),
            ("label of the mirrored copy", take.copy, palette.QUIET, "-", 1.6),
            ("from contacts", phases_of[name]["from contacts"], palette.SEQUENCE[2], "--", 1.6),
            ("fitted, 1 s", phases_of[name]["fitted, 1 s"], palette.SEQUENCE[1], ":", 1.8),
        )
        for label, phase, colour, dashes, width in lines:
            cycles = phase[part] / TURN
            broken = np.where(np.abs(np.diff(cycles, prepend=cycles[0])) > 0.5, np.nan, cycles)
            below.plot(seconds, broken, dashes, color=colour, linewidth=width, label=label)
        above.set(ylabel="speed (m/s)", ylim=(-0.8, 6), title=f"Toes of {name}; bars: contact")
        below.set(xlabel="time (s)", ylabel="phase (cycles)", title="Global phase", xlim=(seconds[0], seconds[-1]))
        above.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2)
        below.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=4, fontsize=8)
    alt = f"Toe speeds of {name} with contacts, and below the phase as labelled twice, from contacts and fitted."
    shown = figure(above, figures / "10_global_phase_and_pfnn-labels.png", alt)
shown

# %% [markdown]
# What to look for: the dashed line has its zero where a bar of the right foot begins, the black label a little later.
# From 10.1 to 11.5 s the label skips two steps: such stretches do not count.
#
# ### Why labels come late, and how noisy they are
#
# Each label of 0 or pi with which a counted half cycle begins is compared with moments of its own step: the end of the
# ankle's fall, about the heel's strike; the toe's first frame below a speed; the middle of the stance.

# %%
LIMITS = (0.3, 0.1, 0.05, 0.02)
sets, delays, shown = {}, {}, LEFT_OUT


def moments(take, labels: np.ndarray) -> dict[str, np.ndarray]:
    falls = footfalls(labels, take.fps)
    found = {"after the ankle's fall ends (s)": landing_delays(take.ankles[..., 1], falls, take.fps)}
    found |= {f"after the toe is below {v} m/s (s)": label_delays(take.speeds, falls, take.fps, v) for v in LIMITS}
    found["toe's speed at the label (m/s)"] = np.array([take.speeds[fall] for fall in falls])
    found["toe above its place in the next 0.2 s (cm)"] = np.array([100 * rise(take, *fall) for fall in falls])
    shares = stance_shares(foot_contacts(take.toes, take.fps, rule), falls)
    return found | {"share of the stance gone by": shares}


def rise(take, frame: int, foot: int) -> float:
    return float(take.toes[frame, foot, 1] - np.median(take.toes[frame : frame + round(0.2 * take.fps), foot, 1]))


def quartiles(values: np.ndarray) -> str:
    low, middle, high = np.nanpercentile(values, (25, 50, 75))
    return f"{middle:.3f} ({low:.3f} to {high:.3f})"


if labelled:
    sets = {name: (take, take.own) for name, take in takes.items()}
    sets["mirrored copy of NewCaptures10"] = (takes["NewCaptures10"], takes["NewCaptures10"].copy)
    delays = {name: moments(take, labels) for name, (take, labels) in sets.items()}
    shown = table(
        ("median (quartiles)", *delays),
        *((what, *(quartiles(of[what]) for of in delays.values())) for what in next(iter(delays.values()))),
    )
shown

# %%
shown = LEFT_OUT
if labelled:
    reach = np.arange(-48, 37)
    with plots.style():
        axes = Figure(figsize=(7.2, 3.2)).subplots()
        for (name, (take, labels)), colour in zip(sets.items(), palette.SEQUENCE, strict=False):
            falls = footfalls(labels, take.fps)
            around = np.array([take.speeds[np.clip(frame + reach, 0, None), foot] for frame, foot in falls])
            low, middle, high = np.percentile(around, (25, 50, 75), axis=0)
            axes.plot(reach / take.fps, middle, color=colour, label=f"{name} ({len(falls)} steps)")
            axes.fill_between(reach / take.fps, low, high, color=colour, alpha=0.18, linewidth=0)
        for speed, text, at, side in ((rule.speed, "contact", 0.295, "right"), (0.02, "rest", -0.395, "left")):
            axes.axhline(speed, color=palette.INK, linestyle=":", linewidth=1.0)
            axes.annotate(f"{text}: {speed} m/s", (at, speed * 1.1), ha=side, fontsize=9)
        axes.axvline(0, color=palette.HIGHLIGHT, linewidth=1.2)
        axes.set(xlabel="time from the label (s)", ylabel="toe speed (m/s)", yscale="log", xlim=(-0.4, 0.3))
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3, fontsize=8)
    alt = "Toe speed around labelled contacts: at the labels of the takes it just sinks under 0.02 m/s."
    shown = figure(axes, figures / "10_global_phase_and_pfnn-offset.png", alt)
shown

# %% [markdown]
# What to look for: the labels of both takes stand, nearly to the frame, where the toe is first slower than 0.02 m/s. So
# they mean a foot that rests, ours one that lands, and the offset is no error of either. A resting toe trembles, so
# that first frame is partly chance.
#
# How well do two sets of labels of one motion agree?

# %%
shown, ratio = LEFT_OUT, None
if labelled:
    take = takes["NewCaptures10"]
    both = scored_frames(take.own, take.fps) & scored_frames(take.copy, take.fps)
    contact = phases_of["NewCaptures10"]["from contacts"]
    noise = score_phase(take.copy, take.own, both)
    raw = np.median(distance(take.copy[both], take.own[both], TURN)) / TURN
    against = {"labels": score_phase(contact, take.own, both), "copy": score_phase(contact, take.copy, both)}
    ratio = against["labels"].median / noise.median
    shown = table(
        (f"NewCaptures10, {noise.frames} frames", "median", "ninth decile", "offset"),
        *(
            (what, f"{s.median:.3f}", f"{s.ninth_decile:.3f}", f"{s.offset:+.3f}")
            for what, s in (
                ("labels of the copy against labels of the take", noise),
                ("from contacts against labels of the take", against["labels"]),
                ("from contacts against labels of the copy", against["copy"]),
            )
        ),
        ("labels against labels, without an offset", f"{raw:.3f}", "", ""),
    )
shown

# %% [markdown]
# What to look for: the automatic phase lies about as far from either set of labels as these lie from each other.
#
# ## Fig. 2: the network
#
# > Three layers, every weight a function of the phase ([M18] Fig. 2).
#
# The same by hand: Equation 1 blends the weights of a row's phase, which are then an ordinary network. A phase a tenth
# of a cycle later must give other outputs.


# %%
def elu(h: np.ndarray) -> np.ndarray:
    return np.where(h > 0, h, np.expm1(np.minimum(h, 0)))


def by_hand(h: np.ndarray, phase: float) -> np.ndarray:
    for k, layer in enumerate(network.layers):
        weight, bias = (equation_1(phase, getattr(layer, part).detach().numpy()) for part in ("weight", "bias"))
        h = h @ weight + bias
        h = elu(h) if k < 2 else h
    return h


torch.manual_seed(0)
network = build_synthesis("pfnn", WIDTHS_2018, 0, NetworkSettings()).double().eval()
for layer in network.layers:
    torch.nn.init.normal_(layer.bias)
frame, phase = torch.randn(5, WIDTHS_2018.inputs).double(), TURN * torch.rand(5, 1).double()
ours = network(frame, phase, torch.zeros(5, 0)).detach().numpy()
hand = np.stack([by_hand(frame[r].numpy(), float(phase[r, 0])) for r in range(5)])
late = np.stack([by_hand(frame[r].numpy(), float(phase[r, 0]) + TURN / 10) for r in range(5)])
fig2_off, fig2_null = float(np.abs(ours - hand).max()), float(np.abs(ours - late).max())
assert fig2_off < 1e-10 and fig2_null > 0.1
shapes = [tuple(layer.weight.shape[1:]) for layer in network.layers]
Markdown(f"layers {shapes}; largest difference {fig2_off:.1e}, a tenth of a cycle later {fig2_null:.2f}")

# %% [markdown]
# ## 5.1 The vectors
#
# > 12 points of the trajectory, one in ten frames, and 31 joints make 234 values; 400 come out ([M18] 5.1).
#
# A place and a facing for each point, position and velocity for each joint; out come the six points from the present
# on, position, velocity and two axes for each joint, the change of phase, and the root's step and turn. With both ends
# there would be 13 points and 238 values. The released network has the same points: near the root, its mean places lie
# as far apart as the root goes in ten frames.

# %%
points, ahead = len(holden.SAMPLES), len(holden.FUTURE_SAMPLES)
spacing, balance, shown = None, {}, LEFT_OUT


def turned(path) -> tuple[float, float]:
    """How far a take turns (degrees to the left), and how long it lasts (s)."""
    clip = read_bvh(path, metres_per_unit=catalogue.dataset.metres_per_unit)
    angles = root_of(forward_kinematics(clip), clip.skeleton).angles
    return float(np.degrees(angles[-1] - angles[0])), len(clip) / clip.fps


if labelled:
    released = load_pfnn(weights)
    depth = released.x_mean[holden.X_PLACES][points:]
    around = np.diff(depth)[[points // 2 - 1, points // 2]] / released.y_mean[holden.Y_STEP][1]
    spacing = float(around.mean())
    joints = sum(not site for site in load_clip(catalogue.entries[0], catalogue.dataset).skeleton.sites)
    inputs, outputs = 4 * points + 6 * joints, 4 * ahead + 12 * joints + 1 + 3
    alone = [turned(entry.path) for entry in catalogue.entries]
    copies = [turned(entry.path.with_name(f"{entry.path.stem}_mirror.bvh")) for entry in catalogue.entries]
    for what, of in (("the takes", alone), ("takes and mirrored copies", alone + copies)):
        balance[what] = sum(angle for angle, _ in of) / sum(seconds for _, seconds in of)
    lean = float(released.y_mean[holden.Y_TURN] / released.y_std[holden.Y_TURN])
    shown = table(
        ("what", "value"),
        ("values in, values out", f"{inputs}, {outputs}"),
        ("frames between neighbouring points of the released network", f"{spacing:.2f}"),
        *((f"mean turn of {what} (degrees/s, to the left)", f"{value:.2f}") for what, value in balance.items()),
        ("mean turn over its deviation, released network's data", f"{lean:.4f}"),
    )
shown

# %% [markdown]
# What to look for: the takes turn to the left, with their copies to neither side; the data of the released network
# hardly turn, so they were mirrored as well.
#
# ## What was recorded
#
# The takes of the paper were never published, so what it says of their number and length needs them.


# %%
needs = "the captures of the paper, which were never published"
for identifier in ("m18-data-styles", "m18-data-frames-per-style", "m18-data-gaits"):
    recorder.not_testable(identifier, needs)
printed = [recorder.catalogue.claims[name].paper_value for name in ("m18-data-styles", "m18-data-frames-per-style")]
hours = float(np.prod(printed)) / 60 / 3600
recorder.not_testable("m18-data-hours", f"{needs}; styles and frames in print make {hours:.2f} h at 60 frames a second")
recorder.not_testable("m18-data-frame-rate", f"{needs}; Holden's takes have 120 frames a second")
bounded = largest["from contacts"]
recorder.claim("ours-label-walker", value=round(bounded, 4), n=len(walker), dataset="synthetic")
if labelled:
    found = {how: [round(scores[n][how].ninth_decile, 3) for n in takes] for how in next(iter(scores.values()))}
    medians = [round(scores[n]["from contacts"].median, 3) for n in takes]
    frames = sum(scores[n]["from contacts"].frames for n in takes)
    recorder.claim("m18-data-skeleton", joints == 31, "Holden's takes, end sites not counted", value=joints)
    note = "against weights blended by hand with Equation 1; layers as of a network drawn at random"
    holds = len(shapes) == 3 and fig2_off < 1e-10 < fig2_null
    recorder.claim("m18-fig2-pfnn", holds, note, value=fig2_off, n=5)
    note = f"of Holden's network, whose statistics put {spacing:.1f} frames between two points"
    recorder.claim("m18-trajectory-points", points == 12 and abs(spacing - 10) < 0.5, note, value=points)
    # The printed share of an adapter in the network tells nearly how many values go in and out together.
    names = ("m18-features-input", "m18-features-output", "m18-full-adapter-share")
    wide_in, wide_out, full_share = (recorder.catalogue.claims[name].paper_value for name in names)
    whole = parameters(built("pfnn", Widths(inputs, 1, outputs), 0))
    adapter = 100 * parameters(adapters("full", 1, 512).adapters[0]) / whole
    fits = abs(adapter - full_share) < 0.05
    note = f"from the parts, with the joints of Holden's takes; a full adapter is then {adapter:.2f} % of the network, "
    note += f"in print {full_share}"
    recorder.claim("m18-features-input", inputs == wide_in and fits, note, value=inputs)
    recorder.claim("m18-features-output", outputs == wide_out and fits, note, value=outputs)
    even = abs(balance["takes and mirrored copies"]) < 0.05 * abs(balance["the takes"]) and abs(lean) < 0.01
    note = "degrees/s to the left of Holden's takes, alone and with their copies; the data of the network are even too"
    recorder.claim("m18-data-mirrored", even, note, value=[round(value, 2) for value in balance.values()], n=len(alone))
    note = "ninth decile of the distance from hand labels (cycles), " + " and ".join(takes)
    recorder.claim("m18-phase-label", max(found["from contacts"]) <= 0.15, note, value=found["from contacts"], n=frames)
    note = (
        "contacts are found from foot speed, and nobody cleans them: distance of the phase from hand labels over that "
    )
    note += "of two sets of hand labels from each other; above {0:g} cleaning would be worth its while"
    bound = recorder.catalogue.claims["ours-label-noise"].at_most
    recorder.claim("m18-phase-semi-automatic", ratio > bound, note.format(bound), value=round(ratio, 3), n=noise.frames)
    holds = worst["spline"] <= 3e-6 and worst["lines"] > 0.01
    note = f"largest residual of the release's weights {worst['spline']:.1e}, with straight lines {worst['lines']:.2f}"
    recorder.claim("m18-eq1-spline", holds, note, value=POINTS, n=len(INDICES) * len(PARTS))
    recorder.claim("ours-spline-release", value=float(f"{worst['spline']:.1e}"), n=len(INDICES) * len(PARTS))
    recorder.claim("ours-spline-linear", value=round(worst["lines"], 3), n=len(INDICES) * len(PARTS))
    recorder.claim("ours-label-median", value=medians, n=frames)
    recorder.claim("ours-label-ninth-decile", value=found["from contacts"], n=frames)
    recorder.claim("ours-label-null", value=found["constant rate"], n=frames)
    note = "a second is less than a cycle where single steps stand between rests, as in LocomotionFlat04"
    recorder.claim("ours-label-fitted", value=found["fitted, 1 s"], n=frames, note=note)
    recorder.claim("ours-label-noise", value=round(ratio, 3), n=noise.frames)
    rests = [float(np.nanmedian(delays[n]["after the toe is below 0.02 m/s (s)"])) for n in takes]
    recorder.claim("ours-label-rest", value=[round(rest, 3) for rest in rests], n=sum(halves.values()))
table(
    ("claim", "value", "verdict", "note"),
    *((r.name, "" if r.value is None else r.value, r.verdict, r.note) for r in recorder.record.results),
)

# %%
for how in HOWS:
    recorder.number(f"walker, {how}: largest median distance", largest[how], "cycles")
for name in takes:
    for how, score in scores[name].items():
        recorder.number(f"{name}, {how}: median distance from the labels", score.median, "cycles")
        recorder.number(f"{name}, {how}: offset", score.offset, "cycles")
if labelled:
    recorder.number("NewCaptures10: median distance of its two sets of labels", noise.median, "cycles")
    recorder.number("NewCaptures10: the same without an offset", raw, "cycles")
recorder.write(figures_folder)

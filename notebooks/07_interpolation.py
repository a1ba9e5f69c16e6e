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
# # Interpolation between styles
#
# Paper: [M22], Section 4.4 (blending), 5.1.2 and Fig. 8 (one-hot against FiLM), Section 6 (what goes wrong between).
# Time: preset quick 1 minute, preset cpu 5 minutes, after the trainings.
#
# Two styles are mixed by mixing their codes: FiLM's scales and shifts, or the weights of a one-hot vector. Does FiLM
# pass smoothly, and does one-hot stay with the first style until the end? Characters walk at eleven points between two
# codes, for many pairs of styles, and each walk is placed on the line between the walks of the pure styles.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set the networks were trained on
preset: str = "quick"  # preset of the trainings
figures_folder: str = "build/figures"  # folder for pictures and numbers
runs_folder: str = "build/runs"  # folder of the trained runs
models: list[str] = ["lpn-onehot", "lpn-film"]  # models to compare, with a run of seed 0 each
pair_count: int = 21  # pairs of styles at most
beside: str = "lpn-rollouts"  # data set with the pair of Fig. 8, used where both models have runs on it

# %%
import itertools

import numpy as np
import torch
from IPython.display import Image, Markdown

from stylephase.data.catalogue import load_catalogue
from stylephase.data.registry import dataset as find_dataset
from stylephase.errors import InputError
from stylephase.evaluation import interpolation
from stylephase.evaluation.comparison import difference as paired_difference
from stylephase.evaluation.interpolation import SHARES, blend_of, mean_over_pairs, walked_blends
from stylephase.evaluation.release_blends import FIG_8, PAST_THE_TRUNK, hand_to_trunk, release_blends
from stylephase.evaluation.report import groups_of
from stylephase.evaluation.runs import run_name
from stylephase.evaluation.style import style_space
from stylephase.features.layout import FPS
from stylephase.features.store import VectorStore
from stylephase.files import read_json
from stylephase.models.bundle import is_bundle, load_bundle
from stylephase.models.released import release_bundle
from stylephase.report import plots
from stylephase.report.blends import along_motion, along_plot, triangle_plot
from stylephase.report.manifest import ROOT
from stylephase.report.played import triples
from stylephase.report.png import write_png
from stylephase.report.recorder import Recorder
from stylephase.report.render import Layout, grid, movie
from stylephase.report.show import markdown_table
from stylephase.report.walks import walking_motion
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import roll_out

figures = ROOT / figures_folder
folders = {model: ROOT / runs_folder / run_name(dataset, preset, f"{model}-seed0") for model in models}
bundles = {model: load_bundle(folder) for model, folder in folders.items()}
walks = {model: read_json(folder / "evaluation.json")["rollouts"]["walks"] for model, folder in folders.items()}
gains = {model: {walk["style"]: walk["gain"] for walk in some} for model, some in walks.items()}
film = bundles[models[-1]]
store = VectorStore(load_catalogue(dataset, film.styles), film.about["phases"])
styles = {style: store.load(style) for style in film.styles}
frames = int(10 * FPS)
Markdown(f"Seed 0 of {', '.join(models)} on `{dataset}` ({find_dataset(dataset).origin}).")

# %% [markdown]
# ## Which pairs, and how a blend is measured
#
# > The user may choose three styles, and their FiLM parameters are blended by the place in a triangle ([M22] 4.4).
#
# A walk becomes a point: means and deviations of joint positions and velocities, in coordinates in which a style's own
# clips vary alike every way. `along` is where the walk of a blend lies on the line between the pure walks, 0 at the
# first and 1 at the second. An even blend gains a tenth with each tenth of the second style; a switch gains everything
# at once. The steering's gain is blended as the codes are.

# %%
group = max(groups_of(film.styles).values(), key=lambda names: sum(len(styles[name].x) for name in names))
every = list(itertools.combinations(group, 2))
most = min(6 if preset == "quick" else pair_count, len(every))
pairs = [every[k] for k in np.unique(np.linspace(0, len(every) - 1, most).astype(int))]
space = style_space(list(styles.values()), film.layout)


# %%
# Each blend walks twice, from a pose of the first style's data and from one of the second's.
runs = {model: walked_blends(bundles[model], gains[model], styles, pairs) for model in models}
ends = {model: [interpolation.blends_of([run], film.body, space) for run in two] for model, two in runs.items()}
both = {model: interpolation.blends_of(two, film.body, space) for model, two in runs.items()}
whole = [k for k in range(len(pairs)) if all(both[model][k] is not None for model in models)]
kept = [pairs[k] for k in whole]
blends = {model: [both[model][k] for k in whole] for model in models}
Markdown(f"{len(pairs)} pairs, of which {len(kept)} stayed finite throughout in both models.")

# %% [markdown]
# ## Smooth or not
#
# > One-hot tends to keep the first style until the interpolation is complete; FiLM changes smoothly ([M22] 5.1.2).
#
# `off the line` is the root mean square of how far `along` is from the share; an even blend has 0. The last rows are
# null models: a switch half-way, and the pure walks in random order. Brackets hold 95 of 100 other draws of the styles.

# %%
heads = {"off_line": "off the line", "largest_step": "largest of ten steps", "monotonicity": "monotonicity"}
heads |= {"more_skate": "more foot slide, m/s", "apart": "styles apart"}
table = {
    model: {key: mean_over_pairs(np.array([getattr(b, key) for b in some]), kept) for key in heads}
    for model, some in blends.items()
}
rng, still = np.random.default_rng(0), np.zeros(len(SHARES))
null = {"a switch": [(SHARES > 0.5)[:, None].astype(float)]}
null["a random order"] = [np.array([0, *rng.permutation(SHARES[1:-1]), 1])[:, None] for _ in range(100)]
for label, orders in null.items():
    made = [blend_of(order, still, SHARES) for order in orders]
    means = {key: float(np.mean([getattr(blend, key) for blend in made])) for key in heads}
    table[label] = {key: (value, value, value) for key, value in means.items()}
lines = ["| | " + " | ".join(heads.values()) + " |", "|---" * (len(heads) + 1) + "|"]
for label, row in table.items():
    cells = [f"{m:.2f}" + ("" if label in null else f" [{low:.2f}, {high:.2f}]") for m, low, high in row.values()]
    lines.append(f"| {label} | " + " | ".join(cells) + " |")
Markdown("\n".join(lines))

# %%
panels = along_plot(blends)
alt = "How far each blend has come against the share of the second style, one panel for each model."
plots.save_figure(panels[0].figure, figures / "07_interpolation-along.png", alt=alt)
Image(figures / "07_interpolation-along.png", alt=alt)

# %% [markdown]
# A thin line is a pair of styles, the thick one the median, the dashed one an even blend.

# %%
steps = {model: np.array([blend.largest_step for blend in some]) for model, some in blends.items()}
difference = mean_over_pairs(steps[models[0]] - steps[models[-1]], kept)
even = {model: float(np.mean([blend.even for blend in blends[model]])) for model in models}
worst = {model: " - ".join(kept[int(steps[model].argmax())]) for model in models}
Markdown(
    f"The largest step of {models[0]} is larger than that of {models[-1]} by {difference[0]:.2f} "
    f"[{difference[1]:.2f}, {difference[2]:.2f}]. Pairs that pass evenly (no step above 0.2, hardly ever back): "
    + ", ".join(f"{model} {100 * share:.0f} %" for model, share in even.items())
    + ". The largest steps: "
    + ", ".join(f"{model} {steps[model].max():.2f} ({pair})" for model, pair in worst.items())
    + "."
)

# %% [markdown]
# ## Does it stay with the first style?
#
# Only a character that remembers where it began can stay with it. So: the share at which half the way is made, by
# characters that begin as either style. At 0.5 the start is forgotten. `disagreement` is the mean distance between the
# two.


# %%
def half_ways(model: str) -> np.ndarray:
    there, back = ([some[k] for k in whole] for some in ends[model])
    return np.array([(a.halfway + b.reversed().halfway) / 2 for a, b in zip(there, back, strict=True)])


halves = {model: mean_over_pairs(half_ways(model), kept) for model in models}
apart = {model: interpolation.disagreement(*([some[k] for k in whole] for some in ends[model])) for model in models}
lines = ["| | half the way at a share of | disagreement |", "|---|---|---|"]
lines += [f"| {m} | {h[0]:.2f} [{h[1]:.2f}, {h[2]:.2f}] | {apart[m]:.2f} |" for m, h in halves.items()]
Markdown("\n".join(lines))

# %% [markdown]
# ## What one sees
#
# The pair whose styles lie farthest apart, in the layout of Fig. 8: the first style at the left, the second at the
# right, each at the moment when its right foot comes down.

# %%
shown = int(np.argmax([blend.apart for blend in blends[models[-1]]]))
first, last = kept[shown]
start = whole[shown] * len(SHARES)
strips = [
    along_motion(runs[model][0], range(start, start + len(SHARES)), bundles[model].body, model) for model in models
]
alt = f"Characters along the blend from {first} to {last}, one row for each model."
picture = grid(strips, Layout(frames=len(SHARES), view="side", scale=72, note=f"{first}\nto {last}"))
write_png(figures / "07_interpolation-strip.png", picture, alt=alt)
Image(figures / "07_interpolation-strip.png", alt=alt)

# %%
shares = [start + round(share * (len(SHARES) - 1)) for share in (0, 0.5, 1)]
labels = [first, "half of each", last]
walked = [walking_motion(runs[models[-1]][0], k, film.body, label) for k, label in zip(shares, labels, strict=True)]
seconds = [motion.frames(len(motion) - int(4 * FPS), len(motion)) for motion in walked]
length = movie(figures / "07_interpolation-half.mp4", seconds, fps=30, size=(192, 240))
Markdown(
    f"`{figures_folder}/07_interpolation-half.mp4`: {length} frames, four seconds of both styles and of half of each."
)

# %% [markdown]
# ## The pair of Fig. 8
#
# Weights that learned what the authors' network generated know both its styles; they are judged by walks that an LPN
# with FiLM made, so this is circular. Pairs that are drawn stand beside it.


# %%
def on_figure_8() -> dict[str, list]:
    """For each model the blend of Fig. 8 and of drawn pairs, None where a walk broke off; empty without runs."""
    at = {model: ROOT / runs_folder / run_name(beside, preset, f"{model}-seed0") for model in models}
    if not all(is_bundle(folder) and (folder / "evaluation.json").exists() for folder in at.values()):
        return {}
    theirs = {model: load_bundle(folder) for model, folder in at.items()}
    names = theirs[models[-1]].styles
    draws = np.random.default_rng(0)
    some = [FIG_8, *((names[a], names[b]) for a, b in (draws.choice(len(names), 2, replace=False) for _ in range(20)))]
    chosen = sorted({*names[::3], *itertools.chain(*some)})
    generated = VectorStore(load_catalogue(beside, chosen), theirs[models[-1]].about["phases"])
    vectors, found = {style: generated.load(style) for style in chosen}, {}
    known = style_space(list(vectors.values()), theirs[models[-1]].layout)
    for model, bundle in theirs.items():
        measured = read_json(at[model] / "evaluation.json")["rollouts"]["walks"]
        two = walked_blends(bundle, {walk["style"]: walk["gain"] for walk in measured}, vectors, some)
        found[model] = interpolation.blends_of(two, bundle.body, known)
    return found


figure_8 = on_figure_8()
lines = {}
for model, some in figure_8.items():
    drawn = [blend for blend in some[1:] if blend is not None]
    own = [f"{getattr(some[0], key):.2f}" if some[0] else "broke off" for key in heads]
    lines[f"{model}, {' to '.join(FIG_8)}"] = own
    lines[f"{model}, {len(drawn)} drawn pairs"] = [f"{np.mean([getattr(b, key) for b in drawn]):.2f}" for key in heads]
Markdown(markdown_table(list(heads.values()), lines) if figure_8 else f"No runs on `{beside}` here.")

# %% [markdown]
# ## Three styles at once
#
# Lines lead from what was asked for to where the walks come out, in the plane of the three pure walks. The picture
# shows the first of several threes, which share no style.

# %%
trios = triples(group, most=1 if preset == "quick" else 7)
asked = interpolation.triangle(4)
corners = [int(np.flatnonzero(asked[:, k] == 1)[0]) for k in range(3)]
inner = np.setdiff1d(np.arange(len(asked)), corners)


# %%
def three_way(trio: tuple[str, str, str]) -> tuple[np.ndarray, float, float, np.ndarray]:
    """The shares that come out, how far they are off, how far if the walks are dealt out, and the slide of the feet."""
    codes = torch.from_numpy(asked @ np.stack([film.code(style).numpy() for style in trio])).float()
    mix = asked @ np.array([gains[models[-1]][style] for style in trio])
    middle = interpolation.starts(styles, [(trio[0], trio[1])], film.body, last=False, count=len(asked))
    places, skates = interpolation.walks_of(roll_out(film, codes, middle, frames, Steady(mix)), film.body, space)
    if not np.isfinite(places).all():
        return np.full(asked.shape, np.nan), np.nan, np.nan, skates
    came_out = interpolation.barycentric(places, places[corners])
    dealt = [np.abs(came_out[rng.permutation(inner)] - asked[inner]).mean() for _ in range(200)]
    return came_out, float(np.abs(came_out - asked)[inner].mean()), float(np.mean(dealt)), skates


mixed = {trio: three_way(trio) for trio in trios}
axes = triangle_plot(asked, mixed[trios[0]][0], trios[0])
alt = f"Three-way blends of {', '.join(trios[0])}: shares asked for and shares that came out, in a triangle."
plots.save_figure(axes.figure, figures / "07_interpolation-triangle.png", alt=alt)
Image(figures / "07_interpolation-triangle.png", alt=alt)

# %%
whole_trios = [found for found in mixed.values() if np.isfinite(found[1])]
shares_off, shares_dealt = (np.array([found[k] for found in whole_trios]) for k in (1, 2))
three_off = paired_difference(shares_off, shares_dealt, rng)
slides = np.array([[found[3][some].mean() for some in (corners, inner)] for found in whole_trios]).mean(axis=0)
Markdown(
    f"Of {len(mixed)} threes {len(whole_trios)} stayed finite. A share that comes out is off by "
    f"{shares_off.mean():.2f} in the mean, by {shares_dealt.mean():.2f} if the walks are dealt out anew (difference "
    f"{three_off}). Slide of the feet at the corners {slides[0]:.2f} m/s, between them {slides[1]:.2f} m/s."
)

# %% [markdown]
# ## What the authors' codes do
#
# The release has FiLM codes of a hundred styles, with the pair of Fig. 8 among them. The style space is made of its own
# pure walks: this tells how even its blends are, not how good its styles.


# %%
def authors():
    try:
        return None if preset == "quick" else release_bundle()
    except InputError:
        return None


release = authors()
theirs = None if release is None else release_blends(release)


# %%
def released_values() -> dict[str, tuple[float, float, float]]:
    some = [(blend, pair) for blend, pair in zip(theirs.blends, theirs.pairs, strict=True) if blend is not None]
    return {key: mean_over_pairs(np.array([getattr(b, key) for b, _ in some]), [p for _, p in some]) for key in heads}


def released_table(values: dict[str, tuple[float, float, float]]) -> str:
    cells = [f"{m:.2f} [{low:.2f}, {high:.2f}]" for m, low, high in values.values()]
    fig8 = [f"{getattr(theirs.blends[0], key):.2f}" for key in heads]
    count = sum(blend is not None for blend in theirs.blends)
    return markdown_table(list(heads.values()), {" to ".join(FIG_8): fig8, f"{count} pairs": cells})


of_release = released_values() if theirs else {}
Markdown(released_table(of_release) if of_release else "Not run here.")


# %%
def released_strip() -> Image:
    rows = [along_motion(theirs.run, theirs.characters(p), release.body, " to\n".join(p)) for p in theirs.pairs[:2]]
    alt = "The released network's characters along two blends, the first of which is the paper's Fig. 8."
    drawn = grid(rows, Layout(frames=len(SHARES), view="side", scale=72, note="released codes"))
    write_png(figures / "07_interpolation-released.png", drawn, alt=alt)
    return Image(figures / "07_interpolation-released.png", alt=alt)


released_strip() if theirs else Markdown("Nothing to draw.")

# %% [markdown]
# ## Through the body?
#
# > The straight way between two styles can lead through poses in which limbs cut into the body ([M22] 6).
#
# From folded arms to arms behind the back, the hands have to get past the trunk. Least distance of the nearer hand from
# the line of the trunk (m); half a body's depth is about 0.12 m, and a hand that is nearer cuts into the body.

# %%
HALF_A_BODY = 0.12
near = {} if theirs is None else {pair: hand_to_trunk(release, theirs, pair) for pair in theirs.pairs}
closer = [pair for pair, d in near.items() if d.min() < HALF_A_BODY <= min(d[0], d[-1])]
named = [PAST_THE_TRUNK, *(pair for pair in closer if pair != PAST_THE_TRUNK)] if near else []
lines = {" to ".join(pair): [f"{d:.2f}" for d in near[pair]] for pair in named}
Markdown(markdown_table([f"{share:.1f}" for share in SHARES], lines) if near else "Not run here.")

# %% [markdown]
# ## The record

# %%
params = {"models": models, "pair_count": pair_count, "runs_folder": runs_folder, "beside": beside}
data_files = [folder / "evaluation.json" for folder in folders.values()]
recorder = Recorder("07_interpolation", dataset=dataset, preset=preset, params=params, data_files=data_files)
largest = {model: table[model]["largest_step"] for model in (models[0], models[-1])}
smoother, keeps = difference[1] > 0, halves[models[0]][1] > 0.5
even_film = table[models[-1]]["off_line"][2] < table["a switch"]["off_line"][0] / 2
step_words = [f"{name} {v:.2f} [{low:.2f}, {high:.2f}]" for name, (v, low, high) in largest.items()]
# Where both models know the styles of Fig. 8 its pair decides; elsewhere pairs of the data's own styles.
named_pair = [figure_8[model][0] for model in (models[0], models[-1])] if figure_8 else []
own_words = (
    f"largest of ten steps between two styles, one-hot less FiLM {difference[0]:.3g} [{difference[1]:.2f}, "
    f"{difference[2]:.2f}]; {', '.join(step_words)}; even is 0.1, a switch 1; {len(kept)} pairs of {dataset}"
)
if named_pair and all(named_pair):
    steps_of = dict(zip((models[0], models[-1]), named_pair, strict=True))
    words = [f"{model} {b.largest_step:.2f}, off the line {b.off_line:.2f}" for model, b in steps_of.items()]
    own_words = f"the pair itself on {beside} (circular), largest step: {'; '.join(words)}; {own_words}"
    smoother = steps_of[models[-1]].even and not steps_of[models[0]].even
recorder.claim("m22-fig8-bent-forward-lean-back", smoother, own_words, value=list(difference), n=len(kept), seeds=[0])
released_words = ""
if of_release:
    v, low, high = of_release["off_line"]
    released_words = f"; the authors' own codes have {v:.2f} [{low:.2f}, {high:.2f}] in a space of their own"
recorder.claim(
    "m22-one-hot-keeps-first-style",
    keeps,
    "share at which half the way is made, from either end, with its interval; 0.5 is no memory of the first style",
    value=list(halves[models[0]]),
    n=len(kept),
    seeds=[0],
)
recorder.claim(
    "m22-film-smooth-interpolation",
    even_film,
    f"distance from an even blend, with its interval; a switch has {table['a switch']['off_line'][0]:.2f}, half of "
    "which is asked for" + released_words,
    value=list(table[models[-1]]["off_line"]),
    n=len(kept),
    seeds=[0],
)
if near:
    least = float(min(d.min() for d in near.values()))
    recorder.claim(
        "m22-interpolation-clipping",
        bool(closer),
        f"released weights: pairs between which a hand comes within {HALF_A_BODY} m of the trunk's line, as in neither "
        "style, of how many, and the least distance (m)",
        value=[len(closer), len(near), least],
        n=len(near),
        dataset="100style",
    )
else:
    recorder.not_testable("m22-interpolation-clipping", "the released weights, and a preset other than quick")
for model in models:
    for key in heads:
        recorder.number(f"{key} {model}", list(table[model][key]))
    recorder.number(f"pairs that pass evenly {model}", even[model])
    recorder.number(f"disagreement of both starts {model}", apart[model])
recorder.number("difference of the largest step", list(difference))
recorder.number("three-way share off by", [float(shares_off.mean()), float(shares_dealt.mean())])
if theirs is not None:
    for pair, blend in zip(theirs.pairs, theirs.blends, strict=True):
        recorder.number(f"released largest step, {' to '.join(pair)}", None if blend is None else blend.largest_step)
recorder.write(figures_folder)

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
# # New styles by fine-tuning
#
# Paper: [M22], Section 5.3.2 and Fig. 11. Time: preset quick 1 minute, preset cpu 10 minutes, after a training without
# some of the styles.
#
# Can a network that knows many styles take up a new one when only its style network is trained? A run that never saw
# some styles learns them: their codes, the error of a step, and a walk, before and after.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set the network was trained on
preset: str = "quick"  # preset of the training
figures_folder: str = "build/figures"  # folder for pictures and numbers
runs_folder: str = "build/runs"  # folder of the trained runs
run: str = "lpn-film-heldout-seed0"  # the run that never saw some of the styles
seed: int = 0  # seed of the fine-tuning

# %%
from dataclasses import replace

import numpy as np
import torch
from IPython.display import Image, Markdown

from stylephase.data.catalogue import load_catalogue
from stylephase.evaluation.comparison import difference, group_difference, ratio
from stylephase.evaluation.embedding import codes_of_clips, nearest_centroid, picture, silhouettes
from stylephase.evaluation.new_styles import against_holding, new_style_errors
from stylephase.evaluation.predictors import fit_ridge, predict_hold, untrained
from stylephase.evaluation.rollouts import SETTLE, codes_of, local_poses, start_of, walking_speed
from stylephase.evaluation.runs import run_name
from stylephase.evaluation.style import style_space
from stylephase.features.layout import FPS
from stylephase.features.store import VectorStore
from stylephase.models.bundle import load_bundle
from stylephase.models.zoo import build, widths_of
from stylephase.report import plots
from stylephase.report.manifest import ROOT
from stylephase.report.new_styles import code_maps
from stylephase.report.png import write_png
from stylephase.report.recorder import Recorder
from stylephase.report.render import Layout, grid
from stylephase.report.show import markdown_table
from stylephase.report.walks import data_walk, walking_motion
from stylephase.runtime.calibration import calibrate
from stylephase.runtime.plans import Steady
from stylephase.runtime.rollout import roll_out
from stylephase.training.finetune import FineTuning, fine_tune, with_new_codes

folder, figures = ROOT / runs_folder / run_name(dataset, preset, run), ROOT / figures_folder
base, catalogue = load_bundle(folder), load_catalogue(dataset)
store = VectorStore(catalogue, base.about["phases"])
known = [store.load(style) for style in base.styles]
new = [store.load(style) for style in catalogue.styles if style not in base.styles]
names = [style.style for style in new]
rows = {style.style: [len(style.rows(part)) for part in ("train", "test")] for style in new}
Markdown(
    f"`{run}` on `{dataset}` ({catalogue.dataset.origin}) knows {len(known)} styles. It never saw:\n\n"
    + markdown_table(["frames to learn from", "frames to test on"], {k: [str(n) for n in v] for k, v in rows.items()})
)

# %% [markdown]
# ## Learning
#
# > For a new style it is enough to fine-tune the FiLM generator, with the parameters of the LPN frozen ([M22] 5.3.2).
#
# Each new style is learned alone, by a generator of its own, and then all of them together by one.

# %%
how = FineTuning()
before = with_new_codes(base, new)
alone = {style.style: fine_tune(base, [style], how, seed=seed) for style in new}
together = fine_tune(base, new, replace(how, clips=2 * how.clips, frames=how.frames // 2), seed=seed)
ends = {name: [tuned.errors[0][0], np.mean([mse for mse, _ in tuned.errors[-8:]])] for name, tuned in alone.items()}
Markdown(
    f"{how.steps} steps of {how.clips} clips and {how.clips * how.frames} frames. Training error, with dropout, at the "
    "first step and over the last eight:\n\n" + markdown_table(["first", "last"], ends)
)

# %% [markdown]
# ## What stays
#
# Every tensor of the weights before and after, and every code of the known styles, compared bit by bit.

# %%
tensors = {name: tuned.bundle for name, tuned in [*alone.items(), ("all together", together)]}


# %%
def changed(after) -> dict[str, int]:
    old, fresh = base.network.state_dict(), after.network.state_dict()
    parts = {part: [n for n in old if n.startswith(f"{part}.")] for part in ("synthesis", "generator")}
    counts = {part: sum(not torch.equal(old[n], fresh[n]) for n in some) for part, some in parts.items()}
    codes = sum(not torch.equal(base.codes[style], after.codes[style]) for style in base.styles)
    return counts | {"codes": codes, "all": sum(map(len, parts.values()))}


differing = {name: changed(after) for name, after in tensors.items()}
untouched = sum(d["synthesis"] + d["codes"] for d in differing.values())
heads = ["tensors of the motion network that differ", "of the style network", "codes of known styles that differ"]
Markdown(
    markdown_table(heads, {n: [str(d[k]) for k in ("synthesis", "generator", "codes")] for n, d in differing.items()})
)

# %% [markdown]
# ## The error of a step, before and after
#
# On test frames of the new styles. `before` has the code that the generator gives without having learned the style,
# `best known` the best code of a known style, `wrong` the mean over all known styles. `ridge` is one linear regression
# fitted to the new styles' training frames.

# %%
rivals = {"ridge": fit_ridge(new, base.normaliser), "hold": predict_hold(base.layout, base.normaliser)}


# %%
def errors_of(style) -> dict[str, float]:
    tuned = {"before": before, "after, alone": alone[style.style].bundle, "after, together": together.bundle}
    return new_style_errors(base, tuned, style, rivals)


tested = [style for style in new if len(style.rows("test"))]
errors = {style.style: errors_of(style) for style in tested}
order = ("before", "after, alone", "after, together", "best known", "wrong", "ridge", "hold")
gain = np.array([one["before"] / one["after, alone"] for one in errors.values()])
Markdown(markdown_table(order, {name: [one[key] for key in order] for name, one in errors.items()}))

# %%
rng = np.random.default_rng(0)
first, last = (np.array([[one[when] for one in errors.values()]]) for when in ("before", "after, alone"))
fell = ratio(first, last, rng)
still = [name for name, one in errors.items() if min(one["hold"], one["best known"]) < one["after, alone"]]
# Styles are hard in themselves, so each error is held against that of holding the pose.
unknown = np.array([against_holding(before, base, style, rivals["hold"]) for style in tested])
familiar = np.array([against_holding(base, base, style, rivals["hold"]) for style in known if len(style.rows("test"))])
worse = group_difference(np.log(unknown), np.log(familiar), rng)
Markdown(
    f"Before, the error is {fell} times that after (by chance {fell.p:.2f}; of {len(errors)} styles no order can be "
    f"rarer than {2 / 2 ** len(errors):.2f}). Holding the pose, or a known style's code, is still better in "
    f"{len(still)}: {', '.join(still) or 'none'}. Before, the error of new styles over that of holding the pose is "
    f"{np.exp(worse.value):.2f} [{np.exp(worse.low):.2f}, {np.exp(worse.high):.2f}] times that of known ones (by "
    f"chance {worse.p:.4f})."
)

# %% [markdown]
# ## Codes of clips, before and after
#
# > Before fine-tuning the codes of seen styles separate clearly and those of unseen styles less so; afterwards the
# > unseen ones lie apart at places of their own ([M22] Fig. 11).
#
# Codes of up to 50 walking clips a style. Silhouette and nearest centroid are taken in the space of the codes; a clip
# is left out of its own centroid. `after, alone` joins the codes of each new style by its own generator with those of
# the known styles by theirs; `after, together` has all codes by one generator. Null models: an untrained generator, and
# names shuffled.

# %%
codes = {"before": codes_of_clips(base, [*known, *new])}
own = {name: codes_of_clips(tuned.bundle, [s for s in new if s.style == name]) for name, tuned in alone.items()}
codes["after, alone"] = codes["before"] | {name: group[name] for name, group in own.items()}
codes["after, together"] = codes_of_clips(together.bundle, [*known, *new])
codes["untrained"] = codes_of_clips(untrained(base), [*known, *new])
counts = [len(group) for group in codes["before"].values()]
mixed = np.random.default_rng(0).permutation(np.concatenate(list(codes["before"].values())))
codes["names shuffled"] = dict(zip(codes["before"], np.split(mixed, np.cumsum(counts)[:-1]), strict=True))
silhouette = {when: silhouettes(some) for when, some in codes.items()}
right = {when: nearest_centroid(some) for when, some in codes.items()}


# %%
def mean_of(values: dict[str, float], some: list[str]) -> float:
    return float(np.mean([values[name] for name in some if name in values] or [0.0]))


groups = {"known": list(base.styles), "new": names}
found = {when: [mean_of(table[when], g) for table in (silhouette, right) for g in groups.values()] for when in codes}
heads = ["silhouette, known", "silhouette, new", "nearest centroid, known", "nearest centroid, new"]
clips = f"Clips of a style: {min(counts)} to {max(counts)}, {sum(counts)} in all.\n\n"
Markdown(clips + markdown_table(heads, found))

# %%
each = {
    name: [table[when].get(name, "one clip") for table in (silhouette, right) for when in order[:3]] for name in names
}
heads = [f"{what}, {when}" for what in ("silhouette", "nearest centroid") for when in order[:3]]
Markdown(markdown_table(heads, each))

# %% [markdown]
# Clips that the fine-tuning never saw, asked for their nearest centroid:

# %%
unseen = {"before": codes_of_clips(base, new, part="test")}
fresh = {
    name: codes_of_clips(tuned.bundle, [s for s in new if s.style == name], part="test")
    for name, tuned in alone.items()
}
unseen["after, alone"] = {name: group[name] for name, group in fresh.items() if name in group}
unseen["after, together"] = codes_of_clips(together.bundle, new, part="test")
asked = {when: nearest_centroid(codes[when], some) for when, some in unseen.items()}
Markdown(
    markdown_table(names, {when: [shares.get(name, "no clip") for name in names] for when, shares in asked.items()})
)

# %%
pictures = {when: picture(codes[when]) for when in ("before", "after, together")}
panels = code_maps(pictures, names)
alt = "Style codes of clips in a plane by t-SNE, before and after fine-tuning; known styles pale, new ones strong."
plots.save_figure(panels[0].figure, figures / "08_new_styles-codes.png", alt=alt)
Image(figures / "08_new_styles-codes.png", alt=alt)

# %% [markdown]
# The picture is t-SNE, whose distances mean little; the numbers above are the measure.
#
# The stored codes of known styles stay. But a generator that learned one style alone may give its code whatever clip it
# is shown: below, how many clips of known styles it would still place right. So `after, together` is the fairer row
# above.

# %%
again = {name: codes_of_clips(tuned.bundle, known) for name, tuned in alone.items()}
again["all together"] = {style: codes["after, together"][style] for style in base.styles}
centres = {style: codes["before"][style] for style in base.styles}
kept = {name: mean_of(nearest_centroid(centres, some), list(base.styles)) for name, some in again.items()}
Markdown(markdown_table(["known styles' clips still nearest to their style"], {n: [v] for n, v in kept.items()}))

# %% [markdown]
# ## Walking in the new style
#
# Ten seconds straight on at the speed of the style's data. The nearest real style is found among all styles of the
# data.

# %%
space = style_space([*known, *new], base.layout)
speeds = np.array([walking_speed(style) for style in new])


# %%
def walk(bundle):
    start, own_codes = start_of(new, base.body), codes_of(bundle, new)
    gains = calibrate(bundle, own_codes, start, speeds)
    return roll_out(bundle, own_codes, start, int(10 * FPS), Steady(gains))


after = replace(base, codes=base.codes | {name: tuned.bundle.codes[name] for name, tuned in alone.items()})
walks = {"before": walk(before), "after": walk(after)}
places = {
    when: [space.distances(local_poses(some, k)[SETTLE:]) if some.finite[k] else None for k in range(len(new))]
    for when, some in walks.items()
}
off = {
    when: [float("nan") if d is None else d[space.styles.index(n)] for n, d in zip(names, some, strict=True)]
    for when, some in places.items()
}
near = {
    when: ["not finite" if d is None else space.styles[int(d.argmin())] for d in some] for when, some in places.items()
}
cells = {name: [near["before"][k], off["before"][k], near["after"][k], off["after"][k]] for k, name in enumerate(names)}
heads = ["nearest before", "distance to its own style", "nearest after", "distance to its own style"]
Markdown(markdown_table(heads, cells))

# %%
nearer = np.array(off["before"]) - np.array(off["after"])
shown = list(dict.fromkeys([int(np.nanargmax(nearer)), int(np.nanargmin(nearer))]))


# %%
def strips_of(k: int) -> list:
    made = [walking_motion(some, k, base.body, f"{names[k]}\n{when}") for when, some in walks.items() if some.finite[k]]
    motions = [data_walk(store, names[k], f"{names[k]}\ndata"), *made]
    return [motion.frames(max(len(motion) - 90, 0), len(motion)) for motion in motions]


cycle = [motion for k in shown for motion in strips_of(k)]
alt = "Two new styles: the data, and the character with the code before and after fine-tuning."
write_png(figures / "08_new_styles-strips.png", grid(cycle, Layout(frames=7, scale=70)), alt=alt)
Image(figures / "08_new_styles-strips.png", alt=alt)

# %% [markdown]
# The style whose walk came nearest to its data and the one that went farthest from them: the data above, the character
# before and after fine-tuning below, at the same time steps. The nearest style can be the right one and the walk yet
# farther from it than before: the error of a step is what fine-tuning lowers.
#
# ## What a new style takes with the other models
#
# Values that one more style adds to each model.


# %%
def size(model: str, styles: int) -> int:
    network = build(model, widths_of(model, base.body.layout), styles, base.settings)
    return sum(parameter.numel() for parameter in network.parameters())


added = {model: size(model, 11) - size(model, 10) for model in ("lpn-onehot", "pfnn-resad", "lpn-resad")}
added["lpn-film"] = base.network.synthesis.modulator.values
Markdown(markdown_table(["values for one more style"], {model: [str(count)] for model, count in added.items()}))

# %% [markdown]
# ## The record

# %%
recorder = Recorder(
    "08_new_styles",
    dataset=dataset,
    preset=preset,
    params={"run": run, "runs_folder": runs_folder, "seed": seed},
    data_files=[folder / "model.json"],
)
seeds, count = [base.about["seed"]], len(new)
closer = int((nearer > 0).sum())
recorder.claim(
    "m22-unseen-styles-not-robust",
    worse.low > 0 and worse.p < 0.05,
    "error of a step over that of holding the pose, new styles' over known ones', by chance "
    f"{worse.p:.4f}; before fine-tuning over after, mean {gain.mean():.2f} ({gain.min():.2f} to {gain.max():.2f})",
    value=[float(np.exp(v)) for v in worse.interval],
    n=count,
    seeds=seeds,
)
recorder.claim(
    "m22-fine-tuning-frozen-lpn",
    untouched == 0 and fell.low > 1 and not still and closer > count / 2,
    f"error before over after {fell}; styles whose error is below that of holding the pose and of every known code; "
    "walks nearest to their own style, and walks nearer to it than before; frozen tensors and codes that differ",
    value=[
        len(errors) - len(still),
        sum(n == a for n, a in zip(names, near["after"], strict=True)),
        closer,
        untouched,
    ],
    n=count,
    seeds=seeds,
)
seen, unseen_before = found["before"][:2]
unseen_after = found["after, together"][1]
before, after = silhouette["before"], silhouette["after, together"]
clustered = [name for name in names if name in before and name in after]
values = [np.array([some[name] for name in clustered]) for some in (after, before)]
gained = difference(values[0], values[1], rng)
of_known = np.array([before[name] for name in base.styles if name in before])
blurred = group_difference(of_known, np.array([before[name] for name in names if name in before]), rng)
# Of five styles no order is rarer than 0.06, so that is what chance is held against.
least = max(0.05, 2 / 2 ** len(clustered))
recorder.claim(
    "m22-fig11a-before",
    blurred.low > 0 and blurred.p < 0.05,
    f"mean silhouette in the space of the codes, known styles then new ones; apart by {blurred}, by chance "
    f"{blurred.p:.4f}",
    value=[seen, unseen_before],
    n=count,
    seeds=seeds,
)
recorder.claim(
    "m22-fig11b-after",
    gained.low > 0 and gained.p < least + 0.01,
    "mean silhouette of new styles before, after learning all by one generator, after learning each by its own; "
    f"gained by new styles of several clips {gained}, by chance {gained.p:.2f}; "
    f"of known styles {seen:.2f} before and {found['after, together'][0]:.2f} after",
    value=[unseen_before, unseen_after, found["after, alone"][1]],
    n=count,
    seeds=seeds,
)
protocol = [max(counts), len(known), count]
recorder.claim(
    "m22-fig11-protocol",
    protocol == recorder.catalogue.claims["m22-fig11-protocol"].paper_value,
    f"{min(counts)} to {max(counts)} walking clips of each style, as the data have them",
    value=protocol,
)
recorder.claim(
    "m22-new-style-adapters-large",
    min(added["pfnn-resad"], added["lpn-resad"]) > 10 * added["lpn-film"],
    "values for one more style, large where ten times a FiLM code: PFNN Resad, LPN Resad, a FiLM code",
    value=[added["pfnn-resad"], added["lpn-resad"], added["lpn-film"]],
)
recorder.not_testable(
    "m22-new-style-onehot-retrains-all",
    f"a one-hot run without the new styles; by count a new style adds a column of {added['lpn-onehot']} values to it",
)
for when in codes:
    recorder.number(f"silhouettes and nearest centroids {when}", found[when])
for when, shares in asked.items():
    recorder.number(f"unseen clips nearest to their own style {when}", mean_of(shares, names))
for name, one in errors.items():
    recorder.number(f"error {name}", [one[key] for key in order], ", ".join(order))
for name, share in kept.items():
    recorder.number(f"known clips still right after {name}", share)
recorder.write(figures_folder)

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
# # Training, and whether the character walks
#
# Paper: [M22], Section 4.3 (training) and 4.4 (the character moves). Time: preset quick 1 minute, preset cpu 4 minutes,
# after a training of 1 and 30 minutes.
#
# The network learns one step, from this frame to the next. Does that make a character who walks? The error of a step
# stands beside predictors that know nothing of style, and every style walks for twenty seconds.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set the network was trained on
preset: str = "quick"  # preset of the training
figures_folder: str = "build/figures"  # folder for pictures and numbers
runs_folder: str = "build/runs"  # folder of the trained runs
model: str = "lpn-film"  # model of the runs
bone_steps: int = 150  # steps of the three trainings that try the bone-length term

# %%
from dataclasses import replace

import numpy as np
import torch
from IPython.display import Image, Markdown

from stylephase.data.catalogue import load_catalogue
from stylephase.data.layouts import published_entries
from stylephase.evaluation.protocol import (
    KEPT_BACK,
    changed_by_training,
    drawn_styles,
    epochs,
    in_turn,
    off_from_equation_5,
    passes,
    try_bone_term,
)
from stylephase.evaluation.report import groups_of
from stylephase.evaluation.rollouts import codes_of, start_of
from stylephase.evaluation.runs import find_runs
from stylephase.features.layout import FPS
from stylephase.features.store import VectorStore
from stylephase.models.bundle import load_bundle
from stylephase.report import judged, plots
from stylephase.report.manifest import ROOT
from stylephase.report.png import write_png
from stylephase.report.recorder import QUICK, Recorder
from stylephase.report.render import Layout, grid, movie
from stylephase.report.walks import data_walk, interval, pick, summary, walking_motion
from stylephase.runtime.plans import Steady, TurnOnce
from stylephase.runtime.rollout import roll_out
from stylephase.runtime.walkers import NetworkWalker
from stylephase.training.loop import Trainer
from stylephase.training.presets import PRESETS

runs = [run for run in find_runs(ROOT / runs_folder, dataset, preset) if run.model == model and not run.variant]
# The first is the one that walks below.
runs.sort(key=lambda run: not run.has_weights)
results, logs = [run.evaluation for run in runs], [run.log for run in runs]
seeds = [result["about"]["seed"] for result in results]
figures = ROOT / figures_folder
about = results[0]["about"]
Markdown(f"{len(runs)} runs, seeds {seeds}, on `{about['data']}` ({about['origin']}, {about['licence']})")

# %% [markdown]
# ## What is minimised
#
# > The loss is the squared error of all outputs plus a term for the length of the bones ([M22] Eq. 5).
#
# To fit half an hour of a laptop, the preset `cpu` departs from the paper in all that DEVIATIONS.md lists; most of it
# matters little, but one pass of the style generator serves four steps of the network, and the rectifiers leak, since
# plain ones died within minutes.

# %%
how = PRESETS[about["preset"]]
rows = {
    "steps of the network": how.steps,
    "frames seen": how.steps * how.styles_per_step * how.frames_per_style,
    "dropout on input, hidden, gating": (how.network.input_rate, how.network.hidden_rate, how.network.gating_rate),
    "learning rate of network, generator": (how.network_rate, how.generator_rate),
    "weight of the bone length term": how.bone_weight,
    "minutes, by the clock": [round(log[-1]["seconds"] / 60, 1) for log in logs],
    "minutes of one processor": [round(log[-1]["processor_seconds"] / 60, 1) for log in logs],
}
Markdown("\n".join(["| | |", "|---|---|", *(f"| {key} | {value} |" for key, value in rows.items())]))

# %% [markdown]
# > Both networks are trained together, end to end ([M22] 4.3).
#
# Two checks on a small network of the same kind, of two styles of these data. Which tensors do some rounds of the
# trainer change, in the motion network and in the style network? And does the trainer's loss equal Eq. 5 as written
# here, for outputs that are off at random?

# %%
shown_styles = load_catalogue(dataset).styles[:2]
trainer = Trainer(
    VectorStore(load_catalogue(dataset, shown_styles), about["phases"]), model, PRESETS["quick"], "quick", 0
)
changed, loss_off = changed_by_training(trainer), off_from_equation_5(trainer)
Markdown(f"Tensors that change: {changed}. Largest difference from Eq. 5: {loss_off:.1e}.")

# %% [markdown]
# ## How it went
#
# Training error is measured with dropout, validation error without. The factor of a wrong code says by how much the
# error grows with another style's code: at 1 the code would be ignored. What to look for: the last stretch should be
# nearly flat.

# %%
# Takes of less than four seconds only train: of a data set of nothing else there is no error but that of training.
kinds = {f"{model}, training with dropout": "mse"}
kinds |= {model: "validation_mse"} if logs[0][-1]["validation_mse"] is not None else {}
losses = {name: np.array([[point[key] for point in log] for log in logs]) for name, key in kinds.items()}
steps = np.array([point["step"] for point in logs[0]])
axes = plots.learning_curve(steps, losses, steps_are="step", loss_is="squared error (normalised)")
alt = "Training and validation error against steps, on a logarithmic scale, falling and flattening."
plots.save_figure(axes.figure, figures / "04_training.png", alt=alt)
Image(figures / "04_training.png", alt=alt)

# %%
heads = ("seed", "step", "wrong code multiplies the error by", "codes differ between styles by", "within a style by")
lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
for seed, log in zip(seeds, logs, strict=True):
    for point in (log[len(log) // 4], log[len(log) // 2], log[-1]):
        cells = [
            "none" if point[key] is None else f"{point[key]:.3g}"
            for key in ("wrong_code_factor", "code_between", "code_within")
        ]
        lines.append(f"| {seed} | {point['step']} | " + " | ".join(cells) + " |")
Markdown("\n".join(lines))

# %% [markdown]
# ## One step ahead, beside predictors that know nothing
#
# On test frames that no training saw. `hold` keeps the pose and goes on along the trajectory, `mean` always says the
# mean, `ridge` is one linear regression for all styles, `untrained` is the network as drawn, `dropout` has dropout left
# on, as in the authors' test, `wrong code` has codes of other styles.

# %%
groups = groups_of(load_catalogue(dataset).styles)
table = {
    group: {rival: [r["groups"][group][rival]["mse"] for r in results] for rival in results[0]["groups"][group]}
    for group in results[0]["groups"]
    if results[0]["groups"][group]
}
lines = ["| predictor | " + " | ".join(table) + " |", "|---" * (len(table) + 1) + "|"]
for rival in next(iter(table.values()), ()):
    lines.append(f"| {rival} | " + " | ".join(f"{np.mean(table[group][rival]):.4f}" for group in table) + " |")
Markdown("\n".join(lines) if table else "No take has frames to test on.")


# %%
def one_step_picture() -> Image | Markdown:
    if not table:
        return Markdown("Nothing to draw.")
    called = {"network": model, "dropout": f"{model}, dropout on", "wrong code": f"{model}, wrong code"}
    last, errors = list(table.items())[-1]
    bars = {called.get(rival, rival): interval(v) for rival, v in errors.items() if rival not in ("mean", "untrained")}
    axes = plots.bar_with_interval(bars, quantity=f"error of one step, {last}", unit="normalised, squared")
    alt = f"Squared error of one step ahead for the network and naive predictors on {last}."
    plots.save_figure(axes.figure, figures / "04_training-one-step.png", alt=alt)
    return Image(figures / "04_training-one-step.png", alt=alt)


one_step_picture()

# %% [markdown]
# Linear regression beats the network by far: it sees the whole previous pose, which tells the style. The network
# learned with part of its input dropped and must use the code; what that costs and buys is measured in notebook 05,
# where a network without it is still behind the regression. The rollouts show what one step does not.

# %% [markdown]
# ## Twenty seconds of walking
#
# Each style starts in a pose of its own data and walks straight on, at the gain with which it reaches its data's speed.
# Then it turns by 90 degrees to either side, and is told to stop, after which it walks on slowly: nobody trained it to
# stand (see DEVIATIONS). Nothing corrects the network. `!` marks feet that do
# not alternate. The nearest real style is found by the means and deviations of joint positions and velocities; below
# the table, how often that is right on held-out real clips.

# %%
Markdown(summary(results[0]))

# %%
counts = [result["recognised"] for result in results]
Markdown(f"Held-out real clips nearest to their own style: {counts[0]['right']} of {counts[0]['clips']}.")

# %% [markdown]
# ## What one sees
#
# For each style the data above, the rollout below. What to look for: the back and the head, the arms, how far the feet
# reach.

# %%
bundle = load_bundle(runs[0].folder)
store = VectorStore(load_catalogue(dataset, bundle.styles), about["phases"])
shown = [store.load(style) for style in pick(bundle.styles)]
gains = np.array(
    [walk["gain"] for style in shown for walk in results[0]["rollouts"]["walks"] if walk["style"] == style.style]
)
run = roll_out(bundle, codes_of(bundle, shown), start_of(shown, bundle.body), int(8 * FPS), Steady(gains))
generated = [walking_motion(run, k, bundle.body, f"{style.style}\ngenerated") for k, style in enumerate(shown)]
real = [data_walk(store, style.style, f"{style.style}\ndata") for style in shown]
pairs = [motion for two in zip(real, generated, strict=True) for motion in two]
cycle = [motion.frames(len(motion) - 90, len(motion)) for motion in pairs]
alt = "Strips of data and generated walking for some styles, one and a half seconds each."
write_png(figures / "04_training-strips.png", grid(cycle, Layout(frames=7, scale=70)), alt=alt)
Image(figures / "04_training-strips.png", alt=alt)

# %%
two = sorted({0, min(2, len(shown) - 1)})
wide = [motion.frames(max(len(motion) - 145, 0), len(motion)) for k in two for motion in pairs[2 * k : 2 * k + 2]]
names = " and ".join(shown[k].style for k in two)
alt = f"{names}: recorded walking above what the network generates, thirteen poses each."
write_png(figures / "04_training-wide.png", grid(wide, Layout(frames=13, scale=70)), alt=alt)
Image(figures / "04_training-wide.png", alt=alt)

# %% [markdown]
# All styles, without any correction, 0.4 s between poses. Weights that lie with the code are in half precision and
# have cards of their own in `data/pretrained`: a style near a threshold can lie on its other side there.

# %%
all_walks = results[0]["rollouts"]["walks"]
every = [store.load(walk["style"]) for walk in all_walks]
own_gains = np.array([walk["gain"] for walk in all_walks])
together = roll_out(bundle, codes_of(bundle, every), start_of(every, bundle.body), int(6 * FPS), Steady(own_gains))
alive = [k for k in range(len(every)) if together.finite[k]]
strips = [walking_motion(together, k, bundle.body, every[k].style) for k in alive]
last = [motion.frames(len(motion) - 100, len(motion)) for motion in strips]
alt = "Strips of generated walking in every style, five poses each."
write_png(figures / "04_training-styles.png", grid(last, Layout(frames=5, scale=44)), alt=alt)
Image(figures / "04_training-styles.png", alt=alt)

# %%
lame = [w["style"] for w in all_walks if not (w["finite"] and w["alternate"] and 0.75 <= w["speed_ratio"] <= 1.25)]
strayed = [f"{w['style']} (nearest {w['nearest']})" for w in all_walks if w["nearest"] != w["style"]]
Markdown(
    f"Styles that do not walk, or not within a quarter of their data's speed: {', '.join(lame) or 'none'}. Styles that "
    f"another one is nearest to: {', '.join(strayed) or 'none'}."
)

# %% [markdown]
# ## The paper's skeleton, all styles
#
# The same model trained on walks that the authors' network generated, as its weights lie with the code: every style
# from the moment of its own walk that is kept with them, four poses each.

# %%
MANY, COLUMNS = "lpn-rollouts", 5


def every_style() -> Image | Markdown:
    known = load_bundle(ROOT / "data/pretrained" / MANY)
    codes = torch.stack([known.code(style) for style in known.styles])
    gains_of = {walk["style"]: walk["gain"] for walk in many_walks}
    steady = Steady(np.array([gains_of[style] for style in known.styles]))
    walked = roll_out(known, codes, NetworkWalker(known).start(codes), int(6 * FPS), steady)
    whole = [k for k in range(len(codes)) if walked.finite[k]]
    shown_walks = [walking_motion(walked, k, known.body, known.styles[k]) for k in whole]
    ends = [motion.frames(len(motion) - 75, len(motion)) for motion in shown_walks]
    rows = -(-len(ends) // COLUMNS)
    columns = [grid(ends[at : at + rows], Layout(frames=4, scale=30, note="")) for at in range(0, len(ends), rows)]
    height = max(len(column) for column in columns)
    padded = [np.pad(c, ((0, height - len(c)), (0, 0), (0, 0)), constant_values=255) for c in columns]
    alt = f"Strips of generated walking in {len(ends)} styles, four poses each."
    write_png(figures / "04_training-many.png", np.concatenate(padded, axis=1), alt=alt)
    return Image(figures / "04_training-many.png", alt=alt)


kept = [run for run in find_runs(ROOT / runs_folder, MANY, "cpu") if run.model == model and not run.variant]
many_walks = kept[0].evaluation["rollouts"]["walks"] if kept and preset != QUICK else []
every_style() if many_walks else Markdown("Not drawn with preset quick.")

# %%
slow = [w["style"] for w in many_walks if not (w["finite"] and w["alternate"] and 0.75 <= w["speed_ratio"] <= 1.25)]
other = [walk["style"] for walk in many_walks if walk["nearest"] != walk["style"]]
Markdown(
    f"Of {len(many_walks)} styles these do not walk, or not within a quarter of their data's speed: "
    f"{', '.join(slow) or 'none'}. Nearer to another style ({len(other)}): {', '.join(other) or 'none'}."
)

# %%
turned = roll_out(
    bundle, codes_of(bundle, shown), start_of(shown, bundle.body), int(4 * FPS), TurnOnce(gains, np.pi / 2, 60)
)
motions = [walking_motion(turned, k, bundle.body, style.style) for k, style in enumerate(shown[:2])]
frames = movie(figures / "04_training-turn.mp4", motions, fps=30, size=(256, 256))
Markdown(
    f"`{figures_folder}/04_training-turn.mp4`: {frames} frames of two styles that turn to the left after a second."
)

# %% [markdown]
# ## The paper's training, and ours
#
# > 95 styles are trained, 5 kept back; a batch holds one style, and the styles take turns; 90 epochs, Adam at 0.0001,
# > dropout of 0.3 throughout ([M22] 4.3).
#
# The preset `paper` is that training, for a GPU and days. The batches below are those that a trainer draws. An epoch
# ends with the style of fewest frames; the paper's are counted in the published cuts of 100STYLE.

# %%
theirs, data = PRESETS["paper"], [store.load(style) for style in bundle.styles]
drawn = {
    how: drawn_styles(store, model, PRESETS[how], how, 3 * len(data))
    for how in dict.fromkeys(("paper", about["preset"]))
}
turns = {which: in_turn(styles, len(data)) for which, styles in drawn.items()}
published = [take for take in published_entries() if take.style not in KEPT_BACK and not take.idle]
paper_epochs = epochs(theirs.steps, theirs.frames_per_style, published)
seen = passes(PRESETS[about["preset"]], data)
Markdown(
    f"One style a batch, in turn: {turns}. Preset `paper` makes {paper_epochs:.1f} epochs of the "
    f"{len({take.style for take in published})} styles; ours sees the frames of its smallest style {seen:.0f} times."
)

# %% [markdown]
# > The bone-length term reduces stretching of bones ([M22] 4.3).
#
# Three short trainings of the small network: with the term, without it, and with it from another seed, which shows how
# far from 1 a ratio may lie by chance.

# %%
quick = replace(PRESETS["quick"], steps=bone_steps, save_every=bone_steps)
term = try_bone_term(store, quick, "quick", np.random.default_rng(0))
Markdown(
    f"Bone-length error on test frames without the term over that with it: {term.error}; another seed over the first: "
    f"{term.again}. Squared error without over with it: {term.squared}."
)

# %% [markdown]
# ## The record

# %%
slowest, fastest = judged.stop_range(results)
each_walk = [
    (walk, seed)
    for seed, result in zip(seeds, results, strict=True)
    for walk in result["rollouts"]["walks"]
    if walk["finite"]
]
beyond = [
    f"{walk['style']} of seed {seed} goes at {walk['speed_ratio']:.2f} of its speed"
    for walk, seed in each_walk
    if not 0.75 <= walk["speed_ratio"] <= 1.25
]
unsteady, unsteady_seed = max(each_walk, key=lambda pair: pair[0]["bones"]["worst"])
# What is old in these data.
OLD = [style for style in bundle.styles if "old" in style or "elderly" in style]
old_walks = [walk for result in results for walk in result["rollouts"]["walks"] if walk["style"] in OLD]
notes = {
    "ours-training-minutes": "of the longest; a run uses one core",
    "ours-rollout-speed": f"{'; '.join(beyond) or 'none beyond'}, of {len(all_walks) * len(results)} walks",
    "ours-rollout-style-all": f"the styles missed by seed {seeds[0]}: {', '.join(strayed)}",
    "ours-rollout-bone-worst": f"the least steady: {unsteady['style']} of seed {unsteady_seed}",
    "ours-rollout-old-walks-old": f"walks of {', '.join(OLD)} in all seeds",
}
params = {"model": model, "runs_folder": runs_folder}
recorder = Recorder("04_training", dataset=dataset, preset=preset, params=params, data_files=[run.file for run in runs])
both = {"synthesis", "generator"} <= set(changed) and min(changed.values()) == 1
for identifier, holds, value, note in (
    ("m22-training-end-to-end", both, list(changed.values()), f"share of tensors that the trainer changes: {changed}"),
    ("m22-eq5-loss", loss_off < 1e-6, loss_off, "the trainer's loss against Eq. 5 written out, relative"),
):
    recorder.claim(identifier, holds, note, value=value)
if many_walks:
    note = f"off its speed or not walking: {', '.join(slow)}; nearer to another style: {len(other)}"
    recorder.claim(
        "ours-rollout-many-styles",
        value=1 - len(slow) / len(many_walks),
        n=len(many_walks),
        seeds=[0],
        note=note,
        dataset=MANY,
    )
if dataset == "bandai-namco":
    values = judged.rollout_values(results)
    for group in groups:
        values |= judged.one_step_values(results, group)
    values |= {"ours-code-spread": judged.code_ratio(results), "ours-training-seeds": len(seeds)}
    values |= {"ours-training-minutes": max(log[-1]["processor_seconds"] for log in logs) / 60}
    values |= {"ours-rollout-old-walks-old": float(np.mean([walk["nearest"] == walk["style"] for walk in old_walks]))}
    recorder.number("speed some seconds after being told to stop, of all styles and seeds", [slowest, fastest], "m/s")
    for identifier, value in values.items():
        note = notes.get(identifier, f"the worst of seeds {', '.join(map(str, seeds))}")
        recorder.claim(identifier, value=value, n=len(bundle.styles), seeds=seeds, note=note)
large = find_runs(ROOT / runs_folder, "lpn-rollouts", "cpu")
trained = [len(large[0].evaluation["errors"]) if large else 0, len(KEPT_BACK)]
printed = {name: recorder.catalogue.claims[f"m22-training-{name}"].paper_value for name in ("styles", "epochs")}
recorder.claim(
    "m22-training-styles",
    trained == printed["styles"],
    "styles of lpn-rollouts in which the authors' network walks, and styles kept back",
    value=trained,
)
recorder.claim(
    "m22-training-balanced-batches",
    turns[about["preset"]],
    f"preset paper, and preset {about['preset']}, which draws {how.styles_per_step} styles a batch",
    value=[int(turns["paper"]), int(turns[about["preset"]])],
)
recorder.claim(
    "m22-training-epochs",
    abs(seen / printed["epochs"] - 1) < 0.1,
    f"times that preset {about['preset']} sees each frame of its smallest style; preset paper: {paper_epochs:.1f}",
    value=round(seen, 1),
)
rates = sorted({how.network.input_rate, how.network.hidden_rate, how.network.gating_rate}, reverse=True)
recorder.claim(
    "m22-training-dropout",
    rates == [0.3],
    "on input, hidden layers and gating: half an hour is too short for 0.3 throughout",
    value=rates,
)
recorder.claim(
    "m22-training-learning-rate",
    how.network_rate == how.generator_rate == 1e-4,
    "of network and generator, with warm-up and fall, for half an hour in place of days",
    value=[how.network_rate, how.generator_rate],
)
recorder.claim(
    "m22-training-bone-length-helps",
    term.error.low > max(1.0, term.again.high),
    f"error without the term over that with it, by chance {term.error.p:.4f}; second seed over first {term.again}",
    value=term.error.interval,
)
recorder.number("styles that do not walk", len(lame), ", ".join(lame))
recorder.write(figures_folder)

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
# # Models and costs
#
# Paper: [M22], Section 4 (Fig. 3), Table 2 and Section 5.3.1. Time: 1 minute with every preset.
#
# The paper's seven networks differ in two things only: what decides how the weights are blended, and how the style
# enters. What does each cost, in parameters and in time, and is the table right?

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set of the run, without effect here
preset: str = "quick"  # preset of the run, without effect here
figures_folder: str = "build/figures"  # folder for pictures and numbers

# %%
import numpy as np
import torch
from IPython.display import Markdown
from matplotlib.figure import Figure
from torch.nn import functional

from stylephase.data.archive import where
from stylephase.data.registry import DATA, released_weights
from stylephase.data.registry import dataset as find_dataset
from stylephase.evaluation.bench.frames import frame_rows
from stylephase.evaluation.bench.models import frame_runs, spread
from stylephase.evaluation.bench.ratios import paired_ratios, rank_correlation, ratios, swapped
from stylephase.evaluation.bench.rows import interleaved, threads
from stylephase.evaluation.bench.training import training_rows
from stylephase.evaluation.budget.paper_2022 import PUBLISHED, STYLES, table_2
from stylephase.evaluation.budget.rows import built, parameters
from stylephase.evaluation.release import compare, made_golden
from stylephase.evaluation.release_walks import release_walks
from stylephase.evaluation.stored import missed_by_a_stored_vector
from stylephase.models.bundle import load_bundle
from stylephase.models.generator import FilmGenerator, GeneratorSettings
from stylephase.models.modulators import Film
from stylephase.models.pfnn import Pfnn
from stylephase.models.released import fetch_released, release_bundle
from stylephase.models.synthesis import NetworkSettings, StyledNetwork
from stylephase.models.zoo import PAPER_2022, build_synthesis, widths_of
from stylephase.report import palette, plots
from stylephase.report.claims import REPRODUCED
from stylephase.report.manifest import ROOT
from stylephase.report.recorder import Recorder
from stylephase.report.show import figure, table
from stylephase.runtime.phases import StoredPfnn

figures = ROOT / figures_folder
recorder = Recorder(
    "03_models_and_costs", dataset=dataset, preset=preset, params={}, data_files=[DATA / "registry.toml"]
)
WIDTHS = {name: widths_of(name, PUBLISHED) for name in PAPER_2022}
MODELS = {name: built(name, widths, STYLES) for name, widths in WIDTHS.items()}


# %% [markdown]
# ## Fig. 3: the parts
#
# > A gating network blends expert weights, a style network makes scales and shifts, and layer normalisation stands
# > before them ([M22] 4, Fig. 3).
#
# Every model is put together from the same layer, a gate and a modulator (`models/`).

# %%
rows = []
for name, network in MODELS.items():
    synthesis, how = network.synthesis, PAPER_2022[name]
    sets, inputs, outputs = synthesis.layers[0].weight.shape[0], WIDTHS[name].inputs, WIDTHS[name].outputs
    gate = {"pfnn": "global phase", "lpn": "8 local phase values", "mann": "12 velocities"}[how.backbone]
    rows += [(name, gate, sets, f"{inputs} - 512 - 512 - {outputs}", type(synthesis.modulator).__name__)]
table(("model", "gate looks at", "sets of weights", "widths", "style enters by"), *rows)

# %% [markdown]
# Sizes of LPN-FiLM, read off the module that is trained:

# %%
film = MODELS["lpn-film"]
gating = [tuple(layer.weight.shape) for layer in film.synthesis.gating.layers]
convolutions = [(c.kernel, c.weight.shape[1]) for c in (film.generator.first, film.generator.second)]
dense = [film.generator.dense.out_features, film.generator.code.out_features]
sizes = {
    "layers of the motion network": [tuple(layer.weight.shape) for layer in film.synthesis.layers],
    "layers of the gating network": gating,
    "convolutions (width, filters)": convolutions,
    "dense layers": dense,
}
table(("part", "shape"), *sizes.items())

# %% [markdown]
# ## Three identities
#
# A blend of weights equals our blend of outputs; FiLM is layer normalisation, scale, shift, ELU (Eq. 3); the whole is
# one forward pass (Eq. 4).

# %%
torch.manual_seed(0)
small = NetworkSettings(units=64)
synthesis = build_synthesis("lpn-film", WIDTHS["lpn-film"], 0, small).double().eval()
x, p, code = (torch.randn(5, width, dtype=torch.float64) for width in (348, 8, 4 * small.units))
gate, layer = synthesis.gating(p), synthesis.layers[0]
blended = torch.stack([x[r] @ torch.tensordot(gate[r], layer.weight, 1) + gate[r] @ layer.bias for r in range(5)])
blend_off = float((layer(x, gate) - blended).abs().max().detach())
f, (scale, shift) = blended, code.chunk(4, dim=1)[:2]
by_hand = functional.elu(scale * (f - f.mean(1, keepdim=True)) / f.std(1, keepdim=True, correction=0) + shift)
film_off = float((synthesis.modulator(0, f, x, gate, code) - by_hand).abs().max().detach())
clip, other = torch.randn(2, 5, 240, 300, dtype=torch.float64)
generator = FilmGenerator(300, small.units, GeneratorSettings(filters=8, kernel=5, hidden=16))
whole = StyledNetwork(synthesis, generator).double().eval()
with torch.no_grad():
    parts = synthesis(x, p, whole.generator(clip))
    whole_off, other_off = (float((whole(x, p, some) - parts).abs().max()) for some in (clip, other))
assert blend_off < 1e-10 and film_off < 1e-6 and whole_off == 0 < other_off
Markdown(
    f"largest differences: blend {blend_off:.1e}, Eq. 3 {film_off:.1e}, Eq. 4 in one call or part by part "
    f"{whole_off:.1e} ({other_off:.1e} with another clip)"
)

# %% [markdown]
# > One-hot and residual adapters change one layer; FiLM changes all of them ([M22] 5.1.2).
#
# The hidden layers whose output changes when only the style does:


# %%
def styled_layers(name: str) -> list[int]:
    network = build_synthesis(name, WIDTHS[name], 3, small).eval()
    h, gate = torch.randn(5, small.units), network.gating(torch.rand(5, WIDTHS[name].gate))
    one, two = torch.randn(2, 5, network.modulator.values)
    changed = (
        network.modulator(layer, h, h, gate, one) - network.modulator(layer, h, h, gate, two) for layer in (0, 1)
    )
    return [layer + 1 for layer, change in enumerate(changed) if change.abs().max() > 0]


styled = {name: styled_layers(name) for name in PAPER_2022}
table(("model", "hidden layers that the style changes"), *styled.items())

# %% [markdown]
# ## Eq. 6: a style is a change of weights
#
# > FiLM can be written as a layer with other weights, `W' = W_s W` and `b' = W_s b + shift` ([M22] 5.3.1).
#
# Layer normalisation, for a given row, is a scale and a shift more. So the identity holds row by row: the changed
# weights depend on the frame.

# %%
weight, bias = torch.tensordot(gate[0], layer.weight, 1), gate[0] @ layer.bias
deviation = f[0].var(correction=0).add(1e-8).sqrt()
changed = weight @ torch.diag(scale[0] / deviation)
changed_bias = (bias - f[0].mean()) * scale[0] / deviation + shift[0]
filmed = Film(small.units)(0, f[:1], x[:1], gate[:1], code[:1])[0]
eq6_off = float((filmed - functional.elu(x[0] @ changed + changed_bias)).abs().max().detach())
recorder.claim("m22-eq6-film-is-weight-change", value=eq6_off, n=1)

# %% [markdown]
# ## Table 2: parameters
#
# A.S.N. is the motion network, S.M.N. what holds the styles, P.S.R. what a style keeps at run time. `stylephase count`
# shows the sums.

# %%
COLUMNS = {"A.S.N.": "asn", "S.M.N.": "smn", "P.S.R.": "psr"}
counted = {(row.name, row.quantity): row for row in table_2()}
for (name, column), row in counted.items():
    identifier = f"m22-table2-{name}-{COLUMNS[column]}"
    recorder.claim(identifier, row.verdict == REPRODUCED, row.note, value=row.counted)
assert all(row.counted == row.value for row in counted.values())
table(
    ("model", *COLUMNS),
    *(
        (name, *(f"{r.counted:,}" + ("" if r.verdict == REPRODUCED else f" (print: {r.paper:,})") for r in cells))
        for name in PAPER_2022
        for cells in [[counted[name, column] for column in COLUMNS]]
    ),
)

# %% [markdown]
# All but one number are right to the last digit. The printed size of the style network takes each convolution as a
# dense layer from 256 to 25.
#
# Where the parameters are, in training, and what one style keeps:

# %%
with plots.style():
    left, right = Figure(figsize=(7.2, 3.1)).subplots(1, 2, sharey=True)
    for row, name in enumerate(PAPER_2022):
        asn, smn, psr = (counted[name, column].counted for column in COLUMNS)
        left.barh(row, asn / 1e6, color=palette.colour_of(name))
        left.barh(row, smn / 1e6, left=asn / 1e6, color=palette.lighter(palette.colour_of(name), 0.55), hatch="///")
        right.barh(row, psr, color=palette.colour_of(name))
    left.set(xlabel="parameters in training (million)", yticks=range(7), yticklabels=PAPER_2022)
    right.set(xlabel="values kept for a style (count)", xscale="log", xlim=(1e3, 5e5))
    left.set_title("network, styles (hatched)")
    right.set_title("one style at run time")
    left.invert_yaxis()
alt = "Bars of parameters for seven models: FiLM needs 39 million in training and 2,048 values for a style at run time."
figure(left, figures / "03_models_and_costs-budget.png", alt)

# %% [markdown]
# FiLM has by far the largest style network and keeps the least, since its output can be stored. An adapter has to be
# kept whole, so with many styles the order turns round.

# %%
number = np.unique(np.geomspace(1, 1000, 60).astype(int))
per_style = {name: counted[name, "P.S.R."].counted for name in PAPER_2022}
memory = {n: 4 * (counted[n, "A.S.N."].counted + number * per_style[n]) / 2**20 for n in PAPER_2022}
with plots.style():
    axes = Figure(figsize=(7.2, 3.6)).subplots()
    for name, values in memory.items():
        axes.plot(number, values, color=palette.colour_of(name), linestyle=palette.dashes_of(name), label=name)
    axes.axvline(STYLES, color=palette.HIGHLIGHT, linewidth=1, linestyle=":")
    axes.set(xscale="log", yscale="log", xlabel="styles (count)", ylabel="memory at run time (MiB)")
    axes.annotate("the paper's 95", (STYLES, 500), xytext=(-6, 0), textcoords="offset points", ha="right")
    axes.legend(ncols=2)
alt = "Memory against the number of styles from 1 to 1000: only residual adapters grow beyond the network itself."
figure(axes, figures / "03_models_and_costs.png", alt)

# %% [markdown]
# > Adapters must be kept whole, since their input changes at run time ([M22] 5.2.1).
#
# How much of what an adapter adds would a stored vector, its mean over a walk, miss? Asked of the trained base of
# notebook 12, which walks straight on. Near 0, as with FiLM, whose scales and shifts do not look at the frame, a vector
# could stand for the adapter.

# %%
base = load_bundle(ROOT / "data/pretrained/bandai-namco-base")
missed = dict(zip(base.styles, missed_by_a_stored_vector(base), strict=True))
table(("adapter of", "share that a stored vector misses"), *((name, f"{share:.2f}") for name, share in missed.items()))

# %% [markdown]
# ## Table 2: time of a frame
#
# One thread, one character, five runs in which the models take turns, by the clock of the processor. The PFNN keeps its
# weights at 50 phases, as in both papers. Times of two machines cannot be compared, but ratios to PFNN one-hot can, and
# the order of the seven. A ratio is reproduced where it lies within two joint deviations of the printed one, of which
# ours may be a twentieth of the ratio.

# %%
REFERENCE = "pfnn-onehot"
CLAIMS = recorder.catalogue.claims
PRINTED = {name: tuple(CLAIMS[f"m22-table2-{name}-runtime"].paper_value) for name in PAPER_2022}
runs = frame_runs(WIDTHS, styles=STYLES)
times = {name: spread(values) for name, values in runs.items()}
share, printed_share = paired_ratios(runs, REFERENCE), ratios(PRINTED, REFERENCE)
table(
    ("model", "ours (ms)", "paper (ms)", "ours over PFNN one-hot", "paper's", "agree"),
    *(
        (
            n,
            "{:.2f} ± {:.2f}".format(*times[n]),
            "{:.2f} ± {:.2f}".format(*PRINTED[n]),
            share[n],
            printed_share[n],
            same,
        )
        for n in PAPER_2022
        for same in ["reference" if n == REFERENCE else "yes" if share[n].agrees(printed_share[n]) else "no"]
    ),
)

# %%
with plots.style():
    axes = Figure(figsize=(7.2, 3.0)).subplots()
    for row, name in enumerate(PAPER_2022):
        ours, paper, colour = share[name], printed_share[name], palette.colour_of(name)
        axes.plot([paper.value, ours.value], [row, row], color=palette.GROUND_LINE, linewidth=3)
        style = {"fmt": "o", "color": colour, "label": None if row else "ours"}
        axes.errorbar(ours.value, row, xerr=2 * ours.deviation, **style)
        style = {"fmt": "d", "color": palette.INK, "label": None if row else "paper"}
        axes.errorbar(paper.value, row, xerr=2 * paper.deviation, **style)
    axes.set(xlabel="time of a frame over that of PFNN one-hot (ratio)", yticks=range(7), yticklabels=PAPER_2022)
    axes.set_xlim(left=0)
    axes.legend(loc="upper center", bbox_to_anchor=(0.38, 1.0))
    axes.invert_yaxis()
figure(
    axes,
    figures / "03_models_and_costs-times.png",
    "Time of a frame over PFNN one-hot's, ours and the paper's, for the seven models.",
)

# %%
measured = {name: (ratio.value, ratio.deviation) for name, ratio in share.items()}
pairs, correlation = swapped(measured, PRINTED), rank_correlation(measured, PRINTED)
film_costs = {b: times[f"{b}-film"][0] - times[f"{b}-onehot"][0] for b in ("pfnn", "lpn")}
film_costs_printed = {b: PRINTED[f"{b}-film"][0] - PRINTED[f"{b}-onehot"][0] for b in film_costs}
places = ", ".join(f"{slow} before {fast}" for fast, slow in pairs) or "none"
Markdown(f"rank correlation {correlation:.2f}; pairs that change places: {places}")

# %% [markdown]
# Every PFNN is faster than every network of eight experts, as in print. In print FiLM costs much more than one-hot,
# here about as much, since its vectors are few.

# %% [markdown]
# Part of the PFNN's lead is its stored phases, which no gate of eight numbers allows. The PFNN with its spline
# evaluated in every frame:

# %%
network = build_synthesis("pfnn-onehot", WIDTHS["pfnn-onehot"], STYLES, NetworkSettings()).eval()
assert isinstance(network, Pfnn)
stored, row, onehot = StoredPfnn(network), torch.randn(1, 348), torch.eye(STYLES)[:1]
with threads(1), torch.inference_mode():
    rivals = {"spline": lambda: network(row, torch.ones(1, 1), onehot), "stored": lambda: stored(row, 1.0, onehot)}
    both = interleaved(rivals, rounds=10, each=10)
spline_factor = both["spline"] / both["stored"]
Markdown(f"evaluating the spline in every frame takes {spline_factor:.1f} times as long as stored phases")

# %% [markdown]
# ## The released network
#
# Where the authors' LPN-FiLM is at hand, our network with its weights is compared with a plain form in NumPy, and all
# its styles are asked to walk.

# %%
at_hand = {where(released_weights()["lpn-release"]), where(find_dataset("100style"))} <= {"cache", "mirror"}
agreement, walks = [], []
if at_hand:
    released = fetch_released()
    agreement, walks = compare(released, made_golden(released)), release_walks(release_bundle())
    assert all(one.holds for one in agreement)
largest = {k: max((a.relative for a in agreement if a.precision == k), default=0) for k in ("float32", "float64")}
Markdown("largest relative errors: " + str(largest) if at_hand else "the released weights are not at hand")

# %%
faulty = [walk.style for walk in walks if not walk.walks]
assert not walks or set(faulty) == {"Drunk", "LeftHop", "RightHop", "TwoFootJump"}
walking = [walk for walk in walks if walk.walks]
shown = [walk for walk in walks if walk.style in ("Neutral", "Zombie", "Swimming", "PendulumHands", "Proud")]
heads = ("style", "speed (m/s)", "cycle (frames)", "correlation of feet", "bones vary, worst (%)")
lines = [
    (w.style, f"{w.speed:.2f}", f"{60 * w.steps.cycle:.0f}", f"{w.correlation:.2f}", f"{w.bones.worst:.1f}")
    for w in shown
]
table(heads, *lines, (f"do not walk: {', '.join(faulty) or '-'}", "", "", "", ""))

# %% [markdown]
# Drunk's stored code is broken, as the release says itself. The other three hop; from a standing start they glide.

# %% [markdown]
# ## How fast ours is
#
# Each time stands beside a reference of the same run: training first, then one frame of a character.

# %%
rows = {row.name: row for row in (*training_rows(), *frame_rows())}
heads = ("", "ours", "reference", "ratio", "unit", "wanted")
table(
    heads, *((r.name, f"{r.ours:.4g}", f"{r.reference:.4g}", f"{r.ratio:.2f}", r.unit, r.target) for r in rows.values())
)

# %% [markdown]
# A network of eight experts is read from memory in every frame; the reference "to the floor" only reads as many
# numbers. No form in single precision can be faster; weights of 8 bits can.

# %% [markdown]
# ## What was recorded


# %%
for precision, error in largest.items():
    if at_hand:
        recorder.claim(f"ours-release-{precision}", value=error, n=len(agreement))
if at_hand:
    note = f"not: {', '.join(faulty)}"
    recorder.claim("ours-release-walks", value=len(walking), n=len(walks), note=note)
alone, floor = rows["next frame, network alone"], rows["next frame, network alone, to the floor"]
reading = f"a plain read of the weights takes {floor.reference:.2f} ms on this machine"
products = rows["training step, to its products alone"]
kept = f"the steps run at {products.ratio:.2f} of the rate of their products alone"
step = rows[next(name for name in rows if name.startswith("training step, batch"))]
recorder.claim("ours-bench-training", value=step.ratio, note=kept)
recorder.claim("ours-bench-memory", value=rows["memory of these steps beyond the start"].ours)
recorder.claim("ours-bench-network", value=alone.ours, note=reading)
recorder.claim("ours-bench-network-ratio", value=alone.ratio, note=reading)
recorder.claim("ours-bench-tick", value=rows["next frame, whole tick"].ours, note=reading)
eight = rows["next frame, network alone, weights of 8 bits"]
recorder.claim("ours-bench-eight-bits", value=eight.ratio, note=eight.note)
recorder.claim("ours-bench-batch", value=rows["next frame of 64 characters, two threads, each"].ours)
named = [name for name, _ in film.named_children()] + [name for name, _ in film.synthesis.named_children()]
holds = {"generator", "gating", "layers", "modulator"} <= set(named) and styled["lpn-film"] == [1, 2]
recorder.claim(
    "m22-fig3-overview", holds, "the parts as modules; FiLM stands after both hidden layers", value=", ".join(named)
)
recorder.claim(
    "m22-gating-blends-weights", blend_off < 1e-10, "blending outputs instead, in one product", value=blend_off
)
recorder.claim(
    "m22-eq2-film-parameters", film.synthesis.modulator.values == 4 * 512, value=film.synthesis.modulator.values
)
note = "the printed features are taken as the scale; the deviation is the population's"
recorder.claim("m22-eq3-conditional-normalisation", film_off < 1e-6, note, value=film_off)
note = f"in one call or part by part; with another clip {other_off:.1e}"
recorder.claim("m22-eq4-whole-model", whole_off == 0 < other_off, note, value=whole_off)
hidden = [len(film.synthesis.layers), film.synthesis.layers[1].weight.shape[2]]
recorder.claim("m22-arch-hidden", hidden == [3, 512], value=hidden)
gates = [len(gating), gating[0][0], gating[-1][0]]
recorder.claim("m22-arch-gating", gates == [3, 32, 8], value=gates)
recorder.claim(
    "m22-arch-experts", film.synthesis.layers[0].weight.shape[0] == 8, value=film.synthesis.layers[0].weight.shape[0]
)
found = [len(convolutions), convolutions[0][1], convolutions[0][0], 2]
recorder.claim("m22-arch-generator-convolutions", found == [2, 256, 25, 2], value=found)
recorder.claim("m22-arch-generator-dense", dense == [2048, 2048], value=[len(dense), dense[0]])
found = {PAPER_2022[name].modulator: layers for name, layers in styled.items()}
holds = found == {"onehot": [1], "cp-one-bias": [2], "static": [2], "film": [1, 2]}
recorder.claim("m22-one-layer-against-all", holds, f"hidden layers that the style changes: {found}", value=holds)
traffic = "eight experts go by what memory gives, which they share with whatever else runs"
extra = ", ".join(
    f"{1000 * film_costs[b]:.0f} µs ({b}; in print {1000 * film_costs_printed[b]:.0f})" for b in film_costs
)
small = "of four experts at stored phases, where every call of torch weighs against the products"
REASONS = dict.fromkeys(PAPER_2022, f"not explored further; {traffic}") | {
    "pfnn-resad": f"not explored further; {small}",
    "pfnn-film": f"FiLM over one-hot costs {extra}",
}
recorder.not_testable(f"m22-table2-{REFERENCE}-runtime", "the paper's machine; the other times are judged by this one")
for name in [name for name in PAPER_2022 if name != REFERENCE]:
    near = share[name].agrees(printed_share[name])
    note = f"over PFNN one-hot's time {share[name]}, in print {printed_share[name]}"
    note += "" if near else f"; {REASONS[name]}"
    recorder.claim(f"m22-table2-{name}-runtime", near, note, value=[round(v, 3) for v in times[name]], n=5)
recorder.claim(
    "m22-cost-order",
    not pairs,
    f"change places: {places}; FiLM over one-hot costs {extra}",
    value=round(correlation, 2),
    n=len(times),
)
slowest = max(mean for mean, _ in times.values())
recorder.claim("m22-cost-all-real-time", value=round(1000 / slowest), n=len(times))
backbone = {b: min(times[n][0] for n, how in PAPER_2022.items() if how.backbone == b) for b in ("pfnn", "lpn", "mann")}
factor = round(min(backbone["lpn"], backbone["mann"]) / backbone["pfnn"], 2)
recorder.claim("m22-cost-lpn-slower", factor > 1, "fastest LPN or MANN over the fastest PFNN", value=factor)
fastest = {b: min((n for n in times if PAPER_2022[n].backbone == b), key=lambda n: times[n][0]) for b in backbone}
size = {b: counted[name, "A.S.N."].counted for b, name in fastest.items()}
more = round((size["lpn"] if backbone["lpn"] < backbone["mann"] else size["mann"]) / size["pfnn"], 2)
note = "parameters of the motion network, fastest LPN or MANN over the fastest PFNN, and their times"
recorder.claim("m22-cost-parameter-counts", 1 < more < factor, note, value=[more, factor])
note = "time with the spline evaluated in every frame over that with stored phases"
recorder.claim("m22-cost-pfnn-optimisation", spline_factor > 1, note, value=round(spline_factor, 2))
codes = film.synthesis.modulator.values
note = f"a style keeps {codes:,} values of {parameters(film.generator):,}"
recorder.claim("m22-cost-film-precomputed", codes < parameters(film.generator), note)
least = min(missed.values())
note = (
    f"least share of what an adapter adds that its own mean misses, of {base.model}, {base.about['data']}; 0.1 decides"
)
recorder.claim("m22-cost-adapters-stored", least > 0.1, note, value=round(least, 3), n=len(missed))
twice = per_style["lpn-onehot"] / per_style["lpn-film"]
recorder.claim("m22-cost-onehot-twice-film", twice == 2, value=twice)
note = "values per style of LPN-FiLM over those of the smallest adapter"
share_of_adapter = round(per_style["lpn-film"] / per_style["pfnn-resad"], 3)
recorder.claim("m22-style-representation-small", share_of_adapter < 1, note, value=share_of_adapter)
table(
    ("claim", "value", "verdict", "note"),
    *((r.name, "" if r.value is None else r.value, r.verdict, r.note) for r in recorder.record.results),
)

# %%
for name in PAPER_2022:
    recorder.number(f"time of a frame over PFNN one-hot's, {name}", share[name].value, "ratio")
if walking:
    recorder.number("styles of the release that walk", len(walking), "styles")
    recorder.number("speed of the release, median of styles", float(np.median([w.speed for w in walking])), "m/s")
    cycles = [60 * walk.steps.cycle for walk in walking]
    recorder.number("cycle of the release, median of styles", float(np.median(cycles)), "frames")
    recorder.number("relative error of the release in float32", largest["float32"])
recorder.write(figures_folder)

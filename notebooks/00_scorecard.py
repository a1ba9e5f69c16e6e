# %% [markdown]
# # Where the replication stands
#
# Opens the series. Paper: both papers, [M18] and [M22], all sections. Time: under a minute with every preset.
#
# **stylephase** rebuilds two papers on the way people walk:
#
# * [M18] Mason, Starke, Zhang, Bilen, Komura: *Few-shot Learning of Homogeneous Human Locomotion Styles*, 2018. A
#   network whose weights turn with the phase of the step learns a new style from seconds of motion, through a small
#   residual adapter.
# * [M22] Mason, Starke, Komura: *Real-Time Style Modelling of Human Locomotion via Feature-Wise Transformations and
#   Local Motion Phases*, 2022. A hundred styles in one network: each hand and foot has a phase of its own, and a clip
#   of motion scales and shifts the hidden layers.
#
# `data/claims.toml` lists every claim, table row and figure with the notebook that tests it. This notebook reads what
# the others recorded.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set of the run whose results are shown
preset: str = "quick"  # preset of that run
figures_folder: str = "build/figures"  # folder of pictures and numbers, to show and to add to
reproduce_minutes: float = 0.0  # measured duration of make reproduce, 0 when it was not measured
test_minutes: float = 0.0  # measured duration of make test, 0 when it was not measured

# %%
import numpy as np
from IPython.display import Image, Markdown
from matplotlib.figure import Figure

from stylephase.report import palette, plots, scorecard
from stylephase.report.claims import read_claims, read_records
from stylephase.report.made import admitted
from stylephase.report.manifest import ROOT
from stylephase.report.recorder import Recorder

listed = ROOT / "data" / "claims.toml"
catalogue = read_claims(listed)
results = ROOT / figures_folder
others = [record for record in read_records(results, catalogue) if record.notebook != "00_scorecard"]

# %% [markdown]
# ## What this notebook adds
#
# How long it takes on two cores to run everything, and to check everything.

# %%
params = {"figures_folder": figures_folder, "reproduce_minutes": reproduce_minutes, "test_minutes": test_minutes}
files = [listed, *(results / f"{record.notebook}.json" for record in others)]
recorder = Recorder("00_scorecard", dataset=dataset, preset=preset, params=params, data_files=files)
measured = {"ours-reproduce-minutes": reproduce_minutes, "ours-test-minutes": test_minutes}
for identifier, minutes in measured.items():
    if minutes > 0:
        recorder.claim(identifier, value=minutes, n=1, note="set-up included")
records = [recorder.record, *others]

# %% [markdown]
# ## How to read a verdict
#
# | verdict | meaning |
# |---|---|
# | reproduced | ours agrees, on the data of the paper or where no data are needed |
# | reproduced on other data | ours agrees, but the data are others |
# | differs | ours does not agree, or the effect was not shown; what was found stands beside it |
# | not testable here | what it would take stands beside it |
# | open | not tested yet |
#
# Our own numbers, and some of the papers', are judged by bounds in `data/claims.toml`, written down before; all else
# by a rule in its notebook, beside the evidence. Other data are real capture of other people, walks that a network
# generated, or the synthetic walker: the note tells.

# %%
Markdown(scorecard.HOW_SURE)

# %% [markdown]
# ## The balance

# %%
Markdown(scorecard.summary(catalogue, records))

# %% [markdown]
# Check: every claim is counted once, and each one names a notebook of the series.

# %%
table = scorecard.counts(catalogue, records)
assert sum(sum(row.values()) for row in table.values()) == len(catalogue.claims)
assert all(claim.notebook in catalogue.notebooks for claim in catalogue.claims.values())

# %% [markdown]
# Numbers and settings can agree because a thing is built alike; statements and figures say how it behaves. What to look
# for: amber asks for its reason, in the list below.

# %%
TIGHT = {"columnspacing": 1.0, "handlelength": 1.2}
COLOURS = {
    o: tone for o, tone in zip(scorecard.OUTCOMES, palette.OUTCOMES, strict=True) if o in scorecard.outcomes(table)
}
titles = [title.replace(", ", ",\n") for title in table]
left = np.zeros(len(table), dtype=int)
with plots.style():
    axes = Figure(figsize=(7.2, 3.0)).subplots()
    for outcome, colour in COLOURS.items():
        widths = np.array([row[outcome] for row in table.values()])
        bars = axes.barh(titles, widths, left=left, color=colour, label=outcome, edgecolor=palette.BACKGROUND)
        shown = [str(width) if width > 5 else "" for width in widths]
        axes.bar_label(bars, shown, label_type="center", color=palette.ink_on(colour))
        left += widths
    axes.invert_yaxis()
    axes.set(xlabel="claims (count)")
    axes.grid(axis="y", visible=False)
    axes.figure.legend(*axes.get_legend_handles_labels(), loc="outside upper center", ncols=len(COLOURS), **TIGHT)
alt = f"A bar for each group of claims, divided by verdict. {scorecard.summary_line(catalogue, records)}"
plots.save_figure(axes.figure, results / "00_scorecard.png", alt=alt)
Image(results / "00_scorecard.png", alt=alt)

# %% [markdown]
# ## The runs behind the results

# %%
lines = ["| notebook | data set | preset | claims | minutes | machine |", "|---|---|---|---|---|---|"]
for record in others:
    facts = record.manifest
    cells = [facts["dataset"], facts["preset"], len(record.results), f"{facts['wall_s'] / 60:.1f}", facts["device"]]
    lines.append(f"| {catalogue.notebooks[record.notebook]} | " + " | ".join(map(str, cells)) + " |")
Markdown("\n".join(lines) if others else "No other notebook has recorded anything yet.")

# %% [markdown]
# Each is kept with a digest of the code and data that made it. Those that are older, because their trainings take long:

# %%
Markdown(scorecard.older(admitted(ROOT)) or "None is older than its code or data.")

# %% [markdown]
# ## Every claim

# %%
Markdown(scorecard.tables(catalogue, records, links=""))

# %% [markdown]
# ## The numbers of this notebook

# %%
for outcome in scorecard.OUTCOMES:
    recorder.number(f"claims {outcome}", sum(row[outcome] for row in table.values()), "claims")
recorder.write(figures_folder)

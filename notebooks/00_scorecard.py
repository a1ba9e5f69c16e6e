# %% [markdown]
# # Where the replication stands
#
# Opens the series. Paper: both papers, [M18] and [M22], all sections. Time: a tenth of a minute with every preset.
#
# **stylephase** rebuilds two papers on the way people walk:
#
# * [M18] Mason, Starke, Zhang, Bilen, Komura: *Few-shot Learning of Homogeneous Human Locomotion Styles*, 2018.
#   A network whose weights turn with the phase of the step learns a new style from a few seconds of motion, through
#   a small residual adapter.
# * [M22] Mason, Starke, Komura: *Real-Time Style Modelling of Human Locomotion via Feature-Wise Transformations and
#   Local Motion Phases*, 2022. A hundred styles in one network: each hand and foot has a phase of its own, and a clip
#   of motion scales and shifts the hidden layers.
#
# Every claim, table row and figure of both is listed in `data/claims.toml`, each with the notebook that tests it.
# That notebook records what it found in `figures/`. This one reads both and shows the balance.

# %% tags=["parameters"]
dataset: str = "synthetic"  # data set of the run whose results are shown
preset: str = "quick"  # preset of that run
figures_folder: str = "build/figures"  # folder of pictures and numbers, to show and to add to
reproduce_minutes: float = 0.0  # measured duration of make reproduce, 0 when it was not measured
test_minutes: float = 0.0  # measured duration of make test, 0 when it was not measured

# %%
import matplotlib.pyplot as plt
import numpy as np
from IPython.display import Markdown

from stylephase.report import palette, scorecard
from stylephase.report.claims import read_claims, read_records
from stylephase.report.made import admitted
from stylephase.report.manifest import ROOT
from stylephase.report.png import write_png
from stylephase.report.recorder import Recorder

listed = ROOT / "data" / "claims.toml"
catalogue = read_claims(listed)
results = ROOT / figures_folder
others = [record for record in read_records(results, catalogue) if record.notebook != "00_scorecard"]

# %% [markdown]
# ## What this notebook adds
#
# Most results come from the other notebooks. Two belong here, since they speak of the whole: how long it takes to run
# everything, and to check everything, on two cores. They are open until someone has measured them.

# %%
params = {"figures_folder": figures_folder, "reproduce_minutes": reproduce_minutes, "test_minutes": test_minutes}
files = [listed, *(results / f"{record.notebook}.json" for record in others)]
recorder = Recorder("00_scorecard", dataset=dataset, preset=preset, params=params, data_files=files)
measured = {"ours-reproduce-minutes": reproduce_minutes, "ours-test-minutes": test_minutes}
for identifier, minutes in measured.items():
    if minutes > 0:
        recorder.claim(identifier, value=minutes, n=1)
records = [recorder.record, *others]

# %% [markdown]
# ## How to read a verdict
#
# | verdict | meaning |
# |---|---|
# | reproduced | ours agrees with the paper, within the bounds written down beforehand, on the data the paper used |
# | reproduced on other data | ours agrees, but the data are others, so the claim holds more widely than it was made |
# | differs | ours does not agree; the reason stands beside it |
# | not testable here | we cannot tell; what it would take stands beside it |
# | open | no notebook has looked at it yet |
#
# A verdict on a number is computed from bounds in `data/claims.toml`. A number without bounds, or a statement about how
# motion looks, is judged in its notebook, where the evidence is shown.

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
# The same as a picture.

# %%
COLOURS = dict(
    zip(
        scorecard.OUTCOMES,
        (palette.CONTACT, palette.LEFT, palette.RIGHT, palette.QUIET, palette.SHADOW),
        strict=True,
    )
)
figure, axes = plt.subplots(figsize=(9, 2.6), layout="constrained")
titles = [scorecard.PAPERS[paper] for paper in table]
left = np.zeros(len(table), dtype=int)
for outcome, colour in COLOURS.items():
    widths = np.array([row[outcome] for row in table.values()])
    bars = axes.barh(titles, widths, left=left, color=colour, label=outcome)
    ink = palette.INK if outcome == "open" else palette.BACKGROUND
    axes.bar_label(bars, [str(width) if width > 5 else "" for width in widths], label_type="center", color=ink)
    left += widths
axes.invert_yaxis()
axes.set_xlabel("claims")
axes.spines[["top", "right"]].set_visible(False)
figure.legend(loc="outside upper center", ncols=len(COLOURS), frameon=False)
figure.canvas.draw()
pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3]
alt = f"Three bars, one for each group of claims, divided by verdict. {scorecard.summary_line(catalogue, records)}"
write_png(results / "00_scorecard.png", pixels, alt=alt)

# %% [markdown]
# What to look for: the pale part is what nobody has looked at yet; orange asks for its reason, in the list below.

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

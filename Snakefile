# The pipeline: data -> vectors of each style -> training -> evaluation -> notebooks.
# `make reproduce` runs it. Every rule calls the command line, which writes its files whole or not at all, so an
# interrupted run goes on where it stopped, and a second one redoes only what changed: inputs, options, or code.
import json
from pathlib import Path

DATASET, PRESET = config.get("dataset", "synthetic"), config.get("preset", "quick")
SEVEN = "pfnn-onehot,lpn-onehot,pfnn-resad,lpn-resad,pfnn-film,mann-film,lpn-film"
MODELS = config.get("models", SEVEN).split(",")
SEEDS = str(config.get("seeds", "0")).split(",")

# Styles that one more run never sees, to be learned afterwards (notebook 08); of 100STYLE those that [M22] kept.
KEPT_BACK = "HandsInPockets,Roadrunner,Skip,Star,WildArms"
HELD_OUT = {
    "synthetic": "DraggedLeft,StoopedOver",
    "bandai-namco": "set1-giant,set1-happy,set1-not-confident,set1-proud,set2-elderly",
    "100style": KEPT_BACK,
    "lpn-rollouts": KEPT_BACK,
}
WITHOUT = config.get("without", HELD_OUT.get(DATASET, ""))
# As in [M22] no model sees the styles kept back from its 100; elsewhere styles are few, and one more run spares some.
ALL_WITHOUT = WITHOUT if WITHOUT == KEPT_BACK else ""

# Styles of the base that few-shot learning begins with (notebook 12), and its neutral style, which has a base of its
# own. Of other data sets, name them to have that notebook: --config base=ONE,OTHER neutral=ONE.
BASE = config.get("base", {
    "synthetic": "ChestOut,GiantStrides,KneesUp,Plain,PocketHands,QuickShuffle,Sleepwalk,SlowProcession",
    "bandai-namco": ",".join(f"set2-{style}" for style in (
        "active", "elderly", "exhausted", "feminine", "masculine", "normal", "youthful")),
}.get(DATASET, ""))
NEUTRAL = config.get("neutral", {"synthetic": "Plain", "bandai-namco": "set2-normal"}.get(DATASET, ""))
BASES = {"pfnn-cp-base-seed0": BASE, "pfnn-cp-normal-seed0": NEUTRAL}

# A data set's name may hold a path (own:FOLDER), a folder's name may not.
SET = DATASET.replace(":", "-").replace("/", "-")
RUNS = [f"{model}-seed{seed}" for model in MODELS for seed in SEEDS]
LEFT_OUT = ([] if WITHOUT else ["08"]) + ([] if BASE and NEUTRAL else ["12"]) + ([] if BASE else ["13"])
NOTEBOOKS = sorted(p.stem for p in Path("notebooks").glob("[0-9][0-9]_*.py") if p.stem[:2] not in LEFT_OUT)
LAYERS = "motion data phase features models training runtime evaluation report".split()

# One's own files are read where they lie, so a changed one must be noticed.
OWN_FILES = sorted(map(str, Path(DATASET[4:]).rglob("*.[bB][vV][hH]"))) if DATASET.startswith("own:") else []

DATA = f"build/data/{SET}.json"
RUN = f"build/runs/{SET}-{PRESET}-{{run}}"
SPARING = "lpn-film-seed0" if ALL_WITHOUT else "lpn-film-heldout-seed0"
HELD_OUT_RUN = f"build/runs/{SET}-{PRESET}-{SPARING}"
FIGURES = f"build/figures/{SET}-{PRESET}"
COPIES = f"build/notebooks/{SET}-{PRESET}"

# Styles whose vectors one process makes: to start one takes as long as a style.
LOT = 7

# Runs come first, for most notebooks wait for them, and the longest notebooks before the others: a short one at the end
# leaves no processor waiting for long.
SOONER = 1
LONGEST = ("02_local_phases", "06_failure_cases", "09_play", "14_measuring_style")

# The quick preset only shows that every step runs, so notebooks train and walk for less than they do elsewhere.
QUICKER = {
    "04_training": "--param bone_steps 60",
    "06_failure_cases": "--param starts 3",
    "09_play": "--param seconds 5",
    "15_your_own_mocap": "--param steps 400",
}

# Jobs speak on standard output, so that `make` can send Snakemake's own account of them to a file.
shell.prefix("set -euo pipefail; exec 2>&1; ")

wildcard_constraints:
    lot="[0-9]+", model="[a-z-]+", seed="[0-9]+", run="[a-z-]+-seed[0-9]+", notebook="[0-9]{2}_[a-z_]+",
    base="base|normal"


def code(layer):
    """The library's files up to and with a layer: a step that uses the layer is redone when one of them changes."""
    layers = LAYERS[: LAYERS.index(layer) + 1]
    return sorted(str(path) for name in layers for path in Path("lib/stylephase", name).rglob("*.py"))


def lots():
    """The styles by lots, each the work of one process, once the data are there."""
    names = list(json.loads(Path(DATA).read_text())["frames_by_style"])
    return [names[first : first + LOT] for first in range(0, len(names), LOT)]


def styles(_):
    """The vectors of every style, known once the data are there."""
    checkpoints.data.get()
    return [f"build/vectors/{SET}/{lot}.json" for lot in range(len(lots()))]


def needs(wildcards):
    """What a notebook reads: the data, the other notebooks' numbers, or the trained runs."""
    if wildcards.notebook in ("01_data_and_skeleton", "02_local_phases", "10_global_phase_and_pfnn"):
        return DATA
    if wildcards.notebook in ("03_models_and_costs", "11_residual_adapters", "15_your_own_mocap"):
        return []
    if wildcards.notebook == "00_scorecard":
        return [f"{FIGURES}/{name}.json" for name in NOTEBOOKS if name != wildcards.notebook]
    if wildcards.notebook == "07_interpolation":
        return expand(f"{RUN}/evaluation.json", run=["lpn-film-seed0", "lpn-onehot-seed0"])
    if wildcards.notebook == "08_new_styles":
        return f"{HELD_OUT_RUN}/training.json"
    if wildcards.notebook == "12_few_shot":
        return expand(f"{RUN}/training.json", run=list(BASES))
    if wildcards.notebook == "13_gram_style_transfer":
        return f"build/runs/{SET}-{PRESET}-pfnn-cp-base-seed0/training.json"
    one = wildcards.notebook in ("04_training", "09_play")
    runs = expand(f"{RUN}/evaluation.json", run=[run for run in RUNS if run.startswith("lpn-film-")] if one else RUNS)
    base = wildcards.notebook == "14_measuring_style" and BASE
    return [*runs, *([f"build/runs/{SET}-{PRESET}-pfnn-cp-base-seed0/training.json"] if base else [])]


def more(notebook):
    """Parameters of a notebook beside those that all have."""
    quicker = QUICKER.get(notebook, "") if PRESET == "quick" else ""
    return f"--param run {SPARING}" if notebook == "08_new_styles" else quicker


rule all:
    localrule: True
    input: expand(f"{COPIES}/{{notebook}}.ipynb", notebook=NOTEBOOKS), DATA
    shell: "echo 'The executed notebooks lie in {COPIES}, their numbers in {FIGURES}'"


checkpoint data:
    input: "data/registry.toml", OWN_FILES, code("data")
    output: DATA
    shell:
        """
        echo "Fetching and checking {DATASET}"
        stylephase data check {DATASET:q} --json > {output:q}
        """


rule vectors:
    input: DATA, code("features")
    output: f"build/vectors/{SET}/{{lot}}.json"
    priority: SOONER
    params: styles=lambda wildcards: ",".join(lots()[int(wildcards.lot)])
    shell:
        """
        echo "Vectors of {params.styles}"
        stylephase vectors --data {DATASET:q} --styles {params.styles:q} --json > {output:q}
        """


# A run of other data or code is set aside, so that the training begins anew. When the training itself is interrupted,
# it resumes: its checkpoints are no outputs, so Snakemake leaves them.
rule begin:
    input: styles, code("training")
    output: f"{RUN}/begun"
    priority: SOONER
    params: folder=lambda wildcards, output: Path(output[0]).parent
    shell:
        """
        rm -rf {params.folder:q}.earlier
        mv {params.folder:q} {params.folder:q}.earlier
        mkdir {params.folder:q}
        touch {output:q}
        """


rule train:
    input: f"build/runs/{SET}-{PRESET}-{{model}}-seed{{seed}}/begun"
    output: f"build/runs/{SET}-{PRESET}-{{model}}-seed{{seed}}/training.json"
    params:
        folder=lambda wildcards, output: Path(output[0]).parent,
        without=f"--without {ALL_WITHOUT}" if ALL_WITHOUT else "",
    priority: SOONER
    threads: max(1, workflow.cores // len(RUNS))
    shell:
        """
        echo "Training {wildcards.model} on {DATASET}, preset {PRESET}, seed {wildcards.seed}"
        stylephase train --model {wildcards.model} --data {DATASET:q} --preset {PRESET} --seed {wildcards.seed} \
            --out {params.folder:q} {params.without} --resume --json > {output:q}
        """


rule train_without:
    input: f"build/runs/{SET}-{PRESET}-lpn-film-heldout-seed0/begun"
    output: f"build/runs/{SET}-{PRESET}-lpn-film-heldout-seed0/training.json"
    priority: SOONER
    params: folder=lambda wildcards, output: Path(output[0]).parent
    shell:
        """
        echo "Training lpn-film on {DATASET} without {WITHOUT}"
        stylephase train --model lpn-film --data {DATASET:q} --preset {PRESET} --seed 0 --without {WITHOUT:q} \
            --out {params.folder:q} --resume --json > {output:q}
        """


rule train_base:
    input: f"build/runs/{SET}-{PRESET}-pfnn-cp-{{base}}-seed0/begun"
    output: f"build/runs/{SET}-{PRESET}-pfnn-cp-{{base}}-seed0/training.json"
    priority: SOONER
    params:
        folder=lambda wildcards, output: Path(output[0]).parent,
        styles=lambda wildcards: BASES[f"pfnn-cp-{wildcards.base}-seed0"],
    shell:
        """
        echo "Training the base pfnn-cp-{wildcards.base} on {DATASET}"
        stylephase train --model pfnn-cp --data {DATASET:q} --preset {PRESET} --seed 0 --styles {params.styles:q} \
            --out {params.folder:q} --resume --json > {output:q}
        """


ruleorder: train_without > train_base > train


rule evaluate:
    input: f"{RUN}/training.json", code("evaluation")
    output: f"{RUN}/evaluation.json"
    priority: SOONER
    params: folder=lambda wildcards, output: Path(output[0]).parent
    shell:
        """
        echo "Test errors of {wildcards.run}"
        stylephase evaluate --weights {params.folder:q} --data {DATASET:q} --json > {output:q}
        """


rule notebook:
    input: "notebooks/{notebook}.py", needs, code("report")
    output: f"{COPIES}/{{notebook}}.ipynb", f"{FIGURES}/{{notebook}}.json"
    priority: lambda wildcards: SOONER if wildcards.notebook in LONGEST else 0
    params: more=lambda wildcards: more(wildcards.notebook)
    shell:
        """
        echo "Notebook {wildcards.notebook}"
        python -m stylephase.report.notebooks run {wildcards.notebook} --out {COPIES:q} \
            --param dataset {DATASET:q} --param preset {PRESET} {params.more} --param figures_folder {FIGURES:q}
        """

"""The checks of the paper's protocol see what they are to see, and are not met by a training that does otherwise."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tiny_training as tiny

from stylephase.data.catalogue import load_catalogue
from stylephase.data.layouts import Entry, published_entries
from stylephase.evaluation.protocol import (
    KEPT_BACK,
    changed_by_training,
    drawn_styles,
    epochs,
    in_turn,
    l1_slopes_off,
    off_from_equation_5,
    passes,
    rounds_of,
    try_bone_term,
)
from stylephase.features.store import VectorStore
from stylephase.report.manifest import ROOT
from stylephase.training.loop import Trainer
from stylephase.training.presets import PRESETS, preset_for

STYLES = ("Plain", "ChestOut", "LowCrouch")
SMALL = replace(PRESETS["quick"], steps=12, log_every=12, frames_per_style=8, styles_per_step=2)


@pytest.fixture(scope="module")
def store() -> VectorStore:
    return VectorStore(load_catalogue("synthetic", STYLES), "adaptive")


def test_the_papers_preset_takes_styles_in_turn_and_one_that_draws_them_does_not(store):
    paper = replace(PRESETS["paper"], network=PRESETS["quick"].network)
    assert in_turn(drawn_styles(store, "lpn-film", paper, "paper", 9), len(STYLES))
    drawn = replace(paper, in_turn=False)
    assert not in_turn(drawn_styles(store, "lpn-film", drawn, "paper", 9), len(STYLES))
    assert not in_turn(drawn_styles(store, "lpn-film", SMALL, "quick", 9), len(STYLES))


def test_the_papers_preset_makes_the_papers_epochs():
    takes = [take for take in published_entries() if take.style not in KEPT_BACK and not take.idle]
    paper = PRESETS["paper"]
    assert epochs(paper.steps, paper.frames_per_style, takes) == pytest.approx(90, abs=1)


def test_an_epoch_ends_with_the_smallest_style():
    takes = [
        Entry(Path("a"), "a", "FW", 0, 100),
        Entry(Path("b"), "b", "FW", 0, 1000),
        Entry(Path("c"), "b", "TR1", 0, 5),
    ]
    # 80 frames train of the smaller style: ten batches of 8, and as many of the other.
    assert epochs(60, 8, takes) == pytest.approx(3)


def test_passes_count_the_frames_drawn_of_the_smallest_style(store):
    styles = [store.load(style) for style in STYLES]
    even = replace(SMALL, style_power=0.0)
    least = min(len(style.rows("train")) for style in styles)
    assert passes(even, styles) == pytest.approx(12 * 2 * 8 / 3 / least)


def test_the_bone_term_is_weighed_against_a_second_seed(store):
    term = try_bone_term(store, SMALL, "quick", np.random.default_rng(0))
    assert term.error.low <= term.error.value <= term.error.high
    assert term.again.value != term.error.value


def test_the_styles_kept_back_are_those_of_the_pipeline():
    named = re.search(r'KEPT_BACK = "(.*)"', (ROOT / "Snakefile").read_text())
    assert named
    assert named[1].split(",") == list(KEPT_BACK)


def test_in_a_training_of_adapters_a_round_changes_the_shared_weights_and_those_of_its_style(store):
    how = replace(preset_for("quick", "pfnn-cp"), frames_per_style=8)
    found = rounds_of(Trainer(store, "pfnn-cp", how, "quick", 0), 7)
    assert in_turn(found.drawn, len(STYLES)) and found.own_alone
    two = replace(how, styles_per_step=2)
    found = rounds_of(Trainer(store, "pfnn-cp", two, "quick", 0), 4)
    assert not in_turn(found.drawn, len(STYLES)) and found.own_alone
    assert (found.changed[1:].sum(axis=0) == 2).all()


def test_the_slopes_of_the_l1_terms_are_those_of_the_paper_and_are_missed_where_a_term_is(store):
    how = preset_for("quick", "pfnn-cp")
    trainer = Trainer(store, "pfnn-cp", how, "quick", 0)
    assert max(l1_slopes_off(trainer, 1).values()) < 1e-6
    trainer.l1_terms = lambda chosen: 0 * Trainer.l1_terms(trainer, chosen)
    off = l1_slopes_off(trainer, 1)
    assert off["shared"] > 0.005 and off["its own"] > 0.005 and off["other styles'"] == 0


def test_both_networks_change_and_one_that_is_not_trained_does_not():
    assert changed_by_training(tiny.trainer()) == {"synthesis": 1.0, "generator": 1.0}
    frozen = tiny.trainer()
    frozen.optimisers["generator"].step = lambda *_: None
    assert changed_by_training(frozen)["generator"] == 0.0


def test_the_loss_is_equation_5_and_another_weight_of_bones_is_not():
    assert off_from_equation_5(tiny.trainer()) < 1e-6
    other = tiny.trainer()
    other.scaling.y[1] *= 1.5
    assert off_from_equation_5(other) > 1e-4

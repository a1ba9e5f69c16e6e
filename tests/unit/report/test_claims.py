"""Claims, results and verdicts: what is wrong is refused by name, and verdicts follow from bounds."""

import json
import platform
from pathlib import Path

import numpy as np
import pytest

from stylephase.errors import InputError
from stylephase.report import claims, manifest
from stylephase.report.recorder import QUICK_NOTE, Recorder

LISTED = """\
[notebooks]
01_small = "A small notebook"
02_other = "Another"

[[claim]]
id = "ratio"
paper = "M22"
where = "Table 1"
name = "A ratio is small."
kind = "number"
paper_value = 0.1
unit = "ratio"
at_most = 0.2
data = "100style"
notebook = "01_small"
status = "open"

[[claim]]
id = "look"
paper = "M18"
where = "Figure 1"
name = "It looks right."
kind = "figure"
data = "100style"
notebook = "01_small"
status = "open"

[[claim]]
id = "elsewhere"
paper = "ours"
where = "Rollouts"
name = "It is tested elsewhere."
kind = "number"
notebook = "02_other"
status = "open"
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A repository with three claims, one module and one notebook."""
    for name, text in {
        "data/claims.toml": LISTED,
        "lib/stylephase/walk.py": "SPEED = 1.2\n",
        "notebooks/01_small.py": "# %%\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture
def recorder(project: Path) -> Recorder:
    return Recorder("01_small", dataset="100style", preset="cpu", params={"seed": 0}, root=project)


def written(recorder: Recorder, **changes) -> Path:
    """The file of a recorder with one claim, its entry changed."""
    recorder.claim("ratio", value=0.15, n=3, seeds=[0, 1])
    recorder.write("figures")
    path = recorder.root / "figures" / "01_small.json"
    whole = json.loads(path.read_text())
    whole["claims"][0] |= changes
    path.write_text(json.dumps(whole))
    return path


class TestBounds:
    @pytest.mark.parametrize(
        ("value", "bounds", "inside"),
        [
            (0.2, (None, 0.2), True),
            (0.2001, (None, 0.2), False),
            (3, (3, None), True),
            (2.999, (3, None), False),
            ([0.8, 1.2], (0.75, 1.25), True),
            ([0.7, 1.2], (0.75, 1.25), False),
        ],
    )
    def test_bounds_are_inclusive_and_hold_for_every_element(self, value, bounds, inside):
        assert claims.within_bounds(value, *bounds) is inside

    @pytest.mark.parametrize("value", [np.nan, np.inf, [0.1, np.nan]])
    def test_nothing_is_said_of_what_is_not_finite(self, value):
        with pytest.raises(ValueError, match="finite"):
            claims.within_bounds(value, None, 1)

    def test_nothing_is_said_without_a_bound(self):
        with pytest.raises(ValueError, match="bound"):
            claims.within_bounds(1.0, None, None)


class TestCatalogue:
    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            ('status = "open"', 'satus = "open"', ":6: claim ratio has unknown fields: satus"),
            ('notebook = "01_small"\n', "", ":6: claim ratio lacks notebook"),
            ('notebook = "02_other"', 'notebook = "03_third"', ":29: claim elsewhere has notebook '03_third'"),
            ('kind = "figure"', 'kind = "picture"', ":19: claim look has kind 'picture'"),
            ('id = "look"', 'id = "ratio"', ":19: claim ratio is listed twice"),
            ('paper = "ours"', 'paper = "M20"', ":29: claim elsewhere has paper 'M20'"),
            ("at_most = 0.2", "at_most =", "not TOML"),
        ],
    )
    def test_a_faulty_catalogue_is_refused_with_its_line(self, tmp_path, old, new, message):
        path = tmp_path / "claims.toml"
        path.write_text(LISTED.replace(old, new, 1))
        with pytest.raises(InputError) as caught:
            claims.read_claims(path)
        assert str(caught.value).startswith(f"{path}:") and message in str(caught.value)

    def test_a_missing_catalogue_is_named(self, tmp_path):
        with pytest.raises(InputError, match=r"claims\.toml: cannot read"):
            claims.read_claims(tmp_path / "claims.toml")


class TestRecords:
    @pytest.mark.parametrize(
        ("changes", "message"),
        [
            ({"id": "rate"}, "rate is not in claims.toml"),
            ({"id": "elsewhere"}, "elsewhere belongs to notebook 02_other"),
            ({"name": "A ratio was small."}, "out of date: name changed"),
            ({"paper_value": 0.11}, "out of date: paper_value changed"),
            ({"verdict": "nearly"}, "has verdict 'nearly'"),
            ({"verdict": "differs", "value": 0.4}, "needs a note: the reason"),
            ({"verdict": "not testable here"}, "needs a note: what it needs"),
            ({"value": float("nan")}, "expected finite values"),
            ({"value": None}, "has no value"),
            ({"value": 0.4}, "but claims.toml asks for at most 0.2"),
            ({"verdict": "differs", "note": "why"}, "but claims.toml asks for at most 0.2"),
            ({"colour": "red"}, "has other fields"),
        ],
    )
    def test_a_faulty_result_is_refused_with_its_file(self, recorder, changes, message):
        path = written(recorder, **changes)
        with pytest.raises(InputError) as caught:
            claims.read_record(path, recorder.catalogue)
        assert str(caught.value).startswith(f"{path}: ") and message in str(caught.value)

    def test_a_result_recorded_twice_is_refused(self, recorder):
        path = written(recorder)
        whole = json.loads(path.read_text())
        path.write_text(json.dumps(whole | {"claims": whole["claims"] * 2}))
        with pytest.raises(InputError, match="ratio is recorded twice"):
            claims.read_record(path, recorder.catalogue)

    def test_a_file_of_another_shape_is_refused(self, recorder, tmp_path):
        path = tmp_path / "01_small.json"
        path.write_text('{"claims": []}')
        with pytest.raises(InputError, match='expected an object with "claims" and "manifest"'):
            claims.read_record(path, recorder.catalogue)

    def test_what_was_recorded_is_read_back(self, recorder):
        recorder.number("frames", np.int64(3))
        written(recorder)
        (record,) = claims.read_records(recorder.root / "figures", recorder.catalogue)
        assert record.results == recorder.record.results
        assert record.numbers == {"frames": {"value": 3, "unit": ""}}

    def test_a_folder_that_is_missing_holds_no_records(self, recorder):
        assert claims.read_records(recorder.root / "figures", recorder.catalogue) == []


class TestRecorder:
    def test_the_file_has_the_fields_that_others_rely_on(self, recorder):
        whole = json.loads(written(recorder).read_text())
        assert set(whole) == {"claims", "manifest"}
        assert whole["claims"] == [
            {
                "id": "ratio",
                "name": "A ratio is small.",
                "paper": "M22",
                "where": "Table 1",
                "paper_value": 0.1,
                "value": 0.15,
                "unit": "ratio",
                "n": 3,
                "seeds": [0, 1],
                "tolerance": "at most 0.2",
                "verdict": "reproduced",
                "note": "",
            }
        ]
        assert list(whole["manifest"]) == [
            *("dataset", "preset", "params", "code_hash", "data_hash", "versions", "device", "wall_s")
        ]

    def test_other_data_than_the_claims_are_said_to_be_other(self, recorder):
        assert recorder.claim("ratio", value=0.15, dataset="xia") == "reproduced on other data"

    def test_numbers_and_arrays_of_numpy_are_kept_as_plain_numbers(self, recorder):
        recorder.claim("ratio", value=np.array([0.1, 0.2]))
        recorder.write("figures")
        assert json.loads((recorder.root / "figures/01_small.json").read_text())["claims"][0]["value"] == [0.1, 0.2]

    @pytest.mark.parametrize(
        ("identifier", "given", "message"),
        [
            ("rate", {"value": 1.0}, "not in claims.toml"),
            ("elsewhere", {"value": 1.0, "holds": True}, "belongs to notebook 02_other"),
            ("look", {"value": 1.0}, "needs a verdict: it has no bounds"),
            ("ratio", {}, "needs a verdict: it has no value"),
            ("ratio", {"value": np.nan}, "expected finite values"),
            ("ratio", {"value": 0.5}, "needs a note: the reason"),
            ("ratio", {"value": 0.5, "holds": True}, "asks for at most 0.2"),
            ("look", {"holds": False}, "needs a note: the reason"),
        ],
    )
    def test_a_claim_that_cannot_stand_is_refused(self, recorder, identifier, given, message):
        with pytest.raises(InputError, match=message):
            recorder.claim(identifier, **given)
        assert recorder.entries == {}

    def test_what_is_not_testable_says_what_it_needs(self, recorder):
        with pytest.raises(InputError, match="needs a note: what it needs"):
            recorder.not_testable("look", "")

    @pytest.mark.parametrize(
        ("holds", "dataset", "verdict"),
        [(True, None, "reproduced"), (True, "xia", "reproduced on other data"), (False, "xia", "differs")],
    )
    def test_without_bounds_the_notebook_says_whether_a_claim_holds(self, recorder, holds, dataset, verdict):
        assert recorder.claim("look", holds, "by eye", dataset=dataset) == verdict

    def test_a_claim_is_recorded_once(self, recorder):
        recorder.not_testable("look", "eyes")
        with pytest.raises(InputError, match="look is recorded twice"):
            recorder.not_testable("look", "eyes")

    def test_the_quick_preset_is_reason_enough_to_differ(self, project):
        quick = Recorder("01_small", dataset="100style", preset="quick", params={}, root=project)
        assert quick.claim("ratio", value=0.5) == "differs"
        assert quick.entries["ratio"]["note"] == QUICK_NOTE


class TestManifest:
    def code_hash(self, project: Path) -> str:
        whole = manifest.manifest(notebook="01_small", dataset="d", preset="p", params={}, data_files=[], root=project)
        return whole["code_hash"]

    @pytest.mark.parametrize("changed", ["lib/stylephase/walk.py", "notebooks/01_small.py"])
    def test_the_code_hash_follows_library_and_notebook(self, project, changed):
        before = self.code_hash(project)
        assert self.code_hash(project) == before
        (project / changed).write_text("SPEED = 1.3\n")
        assert self.code_hash(project) != before

    def test_the_data_hash_knows_names_but_not_the_order(self, tmp_path):
        first, second, third = (tmp_path / name for name in "abc")
        first.write_text("1"), second.write_text("2"), third.write_text("1")
        both = manifest.combined_hash([first, second], tmp_path)
        assert manifest.combined_hash([second, first], tmp_path) == both
        assert manifest.combined_hash([third, second], tmp_path) != both

    def test_versions_name_python_and_skip_what_is_not_installed(self):
        assert set(manifest.versions(["numpy", "no-such-package"])) == {"python", "numpy"}

    def test_the_device_is_no_host(self):
        assert "threads" in manifest.device()
        assert platform.node() not in manifest.device()

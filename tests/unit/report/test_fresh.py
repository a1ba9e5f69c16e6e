"""What makes a notebook stale, and what does not."""

import ast
import json
from dataclasses import replace
from pathlib import Path

import pytest

from stylephase.report import fresh, made, notebooks, ran
from stylephase.report.sources import Sources

LIBRARY = '''\
"""Steps."""

SPEED = 1.2  # m/s
LIMIT = SPEED * 2
UNUSED = 3
_STEPS = []


def step(n: int) -> float:
    """One step."""
    return min(n * SPEED, LIMIT)


def never():
    return UNUSED


class Walker:
    """Walks."""

    legs: int = 2

    def walk(self):
        def leg():
            return step(self.legs)

        return leg()

    def run(self):
        return never()
'''
SCRIPT = """\
# %% [markdown]
# # A small notebook

# %% tags=["parameters"]
figures_folder: str = "figures"  # where numbers go

# %%
from stylephase.walk import Walker

Walker().walk()  # walk
"""
RAN = ["stylephase.walk:Walker.walk", "stylephase.walk:step"]
NAME = "01_small"
PRINTED = '{"output_type": "stream", "name": "stdout", "text": "1"}'
FILES = {
    "lib/stylephase/walk.py": LIBRARY,
    f"notebooks/{NAME}.py": SCRIPT,
    "data/claims.toml": f'[[claim]]\nnotebook = "{NAME}"\nat_most = 3\nstatus = "open"\n'
    '[[claim]]\nnotebook = "02_other"\nat_most = 5\nstatus = "open"\n',
    "data/registry.toml": "[walks]\nfps = 30\n[runs]\nfps = 60\n",
    "data/table.csv": "1,2\n",
    "data/pretrained/small/model.json": "{}",
    "data/pretrained/small/model.safetensors": "weights",
    f"figures/{NAME}.png": "a picture",
}


@pytest.fixture
def project(tmp_path: Path, cache: Path) -> Path:
    """A repository with a library, data, and one notebook that was made with them."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    read = ["data/claims.toml", "data/registry.toml", "data/table.csv", "data/pretrained/small/model.json"]
    noted = {"ran": RAN, "started": [], "written": [], "read": [str(tmp_path / name) for name in read]}
    noted["read"].append(str(cache / "walks-0123456789ab/one.bvh"))
    script = notebooks.read_script(tmp_path / f"notebooks/{NAME}.py")
    copy = notebooks.clean(script)
    notebooks.write_notebook(copy, tmp_path / f"notebooks/{NAME}.ipynb")
    parameters = {"figures_folder": "figures"}
    entry = made.made_of(tmp_path, NAME, parameters, notebooks.code_cells(script), noted)
    outputs = made.output_digests(tmp_path, NAME, copy, "figures")
    made.write(made.place(tmp_path, NAME), replace(entry, outputs=outputs))
    assert fresh.changed(NAME, tmp_path) == []
    return tmp_path


def edit(root: Path, file: str, old: str, new: str) -> None:
    text = (root / file).read_text()
    assert old in text
    (root / file).write_text(text.replace(old, new))


@pytest.mark.parametrize(
    ("file", "old", "new", "changed"),
    [
        ("lib/stylephase/walk.py", "min(n * SPEED", "max(n * SPEED", ["stylephase.walk:step"]),
        ("lib/stylephase/walk.py", "1.2", "1.3", ["stylephase.walk:SPEED"]),
        ("lib/stylephase/walk.py", "SPEED * 2", "SPEED * 3", ["stylephase.walk:LIMIT"]),
        ("lib/stylephase/walk.py", "legs: int = 2", "legs: int = 4", ["stylephase.walk:Walker"]),
        ("lib/stylephase/walk.py", "step(self.legs)", "step(self.legs + 1)", ["stylephase.walk:Walker.walk"]),
        ("lib/stylephase/walk.py", "def step", "def stride", ["stylephase.walk:step (gone)"]),
        (f"notebooks/{NAME}.py", "Walker().walk()", "Walker().walk() + 1", ["cell 1"]),
        (f"notebooks/{NAME}.py", "# walk\n", "# walk\n\n# %%\n1 + 1\n", ["1 cells"]),
        (f"notebooks/{NAME}.py", "small notebook", "small story", [fresh.TEXT]),
        (f"notebooks/{NAME}.py", "# walk\n", "# walk a little\n", [fresh.TEXT]),
        ("data/table.csv", "1,2", "1,3", ["data/table.csv"]),
        ("data/pretrained/small/model.safetensors", "weights", "others", ["data/pretrained/small"]),
        ("data/claims.toml", "at_most = 3", "at_most = 4", ["data/claims.toml"]),
        ("data/registry.toml", "fps = 30", "fps = 31", ["data/registry.toml:walks"]),
        (f"figures/{NAME}.png", "a picture", "another", [f"{NAME}.png"]),
        (f"notebooks/{NAME}.ipynb", '"outputs": []', f'"outputs": [{PRINTED}]', [f"{NAME}.ipynb"]),
    ],
)  # fmt: skip
def test_a_change_that_may_change_an_output_is_named(project, file, old, new, changed):
    edit(project, file, old, new)
    assert fresh.changed(NAME, project) == changed


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("lib/stylephase/walk.py", "One step.", "A step."),
        ("lib/stylephase/walk.py", "# m/s", "# metres per second"),
        ("lib/stylephase/walk.py", "min(n * SPEED, LIMIT)", "min(\n        n * SPEED,\n        LIMIT,\n    )"),
        ("lib/stylephase/walk.py", "n: int", "n: float"),
        ("lib/stylephase/walk.py", "return UNUSED", "return UNUSED + 1"),
        ("lib/stylephase/walk.py", "UNUSED = 3", "UNUSED = 4"),
        ("lib/stylephase/walk.py", "return never()", "return 5"),
        ("data/claims.toml", "at_most = 5", "at_most = 6"),
        ("data/claims.toml", 'status = "open"', 'status = "recorded"'),
        ("data/registry.toml", "fps = 60", "fps = 50"),
    ],
)
def test_a_change_that_cannot_leaves_it_fresh(project, file, old, new):
    edit(project, file, old, new)
    assert fresh.changed(NAME, project) == []


def test_a_function_notes_its_name_before_it_does_anything():
    names, tree = {"__ran__": {}}, ran.noting(ast.parse(LIBRARY), "walk")
    exec(compile(tree, "walk.py", "exec"), names)
    assert names["Walker"]().walk() == 2.4 and names["step"].__doc__ == "One step."
    assert sorted(names["__ran__"]) == ["walk:Walker.walk", "walk:step"]


def test_what_may_run_is_found_by_name(project):
    sources = Sources(project)
    assert {"stylephase.walk:never", "stylephase.walk:step"} <= sources.reachable(["stylephase.walk:Walker"])
    assert "stylephase.walk:never" not in sources.reachable(["stylephase.walk:step"])


def test_text_is_brought_into_step_without_a_run(project):
    edit(project, f"notebooks/{NAME}.py", "small notebook", "small story")
    fresh.make(NAME, project)
    assert fresh.changed(NAME, project) == []


def test_missing_runs_are_one_line_and_the_others_go_on(project, capsys, monkeypatch):
    entry, path = made.read(made.place(project, NAME)), made.place(project, NAME)
    made.write(path, replace(entry, runs=["build/runs/one"]))
    edit(project, "data/table.csv", "1", "5")
    for file in (f"notebooks/{NAME}.py", f"notebooks/{NAME}.ipynb", f"notebooks/{NAME}.made.json"):
        (project / file.replace(NAME, "02_other")).write_text((project / file).read_text())
    made.write(made.place(project, "02_other"), replace(entry, parameters={"figures_folder": "figures"}))
    (project / made.LISTED).write_text('# why\n02_other = "later"\n01_small = "no runs"\n')
    ran_again = []
    monkeypatch.setattr(notebooks, "run", lambda name, given, **_: ran_again.append((name, given)))
    monkeypatch.setattr(fresh.scorecard, "main", lambda *_: 0)
    assert fresh.main(["make"], project) == 2
    assert capsys.readouterr().err == "01_small needs trained runs that are not there: build/runs/one\n"
    assert ran_again == [("02_other", {"figures_folder": "figures"})]
    assert made.admitted(project) == {"01_small": "no runs"}


def test_a_vouched_change_keeps_its_reason_and_what_is_called_now(project, capsys):
    assert fresh.main(["vouch", NAME, "--reason", "why not"], project) == 2
    edit(project, "lib/stylephase/walk.py", "min(n * SPEED", "min(never() * 0 + n * SPEED")
    assert fresh.main(["vouch", NAME, "--reason", "adds nothing"], project) == 0
    assert fresh.main([], project) == 0
    entry = made.read(made.place(project, NAME))
    assert entry.vouched == [{"reason": "adds nothing", "changed": ["stylephase.walk:step"]}]
    edit(project, "lib/stylephase/walk.py", "UNUSED = 3", "UNUSED = 4")
    assert fresh.changed(NAME, project) == ["stylephase.walk:UNUSED"]


def test_nobody_can_vouch_for_another_picture(project, capsys):
    edit(project, f"figures/{NAME}.png", "a picture", "another")
    assert fresh.main(["vouch", NAME, "--reason", "it is prettier"], project) == 2
    assert f"did not make {NAME}.png" in capsys.readouterr().err


def test_a_run_notes_functions_files_and_its_outputs(tmp_path, root, cache):
    (tmp_path / "lib").symlink_to(root / "lib")
    for name, text in {"data/a.json": "1", "build/runs/one/log.json": "2", f"notebooks/{NAME}.py": ""}.items():
        (tmp_path / name).parent.mkdir(parents=True)
        (tmp_path / name).write_text(text)
    work = (
        'write_json(f"{figures_folder}/01_small.json", read_json("data/a.json") + read_json("build/runs/one/log.json"))'
    )
    script = SCRIPT.partition("from stylephase")[0] + f"from stylephase.files import read_json, write_json\n\n{work}\n"
    (tmp_path / f"notebooks/{NAME}.py").write_text(script)
    notebooks.run(NAME, {}, out=tmp_path / "notebooks", root=tmp_path)
    entry = made.read(made.place(tmp_path, NAME))
    assert {"stylephase.files:write_text", "stylephase.training.loop:Trainer"} <= entry.code.keys()
    assert "stylephase.files:write_arrays" in entry.code, "behind trained runs"
    assert (list(entry.data), entry.runs) == (["data/a.json"], ["build/runs/one"])
    assert list(entry.outputs) == [f"{NAME}.ipynb", f"{NAME}.json"]
    assert "told" not in (tmp_path / f"notebooks/{NAME}.ipynb").read_text()
    assert fresh.changed(NAME, tmp_path) == [] and json.loads((tmp_path / f"figures/{NAME}.json").read_text()) == 3

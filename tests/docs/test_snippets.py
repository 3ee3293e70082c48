"""What the README and the documentation show is true: their snippets run, the files and names they mention exist.

A comment before a snippet says how it is treated: `<!-- test: file NAME -->` keeps it as a file for what follows,
`<!-- test: not run, REASON -->` only lets its syntax be checked.
"""

import ast
import importlib
import re
import runpy
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import typer
import yaml
from commands import fatplan
from conftest import PAPER, ROOT
from forgotten_plugins import forgotten_plugins
from markdown_it import MarkdownIt

import fatigue_planner as fp
from fatigue_planner.cli.main import app
from fatigue_planner.core.plugins import ENTRY_POINTS, load_plugin
from fatigue_planner.experiment.build import reaction_requests
from fatigue_planner.experiment.loader import load_experiment, parse_experiment, read_content
from fatigue_planner.experiment.schema import Experiment
from fatigue_planner.human.model import build_human
from fatigue_planner.human.strength_sets import load_strengths
from fatigue_planner.motion.settings import Cycle
from fatigue_planner.motion.simulator import simulate
from fatigue_planner.motion.tasks.registry import Preference
from fatigue_planner.motion.verification import measure
from fatigue_planner.reactions.reaction import Reaction
from fatigue_planner.recordings.imports.subject import load_subject
from fatigue_planner.recordings.mapping import load_mapping
from fatigue_planner.station.line.loader import load_line
from fatigue_planner.station.loader import load_station
from fatigue_planner.study.claims.loader import load_claims

GENERATED = {"human.md"}  # by `fatplan human report`
PAGES = sorted({ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *ROOT.glob("docs/*.md")})
PAGES = [page for page in PAGES if page.name not in GENERATED]
LANGUAGES = {"python", "yaml", "toml", "console", "sh", "text"}
# What commands start with besides fatplan, python and make.
OTHER_PROGRAMS = {"pip", "dask", "openssl", "mkdir", "chmod", "cd", "cp", "python3", "jq"}
# Commands that need a few seconds at most and change nothing outside their folder.
QUICK = {"validate", "schema"}


@dataclass(frozen=True)
class Snippet:
    """A block of code of a page; `line` is the number of its first line."""

    language: str
    text: str
    line: int
    note: str

    @property
    def not_run(self) -> bool:
        return self.note.startswith("not run")

    @property
    def file(self) -> str | None:
        return self.note.removeprefix("file ") if self.note.startswith("file ") else None


@cache
def snippets(page: Path) -> list[Snippet]:
    found, note = [], ""
    for token in MarkdownIt().enable("table").parse(page.read_text(encoding="utf-8")):
        if token.type == "html_block":
            comment = re.fullmatch(r"<!-- test: (.*) -->", token.content.strip())
            note = comment[1] if comment else note
        elif token.type in {"fence", "code_block"}:
            assert token.map is not None
            if not token.info.startswith("{"):  # a directive of the site
                found.append(Snippet(token.info, token.content, token.map[0] + 2, note))
            note = ""
    return found


def with_language(*languages: str) -> list[Path]:
    return [page for page in PAGES if any(snippet.language in languages for snippet in snippets(page))]


def names(pages: list[Path]) -> Any:
    return pytest.mark.parametrize("page", pages, ids=[str(page.relative_to(ROOT)) for page in pages])


@names(PAGES)
def test_every_snippet_says_what_it_is(page: Path) -> None:
    assert {snippet.language for snippet in snippets(page)} <= LANGUAGES


# --- Python ----------------------------------------------------------------------------------------------------------


def run_python(page: Path, folder: Path) -> None:
    """Run the Python of a page as one module whose lines have the page's numbers."""
    lines: list[str] = []
    for snippet in snippets(page):
        if snippet.language == "python":
            ast.parse(snippet.text)
            if not snippet.not_run:
                lines += [""] * (snippet.line - 1 - len(lines)) + snippet.text.splitlines()
    module = folder / f"{page.stem}.py"
    module.write_text("\n".join(lines) + "\n", encoding="utf-8")
    runpy.run_path(str(module))


@names(with_language("python"))
def test_the_python_of_a_page_runs(
    page: Path, tmp_path: Path, cache_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(ROOT / "experiments", tmp_path / "experiments")
    shutil.copytree(cache_folder, tmp_path / "cache")
    monkeypatch.chdir(tmp_path)
    with forgotten_plugins():
        run_python(page, tmp_path)


@pytest.fixture
def own_kinds() -> Iterator[dict[str, Any]]:
    """What the plug-ins shown define."""
    with forgotten_plugins():
        found = [vars(load_plugin(ROOT / f"examples/own_{name}.py")) for name in ("policy", "belief", "motion_task")]
        yield {name: thing for module in found for name, thing in module.items()}


def test_the_policy_and_the_belief_shown_do_what_they_say(
    own_kinds: dict[str, Any], paper: Experiment, reactions: tuple[Reaction, ...]
) -> None:
    """Two of the paper's three possible states are kept, with the proportions that the exact belief gives them."""
    content = read_content(PAPER) | {"belief": {"kind": "likeliest", "count": 2}}
    by_name = {str(reaction.name): reaction for reaction in reactions}
    scenario = fp.scenario(parse_experiment(content, "mine.yaml"), by_name, "multiple_novice")
    exact = fp.scenario(paper, by_name, "multiple_novice")
    rng = np.random.default_rng(0)
    kept, whole = (found.initial_belief("prior", found.model, rng).update(0, 1, rng) for found in (scenario, exact))
    assert isinstance(kept, own_kinds["LikeliestBelief"]) and len(whole.weights) == 3
    likeliest = np.sort(whole.weights)[::-1][:2]
    np.testing.assert_allclose(kept.weights, likeliest / likeliest.sum(), rtol=1e-12)
    assert all((row == whole.states).all(axis=1).any() for row in kept.states)
    run = fp.run(scenario, {"kind": "stubborn", "cycles": 2}, n_cycles=6)
    assert run.cycles["action"].tolist() == ["high", "high", "low", "low", "high", "high"]


def test_the_kind_of_task_shown_keeps_the_head_at_its_height(own_kinds: dict[str, Any]) -> None:
    task = own_kinds["HeadHeight"].model_validate({"kind": "head_height", "weight": 1000, "height_m": 1.4}, strict=True)
    request = reaction_requests(load_experiment(PAPER))[0].motion
    short = Cycle(reach_s=2.0, work_s=1.0, return_s=2.0)
    motion = simulate(replace(request, cycle=short, preference=Preference.model_construct(tasks=(task,))))
    human = build_human(request.worker)
    data = human.model.createData()
    pin.framesForwardKinematics(human.model, data, motion.configuration[motion.phase("work").stop - 1])
    assert data.oMf[human.model.getFrameId("head")].translation[2] == pytest.approx(1.4, abs=0.01)


def test_the_toml_shown_names_the_entry_points_that_are_looked_for() -> None:
    texts = [snippet.text for page in PAGES for snippet in snippets(page) if snippet.language == "toml"]
    assert [list(tomllib.loads(text)["project"]["entry-points"]) for text in texts] == [[ENTRY_POINTS]]


# --- YAML ------------------------------------------------------------------------------------------------------------

# Sections of which a fragment may give some keys; it replaces the others whole.
MERGED = {"benchmark", "cycle", "controller", "fatigue", "statistics"}


def as_experiment(fragment: dict[str, Any], path: Path) -> Path:
    """The paper's experiment with the sections of a fragment, as a file."""
    content = yaml.safe_load(PAPER.read_text(encoding="utf-8"))
    if "conditions" in fragment.get("benchmark", {}) or "policies" in fragment.get("benchmark", {}):
        content["statistics"] = {}
        content["figures"] = {}
    for section, value in fragment.items():
        content[section] = content[section] | value if section in MERGED else value
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path


def understand(snippet: Snippet, path: Path) -> None:
    """Load what a block shows with what reads it, which raises if it does not understand it."""
    text = snippet.text
    content = yaml.safe_load(text)
    if "distributed" in content:  # Dask's settings
        assert content["distributed"]["comm"]["require-encryption"] is True
    elif "height_m" in content:
        path.write_text(text, encoding="utf-8")
        load_subject(path)
    elif "landmarks" in content:
        path.write_text(text, encoding="utf-8")
        load_mapping(str(path))
    elif "crew" in content:
        stations = {name: {**said, "file": "car_line"} for name, said in content["stations"].items()}
        path.write_text(yaml.safe_dump({**content, "stations": stations}))
        load_line(path)
    elif "operations" in content:
        path.write_text(text, encoding="utf-8")
        load_station(path)
    elif "population" in content:
        path.write_text(text, encoding="utf-8")
        load_strengths(str(path))
    elif "claims" in content:
        path.write_text(text, encoding="utf-8")
        shutil.copy(PAPER, path.parent)
        load_claims(path)
    elif snippet.file:  # a whole one
        path.write_text(text, encoding="utf-8")
        load_experiment(path)
    else:
        load_experiment(as_experiment(content, path))


@names(with_language("yaml"))
def test_the_yaml_of_a_page_is_understood(page: Path, tmp_path: Path) -> None:
    for snippet in snippets(page):
        if snippet.language == "yaml":
            understand(snippet, tmp_path / f"line_{snippet.line}.yaml")


def test_the_actions_shown_can_be_performed(tmp_path: Path) -> None:
    block = next(snippet for snippet in snippets(ROOT / "docs" / "tasks.md") if "actions:" in snippet.text)
    experiment = load_experiment(as_experiment(yaml.safe_load(block.text), tmp_path / "mine.yaml"))
    assert list(experiment.actions)[:3] == ["hold", "rack_x0.3_z0.9", "rack_x0.3_z1.2"] and len(experiment.actions) == 8
    request = reaction_requests(experiment)[-1].motion
    quality = measure(request, simulate(request))
    assert quality.faults(experiment.accuracy.model_copy(update={"hand_error_m": 0.03})) == []


# --- commands --------------------------------------------------------------------------------------------------------


def commands_of(snippet: Snippet) -> list[list[str]]:
    """The commands of a block: the lines after a prompt, or all of them, without their output and comments."""
    text = snippet.text.replace("\\\n", " ")
    lines = text.splitlines()
    if snippet.language == "console":
        lines = [line.removeprefix("$ ") for line in lines if line.startswith("$ ")]
    found = []
    for line in lines:
        lexer = shlex.shlex(line, posix=True, punctuation_chars="|&")
        lexer.whitespace_split, lexer.commenters = True, "#"
        words: list[str] = []
        for word in [*lexer, "|"]:
            if word.strip("|&"):
                words.append(word)
            elif words:
                found.append(words)
                words = []
    return found


def check_fatplan(words: list[str]) -> None:
    """Let the command line parse the words, without doing what they say. Raises what it raises."""
    command: Any = typer.main.get_command(app)
    context = None
    try:
        while True:
            context = command.make_context(words[0] if context else "fatplan", words[bool(context) :], parent=context)
            words = [*getattr(context, "_protected_args", []), *context.args]
            command = getattr(context.command, "commands", {}).get(words[0] if words else "")
            if command is None:
                assert not hasattr(context.command, "commands"), f"no such command: {words}"
                return
    except typer.Exit:  # --version, --help
        pass


def targets() -> set[str]:
    return set(re.findall(r"^([a-z][a-z-]*):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.M))


@names(with_language("console", "sh"))
def test_the_commands_of_a_page_are_understood(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("experiments", "examples"):
        shutil.copytree(ROOT / folder, tmp_path / folder)
    monkeypatch.chdir(tmp_path)
    with forgotten_plugins():
        check_commands(page, tmp_path)


def check_commands(page: Path, tmp_path: Path) -> None:
    for snippet in snippets(page):
        if snippet.file:
            (tmp_path / snippet.file).write_text(snippet.text, encoding="utf-8")
        if snippet.language not in {"console", "sh"}:
            continue
        for program, *words in commands_of(snippet):
            if program == "fatplan":
                check_fatplan(words)
                if words[0] in QUICK and all((tmp_path / word).exists() for word in words[1:]):
                    done = fatplan(*words, cwd=tmp_path)
                    assert done.returncode == 0, done.stderr
            elif program in {"make", "python"}:
                known = targets() | {str(file.relative_to(ROOT)) for file in ROOT.glob("*/*.py")}
                assert words[0] in known, f"{page.name}: {program} {words[0]}"
            else:
                assert Path(program).name in OTHER_PROGRAMS or program == ".", f"{page.name}: {program}"


@pytest.mark.slow
def test_the_tutorial_can_be_followed(tmp_path: Path) -> None:
    """Every command of fatplan in it, one after the other, in a folder of its own."""
    shutil.copytree(ROOT / "experiments", tmp_path / "experiments")
    ran = []
    for snippet in snippets(ROOT / "docs" / "tutorial.md"):
        if snippet.file:
            (tmp_path / snippet.file).write_text(snippet.text, encoding="utf-8")
        if snippet.language == "console" and not snippet.not_run:
            for program, *words in commands_of(snippet):
                if program == "fatplan":
                    done = fatplan(*words, cwd=tmp_path)
                    assert done.returncode == 0, done.stderr
                    ran.append(words[0])
    assert {"doctor", "init", "simulate", "view", "benchmark", "validate", "report"} <= set(ran)
    assert (tmp_path / "motions.html").stat().st_size > 100_000 and (tmp_path / "results").exists()


@pytest.mark.slow
def test_the_way_from_recordings_to_a_plan_can_be_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every command of the page, one after the other; what a command says goes into the experiment as the page says."""
    monkeypatch.chdir(tmp_path)
    experiment = Path("people.yaml")
    ran, learnt = [], {"worker": "ann", "initial_belief": "rested", "hidden_worker": "learnt"}

    def add(content: dict[str, Any]) -> None:
        whole = yaml.safe_load(experiment.read_text())
        for key, value in content.items():
            whole[key] = whole.get(key, {}) | value
        experiment.write_text(yaml.safe_dump(whole, sort_keys=False))

    for snippet in snippets(ROOT / "docs" / "from-recordings.md"):
        if snippet.file:
            Path(snippet.file).write_text(snippet.text, encoding="utf-8")
        for program, *words in commands_of(snippet) if snippet.language == "console" else ():
            if program == "python":
                with monkeypatch.context() as patch:
                    patch.setattr("sys.argv", words)
                    runpy.run_path(str(ROOT / words[0]), run_name="__main__")
                continue
            done = fatplan(*words, *(("--jobs", "1") if words[0] in {"simulate", "benchmark"} else ()))
            assert done.returncode == 0, done.stdout + done.stderr
            ran.append(" ".join(words[:2]))
            if ran[-1] == "record import":
                add(yaml.safe_load(done.stdout.splitlines()[-1]))
            elif ran[-1] == "record recognise":
                add(yaml.safe_load(Path("results/people/recognition/recognition.yaml").read_text()))
            elif ran[-1] == "record learn":
                found = yaml.safe_load(Path("learnt.yaml").read_text())
                model = {"choice_model": "learnt"} if "choice_models" in found else {}
                conditions = load_experiment(experiment).plain()["benchmark"]["conditions"]
                assert set(conditions) == {"ann"}
                whole = yaml.safe_load(experiment.read_text())
                whole["benchmark"]["conditions"]["learnt"] = learnt | model
                add(found | {"benchmark": whole["benchmark"]})
    assert ran.count("record import") == 3 and ran[-1] == "report people.yaml"
    page = Path("results/people/report.html").read_text()
    assert "3 reactions were recorded, not simulated" in page


# --- names -----------------------------------------------------------------------------------------------------------

FOLDERS = ("fatigue_planner/", "tests/", "experiments/", "examples/", "perf/", "docs/")


@names(PAGES)
def test_the_files_and_modules_a_page_mentions_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    tests = {file.name for file in (ROOT / "tests").rglob("test_*.py")}
    for word in re.findall(r"`([^`\s]+)`", text):
        if word.startswith(FOLDERS):
            assert (ROOT / word).exists(), word
        elif re.fullmatch(r"test_\w+\.py", word):
            assert word in tests, word
        elif re.fullmatch(r"fatigue_planner(\.[a-z_]+)+", word) and word != ENTRY_POINTS:
            importlib.import_module(word)
    if page.parent == ROOT:  # the site's build checks the links of the others
        for link in re.findall(r"\]\((?!https?:)([^)#]+)", text):
            assert (ROOT / link).exists(), link


def test_the_glossary_names_what_is_there() -> None:
    """Each `name`, in the `room/file.py` of its part of the cell if one is given, else anywhere in the package."""
    package = ROOT / "fatigue_planner"
    texts = {str(file.relative_to(package)): file.read_text(encoding="utf-8") for file in package.rglob("*.py")}
    everything = "".join(texts.values())
    rows = re.findall(r"^\| .* \| (.+?) \| .+ \|$", (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8"), re.M)
    parts = [part for row in rows if row != "fatplan" for part in row.split(";")]
    assert len(parts) >= 60
    for part in parts:
        words = re.findall(r"`([^`]+)`", part)
        files = [word for word in words if word.endswith(".py")]
        assert all(file in texts for file in files), part
        text = texts[files[0]] if files else everything
        for name in set(words) - set(files):
            assert re.search(rf"\b{re.escape(name)}\b", text), part


def test_the_readme_fits_one_screen() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) <= 350

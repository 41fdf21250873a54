"""What is said of wrong scenes, options and runs."""

from __future__ import annotations

import os
import pickle

import numpy as np
import pytest
import qrm
from conftest import ROOT


@pytest.fixture
def scene_file(tmp_path):
    """A scene file with some text replaced."""

    def write(old: str, new: str, scene: str = "quick-return"):
        text = (ROOT / f"scenes/{scene}.toml").read_text()
        assert old in text
        path = tmp_path / "changed.toml"
        path.write_text(text.replace(old, new, 1))
        return path

    return write


def test_a_wrong_scene_is_shown_with_line_and_column(scene_file):
    path = scene_file("B.x + BC*cos(phi5)", "B.x + BD*cos(phi5)")
    with pytest.raises(qrm.SceneError) as raised:
        qrm.load(path)
    error = raised.value
    line = next(line for line in path.read_text().splitlines() if "BD*cos" in line)
    assert path.read_text().splitlines()[error.line - 1] == line
    assert line[error.column - 1 :].startswith("BD")
    assert error.path == str(path)
    assert f"{path}:{error.line}:{error.column}" in str(error)
    assert error.hints and isinstance(error, ValueError)
    assert [finding.message for finding in error.findings] and error.findings[0].hint == error.hints[0]
    same = pickle.loads(pickle.dumps(error))
    assert (str(same), same.line, same.findings) == (str(error), error.line, error.findings)


def test_all_mistakes_of_a_scene_are_found(scene_file, tmp_path):
    text = scene_file("B.x + BC*cos(phi5)", "B.x + BD*cos(phi5)").read_text()
    path = tmp_path / "two.toml"
    path.write_text(text.replace("C.y - yC", "C.y - yD"))
    with pytest.raises(qrm.SceneError) as raised:
        qrm.load(path)
    lines = [finding.line for finding in raised.value.findings]
    assert len(lines) >= 2 and lines == sorted(lines)


def test_a_column_counts_characters(tmp_path):
    path = tmp_path / "umlaut.toml"
    path.write_text('name = "x"\n"ä" = "ö" = 1\n')
    with pytest.raises(qrm.SceneError) as raised:
        qrm.load(path)
    error = raised.value
    assert f"{path}:{error.line}:{error.column}" in str(error)


def test_a_mechanism_that_cannot_be_assembled_names_the_constraint(quick_return):
    with pytest.raises(qrm.SceneError, match="cannot be assembled") as raised:
        quick_return.run(BC=0.1)
    source = quick_return.source.splitlines()
    assert "guide" in source[raised.value.line - 1]


def test_a_missing_file_is_reported(tmp_path):
    with pytest.raises(qrm.SceneError, match="there is no such file") as raised:
        qrm.load(tmp_path / "none.toml")
    assert raised.value.line is None and raised.value.path.endswith("none.toml")


@pytest.mark.parametrize(
    ("options", "message", "hint"),
    [
        ({"O2B": 1}, "scene `quick-return` has no parameter `O2B`", "O2A"),
        ({"method": "dop835"}, "there is no method `dop835`", "dop853"),
        ({"projection": "mas"}, "there is no projection `mas`", "mass"),
        ({"tolerance": 1e-9}, "`tolerance` needs a method", '`method="dop853"`'),
        ({"step": -1}, "`step` must be above zero, but is -1", None),
        ({"end_time": 1, "until": "phi2 > 1"}, "`end_time` and `until` are both given", "keep one"),
        ({"O2A": float("nan")}, "`O2A` must be finite, but is nan", None),
        ({"start": {"phi4": 1}}, "`phi4` is not given at the start", "phi2"),
    ],
)
def test_a_wrong_option_is_named(quick_return, options, message, hint):
    with pytest.raises(qrm.OptionError) as raised:
        quick_return.run(**options)
    assert message in str(raised.value)
    assert isinstance(raised.value, ValueError)
    if hint:
        assert any(hint in own for own in raised.value.hints), raised.value.hints


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("use a smaller --tolerance", "use a smaller tolerance"),
        ("add `--method dop853`, or choose `--step` instead", 'add `method="dop853"`, or choose `step` instead'),
        ("`--set O2A` needs a number", "`O2A` needs a number"),
        ("`--shard 1/4`; a--b, --closure-tolerance", "`--shard 1/4`; a--b, closure_tolerance"),
        ("`cargo build --release`", "`cargo build --release`"),
    ],
)
def test_options_of_the_command_are_arguments_in_messages(text, expected):
    assert str(qrm.Error(text)) == expected


def test_an_unknown_scene_is_named():
    with pytest.raises(qrm.OptionError, match="there is no scene `quick-retrun`") as raised:
        qrm.load("quick-retrun")
    assert "quick-return" in raised.value.hints[0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"O2A": [0.2]}, "`O2A` must be a number or a text"),
        ({"O2A": True}, "`O2A` must be a number or a text"),
        ({"every": 2.5}, "`every` must be a whole number"),
        ({"start": 3}, "`start` must be a dict"),
        ({"set": {"O2A": 1}, "O2A": 1}, "`O2A` is given twice"),
    ],
)
def test_a_value_of_another_type_is_a_type_error(quick_return, options, message):
    with pytest.raises(TypeError, match=message):
        quick_return.run(**options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"every": 0}, "`every` must be from 1 to"),
        ({"every": -1}, "`every` must be from 1 to"),
        ({"closure_iterations": -1}, "`closure_iterations` must be from 0 to"),
        ({"closure_iterations": 2**63}, "`closure_iterations` must be from 0 to"),
        ({"O2A": 10**400}, "`O2A` is too large"),
    ],
)
def test_a_value_that_cannot_be_is_an_option_error(quick_return, options, message):
    with pytest.raises(qrm.OptionError, match=message):
        quick_return.run(**options)


@pytest.mark.parametrize("threads", [0, -1, 5000, 10**6, 2**63])
def test_a_number_of_threads_that_cannot_be_is_an_option_error(quick_return, threads):
    with pytest.raises(qrm.OptionError, match="`threads` must be from 1 to 4096, but is"):
        quick_return.sweep(O2A=[0.2, 0.25], threads=threads)


def test_a_device_that_is_not_there_is_an_option_error(quick_return):
    with pytest.raises(qrm.OptionError, match="there is no device `tpu`"):
        quick_return.sweep(O2A=[0.2, 0.25], device="tpu")
    try:
        table = quick_return.sweep(O2A=[0.2, 0.25], device="gpu")
    except qrm.OptionError as error:
        assert "there is no GPU with CUDA" in str(error)
    else:
        assert table.done.all()


def test_a_table_beyond_the_memory_is_refused(quick_return):
    few, many = (np.linspace(0.1, 0.2, count) for count in (10_000, 100_000))
    with pytest.raises(qrm.OptionError, match=r"1000000000 designs with .* need .* GB of memory") as raised:
        quick_return.sweep(O2A=few, BC=many)
    assert raised.value.hints == ["vary fewer values, or let `qrm sweep` write a file"]


def test_a_parameter_is_varied_once(quick_return):
    for call in (quick_return.sensitivity, lambda by: quick_return.objectives(by, "maximum N3")):
        with pytest.raises(qrm.OptionError, match='`by="O2A"` is given twice'):
            call(by=["O2A", "O2A"])


def test_a_path_that_is_not_utf_8_is_an_option_error():
    with pytest.raises(qrm.OptionError, match="is not UTF-8"):
        qrm.load(os.fsdecode(b"\xff.toml"))


def test_a_run_that_fails_keeps_its_rows(quick_return):
    with pytest.raises(qrm.RunError, match="did not become true by the latest end") as raised:
        quick_return.run(until="phi2 >= 100")
    result = raised.value.result
    assert result.summary["status"] == "stop_not_reached"
    assert result.t[-1] == result.end_time and len(result.t) > 100


def test_a_run_that_is_not_to_be_trusted_is_an_error():
    with pytest.raises(qrm.RunError, match="do not trust the numbers") as raised:
        qrm.load("double-pendulum").run(end_time=60, step=0.01)
    assert raised.value.result.summary["distrust"]
    assert raised.value.hints

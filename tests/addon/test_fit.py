# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `fit` as its user meets it, and the operator: in the background, whole or not at all."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from support import measured

from lamina.addon.cli.main import run
from lamina.reference_py.fit.readers.measurement import spread_pairs
from lamina.reference_py.material.stack import Stack

RUN = [sys.executable, "-c", "from lamina.addon.cli.main import main; main()"]


def lamina(*arguments, code=0, **options):
    result = subprocess.run([*RUN, *map(str, arguments)], capture_output=True, text=True, timeout=300, **options)
    assert result.returncode == code, result.stdout + result.stderr
    assert "Traceback" not in result.stderr
    return result.stdout, result.stderr


@pytest.fixture
def matte(tmp_path):
    """A table of a matte, reddish surface."""
    wi, wo = spread_pairs(150, np.random.default_rng(0))
    path = tmp_path / "matte.csv"
    path.write_text(measured.table_text(wi, wo, np.array([[0.2, 0.1, 0.05]]) * np.ones((150, 1))))
    return path


def test_a_fit_writes_a_stack_and_says_how_good_it_is(matte):
    out, err = lamina("fit", matte, "-o", "matte.json", "--layers", 0, "--base", "lambert", "--json", cwd=matte.parent)
    told = json.loads(out)
    assert told["error"] < 1e-3 and told["explains"] and told["not_determined"] == []
    stack = Stack.load(matte.parent / "matte.json")
    assert stack.to_dict() == told["stack"]
    assert stack.base["color"] == pytest.approx((0.2 * np.pi, 0.1 * np.pi, 0.05 * np.pi), rel=1e-3)
    assert "table of 150 rows" in err and "wrote matte.json" in err
    out, _ = lamina("fit", matte, "--layers", 0, "--base", "lambert")
    assert "red color of the base" in out and "error 0.0" in out


def test_samples_of_a_model_are_fitted_and_compared():
    out, err = lamina(
        "fit",
        "blue_wall_paint",
        "--sample",
        "lafortune",
        "--wavelength",
        550,
        "--model",
        "weidlich_wilkie",
        "--layers",
        0,
        "--base",
        "lambert",
        "--samples",
        60,
    )
    assert "the green channel stands for 550 nm" in err and "0 layers over lambert" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["cut.binary"], ["cut.binary", "truncated"]),
        (["matte.exr"], [".exr", ".bsdf"]),
        (["metal_foil"], ["is a stack", "--sample"]),
        (["metal_foil", "--sample", "gloss"], ["gloss", "adding"]),
        (["matte.csv", "--base", "gold"], ["gold", "conductor"]),
        (["matte.csv", "--layers", "many"], ["many", "0 to 8"]),
        (["matte.csv", "--model", "position_free"], ["position_free", "adding"]),
        (["matte.csv", "--wavelength", "1000"], ["1000", "780"]),
        (["matte.csv", "--report", "x.doc"], ["x.doc", ".png"]),
        (["matte.csv", "--report", "x.png", "--theta", "10", "nan"], ["10 nan", "0 to 85"]),
        (["matte.csv", "-o", "no/such/folder.json"], ["no/such"]),
        (["matte.csv", "-o", "matte.csv"], ["matte.csv", ".json"]),
        (["folder.json", "-o", "folder.json", "--sample", "adding"], ["folder.json", "what is read"]),
        (["matte.csv", "-o", "taken.json"], ["taken.json", "is a folder"]),
    ],
)
def test_bad_input_is_one_line_and_writes_nothing(matte, arguments, words, monkeypatch, capsys):
    (matte.parent / "cut.binary").write_bytes(measured.merl_bytes(measured.merl_values())[:5000])
    monkeypatch.chdir(matte.parent)
    (matte.parent / "folder.json").write_text("{}")
    (matte.parent / "taken.json").mkdir()
    assert run(["fit", "-o", "out.json", *arguments]) == 2
    err = capsys.readouterr().err
    assert err.splitlines()[-1].startswith("lamina: ") and all(word in err for word in words), err
    assert sorted(p.name for p in matte.parent.iterdir()) == ["cut.binary", "folder.json", "matte.csv", "taken.json"]


@pytest.mark.skipif(os.name != "posix", reason="sends a signal")
def test_ctrl_c_cancels_and_leaves_nothing(tmp_path):
    process = subprocess.Popen(
        [*RUN, "fit", "metal_foil", "--sample", "weidlich_wilkie", "-o", str(tmp_path / "x.json")],
        stderr=subprocess.PIPE,
        text=True,
        # a shell's background jobs, as which tests may run, are born deaf to it
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    for line in process.stderr:
        if "pairs of directions" in line:
            break
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130 and err.strip().splitlines()[-1] == "lamina: cancelled"
    assert list(tmp_path.iterdir()) == []


def test_the_report_is_a_picture(matte):
    pytest.importorskip("matplotlib")
    lamina("fit", matte, "--layers", 0, "--base", "lambert", "--report", "matte.png", "--theta", 10, cwd=matte.parent)
    assert (matte.parent / "matte.png").read_bytes()[:4] == b"\x89PNG"


# --- in Blender ---


@pytest.fixture
def item(blender):
    """The active object, without a material."""
    made = blender.data.objects.new("object", blender.data.meshes.new("mesh"))
    blender.context.collection.objects.link(made)
    blender.context.view_layer.objects.active = made
    return made


def run_out(fitting) -> None:
    limit = time.monotonic() + 120.0
    while fitting.tick() is not None:
        assert time.monotonic() < limit
        time.sleep(0.1)


@pytest.mark.blender
def test_the_operator_gives_the_object_the_fitted_stack(blender, item, matte):
    from lamina.addon.material import material

    assert blender.ops.lamina.fit_measurement(filepath=str(matte), layers=0, base="lambert") == {"FINISHED"}
    (made,) = item.data.materials
    assert made.name == "matte"
    assert material.stack_of(made).base["color"] == pytest.approx((0.2 * np.pi, 0.1 * np.pi, 0.05 * np.pi), rel=1e-3)
    with pytest.raises(RuntimeError, match="matte.exr"):
        blender.ops.lamina.fit_measurement(filepath=str(matte.with_suffix(".exr")))
    with pytest.raises(RuntimeError, match="a cloudy layer goes with .* at least one layer"):
        blender.ops.lamina.fit_measurement(filepath=str(matte), layers=0, base="lambert", cloudy=True)


@pytest.mark.blender
def test_a_fit_beside_the_window(blender, item, matte, tmp_path):
    from lamina.addon.jobs import fitting
    from lamina.addon.material import material

    owner = blender.data.materials.new("owner")
    item.data.materials.append(owner)
    fitting.start(owner, str(matte), 0, "lambert")
    assert fitting.tick() == fitting.TICK and not owner.lamina.is_layered
    assert not blender.ops.lamina.fit_measurement.poll()
    owner.name = "renamed meanwhile"
    run_out(fitting)
    assert material.stack_of(owner).base.kind == "lambert" and "error" in fitting.last_summary(owner)
    (text,) = (t for t in blender.data.texts if t.name in fitting.last_summary(owner))
    assert "table of 150 rows" in text.as_string() and "red color of the base" in text.as_string()

    fitting.start(owner, str(tmp_path / "gone.csv"), 0, "lambert")
    run_out(fitting)
    assert "gone.csv" in fitting.last_summary(owner) and material.stack_of(owner).base.kind == "lambert"

    other = blender.data.materials.new("other")
    fitting.start(other, str(matte), "auto", "auto")
    blender.ops.lamina.cancel_fit()
    assert fitting.running() is None and fitting.tick() is None and not other.lamina.is_layered

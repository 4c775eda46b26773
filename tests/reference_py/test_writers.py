# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of the truth: read back they are the truth, as well as they say; what a format cannot hold is refused in one line."""

import numpy as np
import pytest
from support.stacks import coat, conductor, lambert, stack

from lamina.addon.cli.main import run
from lamina.reference_py.errors import LaminaError
from lamina.reference_py.exchange.writers import error, merl, rgl
from lamina.reference_py.exchange.writers.truth import Truth
from lamina.reference_py.fit import read
from lamina.reference_py.fit.readers.rgl import Material
from lamina.reference_py.optics.frame import spherical

SATIN = stack(coat(0.3, tint=[0.9, 0.7, 0.5], thickness=0.5), base=lambert(0.5))
BRUSHED = stack(base={**conductor(0.2, 3.0, 0.2), "anisotropy": 0.7, "rotation": 0.125})
COARSE = rgl.Sampling(1, 9, (17, 96), 25)


@pytest.fixture
def coarse(monkeypatch):
    """Tables of seconds instead of minutes."""
    monkeypatch.setattr(merl, "SIZES", (16, 16, 32))
    monkeypatch.setattr(rgl, "ISOTROPIC", COARSE)
    monkeypatch.setattr(error, "PAIRS", 400)


def test_merl_gives_back_the_truth(tmp_path, coarse):
    path, truth = tmp_path / "satin.binary", Truth(SATIN, 2)
    merl.write(merl.table(truth), path)
    measured = read(path)
    rows = np.random.default_rng(0).choice(len(measured.f), 200, replace=False)
    wi, wo = measured.wi[rows], measured.wo[rows]
    # both halves of the azimuths are there, and reflect alike
    assert measured.f[rows] == pytest.approx(truth.f(wo, wi), rel=1e-6)
    assert merl.lookup(path, wi, wo) == pytest.approx(measured.f[rows], rel=1e-12)


def test_rgl_gives_back_the_truth_as_well_as_it_says(tmp_path, coarse):
    path, truth = tmp_path / "satin.bsdf", Truth(SATIN, 2)
    rgl.write(rgl.fields(truth, "satin"), path)
    material = Material.load(path)
    said = error.of_table(truth, material.f)
    rng = np.random.default_rng(5)
    cos = rng.uniform(0.1, 1.0, (2, 500))
    wi, wo = spherical(np.arccos(cos), 2.0 * np.pi * rng.random((2, 500)))
    f = truth.f(wo, wi)
    off = np.abs(material.f(wi, wo) - f)
    # directions even in their cosines, not in half angles as those of `said`
    assert np.sum(off * cos[0, :, None] * cos[1, :, None]) / np.sum(f * cos[0, :, None] * cos[1, :, None]) == pytest.approx(said.mean, rel=0.5)
    assert 1e-3 < said.median < 0.02 and said.mean < 0.03
    wrong = error.of_table(truth, lambda wi, wo: 1.1 * material.f(wi, wo))
    assert wrong.median == pytest.approx(0.1, abs=0.01)


def test_rgl_holds_anisotropic_walks(tmp_path, monkeypatch, coarse):
    monkeypatch.setattr(rgl, "ANISOTROPIC", rgl.Sampling(9, 5, (65, 48), 20))
    path, truth = tmp_path / "brushed.bsdf", Truth(BRUSHED, 16)
    assert truth.name == "position_free"
    rgl.write(rgl.fields(truth, "brushed"), path)
    material = Material.load(path)
    assert not material.is_isotropic
    # the grain runs at 45 degrees: highlights differ along it and across
    view, angles = spherical(np.full(2, 0.5), 0.0), np.radians([45.0, 135.0])
    wm = spherical(np.full(2, 0.25), angles)
    wo = 2.0 * np.sum(view * wm, axis=1)[:, None] * wm - view
    along, across = material.f(view, wo)[:, 0]
    exact = Truth(BRUSHED, 4000).f(wo, view)[:, 0]
    assert along / across == pytest.approx(exact[0] / exact[1], rel=0.3) and not 0.5 < exact[0] / exact[1] < 2.0


@pytest.mark.parametrize(
    ("refuse", "layers", "words"),
    [
        (merl.require_holdable, BRUSHED, "the base is anisotropic"),
        (merl.require_holdable, stack(coat(0.0), base=lambert(0.5)), "layer 0 is as smooth as a mirror"),
        (rgl.require_holdable, stack(coat(0.0, ior=1.0), coat(0.0), base=lambert(0.5)), "layer 1 is as smooth"),
        (rgl.require_holdable, stack(base=conductor(0.2, 3.0, 0.0)), "the base is as smooth"),
    ],
)
def test_what_a_table_cannot_hold_is_refused(refuse, layers, words):
    with pytest.raises(LaminaError, match=words) as told:
        refuse(layers)
    assert "\n" not in str(told.value)


def test_a_smooth_surface_under_a_rough_one_is_no_mirror():
    rgl.require_holdable(stack(coat(0.2), coat(0.0, ior=1.8), base=conductor(0.2, 3.0, 0.0)))


def test_the_command_states_the_error(tmp_path, coarse, capsys):
    file, out = tmp_path / "satin.json", tmp_path / "satin.bsdf"
    SATIN.save(file)
    assert run(["export", str(file), "--to", "rgl", "-o", str(out)]) == 0
    said = capsys.readouterr()
    assert "adding" in said.out and "read back at 400 random pairs" in said.out and "40 %" in said.err
    assert read(out).found[0].startswith("RGL material ")


def test_bad_arguments_are_refused_before_work(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("lamina.addon.cli.export.Truth", None)
    for arguments, words in (
        (["glazed_mug", "--to", "rgl", "-o", str(tmp_path / "x.bsdf")], "layer 0 is as smooth"),
        (["brushed_nickel", "--to", "merl", "-o", str(tmp_path / "x.binary")], "anisotropic"),
        (["satin_varnish", "--to", "merl", "-o", str(tmp_path / "x.bsdf")], ".binary"),
        (["satin_varnish", "--to", "merl", "-o", str(tmp_path / "no" / "x.binary")], "folder"),
    ):
        assert run(["export", *arguments]) == 2
        line = capsys.readouterr().err
        assert line.count("\n") == 1 and words in line
    assert list(tmp_path.iterdir()) == []


def test_cancelling_leaves_nothing(tmp_path, coarse, monkeypatch):
    def cancelled(fields):
        raise KeyboardInterrupt

    monkeypatch.setattr(rgl, "tensor_bytes", cancelled)
    SATIN.save(tmp_path / "satin.json")
    assert run(["export", str(tmp_path / "satin.json"), "--to", "rgl", "-o", str(tmp_path / "x.bsdf")]) == 130
    assert [path.name for path in tmp_path.iterdir()] == ["satin.json"]

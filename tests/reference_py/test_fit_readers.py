# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers give back the f that was written, in every format, and one clear line for every broken file."""

import warnings

import numpy as np
import pytest
from support import measured

from lamina.reference_py.errors import LaminaError
from lamina.reference_py.fit.readers import rgl
from lamina.reference_py.fit.readers.by_suffix import read
from lamina.reference_py.fit.readers.measurement import checked, directions_of, half_angles, spread_pairs, subsample, without_shadows


def refused(path, *words):
    with pytest.raises(LaminaError) as told:
        read(path)
    text = str(told.value)
    assert "\n" not in text and path.name in text
    for word in words:
        assert word in text, text


@pytest.fixture
def merl(tmp_path):
    path = tmp_path / "paint.binary"

    def write(data):
        path.write_bytes(data)
        return path

    return write


def test_half_and_difference_angles_are_inverse():
    rng = np.random.default_rng(1)
    wi, wo = spread_pairs(200, rng)
    again = half_angles(*directions_of(*half_angles(wi, wo)))
    assert np.array(again) == pytest.approx(np.array(half_angles(wi, wo)), abs=1e-7)


def test_merl_gives_back_f(merl):
    m = read(merl(measured.merl_bytes(measured.merl_values())))
    assert m.f == pytest.approx(measured.paint(m.wi, m.wo), rel=1e-12)
    assert any("20 x 20 x 40" in sentence for sentence in m.found)
    # a light towards which nothing is masked: cells of all kinds are there
    assert min(m.wi[:, 2].min(), m.wo[:, 2].min()) < 0.15


def test_broken_merl_files_are_named(merl):
    values = measured.merl_values()
    data = measured.merl_bytes(values)
    refused(merl(data[:-800]), "truncated", "48000")
    refused(merl(data[:5]), "no MERL file")
    refused(merl(measured.merl_bytes(values, ">")), "byte order")
    refused(merl(data[:12] + values.astype(">f8").tobytes()), "byte order")
    refused(merl(measured.merl_bytes(values.transpose(0, 3, 2, 1))), "axes are swapped", "theta_h, theta_d, phi_d")
    refused(merl(data[:12] + values.transpose(0, 2, 1, 3).tobytes()), "axes are swapped", "theta_d, theta_h, phi_d")
    refused(merl(data[:12] + values.transpose(0, 3, 1, 2).tobytes()), "axes are swapped", "phi_d, theta_h, theta_d")
    refused(merl(measured.merl_bytes(0.0 * values)), "black")
    with warnings.catch_warnings(action="error"):
        refused(merl(measured.merl_bytes(np.nan * values)), "not finite")
    refused(merl(b"\x07\0\0\0" * 3 + data[12:]), "sizes [7, 7, 7]")


def test_bad_values_are_left_out_and_counted(merl):
    values = measured.merl_values()
    above = np.flatnonzero(values[0].ravel() > 0.0)[:7]
    flat = values.reshape(3, -1)
    flat[:, above[:5]], flat[1, above[5:]] = -0.1, np.nan
    m = read(merl(measured.merl_bytes(values)))
    assert any(s.startswith("5 of") and "negative" in s for s in m.found) and any(s.startswith("2 of") and "not finite" in s for s in m.found)
    assert np.isfinite(m.f).all() and (m.f >= 0.0).all()


def test_a_color_outside_rec709_is_limited_and_what_is_left_out_is_told_by_angle():
    wi, wo = spread_pairs(3000, np.random.default_rng(5))
    f = measured.paint(wi, wo)
    f[:200, 2] = -0.1 * f[:200, 0]
    f[200:230] = -1.0
    m = checked(wi, wo, f, "x")
    assert len(m.f) == 2970 and np.all(m.f[:200, 2] == 0.0) and m.f[:200, 0] == pytest.approx(f[:200, 0])
    limited = next(s for s in m.found if "outside Rec.709" in s)
    assert limited.startswith("200 of 3000") and "30 to 60 degrees" in limited
    assert next(s for s in m.found if "negative" in s).startswith("30 of 3000")


def test_a_shadow_of_the_instrument_is_left_out_and_black_is_not():
    wi, wo = spread_pairs(3000, np.random.default_rng(6))
    f = 0.2 * np.ones((3000, 1))
    back = np.sum(wi * wo, axis=1) > np.cos(np.radians(8.0))  # the lamp before the detector
    f[back] = 0.0
    assert len(checked(wi, wo, f, "a model").f) == 3000
    m = without_shadows(checked(wi, wo, f, "x"))
    assert len(m.f) == 3000 - back.sum() and any(s.startswith(f"{back.sum()} values are exactly 0 among large") for s in m.found)
    lobe = np.maximum(np.sum(wi * wo * [-1.0, -1.0, 1.0], axis=1) - 0.97, 0.0)[:, None] ** 3 * 1e3
    kept = without_shadows(checked(wi, wo, lobe, "x"))
    assert np.mean(kept.f == 0.0) > 0.9 * np.mean(lobe == 0.0), "what is far from the highlight is black"


def test_steepest_is_what_is_asked_for(tmp_path):
    wi, wo = spread_pairs(300, np.random.default_rng(3))
    path = tmp_path / "paint.csv"
    path.write_text(measured.table_text(wi, wo, measured.paint(wi, wo)))
    m = read(path, steepest_deg=60.0)
    assert np.degrees(np.arccos(np.minimum(m.wi[:, 2], m.wo[:, 2]))).max() <= 60.0 and any("steeper than 60" in s for s in m.found)


@pytest.mark.parametrize("nm", [None, [400, 500, 600, 700]], ids=["rgb", "spectra"])
def test_rgl_gives_back_f(tmp_path, nm):
    path = tmp_path / "paint.bsdf"
    path.write_bytes(measured.tensor_bytes(measured.rgl_fields(wavelength_nm=nm)))
    m = read(path)
    assert "isotropic" in m.found[0] and "synthetic" in m.found[0]
    exact = measured.paint(m.wi, m.wo)
    exact = exact if nm is None else exact[:, :1] * np.ones(3)  # a flat spectrum is grey
    inner = (m.wi[:, 2] > 0.2) & (m.wo[:, 2] > 0.2)
    error = np.abs(m.f / exact - 1.0)[inner]
    # what remains is linear interpolation in 9 angles of incidence
    assert np.median(error) < 0.01 and np.quantile(error, 0.95) < 0.1
    if nm:
        assert read(path, 550.0).channels == 1
        with pytest.raises(LaminaError, match="400 to 700"):
            read(path, 900.0)


def test_rgl_is_symmetric_where_only_a_part_of_the_azimuths_was_measured(tmp_path):
    def brushed(wi, wo):
        wh = wi + wo
        return np.repeat((0.1 + np.square(wh[:, 0]) * 0.2)[:, None], 3, axis=1)

    path = tmp_path / "brushed.bsdf"
    path.write_bytes(measured.tensor_bytes(measured.rgl_fields(brushed, phis=np.linspace(-np.pi, -0.5 * np.pi, 7))))
    material = rgl.Material.load(path)
    wi, wo = spread_pairs(400, np.random.default_rng(2))
    inner = (wi[:, 2] > 0.3) & (wo[:, 2] > 0.3)
    wi, wo = wi[inner], wo[inner]
    assert not material.is_isotropic
    assert np.median(np.abs(material.f(wi, wo) / brushed(wi, wo) - 1.0)) < 0.02
    flip = np.array([-1.0, 1.0, 1.0])
    assert material.f(wi * flip, wo * flip) == pytest.approx(material.f(wi, wo), rel=1e-9)


def test_broken_rgl_files_are_named(tmp_path):
    path = tmp_path / "paint.bsdf"
    fields = measured.rgl_fields(thetas=4, cells=8)
    data = measured.tensor_bytes(fields)

    def write(content):
        path.write_bytes(content)
        return path

    refused(write(data[:-100]), "truncated")
    refused(write(data[:30]), "truncated")
    refused(write(b"tensor" + data), "tensor_file")
    refused(write(data[:14] + data[14:18][::-1] + data[18:]), "byte order")
    refused(write(measured.tensor_bytes({k: v for k, v in fields.items() if k != "vndf"})), "'vndf'", "rgb")
    refused(write(measured.tensor_bytes({**fields, "rgb": fields["rgb"].swapaxes(1, 2).copy()})), "axes do not match")
    refused(write(measured.tensor_bytes({**fields, "rgb": 0 * fields["rgb"]})), "black")
    refused(write(measured.tensor_bytes({**fields, "theta_i": fields["theta_i"] * 57.3})), "radians")
    # found by make fuzz: directions were looked for in it
    refused(write(measured.tensor_bytes({**fields, "vndf": fields["vndf"] - 0.5 * fields["vndf"].max()})), "vndf", "negative")
    refused(write(measured.tensor_bytes({k: v for k, v in fields.items() if k != "rgb"})), "spectra")


def test_tables_give_back_f(tmp_path):
    wi, wo = spread_pairs(60, np.random.default_rng(3))
    f = measured.paint(wi, wo)
    path = tmp_path / "paint.csv"
    path.write_text("# measured today\n" + measured.table_text(wi, wo, f))
    m = read(path)
    assert m.f == pytest.approx(f, rel=1e-6) and m.wi == pytest.approx(wi, abs=1e-6)
    path.write_text(measured.table_text(wi, wo, f[:, [0, 0]], ("500nm", "600")))
    assert read(path, 550.0).f[:, 0] == pytest.approx(f[:, 0], rel=1e-6)
    path.write_text(measured.table_text(wi, wo, f))
    assert read(path, 550.0).f[:, 0] == pytest.approx(f[:, 1], rel=1e-6)
    for delimiter, point in ((";", ","), ("\t", "."), ("\t", ",")):
        path.write_text(measured.table_text(wi, wo, f).replace(",", delimiter).replace(".", point))
        assert read(path).f == pytest.approx(f, rel=1e-6)


def test_tables_as_instruments_write_them(tmp_path):
    """Each is 10 degrees in, 10 and 20 out away from the light and 20 back, with f 1, .5 and .25: in another dress."""
    path = tmp_path / "paint.csv"

    def written(text, encoding="utf-8"):
        path.write_bytes(text.encode(encoding))
        return read(path)

    wanted = written("theta_i,phi_i,theta_o,phi_o,f\n10,0,10,180,1\n10,0,20,180,.5\n10,0,20,0,.25\n")
    ten, twenty, half = (f"{np.radians(angle):.9f}" for angle in (10, 20, 180))
    rows = "10,0,10,180,1\n10,0,20,180,.5\n10,0,20,0,.25\n"
    same = {
        f"theta_i [rad],phi_i (rad),theta_r [radians],phi_r [rad],brdf\n{ten},0,{ten},{half},1\n{ten},0,{twenty},{half},.5\n{ten},0,{twenty},0,.25\n": "in radians: theta_i",
        f"θi (°),φi (°),θr (°),φr (°),BRDF (sr-1)\n{rows}": "θi is theta_i",
        f"Theta Incident,Phi Incident,Theta Scatter,Phi Scatter,BRDF\n{rows}": "theta scatter is theta_o",
        f"theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f\n{rows}": "one value",
        f"Instrument: gonio, 3 axes\nDate: 2024-01-01\n\ntheta_i,phi_i,theta_o,phi_o,f\n{rows}": "one value",
        f"# gonio\n# theta_i,phi_i,theta_o,phi_o,f\n{rows}": "one value",
        "theta_i,phi_i,theta_o,phi_o,f,\n" + rows.replace("\n", ",\n"): "one value",
        "theta_i,phi_i,theta_o,phi_o,f,sigma\n" + rows.replace("\n", ",?\n"): "column sigma is left out",
        f"theta_i,phi_i,theta_o,phi_o,f\n{rows}10,0,30,0,\n": "1 of 4 values above the horizon are not finite and left out",
    }  # fmt: skip
    for text, told in same.items():
        for encoding in ("utf-8", "utf-16"):
            m = written(text, encoding)
            assert m.wo == pytest.approx(wanted.wo, abs=1e-8) and m.wi == pytest.approx(wanted.wi, abs=1e-8) and m.f == pytest.approx(wanted.f)
            assert told in "; ".join(map(str, m.found))
    assert written(f"theta_i (°),phi_i (°),theta_o (°),phi_o (°),f\n{rows}", "latin-1").f == pytest.approx(wanted.f)


def test_wavelengths_stand_in_columns_or_in_rows(tmp_path):
    path = tmp_path / "paint.csv"

    def written(text):
        path.write_text(text)
        return read(path)

    wanted = written("theta_i,theta_o,450,550,650\n10,10,1,2,3\n10,20,.1,.2,.4\n")
    assert wanted.channels == 3 and wanted.f[0, 0] > wanted.f[0, 2]
    for name in ("f_{}", "BRDF {} nm", "brdf_{}nm"):
        columns = ",".join(name.format(nm) for nm in (450, 550, 650))
        np.testing.assert_allclose(written(f"theta_i,theta_o,{columns}\n10,10,1,2,3\n10,20,.1,.2,.4\n").f, wanted.f)
    long = "theta_i,theta_o,wavelength [nm],brdf\n10,20,550,.2\n10,10,450,1\n10,10,650,3\n10,20,450,.1\n10,10,550,2\n10,20,650,.4\n"
    np.testing.assert_allclose(written(long).f, wanted.f)
    np.testing.assert_allclose(written(long).wo, wanted.wo)
    assert read(path, 550.0).f[:, 0] == pytest.approx([2.0, 0.2])
    path.write_text(long + "10,30,450,.1\n")
    refused(path, "not every pair of directions has each wavelength once")


def test_tables_as_others_name_them(tmp_path):
    path = tmp_path / "paint.txt"

    def written(text):
        path.write_text(text)
        return read(path)

    wanted = written("theta_i,phi_i,theta_o,phi_o,r,g,b\n10,0,10,180,1,1,2\n10,0,20,180,.5,.5,1\n10,0,20,0,.25,.5,1\n")
    same = (
        "theta_s,phi_s,theta_r,phi_r,R,G,B\n10,0,10,180,1,1,2\n10,0,20,180,.5,.5,1\n10,0,20,0,.25,.5,1\n",
        "theta_i phi_i  theta_v phi_v r g b\n10 0 10 180  1 1 2\n10 0 20 180 .5 .5 1\n10 0 20 0 .25 .5 1\n",
        "theta_i,phi_i,theta_o,phi_o,r,g,b\n10,0,-10,0,1,1,2\n10,0,-20,0,.5,.5,1\n10,0,20,0,.25,.5,1\n",
        "theta_in;theta_out;r;g;b\n10;10;1;1;2\n10;20;0,5;0,5;1\n10;-20;0,25;0,5;1\n",
        "Theta_i (deg),Phi_i [deg],theta_o (degrees),phi_o [°],R [1/sr],G (sr^-1),b\n10,0,10,180,1,1,2\n10,0,20,180,.5,.5,1\n10,0,20,0,.25,.5,1\n",
    )
    for text in same:
        m = written(text)
        assert m.wo == pytest.approx(wanted.wo, abs=1e-9) and m.wi == pytest.approx(wanted.wi, abs=1e-9) and m.f == pytest.approx(wanted.f)
    assert any("half a turn further" in s for s in written(same[2]).found) and any("theta_s is theta_i" in s for s in written(same[0]).found)
    for name in ("brdf", "bsdf", "f"):
        assert written(f"theta_i,phi_i,theta_o,phi_o,{name}\n10,0,10,180,1\n10,0,20,180,.5\n").channels == 1
    path.write_text("theta_r,theta_v,r,g,b\n10,10,1,1,2\n")
    refused(path, "it has theta_r, theta_v, r, g, b;")  # as the file has them
    path.write_text("theta_i [grad],theta_o [grad],r,g,b\n.1,.1,1,1,2\n")
    refused(path, "it has theta_i [grad]")
    refused_text = "theta_i,phi_i,theta_o,phi_o,{}\n10,0,10,180,1\n"
    for name, words in (("brf", "f times pi"), ("f_cos", "times the cosine")):
        path.write_text(refused_text.format(name))
        refused(path, words)


def zemax(f, incidence=(20, 50), azimuth=(0, 60, 120, 180), radial=(0, 5, 10, 20), head="Symmetry PlaneSymmetrical\n", blocks=("Monochrome",)):
    """Text of a table whose value is `f` of wi, wo, which are found anew: a turn about the y axis brings the mirror direction up."""

    def direction(i, a, r):
        i, a, r = np.radians((i, a, r))
        x, y, z = -np.sin(r) * np.cos(a), np.sin(r) * np.sin(a), np.cos(r)
        return np.array([np.cos(i) * x + np.sin(i) * z, y, -np.sin(i) * x + np.cos(i) * z])

    axes = (("SampleRotation", (0,)), ("AngleOfIncidence", incidence), ("ScatterAzimuth", azimuth), ("ScatterRadial", radial))
    text = f"# made for a test\nSource Measured\n{head}SpectralContent {'Monochrome' if len(blocks) == 1 else 'XYZ'}\nScatterType BRDF\n"
    text += "".join(f"{name}  {len(values)}\n{' '.join(map(str, values))}\n" for name, values in axes)
    for channel, block in enumerate(blocks):
        text += f"\n{block}\nDataBegin\n"
        for i in incidence:
            wi = np.array([-np.sin(np.radians(i)), 0.0, np.cos(np.radians(i))])
            rows = [" ".join(f"{f(wi, direction(i, a, r), channel):.9g}" for r in radial) for a in azimuth]
            text += "TIS 0.5\n" + "\n".join(rows) + "\n"
        text += "DataEnd\n"
    return text


def test_zemax_tables_share_a_suffix_and_give_back_f(tmp_path):
    path = tmp_path / "vinyl.bsdf"

    def shape(wi, wo, channel):
        return (0.1 + 0.3 * wo[2] + 0.05 * wo[1] ** 2 + 0.2 * wi[2]) * (1.0, 2.0, 3.0)[channel]

    path.write_text(zemax(shape))
    m = read(path)
    assert len(m.f) == 2 * 4 * 4 and m.channels == 1 and "Zemax or Radiant" in m.found[0]
    assert m.f[:, 0] == pytest.approx([shape(wi, wo, 0) for wi, wo in zip(m.wi, m.wo)], rel=1e-6)
    towards_normal = (m.wi[:, 2] < 0.7) & (m.wo[:, 2] > np.cos(np.radians(50.0)) + 0.1)
    assert towards_normal.any() and np.all(np.abs(m.wo[towards_normal][:, 1]) < 0.31), "azimuth 0 points to the normal"
    path.write_text(zemax(shape, blocks=("TristimulusX", "TristimulusY", "TristimulusZ")))
    assert read(path).channels == 3
    text = zemax(shape)
    for broken, words in (
        (text.replace("BRDF", "BTDF"), "only BRDF"), (text[: len(text) // 2], "announced; truncated"), (text.replace("ScatterRadial  4", "ScatterRadial  5"), "and 4 follow"),
        (text.replace("ScatterRadial", "Radius"), "missing ScatterRadial"), ("nothing", "neither a tensor file"),
    ):  # fmt: skip
        path.write_text(broken)
        refused(path, words)


def test_speos_tables_have_the_scale_of_their_reflectance(tmp_path):
    """A Lambert surface of 40 % has f = .4 / pi, whatever the numbers in its file."""
    path = tmp_path / "wall.brdf"
    theta, phi = np.linspace(0.0, 90.0, 91), np.linspace(0.0, 360.0, 37)
    rows = "".join(f"{t:g}\t" + "\t".join(["7.0"] * len(phi)) + "\n" for t in theta)
    table = f"40.0\n{len(theta)}\t{len(phi)}\n\t" + "\t".join(f"{p:g}" for p in phi) + "\n" + rows
    text = "OPTIS - brdf surface file v9.0\n0\nWall\n0\n\n1\t0\n1\n2\t1\n10\t40\n550\n" + table + table
    path.write_text(text)
    m = read(path)
    assert m.f == pytest.approx(0.4 / np.pi, rel=1e-3) and m.channels == 1
    for broken, words in ((text[:-4000], "truncated"), (text.replace("1\t0", "0\t1", 1), "transmission alone"), (text.replace("OPTIS", "OTHER"), "no BRDF file"),
                          (text.replace("7.0", "much", 1), "'much' is not a number")):  # fmt: skip
        path.write_text(broken)
        refused(path, words)


def test_astm_and_alta_tables_give_back_f(tmp_path):
    wi, wo = spread_pairs(40, np.random.default_rng(5))
    f = 0.1 + 0.3 * wo[:, 2] + 0.2 * wi[:, 2]
    angles = [a for w in (wi, wo) for a in (np.arccos(w[:, 2]), np.arctan2(w[:, 1], w[:, 0]))]
    rows = np.stack([*angles, f, 2.0 * f, 3.0 * f], axis=1)
    text = "SAMPLE_NAME made for a test\nNUM_POINTS 40\nVARS theta_i,phi_i,theta_s,phi_s,{}\n"
    text += "\n".join(",".join(f"{v:.9g}" for v in row) for row in rows) + "\n"
    path = tmp_path / "paint.astm"
    for names, channels in (("R,G,B", 3), ("450nm,550nm,650nm", 3), ("X,Y,Z", 3)):
        path.write_text(text.format(names))
        m = read(path)
        assert m.wi == pytest.approx(wi, abs=1e-7) and m.wo == pytest.approx(wo, abs=1e-7) and m.channels == channels
    path.write_text(text.format("R,G,B"))
    assert read(path).f == pytest.approx(rows[:, 4:])
    for broken, words in ((text.format("R,G,B").replace("VARS", "NAMES"), "no line VARS"), (text.format("R,G,B")[:-60], "named; truncated|announces 40 rows"),
                          (text.format("R,G"), "7 numbers where 6 are named"), (text.format("a,b,c").replace(",a,b,c", ",a,b").replace("0.", "x", 1), "named|not a number")):  # fmt: skip
        path.write_text(broken)
        with pytest.raises(LaminaError, match=words):
            read(path)
    path = tmp_path / "paint.dat"
    theta_h, theta_d, phi_d = half_angles(wi, wo)
    half = np.stack([theta_h, theta_d, phi_d, f], axis=1)
    written = "# made for a test\n#DIM 3 1\n#PARAM_IN RUSIN_TH_TD_PD\n#PARAM_OUT INV_STERADIAN\n#VS 0\n"
    path.write_text(written + "\n".join(" ".join(f"{v:.9g}" for v in row) for row in half))
    m = read(path)
    assert np.stack(half_angles(m.wi, m.wo), axis=1) == pytest.approx(half[:, :3], abs=1e-6) and m.f[:, 0] == pytest.approx(f)
    flat = np.stack([angles[2], angles[0], angles[3] - angles[1], f * wo[:, 2]], axis=1)
    other = "#DIM 3 1\n#PARAM_IN ISOTROPIC_TV_TL_DPHI\n#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n"
    table = "\n".join(" ".join(f"{v:.9g}" for v in row) for row in flat)
    path.write_text(other + table)
    m = read(path)
    assert m.f[:, 0] == pytest.approx(f) and np.sum(m.wi * m.wo, axis=1) == pytest.approx(np.sum(wi * wo, axis=1), abs=1e-7)
    for broken, words in ((table, "no line #DIM"), (other.replace("ISOTROPIC_TV_TL_DPHI", "CARTESIAN") + table, "PARAM_IN is CARTESIAN"),
                          (other, "no rows"), (other.replace("INV_STERADIAN_COSINE_FACTOR", "XYZ_COLOR") + table, "PARAM_OUT is XYZ_COLOR"),
                          (other + "#FORMAT binary\n" + table, "binary")):  # fmt: skip
        path.write_text(broken)
        refused(path, words)
    (tmp_path / "paint.axf").write_text("")
    refused(tmp_path / "paint.axf", "no public description")


def test_what_has_no_color_has_one_channel(tmp_path):
    wi, wo = spread_pairs(60, np.random.default_rng(3))
    f = measured.paint(wi, wo)[:, :1]
    path = tmp_path / "grey.csv"
    for values, names in ((f, ("550",)), (f * np.ones(3), ("r", "g", "b"))):
        path.write_text(measured.table_text(wi, wo, values, names))
        m = read(path)
        assert m.channels == 1 and m.f == pytest.approx(f, rel=1e-6) and any("grey" in sentence for sentence in m.found)
    path.write_text(measured.table_text(wi, wo, f * np.ones(2), ("900", "1000")))
    refused(path, "900 to 1000", "--wavelength")
    assert read(path, 950.0).f == pytest.approx(f, rel=1e-6)


def test_broken_tables_are_named(tmp_path):
    path = tmp_path / "paint.csv"
    head = "theta_i,phi_i,theta_o,phi_o,r,g,b\n"

    def write(text):
        path.write_text(text)
        return path

    refused(write("theta_i,phi_i,r,g,b\n1,2,3,4,5\n"), "theta_o, phi_o")
    refused(write("theta_i,phi_i,theta_o,phi_o,r,b\n1,2,3,4,5,6\n"), "missing column g")
    refused(write("theta_i,phi_i,theta_o,phi_o,r,g,haze\n1,2,3,4,5,6,7\n"), "'haze'")
    refused(write(head + "10,0,20,0,1,1,1\n10,0,20,360,1,1,1\n"), "lines 2 and 3", "same angles")
    refused(write(head + "10,0,20,0,1,1,1\n10,0,200,0,1,1,1\n"), "line 3", "theta_o is 200", "-90 to 180")
    refused(write(head + "10,0,20,0,1,1\n"), "line 2", "6 cells")
    refused(write(head + "10,0,20,0,1,1,much\n"), "line 2", "b is 'much'")
    refused(write("theta_i,phi_i,theta_o,phi_o,r,g,b,550\n1,2,3,4,5,6,7,8\n"), "both r, g, b and wavelengths")
    refused(write(head + "0.1,0,0.5,0,1,1,1\n0.3,0,1.2,0,1,1,1\n"), "radians")
    refused(write(head + "100,0,20,0,1,1,1\n"), "below the horizon")
    refused(write(head + "10,0,20,0,0,0,0\n"), "black")
    refused(write(head + "10,0,20,0,-1,1,1\n20,0,20,0,nan,1,1\n"), "negative or not finite")
    refused(write(head), "no rows")
    refused(write(""), "no rows")
    refused(tmp_path / "missing.csv", "No such file")
    refused(tmp_path / "paint.exr", "'.exr'", ".binary")


def test_subsamples_are_even_seeded_and_whole_when_there_are_few():
    wi, wo = spread_pairs(4000, np.random.default_rng(4))
    m = checked(wi, wo, measured.paint(wi, wo), "x")
    few = subsample(m, 300, np.random.default_rng(5))
    again = subsample(m, 300, np.random.default_rng(5))
    assert len(few.f) == 300 and np.array_equal(few.f, again.f)
    assert subsample(m, 5000, np.random.default_rng(5)) is m
    # data that crowd at one place do not outvote the rest
    crowded = checked(
        np.concatenate([wi, np.repeat(wi[:1], 9000, 0)]),
        np.concatenate([wo, np.repeat(wo[:1], 9000, 0)]),
        measured.paint(wi[:1], wo[:1]) * np.ones((13000, 3)),
        "x",
    )
    chosen = subsample(crowded, 300, np.random.default_rng(5))
    assert np.mean(np.all(chosen.wi == wi[0], axis=1)) < 0.1

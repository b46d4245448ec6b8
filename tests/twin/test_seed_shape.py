"""[seed] shape and kind: the twin's seed from a mesh file, or as published."""

import pytest
import seed_forms
import trimesh

from benchtwin.bench.keys import Air, Seed
from benchtwin.twin.job import Job
from benchtwin.twin.parameters import Parameters, bench
from benchtwin.vision.evidence.read_keys import read_toml
from benchtwin.vision.measurement import MeasurementError

SHAPE = seed_forms.flattened_ellipsoid(12e-3, 8e-3, 7e-3, 0.75)


def write(file, shape):
    trimesh.Trimesh(1e3 * shape.vertices_m, shape.faces).export(file)
    return file


def test_the_twin_has_the_mesh_s_mass_and_size_in_balls(tmp_path):
    file = write(tmp_path / "bean.stl", SHAPE)
    seed = Seed(shape=str(file), shape_unit="mm", density_kg_m3=1200.0)
    (one,) = bench(Parameters(spheres=6), "drop", seed, Air()).sizes.seeds
    assert len(one.radii_m) == 6
    assert one.mass_kg == pytest.approx(1200 * SHAPE.volume_m3, rel=1e-4)
    weighed = Seed(shape=str(file), shape_unit="mm", mass_g=0.9, count=3)
    (one,) = bench(Parameters(spheres=6), "drop", weighed, Air()).sizes.seeds
    assert one.mass_kg == pytest.approx(3e-4, rel=1e-9)


def test_a_job_knows_what_the_mesh_holds_not_where_it_lies(tmp_path):
    def key(file):
        return Job(
            "drop",
            Parameters(),
            {"seed": {"shape": str(file), "shape_unit": "mm"}},
            (1,),
        ).key

    one, same = write(tmp_path / "a.stl", SHAPE), write(tmp_path / "b.stl", SHAPE)
    other = write(tmp_path / "c.stl", SHAPE.scaled(1.1))
    assert key(one) == key(same) != key(other)


def test_bad_keys_are_named(tmp_path):
    write(tmp_path / "bean.stl", SHAPE)
    file = tmp_path / "bench.toml"
    file.write_text('[seed]\nshape = "bean.stl"\nshape_unit = "mm"\n')
    assert read_toml(file)["seed"]["shape"] == str(tmp_path / "bean.stl")
    file.write_text('[seed]\nshape = "pea.stl"\n')
    with pytest.raises(MeasurementError, match=r"there is no file .*pea\.stl"):
        read_toml(file)
    (tmp_path / "bench").mkdir()
    inner = tmp_path / "bench" / "bench.toml"
    for outside in ("../bean.stl", str(tmp_path / "bean.stl"), "/etc/hostname"):
        inner.write_text(f'[seed]\nshape = "{outside}"\n')
        with pytest.raises(MeasurementError, match="lies outside the bench's folder"):
            read_toml(inner)
    (tmp_path / "drop-01").mkdir()
    of_recording = tmp_path / "drop-01" / "recording.toml"
    of_recording.write_text('[seed]\nshape = "../bean.stl"\n')
    assert read_toml(of_recording)["seed"]["shape"] == str(tmp_path / "bean.stl")
    with pytest.raises(
        MeasurementError, match=r"in no unit; say which with \[seed\] shape_unit"
    ):
        bench(Parameters(), "drop", Seed(shape=str(tmp_path / "bean.stl")), Air())


def test_the_twin_is_made_of_the_kind():
    of = bench(Parameters(), "drop", Seed(kind="wheat"), Air())
    assert of.mean_dimensions_m == pytest.approx([7.08e-3, 3.27e-3, 2.98e-3])
    assert of.seed.density_kg_m3 == 1220
    assert (
        bench(Parameters(), "drop", Seed(), Air()).seed.density_kg_m3 != 1220
    )  # the control: without a kind another seed

"""A result as `benchtwin calibrate` leaves it, made up: the soybean paper's numbers."""

import copy
import json

import pytest

VALUES = {
    "restitution": 0.54,
    "static_friction": 0.34,
    "rolling_friction": 0.01,
    "seed_restitution": 0.65,
    "seed_static_friction": 0.55,
    "seed_rolling_friction": 0.04,
}
RESULT = {
    "parameters": {
        k: {
            "value": 1.02 * v,
            "low": 0.9 * v,
            "high": 1.1 * v,
            "unit": "1",
            "status": "calibrated",
            "remark": "",
            "most_probable_set": v,
        }
        for k, v in VALUES.items()
    },
    "conventions": {"rolling": "edem"},
    "materials": {
        "seed": {
            "name": "soybean",
            "density_kg_m3": 1250.0,
            "shear_modulus_pa": 1e7,
            "poisson_ratio": 0.4,
        },
        "wall": {
            "name": "Q235",
            "density_kg_m3": 7850.0,
            "shear_modulus_pa": 8.2e10,
            "poisson_ratio": 0.28,
        },
    },
    "seed_shape": {
        "length_mm": 8.0,
        "width_mm": 6.0,
        "thickness_mm": 6.0,
        "spheres": [[0.0, 0.0, 0.0, 3.0], [1.2, 0.0, 0.0, 2.8], [-1.2, 0.0, 0.0, 2.8]],
    },
}


@pytest.fixture
def result() -> dict:
    return copy.deepcopy(RESULT)


@pytest.fixture
def folder(tmp_path, result):
    (tmp_path / "result.json").write_text(json.dumps(result))
    return tmp_path

"""The path of steepest ascent and the centre: the paper's Tables 7 and 8, and what they
contradict."""

import numpy as np
import pytest

from benchtwin.calibrate.statistics.ascent import (
    choose_centre,
    equal_steps,
    relative_error,
)
from benchtwin.calibrate.statistics.box import Box

FACTORS = ("restitution", "static_friction", "rolling_friction")


def test_table_7_is_equal_steps_through_the_ranges(path):
    box = Box(FACTORS, [0.45, 0.20, 0.01], [0.70, 0.70, 0.06])
    np.testing.assert_allclose(
        equal_steps(box, 6)[list(FACTORS)], path[list(FACTORS)], atol=1e-12
    )


def test_equation_4_gives_the_printed_errors(path):
    printed = [22.58, 15.48, 9.35, 3.23, 2.90, 9.03]
    np.testing.assert_allclose(
        100 * relative_error(path["repose_angle_deg"], 31.0), printed, atol=0.005
    )


def test_the_nearest_group_is_the_centre(path):
    centre = choose_centre(path, "repose_angle_deg", 31.0, FACTORS)
    assert (
        centre.group == 5
        and list(centre.levels["group"]) == [4, 5, 6]
        and not centre.notes
    )
    assert centre.levels.set_index("coded").loc[0, "static_friction"] == pytest.approx(
        0.6
    )
    assert (
        "group 4 is as near"
        in choose_centre(path, "repose_angle_deg", 31.0, FACTORS, noise_sd=0.3).notes[0]
    )


def test_the_path_meets_the_bench_between_its_groups(path):
    met = choose_centre(path, "repose_angle_deg", 31.0, FACTORS).crossing
    assert met["static_friction"] == pytest.approx(
        np.interp(31.0, path["repose_angle_deg"], path["static_friction"]), abs=0.003
    )
    assert choose_centre(path, "repose_angle_deg", 36.0, FACTORS).crossing is None
    assert (
        choose_centre(
            path.assign(repose_angle_deg=31.0), "repose_angle_deg", 31.0, FACTORS
        ).crossing
        is None
    )


def test_noise_moves_the_crossing_less_than_one_group(path):
    rng, found = np.random.default_rng(1), []
    for _ in range(300):
        noisy = path.assign(
            repose_angle_deg=path["repose_angle_deg"] + rng.normal(0, 1.0, len(path))
        )
        met = choose_centre(noisy, "repose_angle_deg", 29.0, FACTORS).crossing
        found.append(
            np.interp(
                met["static_friction"],
                path["static_friction"],
                path["repose_angle_deg"],
            )
        )
    assert abs(np.mean(found) - 29.0) < 0.1 and np.std(found) < 0.5  # one group: 1.0


def test_an_end_of_the_path_asks_for_more_path(path):
    centre = choose_centre(path, "repose_angle_deg", 36.0, FACTORS)
    assert centre.group == 6 and list(centre.levels["group"]) == [4, 5, 6]
    assert "beyond its end" in centre.notes[0] and "does not bracket" in centre.notes[1]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda p: equal_steps(Box.of({"e": (0, 1)}), 2), "steps"),
        (lambda p: relative_error([1.0], 0.0), "bench"),
        (
            lambda p: choose_centre(p.head(2), "repose_angle_deg", 31.0, FACTORS),
            "at least 3 groups",
        ),
    ],
)
def test_bad_paths_are_refused(path, call, message):
    with pytest.raises(ValueError, match=message):
        call(path)

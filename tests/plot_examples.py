"""Made-up files of each kind that there is a picture for, as columns by their headers."""

import csv

import numpy as np

TURN = np.linspace(0.0, 4.5 * np.pi, 400)


def simulation():
    """Two laps and a quarter to the left, of radius 3 m, drifting by 0.4 m a lap in x and -0.1 m in y."""
    one, laps = np.ones(TURN.size), TURN / (2.0 * np.pi)
    return {
        "time_s": 2.0 * TURN,
        "x_m": 3.0 * np.sin(TURN) + 0.4 * laps,
        "y_m": 3.0 * (1.0 - np.cos(TURN)) - 0.1 * laps,
        "yaw_rad": (TURN + np.pi) % (2.0 * np.pi) - np.pi,
        "forward_velocity_mps": 1.5 * one,
        "lateral_velocity_mps": 0.1 * np.sin(TURN),
        "yaw_rate_radps": 0.5 * one,
        "track_speed_left_mps": 1.3 * one,
        "track_speed_right_mps": 1.8 * one,
        "slip_left": 0.02 * np.sin(TURN),
        "slip_right": 0.05 * np.cos(TURN),
        "load_left_n": 500.0 + 50.0 * np.sin(TURN),
        "load_right_n": 500.0 - 50.0 * np.sin(TURN),
    }


def plan():
    """Three segments that wind to the right."""
    way = np.linspace(0.0, 10.0, 101)
    return {
        "time_s": way / 0.8,
        "x_m": way,
        "y_m": np.sin(way / 3.0),
        "yaw_rad": np.cos(way / 3.0) / 3.0,
        "velocity_mps": np.full(way.size, 0.8),
        "curvature_1pm": -np.sin(way / 3.0) / 9.0,
        "slope_rad": np.full(way.size, 0.2),
        "heading_rad": np.cos(way / 3.0) / 3.0,
        "sprocket_rate_left_radps": 8.0 + np.sin(way / 3.0),
        "sprocket_rate_right_radps": 8.0 - np.sin(way / 3.0),
        "sideslip_rad": 0.02 * np.cos(way),
        "slip_left": 0.01 * np.cos(way),
        "slip_right": -0.01 * np.cos(way),
        "segment": (way // 4.0).astype(int),
    }


def forces():
    """A quarter circle, not feasible between a third and two thirds of it."""
    way = np.linspace(0.0, 7.5, 90)
    yaw = way / 5.0
    return {
        "arc_length_m": way,
        "time_s": way,
        "x_m": 5.0 * np.sin(yaw),
        "y_m": 5.0 * (1.0 - np.cos(yaw)),
        "yaw_rad": yaw + 0.1,
        "yaw_rate_radps": np.full(way.size, 0.2),
        "speed_mps": 1.0 + np.sin(yaw),
        "slip_angle_rad": -0.1 * np.sin(yaw),
        "yaw_gradient_1pm": 0.2 + 0.01 * np.cos(yaw),
        "icr_offset_m": 0.3 * np.sin(yaw),
        "force_total_n": 100.0 * np.cos(yaw),
        "force_difference_n": 900.0 + way,
        "force_left_n": 0.5 * (100.0 * np.cos(yaw) - 900.0 - way),
        "force_right_n": 0.5 * (100.0 * np.cos(yaw) + 900.0 + way),
        "friction_moment_nm": 1500.0 - way,
        "constraint_residual": 0.0 * way,
        "feasible": ((way < 2.5) | (way > 5.0)).astype(int),
    }


def identification():
    """Estimates that settle within seconds; the last poses know nothing of what comes after them."""
    time = np.linspace(0.0, 20.0, 200)
    settling = 1.0 - np.exp(-time / 2.0)
    later = np.where(time < 18.0, 1.0, np.nan)
    columns = {
        "time_s": time,
        "icr_left_m": 1.0 + settling,
        "icr_right_m": -1.0 - settling,
        "icr_x_m": 0.5 * settling,
    }
    columns |= {f"p{number}": 0.1 * number * settling for number in range(1, 10)}
    columns |= {f"p{number}_std": 0.01 * number + np.exp(-time) for number in range(1, 10)}
    return columns | {
        "innovation_x_m": 0.03 * np.cos(time),
        "innovation_y_m": 0.04 * np.cos(time),
        "innovation_yaw_rad": 0.01 * np.cos(time),
        "accepted": (np.arange(time.size) % 50 != 49).astype(int),
        "position_error_m": 0.05 * later,
        "yaw_error_rad": -0.01 * later,
        "no_slip_position_error_m": 0.7 * later,
        "no_slip_yaw_error_rad": 0.3 * later,
    }


def prediction():
    """A straight way that is predicted ever less surely."""
    time = np.linspace(0.0, 10.0, 51)
    return {
        "time_s": time,
        "horizon_s": np.full(time.size, 2.0),
        "x_m": time + 2.0,
        "y_m": 0.1 * time,
        "yaw_rad": 0.1 + 0.0 * time,
        "x_std_m": 0.1 + 0.01 * time,
        "y_std_m": 0.2 + 0.01 * time,
        "yaw_std_rad": 0.05 + 0.0 * time,
        "position_error_m": np.where(time < 8.0, 0.3, np.nan),
    }


def lookup():
    """A turn that gets tighter, until there is no answer in the last three of ten rows."""
    row = np.arange(10.0)
    answer = np.where(row < 7.0, 1.0, np.nan)
    return {
        "velocity_mps": 1.0 + 0.0 * row,
        "radius_m": 20.0 - row,
        "heading_rad": 0.1 * row,
        "sprocket_rate_left_radps": (9.0 - 0.1 * row) * answer,
        "sprocket_rate_right_radps": (11.0 + 0.1 * row) * answer,
        "track_speed_left_mps": (0.9 - 0.01 * row) * answer,
        "track_speed_right_mps": (1.1 + 0.01 * row) * answer,
        "sideslip_rad": 0.01 * row * answer,
        "slip_left": -0.01 * row * answer,
        "slip_right": 0.02 * row * answer,
    }


def by_name(columns):
    """Columns as the pictures take them: SI, without unit."""
    units = ("_s", "_m", "_rad", "_mps", "_radps", "_1pm", "_n", "_nm")
    names = (next((name.removesuffix(unit) for unit in units if name.endswith(unit)), name) for name in columns)
    return {name: np.asarray(values, float) for name, values in zip(names, columns.values(), strict=True)}


def write(path, columns):
    """Write columns as a CSV file, NaN as empty cells."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        for row in zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True):
            writer.writerow(["" if value != value else value for value in row])
    return path

"""Places of points in pictures of cameras with principal point, rotation and distortion, by OpenCV.

Command: python3 tests/oracle/camera.py  (writes tests/oracle/camera.csv, and camera.yml, which cv2.FileStorage writes of the
third camera)

Nothing is taken from the program: cv2.projectPoints and the rotation by angles about the fixed x, then y, then z axis.
The scenes stand in tests/camera.rs: no glass, 640 x 480 px, 10 um, the pinhole at (0, 0, 0).
"""

import pathlib

import cv2
import numpy as np

HERE = pathlib.Path(__file__).parent
WIDTH, HEIGHT, PITCH_MM = 640, 480, 0.01
BOARD_MM = 1000.0
# fx, fy, cx, cy in OpenCV's convention, k1 k2 p1 p2 k3, rotation in deg.
CAMERAS = {
    "barrel": (600.0, 600.0, 319.5, 239.5, [-0.28, 0.07, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
    "all": (550.0, 550.0, 331.25, 228.75, [-0.31, 0.12, 0.0011, -0.0023, -0.02], [2.0, -3.5, 1.25]),
    "file": (612.5, 611.875, 308.125, 251.75, [0.19, -0.21, -0.0007, 0.0019, 0.11], [0.0, 0.0, 0.0]),
    "pincushion": (480.0, 480.0, 300.0, 260.0, [0.6, 0.4, 0.01, -0.02, 0.1], [-1.0, 4.0, -90.0]),
}


def turned(angles_deg):
    rx, ry, rz = np.radians(angles_deg)
    x = np.array([[1, 0, 0], [0, np.cos(rx), -np.sin(rx)], [0, np.sin(rx), np.cos(rx)]])
    y = np.array([[np.cos(ry), 0, np.sin(ry)], [0, 1, 0], [-np.sin(ry), 0, np.cos(ry)]])
    z = np.array([[np.cos(rz), -np.sin(rz), 0], [np.sin(rz), np.cos(rz), 0], [0, 0, 1]])
    return z @ y @ x


def main():
    rng = np.random.default_rng(14)
    lines = [
        f"# made by: python3 tests/oracle/camera.py (cv2 {cv2.__version__}, numpy {np.__version__})",
        "# Points of the board at z = 1000 mm, in mm, and where cv2.projectPoints sees them, in px with the middle of the upper",
        "# left pixel at (0.5, 0.5): half a pixel more than OpenCV says.",
        "camera,u_mm,v_mm,x_px,y_px",
    ]
    for name, (fx, fy, cx, cy, distortion, angles) in CAMERAS.items():
        matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        world_from_camera = turned(angles)
        kept = 0
        while kept < 40:
            # A point that is seen on the sensor, on the branch of the distortion that joins on to the centre.
            tangents = (rng.uniform([0, 0], [WIDTH, HEIGHT]) - [cx + 0.5, cy + 0.5]) / [fx, fy]
            direction = world_from_camera @ np.append(tangents * rng.uniform(0.7, 1.1), 1.0)
            point = direction / direction[2] * BOARD_MM
            seen, _ = cv2.projectPoints(point.reshape(1, 1, 3), world_from_camera.T, np.zeros(3), matrix, np.array(distortion))
            x, y = seen.ravel() + 0.5
            if not (0 < x < WIDTH and 0 < y < HEIGHT):
                continue
            lines.append(f"{name},{point[0]!r},{point[1]!r},{x!r},{y!r}".replace("np.float64(", "").replace(")", ""))
            kept += 1
    (HERE / "camera.csv").write_text("\n".join(lines) + "\n")
    fx, fy, cx, cy, distortion, _ = CAMERAS["file"]
    storage = cv2.FileStorage(str(HERE / "camera.yml"), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", WIDTH)
    storage.write("image_height", HEIGHT)
    storage.write("camera_matrix", np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]))
    storage.write("distortion_coefficients", np.array([distortion]))
    storage.write("avg_reprojection_error", 0.21)
    storage.release()


if __name__ == "__main__":
    main()

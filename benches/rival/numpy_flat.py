"""The flat prism by Snell's law in vector form, in NumPy."""

import time

import numpy as np

from .common import ANGLE, BASE, BLACK, BOARD, FOCAL, HEIGHT, INDEX, PITCH, RIDGE, SQUARE, WHITE, WIDTH


def render(n):
    """CPU seconds and picture of n x n samples a pixel: the right facet and the base; the left half is the mirror image."""
    start = time.process_time()
    angle = np.radians(ANGLE)
    sin, cos = np.sin(angle), np.cos(angle)
    picture = np.zeros((HEIGHT, WIDTH // 2))
    for part in range(n * n):
        i = (np.arange(WIDTH // 2) + (part % n + 0.5) / n)[None, :] * (PITCH / FOCAL)
        j = (np.arange(HEIGHT) - HEIGHT / 2 + (part // n + 0.5) / n)[:, None] * (PITCH / FOCAL)
        norm = 1.0 / np.sqrt(i * i + j * j + 1.0)
        x, y, z = i * norm, j * norm, norm
        along = cos * z - sin * x
        t = RIDGE * cos / along
        px, py, pz = x * t, y * t, z * t
        bend = np.sqrt(1.0 - (1.0 - along * along) / INDEX**2) - along / INDEX
        x, y, z = x / INDEX - bend * sin, y / INDEX, z / INDEX + bend * cos
        t = (BASE - pz) / z
        px, py = px + x * t, py + y * t
        t = (BOARD - BASE) / np.sqrt(1.0 - INDEX**2 * (1.0 - z * z))
        column = np.floor((px + INDEX * x * t) / SQUARE + 0.5).astype(int)
        row = np.floor((py + INDEX * y * t) / SQUARE + 0.5).astype(int)
        picture += np.where((column + row) % 2 == 0, BLACK, WHITE)
    picture = np.hstack([picture[:, ::-1], picture]) / (n * n)
    return time.process_time() - start, picture

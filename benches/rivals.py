#!/usr/bin/env python3
"""The same picture by other renderers, with its cost and its error: python3 benches/rivals.py [BIPRISM]

The flat biprism of the design paper before a checkerboard, 1920 x 1080 px, refraction only. A rival that is not installed is
named and left out:

  biprism   the command BIPRISM, target/release/biprism if not given
  NumPy     Snell's law at three planes, n x n samples a pixel      pip install numpy (needed in any case)
  POV-Ray   planes in f64, one sample or adaptive ones              the program povray
  Mitsuba   path tracing through `dielectric`, stratified samples   pip install mitsuba

CPU seconds, user and system, of all threads: of whole commands for biprism and POV-Ray, of the render alone for NumPy and
Mitsuba (which compiles its kernels on a first picture, not counted). RMSE: against the picture of biprism's level `exact`,
of full scale 1, after a common factor of each rival is taken out, which is shown: Mitsuba's dielectric reflects a part of
the light. Shift: RMSE over the pixels that hold an edge, as a share of the contrast; an edge that moves by a share of a pixel
changes its pixels by that share, so this is about how far edges are off, in px.
"""

import importlib.util
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import zlib

WIDTH, HEIGHT, PITCH, FOCAL = 1920, 1080, 0.0055, 35.0
INDEX, RIDGE, BASE, ANGLE = 1.48, 78.472, 87.017, 8.85428
BOARD, SQUARE, COUNT, BLACK, WHITE = 1000.0, 10.0, 41, 0.05, 0.85

SCENE = f"""name = "rivals"
accuracy = "LEVEL"
[camera]
focal_length_mm = {FOCAL}
width_px = {WIDTH}
height_px = {HEIGHT}
pixel_pitch_um = {1e3 * PITCH}
[prism]
kind = "flat"
index = {INDEX}
ridge_distance_mm = {RIDGE}
thickness_mm = {BASE - RIDGE}
facet_angle_deg = {ANGLE}
[board]
columns = {COUNT}
rows = {COUNT}
square_mm = {SQUARE}
position_mm = [0.0, 0.0, {BOARD}]
black = {BLACK}
white = {WHITE}
[output]
encoding = "linear"
"""

POV = """#version 3.7;
global_settings {{ assumed_gamma 1.0 max_trace_level 8 }}
camera {{ perspective location <0,0,0> direction <0,0,1> right x*{aspect_x} up y*{aspect_y} }}
plane {{ <0,0,-1>, -{board}
  pigment {{ checker color rgb {white} color rgb {black} scale {square} translate {half} }}
  finish {{ ambient 0 diffuse 0 emission 1 }} }}
intersection {{
  plane {{ <{sin},0,-{cos}>, -{ridge_cos} }}
  plane {{ <-{sin},0,-{cos}>, -{ridge_cos} }}
  plane {{ <0,0,1>, {base} }}
  pigment {{ rgbt <1,1,1,1> }} finish {{ ambient 0 diffuse 0 }} interior {{ ior {index} }} }}
"""


def png(path):
    """A 16-bit PNG, without interlace, as an array of rows, columns and channels, of full scale 1."""
    import numpy as np

    data = open(path, "rb").read()
    at, packed, header = 8, [], None
    while at < len(data):
        size, kind = int.from_bytes(data[at : at + 4], "big"), data[at + 4 : at + 8]
        body = data[at + 8 : at + 8 + size]
        if kind == b"IHDR":
            header = body
        elif kind == b"IDAT":
            packed.append(body)
        at += 12 + size
    width, height = int.from_bytes(header[:4], "big"), int.from_bytes(header[4:8], "big")
    depth, colour = header[8], header[9]
    channels = {0: 1, 2: 3, 6: 4}[colour]
    if depth != 16 or header[12] != 0:
        raise ValueError(f"{path}: depth {depth}, interlace {header[12]}")
    step, length = 2 * channels, 2 * channels * width
    raw = np.frombuffer(zlib.decompress(b"".join(packed)), np.uint8).reshape(height, length + 1)
    out = np.zeros((height + 1, length), np.uint8)
    for j in range(height):
        form, line, above = raw[j, 0], raw[j, 1:], out[j]
        if form == 0:
            row = line
        elif form == 1:
            row = np.cumsum(line.reshape(-1, step), axis=0, dtype=np.uint8).reshape(-1)
        elif form == 2:
            row = line + above
        else:
            up, values, row = above.tolist(), line.tolist(), [0] * length
            for k, value in enumerate(values):
                a, b, c = (row[k - step], up[k], up[k - step]) if k >= step else (0, up[k], 0)
                if form == 3:
                    guess = (a + b) // 2
                else:
                    pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
                    guess = a if pa <= pb and pa <= pc else b if pb <= pc else c
                row[k] = (value + guess) & 255
        out[j + 1] = row
    pixels = out[1:].reshape(height, width, channels, 2).astype(np.uint16)
    return (pixels[..., 0] * 256 + pixels[..., 1]) / 65535.0


def cpu(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def command(arguments, **options):
    """Runs a command; its CPU seconds."""
    before = cpu(resource.RUSAGE_CHILDREN)
    done = subprocess.run(arguments, capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{arguments[0]} ended with {done.returncode}: {done.stderr[-400:]}")
    return cpu(resource.RUSAGE_CHILDREN) - before


def by_biprism(program, folder, level):
    scene, picture = os.path.join(folder, f"{level}.toml"), os.path.join(folder, f"{level}.png")
    with open(scene, "w") as file:
        file.write(SCENE.replace("LEVEL", level))
    return command([program, "render", scene, "--out", picture]), png(picture)[..., 0]


def by_numpy(n):
    """Snell's law in vector form at the right facet and at the base; the left half is the mirror image."""
    import numpy as np

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


def by_povray(folder, options):
    import numpy as np

    angle = np.radians(ANGLE)
    text = POV.format(
        aspect_x=WIDTH * PITCH / FOCAL, aspect_y=HEIGHT * PITCH / FOCAL, board=BOARD, white=WHITE, black=BLACK,
        square=SQUARE, half=SQUARE / 2, sin=np.sin(angle), cos=np.cos(angle), ridge_cos=RIDGE * np.cos(angle), base=BASE,
        index=INDEX,
    )
    scene, picture = os.path.join(folder, "rivals.pov"), os.path.join(folder, "rivals.png")
    with open(scene, "w") as file:
        file.write(text)
    form = [f"+W{WIDTH}", f"+H{HEIGHT}", "+FN16", "File_Gamma=1.0", "-D", "-J", f"+I{scene}", f"+O{picture}"]
    seconds = command(["povray", *form, *options], cwd=folder)
    return seconds, png(picture)[..., :3].mean(axis=2)


def by_mitsuba(variant, samples, folder):
    """In a process of its own, for a wrong LLVM ends it; raises RuntimeError then."""
    import numpy as np

    result = os.path.join(folder, "mitsuba.npy")
    command([sys.executable, __file__, "--mitsuba", variant, str(samples), result])
    seconds, picture = np.load(result, allow_pickle=True)
    return seconds, picture


def mitsuba(variant, samples):
    import mitsuba as mi
    import numpy as np

    mi.set_variant(variant)
    wide, tall = 40.0, 30.0
    back = RIDGE + wide * np.tan(np.radians(ANGLE))
    v = [(x, y, z) for y in (-tall, tall) for x, z in ((0, RIDGE), (wide, back), (wide, BASE), (-wide, BASE), (-wide, back))]
    lines = [f"v {x:.17g} {y:.17g} {z:.17g}" for x, y, z in v]
    quads = [(0, 1, 6, 5), (4, 0, 5, 9), (2, 3, 8, 7), (1, 2, 7, 6), (3, 4, 9, 8)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))] + [(0, 4, 3), (0, 3, 2), (0, 2, 1), (5, 8, 9), (5, 7, 8), (5, 6, 7)]
    middle = np.array([0.0, 0.0, 0.5 * (RIDGE + BASE)])
    points = np.array(v)
    for a, b, c in faces:
        # Outward, whatever the order above.
        normal = np.cross(points[b] - points[a], points[c] - points[a])
        if normal @ (points[a] - middle) < 0:
            b, c = c, b
        lines.append(f"f {a + 1} {b + 1} {c + 1}")
    with tempfile.NamedTemporaryFile("w", suffix=".obj", delete=False) as file:
        file.write("\n".join(lines) + "\n")
    place = mi.ScalarTransform4f
    checker = {
        "type": "checkerboard",
        "color0": {"type": "rgb", "value": [BLACK] * 3},
        "color1": {"type": "rgb", "value": [WHITE] * 3},
        "to_uv": place().scale([COUNT / 2, COUNT / 2, 1]),
    }
    half = 0.5 * COUNT * SQUARE
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6, "rr_depth": 100},
        "sensor": {
            "type": "perspective",
            "fov": float(np.degrees(2 * np.arctan(0.5 * WIDTH * PITCH / FOCAL))),
            "fov_axis": "x",
            "near_clip": 1.0,
            "to_world": place().look_at(origin=[0, 0, 0], target=[0, 0, 1], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"},
                     "pixel_format": "luminance", "component_format": "float32"},
            "sampler": {"type": "stratified", "sample_count": 16},
        },
        "prism": {"type": "obj", "filename": file.name, "face_normals": True,
                  "bsdf": {"type": "dielectric", "int_ior": INDEX, "ext_ior": 1.0}},
        "board": {"type": "rectangle", "to_world": place().translate([0, 0, BOARD]).rotate([0, 1, 0], 180).scale([half, half, 1]),
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0] * 3}},
                  "emitter": {"type": "area", "radiance": checker}},
    })
    os.unlink(file.name)
    np.array(mi.render(scene, spp=1))
    start = time.process_time()
    picture = np.array(mi.render(scene, spp=samples))[..., 0]
    return time.process_time() - start, picture


def main():
    if importlib.util.find_spec("numpy") is None:
        sys.exit("NumPy is not installed, and compares the pictures: pip install numpy")
    import numpy as np

    program = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(__file__), "../target/release/biprism")
    if shutil.which(program) is None:
        sys.exit(f"{program} is not there: cargo build --release, or name the command")
    program = os.path.abspath(shutil.which(program))
    with tempfile.TemporaryDirectory() as folder:
        reference = by_biprism(program, folder, "exact")[1]
        edges = ((reference > BLACK + 1e-3) & (reference < WHITE - 1e-3)).mean()
        print(f"{edges * 100:.2f} % of the pixels hold an edge")
        print(f"{'':34} {'CPU s':>9} {'RMSE':>9} {'shift px':>9} {'factor':>7}")

        def row(name, seconds, picture):
            factor = (reference * picture).sum() / (picture * picture).sum()
            rmse = np.sqrt(((factor * picture - reference) ** 2).mean())
            shift = rmse / np.sqrt(edges) / (WHITE - BLACK)
            print(f"{name:34} {seconds:9.3f} {rmse:9.2e} {shift:9.2e} {factor:7.4f}", flush=True)

        for level in ("draft", "standard", "exact"):
            row(f"biprism, {level}", *by_biprism(program, folder, level))
        for n in (1, 4, 8):
            row(f"NumPy, {n} x {n}", *by_numpy(n))
        if shutil.which("povray"):
            for name, options in (("one sample", ["-A"]), ("+AM1 +A0.01 +R4", ["+AM1", "+A0.01", "+R4"]), ("+AM1 +A0.01 +R9", ["+AM1", "+A0.01", "+R9"])):
                row(f"POV-Ray, {name}", *by_povray(folder, options))
        else:
            print("POV-Ray is not installed: povray is not on the PATH")
        if importlib.util.find_spec("mitsuba"):
            for variant, counts in (("llvm_ad_mono", (1, 16, 64)), ("scalar_rgb", (1, 16))):
                try:
                    for samples in counts:
                        row(f"Mitsuba {variant}, {samples} spp", *by_mitsuba(variant, samples, folder))
                    break
                except RuntimeError:
                    print(f"Mitsuba {variant} does not run here: it needs a newer LLVM (DRJIT_LIBLLVM_PATH)")
        else:
            print("Mitsuba is not installed: pip install mitsuba")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--mitsuba"]:
        import numpy

        made = mitsuba(sys.argv[2], int(sys.argv[3]))
        numpy.save(sys.argv[4], numpy.array(made, dtype=object), allow_pickle=True)
    else:
        main()

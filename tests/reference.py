#!/usr/bin/env python3
"""Compares `lightmend probe` with irradiance that an independent renderer computed, and prints a Markdown table.

  reference.py [REFERENCE] [--lightmend PROGRAM] [--out FOLDER] [--scenes NAME...] [--photons N...] [--cell M...] [--worst K]

REFERENCE (or the environment variable LIGHTMEND_REFERENCE) holds a folder per scene: scene_X.json (mesh, reflectances, lamps), its
OBJ, and ref_X.csv (points with direct and indirect irradiance and the standard error of the latter), one of each per state X.

Every scene goes through `lightmend import`, which drops triangles without area; its lamps are then written into the scene file.

Columns. All errors are of illuminance, 0.2126 R + 0.7152 G + 0.0722 B. Median and 95th percentile: of |error| / reference, over the
points whose reference exceeds 5 % of the mean. Signed: mean error / mean reference, over all points. Noise: what the combined
standard errors of both sides predict for the column before it; within 3: share of points whose error is below three of them.
"""

import argparse
import csv
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

# Longest edge of a mesh element, metres: fine enough for 20 M photons (docs/accuracy.md has the choice's influence).
CELLS = {"cornell": 0.06, "ajar": 0.25, "living": 0.25, "furnished": 0.15}
LUMINANCE = (0.2126, 0.7152, 0.0722)


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return [x / length for x in a]


def lamp_rotation(aim, up):
    """Degrees about the fixed x, y, z axes that turn our lamp to nadir = `aim` and the C = 0 half plane through `up`.

    The reference: γ = 0 along aim, C = 0 through up, C = 90 along up × aim. Ours, unturned in a scene whose up axis is y: nadir −y,
    C = 0 along x, C = 90 along −z. So x, −z, −y go to up, up × aim, aim.
    """
    aim = unit(aim)
    along = sum(u * a for u, a in zip(up, aim))
    up = unit([u - along * a for u, a in zip(up, aim)])
    columns = (up, [-a for a in aim], cross(aim, up))
    r = [[column[row] for column in columns] for row in range(3)]
    # R = Rz · Ry · Rx.
    sin_y = max(-1.0, min(1.0, -r[2][0]))
    y = math.asin(sin_y)
    if abs(sin_y) < 1.0 - 1e-9:
        x, z = math.atan2(r[2][1], r[2][2]), math.atan2(r[1][0], r[0][0])
    else:  # Only x ∓ z is determined: let x do nothing.
        x, z = 0.0, math.atan2(-r[0][1], r[1][1])
    return [round(math.degrees(angle), 9) + 0.0 for angle in (x, y, z)]


def ron_tuple(values):
    return "(" + ", ".join(repr(float(v)) for v in values) + ")"


def lamp_entry(number, light, folder):
    fields = [f'name: "lamp {number}"', f"position: {ron_tuple(light['position'])}", f"intensity: {ron_tuple(light['intensity'])}"]
    if "ies" in light:
        fields.append(f"rotation: {ron_tuple(lamp_rotation(light['aim'], light['up']))}")
        fields.append(f"photometry: {json.dumps(str((folder / light['ies']).resolve()), ensure_ascii=False)}")
    return "        (" + ", ".join(fields) + "),\n"


def write_scene(program, json_path, scene_path, cell):
    """Our scene file of a reference scene."""
    scene = json.loads(json_path.read_text(encoding="utf-8"))
    mesh = json_path.parent / scene["mesh"]
    used = set(re.findall(r"^usemtl\s+(.*\S)", mesh.read_text(encoding="utf-8"), re.MULTILINE))
    command = [program, "import", mesh, "--out", scene_path, "--up", scene["up"], "--cell", str(cell), "--quiet"]
    for name in sorted(used):
        command += ["--reflectance", f"{name}={','.join(map(repr, scene['materials'][name]))}"]
    subprocess.run(command, check=True)
    lamps = "".join(lamp_entry(n, light, json_path.parent) for n, light in enumerate(scene["lights"], 1))
    text = scene_path.read_text(encoding="utf-8")
    if text.count("lamps: []") != 1:
        sys.exit(f"{scene_path}: there is no single empty list of lamps to fill")
    scene_path.write_text(text.replace("lamps: []", f"lamps: [\n{lamps}    ]"), encoding="utf-8")


def read_points(path):
    """Per point: the point, direct and indirect illuminance, standard error of the latter (channels fully correlated)."""
    def luminance(row, what):
        return sum(w * float(row[f"{what}_{c}"]) for w, c in zip(LUMINANCE, "rgb"))

    with open(path, encoding="utf-8", newline="") as file:
        return [
            {
                "place": [float(row[k]) for k in ("x", "y", "z", "nx", "ny", "nz")],
                "direct": luminance(row, "direct"),
                "indirect": luminance(row, "indirect"),
                "noise": luminance(row, "indirect_se"),
            }
            for row in csv.DictReader(file)
        ]


def quantile(values, share):
    values = sorted(values)
    place = share * (len(values) - 1)
    low = int(place)
    high = min(low + 1, len(values) - 1)
    return values[low] + (place - low) * (values[high] - values[low])


def relative_errors(ours, reference, what):
    least = 0.05 * sum(r[what] for r in reference) / len(reference)
    return [abs(o[what] - r[what]) / r[what] for o, r in zip(ours, reference) if r[what] > least]


def row(ours, reference):
    cells = []
    for what in ("direct", "indirect"):
        mean = sum(r[what] for r in reference) / len(reference)
        errors = relative_errors(ours, reference, what)
        signed = sum(o[what] - r[what] for o, r in zip(ours, reference)) / len(reference) / mean
        cells += [f"{100 * quantile(errors, 0.5):.2f}", f"{100 * quantile(errors, 0.95):.2f}", f"{100 * signed:+.2f}"]
    combined = [math.hypot(o["noise"], r["noise"]) for o, r in zip(ours, reference)]
    squares = sum(c * c for c in combined)
    within = sum(abs(o["indirect"] - r["indirect"]) <= 3.0 * c for o, r, c in zip(ours, reference, combined))
    error = math.sqrt(sum((o["indirect"] - r["indirect"]) ** 2 for o, r in zip(ours, reference)) / len(reference))
    count = len(reference)
    cells.append(f"± {100 * math.sqrt(squares) / count / mean:.2f}")
    cells += [f"{100 * error / mean:.2f}", f"{100 * math.sqrt(squares / count) / mean:.2f}", f"{100 * within / count:.0f}"]
    return cells


def worst(ours, reference, count):
    """The points furthest off: of direct light by error, of indirect light in standard errors."""
    lines = []
    pairs = list(zip(ours, reference))
    for what, measure in (
        ("direct", lambda o, r: abs(o["direct"] - r["direct"])),
        ("indirect", lambda o, r: abs(o["indirect"] - r["indirect"]) / (math.hypot(o["noise"], r["noise"]) or 1.0)),
    ):
        for o, r in sorted(pairs, key=lambda p: -measure(*p))[:count]:
            place = " ".join(f"{v:.4f}" for v in r["place"])
            noise = f" ± {o['noise']:.4g} (reference ± {r['noise']:.4g})" if what == "indirect" else ""
            lines.append(f"    {what} at {place}: {o[what]:.5g}, reference {r[what]:.5g}{noise}")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", nargs="?", default=os.environ.get("LIGHTMEND_REFERENCE"))
    parser.add_argument("--lightmend", default="lightmend", metavar="PROGRAM")
    parser.add_argument("--out", help="where scenes and readings go; by default a temporary folder", metavar="FOLDER")
    parser.add_argument("--scenes", nargs="+", default=sorted(CELLS), choices=sorted(CELLS), metavar="NAME")
    parser.add_argument("--photons", nargs="+", type=int, default=[1_152_000], metavar="N")
    parser.add_argument("--cell", nargs="+", type=float, help="longest edge of a mesh element, metres; by default one per scene")
    parser.add_argument("--worst", type=int, default=0, metavar="K", help="also list the K points furthest off")
    arguments = parser.parse_args()
    if arguments.reference is None:
        sys.exit("no reference: give its folder, or set LIGHTMEND_REFERENCE")
    with tempfile.TemporaryDirectory() as temporary:
        try:
            compare(arguments, Path(arguments.reference), Path(arguments.out or temporary))
        except subprocess.CalledProcessError as error:  # It has said why.
            sys.exit(f"{arguments.lightmend} {error.cmd[1]} failed with status {error.returncode}")
        except OSError as error:
            sys.exit(str(error))


def compare(arguments, reference_folder, out):
    print("| scene | state | cell, m | photons | points | direct: median % | 95th % | signed % | indirect: median % | 95th % | signed % "
          "| its noise | RMS % of mean | its noise | within 3, % |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    for name in arguments.scenes:
        states = sorted((reference_folder / name).glob("scene_*.json"))
        if not states:
            sys.exit(f"{reference_folder / name}: there is no scene_*.json")
        for json_path in states:
            state = json_path.stem.removeprefix("scene_")
            reference = read_points(json_path.parent / f"ref_{state}.csv")
            for cell in arguments.cell or [CELLS[name]]:
                folder = out / name / state / str(cell)
                folder.mkdir(parents=True, exist_ok=True)
                write_scene(arguments.lightmend, json_path, folder / "scene.ron", cell)
                points = json_path.parent / "points.csv"
                for photons in arguments.photons:
                    readings = folder / f"{photons}.csv"
                    subprocess.run([arguments.lightmend, "probe", folder / "scene.ron", "--points", points, "--out", readings,
                                    "--photons", str(photons), "--quiet"], check=True)
                    ours = read_points(readings)
                    if len(ours) != len(reference):
                        sys.exit(f"{readings}: {len(ours)} points, the reference has {len(reference)}")
                    cells = [name, state, str(cell), f"{photons:,}", str(len(ours)), *row(ours, reference)]
                    print("| " + " | ".join(cells) + " |", flush=True)
                    if arguments.worst:
                        print(worst(ours, reference, arguments.worst), flush=True)


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Compares `lightmend probe`, or `lightmend reference`, with irradiance that an independent renderer computed, and prints a Markdown table.

  reference.py [REFERENCE] [--lightmend PROGRAM] [--out FOLDER] [--scenes NAME...] [--photons N...] [--cell M...] [--worst K]
  reference.py [REFERENCE] [--lightmend PROGRAM] [--out FOLDER] [--scenes NAME...] --paths [N...] [--seed N] [--worst K]

REFERENCE (or the environment variable LIGHTMEND_REFERENCE) holds a folder per scene: scene_X.json (mesh, reflectances, lamps), its
OBJ, and ref_X.csv (points with direct and indirect irradiance and the standard error of the latter), one of each per state X.

Every scene goes through `lightmend import`, which drops triangles without area; its lamps are then written into the scene file.

With --paths it is `lightmend reference` that is compared, and points off by three combined standard errors or more are listed.

Columns. All errors are of illuminance, 0.2126 R + 0.7152 G + 0.0722 B. Median and 95th percentile: of |error| / reference, over the
points whose reference exceeds 5 % of the mean. Signed: mean error / mean reference, over all points. Noise: what the combined
standard errors of both sides predict for the column before it; within 3: share of points whose error is at most three of them; RMS z: root
mean square of error / combined standard error, 1 when the standard errors are right and nothing else differs.
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
# Paths per point: enough for standard errors about half of the reference's; in the dark room of `ajar`, which that lit from the lamp, they
# stay above them.
PATHS = {"cornell": 1 << 18, "ajar": 1 << 20, "living": 1 << 18, "furnished": 1 << 17}
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


def z(our, reference):
    """Error of indirect illuminance in combined standard errors."""
    error, noise = our["indirect"] - reference["indirect"], math.hypot(our["noise"], reference["noise"])
    return error / noise if noise > 0.0 else (0.0 if error == 0.0 else math.copysign(math.inf, error))


def row(ours, reference):
    cells = []
    for what in ("direct", "indirect"):
        mean = sum(r[what] for r in reference) / len(reference)
        errors = relative_errors(ours, reference, what)
        signed = sum(o[what] - r[what] for o, r in zip(ours, reference)) / len(reference) / mean
        cells += [f"{100 * quantile(errors, 0.5):.2f}", f"{100 * quantile(errors, 0.95):.2f}", f"{100 * signed:+.2f}"]
    squares = sum(math.hypot(o["noise"], r["noise"]) ** 2 for o, r in zip(ours, reference))
    error = math.sqrt(sum((o["indirect"] - r["indirect"]) ** 2 for o, r in zip(ours, reference)) / len(reference))
    count = len(reference)
    cells.append(f"± {100 * math.sqrt(squares) / count / mean:.2f}")
    cells += [f"{100 * error / mean:.2f}", f"{100 * math.sqrt(squares / count) / mean:.2f}"]
    return cells + agreement([z(o, r) for o, r in zip(ours, reference)])


def agreement(deviations):
    """Share of points within three combined standard errors, and the root mean square of all."""
    within = sum(abs(d) <= 3.0 for d in deviations) / len(deviations)
    return [f"{100 * within:.1f}", f"{math.sqrt(sum(d * d for d in deviations) / len(deviations)):.2f}"]


def worst(ours, reference, count):
    """The points furthest off: of direct light by error, of indirect light in standard errors."""
    pairs = list(zip(ours, reference))
    direct = sorted(pairs, key=lambda p: -abs(p[0]["direct"] - p[1]["direct"]))[:count]
    indirect = sorted(pairs, key=lambda p: -abs(z(*p)))[:count]
    return [told("direct", *p) for p in direct] + [told("indirect", *p) for p in indirect]


def told(what, our, reference):
    place = " ".join(f"{v:.4f}" for v in reference["place"])
    noise = ""
    if what == "indirect":
        noise = f" ± {our['noise']:.4g} (reference ± {reference['noise']:.4g}): {z(our, reference):+.2f} standard errors"
    return f"    {what} at {place}: {our[what]:.5g}, reference {reference[what]:.5g}{noise}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", nargs="?", default=os.environ.get("LIGHTMEND_REFERENCE"))
    parser.add_argument("--lightmend", default="lightmend", metavar="PROGRAM")
    parser.add_argument("--out", help="where scenes and readings go; by default a temporary folder", metavar="FOLDER")
    parser.add_argument("--scenes", nargs="+", default=sorted(CELLS), choices=sorted(CELLS), metavar="NAME")
    parser.add_argument("--photons", nargs="+", type=int, default=[1_152_000], metavar="N")
    parser.add_argument("--cell", nargs="+", type=float, help="longest edge of a mesh element, metres; by default one per scene")
    parser.add_argument("--paths", nargs="*", type=int, metavar="N",
                        help="compare `lightmend reference`, with N paths per point; without a number as many as suit the scene")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of these paths")
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


def readings_of(arguments, name):
    """What to compare for a scene: cell, number of photons or paths, and the arguments that give it."""
    if arguments.paths is not None:
        for paths in arguments.paths or [PATHS[name]]:
            yield CELLS[name], paths, ["reference", "--paths", str(paths), "--seed", str(arguments.seed)]
    else:
        for cell in arguments.cell or [CELLS[name]]:
            for photons in arguments.photons:
                yield cell, photons, ["probe", "--photons", str(photons)]


def compare(arguments, reference_folder, out):
    print(f"| scene | state | cell, m | {'photons' if arguments.paths is None else 'paths per point'} | points | direct: median % | 95th % "
          "| signed % | indirect: median % | 95th % | signed % | its noise | RMS % of mean | its noise | within 3, % | RMS z |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    deviations = []
    for name in arguments.scenes:
        states = sorted((reference_folder / name).glob("scene_*.json"))
        if not states:
            sys.exit(f"{reference_folder / name}: there is no scene_*.json")
        for json_path in states:
            state = json_path.stem.removeprefix("scene_")
            reference = read_points(json_path.parent / f"ref_{state}.csv")
            for cell, count, (command, *options) in readings_of(arguments, name):
                folder = out / name / state / str(cell)
                folder.mkdir(parents=True, exist_ok=True)
                write_scene(arguments.lightmend, json_path, folder / "scene.ron", cell)
                readings = folder / f"{command}-{count}.csv"
                points = json_path.parent / "points.csv"
                subprocess.run([arguments.lightmend, command, folder / "scene.ron", "--points", points, "--out", readings,
                                *options, "--quiet"], check=True)
                ours = read_points(readings)
                if len(ours) != len(reference):
                    sys.exit(f"{readings}: {len(ours)} points, the reference has {len(reference)}")
                cells = [name, state, str(cell), f"{count:,}", str(len(ours)), *row(ours, reference)]
                print("| " + " | ".join(cells) + " |", flush=True)
                listed = worst(ours, reference, arguments.worst)
                if command == "reference":
                    listed += [told("indirect", o, r) for o, r in zip(ours, reference) if abs(z(o, r)) > 3.0]
                print("".join(line + "\n" for line in listed), end="", flush=True)
                deviations += [z(o, r) for o, r in zip(ours, reference)]
    within, rms = agreement(deviations)
    print(f"\nAll {len(deviations)} readings together: {within} % within three combined standard errors, RMS z {rms}.")


if __name__ == "__main__":
    main()

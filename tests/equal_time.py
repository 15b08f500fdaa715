#!/usr/bin/env python3
"""Error at equal time: `lightmend probe` and `lightmend reference` beside Mitsuba 3, as a Markdown table.

  equal_time.py [REFERENCE] [--lightmend PROGRAM] [--scenes NAME...] [--seconds S...] [--threads N] [--cell M...] [--loop FILE] [--methods METHOD...]

REFERENCE as in reference.py. Needs Mitsuba (`pip install mitsuba numpy`) and an LLVM that Dr.Jit takes.

Mitsuba's `path` integrator, as it comes, is given rays that leave the points in stratified cosine-distributed directions; the mean of what
it returns, times pi, is indirect irradiance, since a ray never meets a point lamp. It knows no photometric files, so scenes with such lamps
need --loop: a Python file with a class `Ref(scene, base=folder)` whose `batch(points, normals, strata, repeats, seed)` returns mean
indirect irradiance per point, as the program that made the reference has it.

Seconds are those of tracing: of Lightmend the run's wall time less that of a run without points and with next to no photons (process, scene, trees), of
Mitsuba the time in batches after one that compiles. What is left out is given as start-up. Each program gets as much work as fits into
the budget by its own rate in a trial run; the seconds are what it then took. Errors are of indirect illuminance as in reference.py.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import reference as points_of

# Photons for each ray that gathers at a point: a few hundred points then take most of the time, and noise is mostly the rays'.
PHOTONS_PER_RAY = 64
# A work of 1 is this much.
WORK = {
    "probe": lambda rays: ["--rays", str(rays), "--photons", str(max(4608, PHOTONS_PER_RAY * rays))],
    "reference": lambda paths: ["--paths", str(paths)],
}
LEAST = {"probe": 2048, "reference": 32}


def run(arguments, name, scene, points, out, amount):
    """Wall time of a run."""
    start = time.perf_counter()
    subprocess.run([arguments.lightmend, name, scene, "--points", points, "--out", out, *WORK[name](amount), "--threads",
                    str(arguments.threads), "--quiet"], check=True)
    return time.perf_counter() - start


def ours(arguments, command, scene, points, out):
    """For each budget: amount of work, seconds, start-up, illuminance per point."""
    least = LEAST[command]
    nowhere = out.with_name("nowhere.csv")
    nowhere.write_text("x,y,z,nx,ny,nz\n", encoding="utf-8")
    start_up = min(run(arguments, command, scene, nowhere, out, 1) for _ in range(3))
    amount, seconds = least, 0.0
    while seconds < 1.0:  # A trial long enough to tell the rate.
        amount *= 4
        seconds = run(arguments, command, scene, points, out, amount) - start_up
    rate = amount / seconds
    for budget in arguments.seconds:
        amount = max(least, round(rate * budget))
        seconds = run(arguments, command, scene, points, out, amount) - start_up
        yield amount, seconds, start_up, [p["indirect"] for p in points_of.read_points(out)]


class MitsubaPath:
    """Mitsuba's own path integrator."""

    def __init__(self, scene, base, folder):
        import drjit as dr
        import mitsuba as mi
        self.mi, self.dr = mi, dr
        vertices, faces, material = [], {}, None
        for line in (base / scene["mesh"]).read_text(encoding="utf-8").splitlines():
            if line.startswith("v "):
                vertices.append(line)
            elif line.startswith("usemtl"):
                material = line.split(None, 1)[1].strip()
            elif line.startswith("f "):
                corners = [int(c.split("/")[0]) for c in line.split()[1:]]
                corners = [c if c > 0 else len(vertices) + 1 + c for c in corners]
                for k in range(2, len(corners)):
                    faces.setdefault(material, []).append(f"f {corners[0]} {corners[k - 1]} {corners[k]}")
        world = {"type": "scene", "integrator": {"type": "path", "max_depth": -1}}
        for number, (material, listed) in enumerate(faces.items()):
            part = folder / f"part{number}.obj"
            part.write_text("\n".join(vertices + listed) + "\n", encoding="utf-8")
            colour = {"type": "rgb", "value": scene["materials"][material]}
            surface = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}
            world[f"part{number}"] = {"type": "obj", "filename": str(part), "face_normals": True, "bsdf": surface}
        for number, light in enumerate(scene["lights"]):
            intensity = {"type": "rgb", "value": light["intensity"]}
            world[f"lamp{number}"] = {"type": "point", "position": light["position"], "intensity": intensity}
        self.scene = mi.load_dict(world)
        self.integrator, self.sampler = self.scene.integrator(), mi.load_dict({"type": "independent"})

    def batch(self, points, normals, strata, repeats, seed):
        import numpy as np
        mi, dr = self.mi, self.dr
        count = strata * strata * repeats
        index = dr.arange(mi.UInt32, len(points) * count)
        self.sampler.seed(dr.opaque(mi.UInt32, seed), len(points) * count)
        point, stratum = index // count, index % (strata * strata)
        column = lambda values, k: dr.gather(mi.Float, mi.Float(values[:, k].astype("float32")), point)
        place, normal = (mi.Vector3f(*[column(v, k) for k in range(3)]) for v in (points, normals))
        jitter = self.sampler.next_2d()
        square = mi.Point2f((mi.Float(stratum % strata) + jitter.x) / strata, (mi.Float(stratum // strata) + jitter.y) / strata)
        direction = mi.Frame3f(normal).to_world(mi.warp.square_to_cosine_hemisphere(square))
        ray = mi.RayDifferential3f(mi.Point3f(place + normal * 1e-4), direction)
        light, _, _ = self.integrator.sample(self.scene, self.sampler, ray)
        sums = [dr.block_sum(light[k], count) for k in range(3)]
        dr.eval(*sums)
        return np.stack([np.array(s, np.float64) for s in sums], 1) / count * np.pi


def mitsuba(arguments, json_path, points_path, folder):
    """For each budget: paths per point, seconds, start-up, illuminance per point; nothing if the scene's lamps cannot be had."""
    import numpy as np
    scene, base = json.loads(json_path.read_text(encoding="utf-8")), json_path.parent
    start = time.perf_counter()
    import drjit as dr
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(arguments.threads)
    table = np.loadtxt(points_path, delimiter=",", skiprows=1, ndmin=2)
    points, normals = table[:, :3], table[:, 3:6]
    if arguments.loop:
        sys.path.insert(0, str(Path(arguments.loop).resolve().parent))
        tracer = __import__(Path(arguments.loop).stem).Ref(scene, base=str(base))
        traced = lambda *a: tracer.batch(*a)[0]
    elif any("ies" in light for light in scene["lights"]):
        return
    else:
        tracer = MitsubaPath(scene, base, folder)
        traced = tracer.batch
    strata, repeats = 16, 8  # 2048 paths a point, half a million a batch: Dr.Jit's kernels fill both threads.
    traced(points, normals, strata, repeats, 1)
    start_up = time.perf_counter() - start
    for budget in arguments.seconds:
        start, batches, total = time.perf_counter(), 0, 0.0
        while True:
            batches += 1
            total = total + traced(points, normals, strata, repeats, 1 + batches)
            seconds = time.perf_counter() - start
            if seconds * (batches + 0.5) / batches > budget:
                break
        yield batches * strata * strata * repeats, seconds, start_up, list(total / batches @ np.array(points_of.LUMINANCE))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("reference", nargs="?", default=os.environ.get("LIGHTMEND_REFERENCE"))
    parser.add_argument("--lightmend", default="lightmend", metavar="PROGRAM")
    parser.add_argument("--scenes", nargs="+", default=["cornell"], choices=sorted(points_of.CELLS), metavar="NAME")
    parser.add_argument("--seconds", nargs="+", type=float, default=[2.0, 10.0, 30.0], metavar="S")
    parser.add_argument("--threads", type=int, default=2, metavar="N")
    parser.add_argument("--cell", nargs="+", type=float, metavar="M", help="longest edge of a mesh element, metres; by default one per scene")
    parser.add_argument("--loop", metavar="FILE", help="a path tracer on Mitsuba's kernels, instead of its `path`")
    parser.add_argument("--methods", nargs="+", default=["probe", "reference", "mitsuba"], choices=["probe", "reference", "mitsuba"])
    arguments = parser.parse_args()
    if arguments.reference is None:
        sys.exit("no reference: give its folder, or set LIGHTMEND_REFERENCE")
    print("| scene | method | work | seconds | start-up, s | indirect: median % | 95th % | RMS % of mean |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        for name in arguments.scenes:
            compare(arguments, Path(arguments.reference) / name, name, Path(temporary))


def compare(arguments, source, name, folder):
    points, values = source / "points.csv", points_of.read_points(source / "ref_a.csv")
    mean = sum(v["indirect"] for v in values) / len(values)

    def tell(method, unit, results):
        for amount, seconds, start_up, found in results:
            errors = points_of.relative_errors([{"indirect": f} for f in found], values, "indirect")
            rms = (sum((f - v["indirect"]) ** 2 for f, v in zip(found, values)) / len(values)) ** 0.5 / mean
            shares = [f"{100 * share:.2f}" for share in (points_of.quantile(errors, 0.5), points_of.quantile(errors, 0.95), rms)]
            print(f"| {name} | {method} | {amount:,} {unit} | {seconds:.1f} | {start_up:.1f} | " + " | ".join(shares) + " |", flush=True)

    scene, out = folder / f"{name}.ron", folder / "read.csv"
    for cell in arguments.cell or [points_of.CELLS[name]]:
        points_of.write_scene(arguments.lightmend, source / "scene_a.json", scene, cell)
        if "probe" in arguments.methods:
            tell(f"`probe`, cells of {cell} m", f"rays a point, {PHOTONS_PER_RAY} times as many photons", ours(arguments, "probe", scene, points, out))
    if "reference" in arguments.methods:
        tell("`reference`", "paths a point", ours(arguments, "reference", scene, points, out))
    if "mitsuba" in arguments.methods:
        method = "Mitsuba's kernels, own loop" if arguments.loop else "Mitsuba's `path`"
        tell(method, "paths a point", mitsuba(arguments, source / "scene_a.json", points, folder))
    noise = (sum(v["noise"] ** 2 for v in values) / len(values)) ** 0.5 / mean
    print(f"| {name} | the values themselves, by their standard errors | | | | | | {100 * noise:.2f} |", flush=True)


if __name__ == "__main__":
    main()

// Depth prepass: the depth of what is seen first, and which triangle it is. Twin of `prepass.rs`.

struct Seen {
    @invariant @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, either) triangle: u32,
}

@vertex
fn place(@location(0) position: vec3f, @location(1) triangle: u32) -> Seen {
    return Seen(project(position - frame.eye, 1.0), triangle);
}

// 0 is left for where nothing is seen.
@fragment
fn identify(seen: Seen) -> @location(0) u32 {
    return seen.triangle + 1u;
}

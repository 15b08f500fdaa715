// What all shaders share: the camera, the lamps, and how points are projected. Twin of `frame.rs`.

struct Frame {
    eye: vec3f,
    near: f32,
    // Projection: axes of the picture divided by their squared lengths.
    across: vec3f,
    width: f32,
    upwards: vec3f,
    height: f32,
    forward: vec3f,
    lamps: u32,
    // Rays: half the picture's width and height at distance 1.
    right: vec3f,
    parts: u32,
    above: vec3f,
    unused: f32,
}

struct Lamp {
    // Metres.
    position: vec3f,
    // First sample of its cube map, or NONE.
    map: u32,
    // Candela per channel, or the factor of the cube map's.
    intensity: vec3f,
    intervals: u32,
    // From the world to the lamp's axes, row by row; beside them cos γ of the last and of the first measured angle.
    x: vec3f,
    last: f32,
    y: vec3f,
    first: f32,
    z: vec3f,
    unused: f32,
}

const NONE = 0xffffffffu;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> lamps: array<Lamp, 640>;

// Where entry k of a table is; `table.rs` is the twin.
fn entry(k: u32) -> vec2u {
    return vec2u(k & 2047u, k >> 11u);
}

// A point (w = 1) or direction (w = 0) relative to the eye, in clip space: depth is near / distance.
fn project(d: vec3f, w: f32) -> vec4f {
    return vec4f(dot(frame.across, d), dot(frame.upwards, d), frame.near * w, dot(frame.forward, d));
}

// One triangle that covers the picture.
fn whole_picture(vertex: u32) -> vec4f {
    return vec4f(f32(vertex & 1u) * 4.0 - 1.0, f32(vertex >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

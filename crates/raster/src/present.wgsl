// The picture in a window, and outlines of what is marked. Twin of `present.rs`.

// Whether outlines are drawn: without, triangle numbers are not looked at.
override MARKED: bool = false;
// Whether the target takes linear light, and makes sRGB of it by itself.
override LINEAR: bool = false;

struct Mark {
    // sRGB and opacity.
    colour: vec4f,
    // Triangle numbers of the object, one past the last, each with one added as in the prepass.
    first: u32,
    end: u32,
}

struct Present {
    // Corner of the viewport, pixels of the target.
    corner: vec2f,
    // One pixel of the target as a share of the viewport.
    step: vec2f,
    marks: array<Mark, 8>,
    count: u32,
}

@group(0) @binding(0) var<uniform> present: Present;
@group(0) @binding(1) var picture: texture_2d<f32>;
@group(0) @binding(2) var filtered: sampler;
@group(0) @binding(3) var ids: texture_2d<u32>;

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(f32(vertex & 1u) * 4.0 - 1.0, f32(vertex >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// The sample at a place, both from the upper left; past the edge the one on the edge.
fn sample(at: vec2f) -> vec2u {
    let size = vec2f(textureDimensions(ids));
    return vec2u(clamp(at * size, vec2f(0.0), size - 1.0));
}

// 1 where a number is the mark's.
fn within(mark: Mark, id: u32) -> u32 {
    return select(0u, 1u, id >= mark.first && id < mark.end);
}

// Where an edge of a marked object runs between the four pixels that touch this one's corners: a line two pixels wide.
fn outlined(colour: vec3f, at: vec2f) -> vec3f {
    let low = sample(at - present.step);
    let high = sample(at + present.step);
    let a = textureLoad(ids, low, 0).r;
    let b = textureLoad(ids, vec2u(high.x, low.y), 0).r;
    let c = textureLoad(ids, vec2u(low.x, high.y), 0).r;
    let d = textureLoad(ids, high, 0).r;
    var result = colour;
    for (var n = 0u; n < present.count; n++) {
        let mark = present.marks[n];
        let count = within(mark, a) + within(mark, b) + within(mark, c) + within(mark, d);
        result = mix(result, mark.colour.rgb, select(0.0, mark.colour.a, count > 0u && count < 4u));
    }
    return result;
}

fn to_linear(srgb: vec3f) -> vec3f {
    return select(pow((srgb + 0.055) / 1.055, vec3f(2.4)), srgb / 12.92, srgb <= vec3f(0.04045));
}

@fragment
fn show(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let at = (position.xy - present.corner) * present.step;
    var colour = textureSampleLevel(picture, filtered, at, 0.0).rgb;
    if MARKED {
        colour = outlined(colour, at);
    }
    if LINEAR {
        colour = to_linear(colour);
    }
    return vec4f(colour, 1.0);
}

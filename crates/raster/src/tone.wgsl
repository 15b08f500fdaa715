// Exposure, tone curve or false colours, and sRGB. Twin of `tone.rs`.

struct Tone {
    // Samples along each side of a pixel.
    grid: u32,
    // 0: tone curve; 1: false colours, linear; 2: false colours, logarithmic; 3: colours as they are.
    kind: u32,
    // Exposure, or 0 for an automatic one.
    exposure: f32,
    // The values of the first and the last false colour.
    low: f32,
    high: f32,
    // sRGB, 0 to 1.
    colours: array<vec4f, 9>,
}

@group(0) @binding(0) var<uniform> tone: Tone;
@group(0) @binding(1) var light: texture_2d<f32>;
// What the passes before have measured.
@group(0) @binding(2) var measured: texture_2d<f32>;

fn luminance(rgb: vec3f) -> f32 {
    return dot(rgb, vec3f(0.2126, 0.7152, 0.0722));
}

// Sides of the tiles in which the exposure is measured, samples; the same in `targets.rs`.
const TILE = 16u;

// Of one tile, the sum of the logarithms and how many samples are not black; every second sample of every second row is enough for a mean.
@fragment
fn measure_tile(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let size = textureDimensions(light);
    let low = vec2u(position.xy) * TILE;
    let high = min(low + TILE, size);
    var sum = vec2f(0.0);
    for (var y = low.y; y < high.y; y += 2u) {
        for (var x = low.x; x < high.x; x += 2u) {
            let l = luminance(textureLoad(light, vec2u(x, y), 0).rgb);
            sum += select(vec2f(0.0), vec2f(log2(max(l, 1e-30)), 1.0), l > 0.0);
        }
    }
    return vec4f(sum, 0.0, 0.0);
}

// The exposure: middle grey for the logarithmic mean of what is not black.
@fragment
fn measure_picture() -> @location(0) vec4f {
    let size = textureDimensions(measured);
    var sum = vec2f(0.0);
    for (var y = 0u; y < size.y; y++) {
        for (var x = 0u; x < size.x; x++) {
            sum += textureLoad(measured, vec2u(x, y), 0).xy;
        }
    }
    return vec4f(select(1.0, 0.22 / exp2(sum.x / max(sum.y, 1.0)), sum.y > 0.0), 0.0, 0.0, 0.0);
}

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(f32(vertex & 1u) * 4.0 - 1.0, f32(vertex >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn to_srgb(linear: vec3f) -> vec3f {
    let x = clamp(linear, vec3f(0.0), vec3f(1.0));
    return select(1.055 * pow(x, vec3f(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3f(0.0031308));
}

fn false_colour(value: f32) -> vec3f {
    var place = (value - tone.low) / (tone.high - tone.low);
    if tone.kind == 2u {
        place = log2(max(value, 1e-30) / tone.low) / log2(tone.high / tone.low);
    }
    let at = clamp(place, 0.0, 1.0) * 8.0;
    let k = min(u32(at), 7u);
    return mix(tone.colours[k].rgb, tone.colours[k + 1u].rgb, at - f32(k));
}

@fragment
fn develop(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let corner = vec2u(position.xy) * tone.grid;
    var sum = vec4f(0.0);
    for (var y = 0u; y < tone.grid; y++) {
        for (var x = 0u; x < tone.grid; x++) {
            sum += textureLoad(light, corner + vec2u(x, y), 0);
        }
    }
    let rgb = sum.rgb / f32(tone.grid * tone.grid);
    if tone.kind == 3u {
        return vec4f(to_srgb(rgb), 1.0);
    }
    if tone.kind != 0u {
        // Where nothing is seen there is nothing to measure.
        return vec4f(select(vec3f(0.0), false_colour(luminance(rgb)), sum.a > 0.0), 1.0);
    }
    let exposed = rgb * select(tone.exposure, textureLoad(measured, vec2u(0u), 0).x, tone.exposure == 0.0);
    // Reinhard et al. 2002, Eq. 4, on luminance.
    let l = luminance(exposed);
    let white = 4.0;
    let factor = (1.0 + l / (white * white)) / (1.0 + l);
    return vec4f(to_srgb(exposed * factor), 1.0);
}

// Exposure, tone curve or false colours, and sRGB. Twin of `tone.rs`.

struct Tone {
    // Pixels of the picture.
    width: u32,
    height: u32,
    // Samples along each side of a pixel.
    grid: u32,
    // 0: tone curve; 1: false colours, linear; 2: false colours, logarithmic; 3: colours as they are.
    kind: u32,
    // Exposure, or 0 for an automatic one.
    exposure: f32,
    // The values of the first and the last false colour.
    low: f32,
    high: f32,
    unused: f32,
    // sRGB, 0 to 1.
    colours: array<vec4f, 9>,
}

@group(0) @binding(0) var<uniform> tone: Tone;
@group(0) @binding(1) var light: texture_2d<f32>;
// Per tile, the sum of the logarithms and how many pixels are not black; at the end, the exposure.
@group(0) @binding(2) var<storage, read_write> tiles: array<vec2f>;
@group(1) @binding(0) var<storage, read> measured: array<vec2f>;

fn luminance(rgb: vec3f) -> f32 {
    return dot(rgb, vec3f(0.2126, 0.7152, 0.0722));
}

const TILE = 16u;
var<workgroup> sums: array<vec2f, 256>;

fn add_up(own: vec2f, place: u32) {
    sums[place] = own;
    workgroupBarrier();
    for (var half = 128u; half > 0u; half /= 2u) {
        if place < half {
            sums[place] += sums[place + half];
        }
        workgroupBarrier();
    }
}

// The logarithmic mean, in an order that is always the same.
@compute @workgroup_size(16, 16)
fn measure_tile(@builtin(global_invocation_id) pixel: vec3u, @builtin(local_invocation_index) place: u32, @builtin(workgroup_id) tile: vec3u, @builtin(num_workgroups) count: vec3u) {
    let size = textureDimensions(light);
    var own = vec2f(0.0);
    if pixel.x < size.x && pixel.y < size.y {
        let l = luminance(textureLoad(light, pixel.xy, 0).rgb);
        own = select(vec2f(0.0), vec2f(log2(max(l, 1e-30)), 1.0), l > 0.0);
    }
    add_up(own, place);
    if place == 0u {
        tiles[1u + tile.y * count.x + tile.x] = sums[0];
    }
}

// Middle grey for the logarithmic mean of what is not black.
@compute @workgroup_size(256)
fn measure_picture(@builtin(local_invocation_index) place: u32) {
    let size = textureDimensions(light);
    let count = ((size.x + TILE - 1u) / TILE) * ((size.y + TILE - 1u) / TILE);
    var own = vec2f(0.0);
    for (var tile = place; tile < count; tile += 256u) {
        own += tiles[1u + tile];
    }
    add_up(own, place);
    if place == 0u {
        let mean = exp2(sums[0].x / max(sums[0].y, 1.0));
        tiles[0] = vec2f(select(1.0, 0.22 / mean, sums[0].y > 0.0), 0.0);
    }
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
    let exposed = rgb * select(tone.exposure, measured[0].x, tone.exposure == 0.0);
    // Reinhard et al. 2002, Eq. 4, on luminance.
    let l = luminance(exposed);
    let white = 4.0;
    let factor = (1.0 + l / (white * white)) / (1.0 + l);
    return vec4f(to_srgb(exposed * factor), 1.0);
}

// Composition: out = indirect + Σ lamp · mask (Dmitriev et al. 2002, Eq. 7), in linear light. Twin of `composition.rs`.
//
// Every pixel knows its triangle; the point seen is where the pixel's ray meets it, so that nothing depends on how triangles were
// rasterised, and each pixel is shaded once.

// What the scene has: a pipeline without them is another, shorter program.
override TEXTURED: bool = false;
override GONIOMETRIC: bool = false;

// Which parts are added; the same bits as `Parts` in `composition.rs`.
const INDIRECT = 1u;
const DIRECT = 2u;
const REFLECTED = 4u;
const ELEMENTS = 8u;

const INVERSE_PI = 0.31830988618;

struct Triangle {
    // World-space corners, metres.
    a: vec3f,
    material: u32,
    b: vec3f,
    // n: the triangle is cut into n² mesh elements.
    divisions: u32,
    c: vec3f,
    // First irradiance of its lattice points, for the front and the back; NONE where no light ever came.
    front: u32,
    // Unit, of the front.
    normal: vec3f,
    back: u32,
}

struct Material {
    // Linear Rec. 709.
    reflectance: vec3f,
    texture: u32,
}

struct Texture {
    // First texel of level 0; the other levels follow, each half as large.
    first: u32,
    width: u32,
    height: u32,
    levels: u32,
}

@group(1) @binding(0) var ids: texture_2d<u32>;
@group(1) @binding(1) var masks: texture_2d_array<f32>;
@group(1) @binding(2) var<storage, read> triangles: array<Triangle>;
// Lux; three numbers a lattice point.
@group(1) @binding(3) var<storage, read> irradiance: array<f32>;
@group(1) @binding(4) var<storage, read> materials: array<Material>;
@group(1) @binding(5) var<storage, read> cube_maps: array<f32>;
@group(1) @binding(6) var<storage, read> uvs: array<vec2f>;
@group(1) @binding(7) var<storage, read> textures: array<Texture>;
@group(1) @binding(8) var<storage, read> texels: array<u32>;

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return whole_picture(vertex);
}

fn ray_through(at: vec2f) -> vec3f {
    let x = 2.0 * at.x / frame.width - 1.0;
    let y = 1.0 - 2.0 * at.y / frame.height;
    return frame.forward + frame.right * x + frame.above * y;
}

// Barycentric weights of the second and third corner where a ray from the eye meets the triangle's plane.
fn weights(triangle: Triangle, ray: vec3f) -> vec2f {
    let u = triangle.b - triangle.a;
    let v = triangle.c - triangle.a;
    let p = cross(ray, v);
    let determinant = dot(u, p);
    let s = frame.eye - triangle.a;
    let at = vec2f(dot(s, p), dot(ray, cross(s, u))) / determinant;
    // Edge-on there is no plane to meet: any point of the triangle is as good.
    return select(vec2f(1.0 / 3.0), at, determinant != 0.0);
}

// The weights of the nearest point inside.
fn inside(at: vec2f) -> vec2f {
    let positive = max(at, vec2f(0.0));
    return positive / max(1.0, positive.x + positive.y);
}

// Light that arrives from surfaces: linear between the three lattice points about the place.
fn indirect(triangle: Triangle, first: u32, at: vec2f) -> vec3f {
    let n = triangle.divisions;
    let scaled = at * f32(n);
    let i = min(u32(scaled.x), n - 1u);
    let j = min(u32(scaled.y), n - 1u - i);
    let f = scaled - vec2f(f32(i), f32(j));
    // Row i holds n − i + 1 points.
    let row = i * (n + 1u) - i * (i - min(i, 1u)) / 2u;
    let here = first + row + j;
    let next_row = here + n + 1u - i;
    let inverted = f.x + f.y > 1.0 && i + j < n - 1u;
    let corner = select(here, next_row + 1u, inverted);
    let w = select(vec3f(1.0 - f.x - f.y, f.x, f.y), vec3f(f.x + f.y - 1.0, 1.0 - f.y, 1.0 - f.x), inverted);
    return point_irradiance(corner) * w.x + point_irradiance(next_row) * w.y + point_irradiance(here + 1u) * w.z;
}

fn point_irradiance(point: u32) -> vec3f {
    return vec3f(irradiance[3u * point], irradiance[3u * point + 1u], irradiance[3u * point + 2u]);
}

// The factor of a lamp's intensity towards a direction: its cube map's candela. `goniometric.rs` is the twin.
fn candela(lamp: Lamp, away: vec3f) -> f32 {
    let d = vec3f(dot(lamp.x, away), dot(lamp.y, away), dot(lamp.z, away));
    let size = abs(d);
    var axis = 2u;
    var along = d.z;
    var across = d.xy;
    if size.x >= size.y && size.x >= size.z {
        axis = 0u;
        along = d.x;
        across = d.yz;
    } else if size.y >= size.z {
        axis = 1u;
        along = d.y;
        across = d.zx;
    }
    let n = f32(lamp.intervals);
    let at = clamp((across / abs(along) + 1.0) * 0.5, vec2f(0.0), vec2f(1.0)) * n;
    let low = min(floor(at), vec2f(n - 1.0));
    let f = at - low;
    let side = lamp.intervals + 1u;
    let face = 2u * axis + select(0u, 1u, along < 0.0);
    let k = lamp.map + (face * side + u32(low.y)) * side + u32(low.x);
    let value = mix(mix(cube_maps[k], cube_maps[k + 1u], f.x), mix(cube_maps[k + side], cube_maps[k + side + 1u], f.x), f.y);
    let cosine = -d.z * inverseSqrt(dot(d, d));
    return select(0.0, value, cosine >= lamp.last && cosine <= lamp.first);
}

// A texel in linear light: square roots in 11, 11 and 10 bits. `textures.rs` is the twin.
fn texel(first: u32, width: u32, height: u32, x: i32, y: i32) -> vec3f {
    let column = u32((x % i32(width) + i32(width)) % i32(width));
    let row = u32((y % i32(height) + i32(height)) % i32(height));
    let packed = texels[first + row * width + column];
    let root = vec3f(f32(packed & 2047u) / 2047.0, f32(packed >> 11u & 2047u) / 2047.0, f32(packed >> 22u) / 1023.0);
    return root * root;
}

fn bilinear(texture: Texture, level: u32, uv: vec2f) -> vec3f {
    var first = texture.first;
    var width = texture.width;
    var height = texture.height;
    for (var l = 0u; l < level; l++) {
        first += width * height;
        width = max(width / 2u, 1u);
        height = max(height / 2u, 1u);
    }
    let at = fract(vec2f(uv.x, 1.0 - uv.y)) * vec2f(f32(width), f32(height)) - 0.5;
    let low = floor(at);
    let f = at - low;
    let x = i32(low.x);
    let y = i32(low.y);
    return mix(
        mix(texel(first, width, height, x, y), texel(first, width, height, x + 1, y), f.x),
        mix(texel(first, width, height, x, y + 1), texel(first, width, height, x + 1, y + 1), f.x),
        f.y);
}

fn trilinear(texture: Texture, level: f32, uv: vec2f) -> vec3f {
    let clamped = clamp(level, 0.0, f32(texture.levels - 1u));
    let fine = u32(clamped);
    let coarse = min(fine + 1u, texture.levels - 1u);
    return mix(bilinear(texture, fine, uv), bilinear(texture, coarse, uv), clamped - f32(fine));
}

fn uv_at(triangle: u32, at: vec2f) -> vec2f {
    return uvs[3u * triangle] * (1.0 - at.x - at.y) + uvs[3u * triangle + 1u] * at.x + uvs[3u * triangle + 2u] * at.y;
}

// The texture's mean over the pixel: up to 8 samples along the longer side of its footprint (McCormack et al. 1999, simplified).
fn textured(id: u32, triangle: Triangle, texture: Texture, pixel: vec2f, at: vec2f) -> vec3f {
    let uv = uv_at(id, at);
    let size = vec2f(f32(texture.width), f32(texture.height));
    let to_right = uv_at(id, weights(triangle, ray_through(pixel + vec2f(0.5, 0.0)))) - uv_at(id, weights(triangle, ray_through(pixel - vec2f(0.5, 0.0))));
    let downwards = uv_at(id, weights(triangle, ray_through(pixel + vec2f(0.0, 0.5)))) - uv_at(id, weights(triangle, ray_through(pixel - vec2f(0.0, 0.5))));
    let lengths = vec2f(length(to_right * size), length(downwards * size));
    let longer = select(downwards, to_right, lengths.x > lengths.y);
    let most = max(lengths.x, lengths.y);
    // A footprint as wide as long, but for rounding, is one sample.
    let samples = clamp(ceil(most / max(min(lengths.x, lengths.y), 1.0) - 0.01), 1.0, 8.0);
    let level = log2(max(most / samples, 1.0));
    var sum = vec3f(0.0);
    for (var k = 0.0; k < samples; k += 1.0) {
        sum += trilinear(texture, level, uv + longer * ((k + 0.5) / samples - 0.5));
    }
    return sum / samples;
}

// A colour for each mesh element.
fn element_colour(id: u32, n: u32, at: vec2f) -> vec3f {
    let scaled = at * f32(n);
    let i = min(u32(scaled.x), n - 1u);
    let j = min(u32(scaled.y), n - 1u - i);
    let upper = select(0u, 1u, fract(scaled.x) + fract(scaled.y) > 1.0 && i + j < n - 1u);
    var h = (id * 2654435761u) ^ (i * 2246822519u) ^ (j * 3266489917u) ^ (upper * 668265263u);
    h = (h ^ (h >> 15u)) * 2246822519u;
    h = (h ^ (h >> 13u)) * 3266489917u;
    h = h ^ (h >> 16u);
    return 0.15 + 0.75 * vec3f(f32(h & 255u), f32(h >> 8u & 255u), f32(h >> 16u & 255u)) / 255.0;
}

@fragment
fn compose(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    let seen = textureLoad(ids, pixel, 0).r;
    // Where nothing is seen, triangle 0 is looked at for nothing, and the result is dropped.
    let id = max(seen, 1u) - 1u;
    let triangle = triangles[id];
    let ray = ray_through(position.xy);
    let at = inside(weights(triangle, ray));
    let from_back = dot(triangle.normal, ray) > 0.0;
    let normal = select(triangle.normal, -triangle.normal, from_back);
    let from_a = (triangle.b - triangle.a) * at.x + (triangle.c - triangle.a) * at.y;

    var sum = vec3f(0.0);
    if (frame.parts & INDIRECT) != 0u {
        let first = select(triangle.front, triangle.back, from_back);
        // A loop of at most one turn: drivers without branches skip it where no pixel at hand needs it.
        for (var turn = select(1u, 0u, first == NONE); turn > 0u; turn--) {
            sum += indirect(triangle, first, at);
        }
    }
    if (frame.parts & DIRECT) != 0u {
        for (var l = 0u; l < frame.lamps; l++) {
            let lamp = lamps[l];
            let to_lamp = (lamp.position - triangle.a) - from_a;
            let facing = dot(normal, to_lamp);
            let mask = textureLoad(masks, pixel, l / 4u, 0)[l % 4u];
            for (var turn = select(0u, 1u, facing > 0.0 && mask > 0.0); turn > 0u; turn--) {
                let squared = dot(to_lamp, to_lamp);
                var power = mask * facing * inverseSqrt(squared) / squared;
                if GONIOMETRIC && lamp.map != NONE {
                    power *= candela(lamp, -to_lamp);
                }
                sum += lamp.intensity * power;
            }
        }
    }
    if (frame.parts & REFLECTED) != 0u {
        let material = materials[triangle.material];
        var reflectance = material.reflectance;
        if TEXTURED {
            for (var turn = select(1u, 0u, material.texture == NONE); turn > 0u; turn--) {
                reflectance *= textured(id, triangle, textures[material.texture], position.xy, at);
            }
        }
        sum *= reflectance * INVERSE_PI;
    }
    if (frame.parts & ELEMENTS) != 0u {
        sum = element_colour(id, triangle.divisions, at);
    }
    return select(vec4f(0.0), vec4f(sum, 1.0), seen != 0u);
}

// Composition: out = indirect + Σ lamp · mask (Dmitriev et al. 2002, Eq. 7), in linear light. Twin of `composition.rs`.
//
// Every pixel knows its triangle; the point seen is where the pixel's ray meets it, so that nothing depends on how triangles were
// rasterised, and each pixel is shaded once.

// What the scene has: a pipeline without them is another, shorter program.
override TEXTURED: bool = false;
override GONIOMETRIC: bool = false;
// How many lamps are drawn, or 0 for as many as the frame says: a loop of known length has no jumps.
override LAMPS: u32 = 0u;

// Which parts are added; the same bits as `Parts` in `composition.rs`.
const INDIRECT = 1u;
const DIRECT = 2u;
const REFLECTED = 4u;
const ELEMENTS = 8u;

const INVERSE_PI = 0.31830988618;

struct Triangle {
    // World-space corners, metres.
    a: vec3f,
    b: vec3f,
    c: vec3f,
    // Unit, of the front.
    normal: vec3f,
    material: u32,
    // n: the triangle is cut into n² mesh elements.
    divisions: u32,
    // First irradiance of its lattice points, for the front and the back; NONE where no light ever came.
    front: u32,
    back: u32,
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
// Four entries a triangle.
@group(1) @binding(2) var triangles: texture_2d<u32>;
// Lux, one entry a lattice point.
@group(1) @binding(3) var irradiance: texture_2d<f32>;
// Linear Rec. 709 as bits, and the number of the texture or NONE.
@group(1) @binding(4) var materials: texture_2d<u32>;
// Candela at a sample, at the next in its row, and at those in the next row.
@group(1) @binding(5) var cube_maps: texture_2d<f32>;
@group(1) @binding(6) var uvs: texture_2d<f32>;
@group(1) @binding(7) var textures: texture_2d<u32>;
@group(1) @binding(8) var texels: texture_2d<u32>;

fn triangle_of(id: u32) -> Triangle {
    let a = textureLoad(triangles, entry(4u * id), 0);
    let b = textureLoad(triangles, entry(4u * id + 1u), 0);
    let c = textureLoad(triangles, entry(4u * id + 2u), 0);
    let normal = textureLoad(triangles, entry(4u * id + 3u), 0);
    return Triangle(bitcast<vec3f>(a.xyz), bitcast<vec3f>(b.xyz), bitcast<vec3f>(c.xyz), bitcast<vec3f>(normal.xyz), a.w, b.w, c.w, normal.w);
}

struct Covered {
    @invariant @builtin(position) position: vec4f,
}

// All pixels.
@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> Covered {
    return Covered(whole_picture(vertex));
}

// Those that see a certain triangle: as in the prepass, to the bit.
@vertex
fn place(@location(0) position: vec3f) -> Covered {
    return Covered(project(position - frame.eye, 1.0));
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
    return textureLoad(irradiance, entry(point), 0).rgb;
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
    let corners = textureLoad(cube_maps, entry(k), 0);
    let value = mix(mix(corners.x, corners.y, f.x), mix(corners.z, corners.w, f.x), f.y);
    let cosine = -d.z * inverseSqrt(dot(d, d));
    return select(0.0, value, cosine >= lamp.last && cosine <= lamp.first);
}

// Light of a lamp at a point given from a corner of its triangle, as if nothing stood in between.
fn direct(lamp: Lamp, corner: vec3f, from_corner: vec3f, normal: vec3f) -> vec3f {
    let to_lamp = (lamp.position - corner) - from_corner;
    let facing = dot(normal, to_lamp);
    let squared = dot(to_lamp, to_lamp);
    var power = max(facing, 0.0) * inverseSqrt(squared) / squared;
    if GONIOMETRIC && lamp.map != NONE {
        power *= candela(lamp, -to_lamp);
    }
    return lamp.intensity * power;
}

// A texel's place in a repeated image, from at most one image away: integer division is slow where it is done in software.
fn repeated(k: i32, count: i32) -> u32 {
    return u32(k + select(0, count, k < 0) - select(0, count, k >= count));
}

// A texel in linear light: square roots in 11, 11 and 10 bits. `textures.rs` is the twin.
fn texel(first: u32, width: u32, height: u32, x: i32, y: i32) -> vec3f {
    let column = repeated(x, i32(width));
    let row = repeated(y, i32(height));
    let packed = textureLoad(texels, entry(first + row * width + column), 0).r;
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
    let a = textureLoad(uvs, entry(3u * triangle), 0).xy;
    let b = textureLoad(uvs, entry(3u * triangle + 1u), 0).xy;
    let c = textureLoad(uvs, entry(3u * triangle + 2u), 0).xy;
    return a * (1.0 - at.x - at.y) + b * at.x + c * at.y;
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
    let triangle = triangle_of(id);
    let ray = ray_through(position.xy);
    let at = inside(weights(triangle, ray));
    let from_back = dot(triangle.normal, ray) > 0.0;
    let normal = select(triangle.normal, -triangle.normal, from_back);
    let from_a = (triangle.b - triangle.a) * at.x + (triangle.c - triangle.a) * at.y;

    var sum = vec3f(0.0);
    if (frame.parts & INDIRECT) != 0u {
        let first = select(triangle.front, triangle.back, from_back);
        if first != NONE {
            sum += indirect(triangle, first, at);
        }
    }
    if (frame.parts & DIRECT) != 0u {
        if LAMPS > 0u {
            for (var l = 0u; l < LAMPS; l++) {
                sum += select(vec3f(0.0), direct(lamps[l], triangle.a, from_a, normal), textureLoad(masks, pixel, l / 4u, 0)[l % 4u] > 0.0);
            }
        } else {
            for (var l = 0u; l < frame.lamps; l++) {
                sum += select(vec3f(0.0), direct(lamps[l], triangle.a, from_a, normal), textureLoad(masks, pixel, l / 4u, 0)[l % 4u] > 0.0);
            }
        }
    }
    if (frame.parts & REFLECTED) != 0u {
        let material = textureLoad(materials, entry(triangle.material), 0);
        var reflectance = bitcast<vec3f>(material.rgb);
        if TEXTURED && material.a != NONE {
            let texture = textureLoad(textures, entry(material.a), 0);
            reflectance *= textured(id, triangle, Texture(texture.x, texture.y, texture.z, texture.w), position.xy, at);
        }
        sum *= reflectance * INVERSE_PI;
    }
    if (frame.parts & ELEMENTS) != 0u {
        sum = element_colour(id, triangle.divisions, at);
    }
    return select(vec4f(0.0), vec4f(sum, 1.0), seen != 0u);
}

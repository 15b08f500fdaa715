// Shadow volumes into the stencil, then lit or not into one channel of a mask. Twin of `shadow.rs`.

struct Corner {
    @invariant @builtin(position) position: vec4f,
}

// Vertices come in pairs: where they are (w = 1), and where the lamp throws their shadow (w = 0): so many times as far from the lamp, or to
// infinity if `times` is 0.
@vertex
fn throw_shadow(@location(0) vertex: vec4f, @location(1) lamp: vec3f, @location(2) times: f32) -> Corner {
    let away = vertex.xyz - lamp;
    let far = select((lamp - frame.eye) + away * times, away, times == 0.0);
    let near = vertex.w == 1.0;
    return Corner(project(select(far, vertex.xyz - frame.eye, near), select(select(1.0, 0.0, times == 0.0), 1.0, near)));
}

@fragment
fn count() {}

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return whole_picture(vertex);
}

// All is lit at first.
@fragment
fn shaded() -> @location(0) vec4f {
    return vec4f(0.0);
}

// Shadow volumes into the stencil, then lit or not into one channel of a mask. Twin of `shadow.rs`.

struct Corner {
    @invariant @builtin(position) position: vec4f,
}

// Vertices come in pairs: where they are (w = 1), and where the lamp throws their shadow at infinity (w = 0).
@vertex
fn throw_shadow(@location(0) vertex: vec4f, @builtin(instance_index) lamp: u32) -> Corner {
    let d = vertex.xyz - select(lamps[lamp].position, frame.eye, vertex.w == 1.0);
    return Corner(project(d, vertex.w));
}

@fragment
fn count() {}

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return whole_picture(vertex);
}

@fragment
fn lit() -> @location(0) vec4f {
    return vec4f(1.0);
}

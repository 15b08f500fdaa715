//! Pipelines of all passes, and what is common to making them.

use crate::{
    composition::Variant,
    device::Device,
    shadow::Count,
    targets::{DEPTH, IDS, LIGHT, MASKS, MEASURED, PICTURE},
};
use wgpu::{
    BindGroupLayout, BindingType, BufferBindingType, ColorWrites, CompareFunction, RenderPipeline, ShaderModule, ShaderStages,
    StencilFaceState, StencilOperation, TextureSampleType, TextureViewDimension,
};

/// A uniform buffer.
pub const UNIFORM: BindingType =
    BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };

/// A texture that is read texel by texel.
pub const fn texture(sample_type: TextureSampleType, view_dimension: TextureViewDimension) -> BindingType {
    BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// Not filtered.
pub const FLOAT: TextureSampleType = TextureSampleType::Float { filterable: false };

/// A layout whose bindings are numbered in order.
pub fn layout(device: &Device, label: &str, bindings: &[(ShaderStages, BindingType)]) -> BindGroupLayout {
    let entries: Vec<_> = (0u32..)
        .zip(bindings)
        .map(|(binding, (visibility, ty))| wgpu::BindGroupLayoutEntry { binding, visibility: *visibility, ty: *ty, count: None })
        .collect();
    device.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}

/// A group whose bindings are numbered in order.
pub fn group(device: &Device, layout: &BindGroupLayout, resources: &[wgpu::BindingResource]) -> wgpu::BindGroup {
    let entries: Vec<_> =
        (0u32..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() }).collect();
    device.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// A shader, after what all share.
pub fn shader(device: &Device, label: &str, source: &str) -> ShaderModule {
    let source = format!("{}\n{source}", include_str!("frame.wgsl"));
    let source = wgpu::ShaderSource::Wgsl(source.into());
    device.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source })
}

/// What one render pipeline is.
#[derive(Clone)]
pub struct Recipe<'a> {
    /// For messages.
    pub label: &'a str,
    /// Where its functions are.
    pub module: &'a ShaderModule,
    /// Of the vertex stage, then of the fragment stage.
    pub functions: [&'a str; 2],
    /// Bind groups.
    pub groups: &'a [&'a BindGroupLayout],
    /// What vertices are made of; nothing if they are made from their number.
    pub vertices: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    /// Which winding is a front.
    pub front: wgpu::FrontFace,
    /// Triangles that are not drawn.
    pub cull: Option<wgpu::Face>,
    /// Depth and stencil.
    pub depth: Option<wgpu::DepthStencilState>,
    /// Where colours go, and which of their channels.
    pub target: (wgpu::TextureFormat, ColorWrites),
    /// Values of what the shader leaves open.
    pub constants: &'a [(&'a str, f64)],
}

impl Recipe<'_> {
    /// Makes it.
    pub fn make(&self, device: &Device) -> RenderPipeline {
        let groups: Vec<Option<&BindGroupLayout>> = self.groups.iter().map(|g| Some(*g)).collect();
        let layout = device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let compilation_options = wgpu::PipelineCompilationOptions { constants: self.constants, ..Default::default() };
        let [vertex, fragment] = self.functions;
        device.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: self.module,
                entry_point: Some(vertex),
                compilation_options: compilation_options.clone(),
                buffers: self.vertices,
            },
            primitive: wgpu::PrimitiveState { front_face: self.front, cull_mode: self.cull, ..Default::default() },
            depth_stencil: self.depth.clone(),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: self.module,
                entry_point: Some(fragment),
                compilation_options,
                targets: &[Some(wgpu::ColorTargetState { format: self.target.0, blend: None, write_mask: self.target.1 })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Depth and stencil of a pass that only reads depth.
fn read_depth(compare: CompareFunction, front: StencilFaceState, back: StencilFaceState) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(false),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState { front, back, read_mask: 0xff, write_mask: 0xff },
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Vertices of the prepass: position, number of the triangle.
const PLACES: [Option<wgpu::VertexBufferLayout>; 1] =
    [stepped(16, wgpu::VertexStepMode::Vertex, &wgpu::vertex_attr_array![0 => Float32x3, 1 => Uint32])];

/// A buffer of vertices, or of what all vertices of one instance share.
const fn stepped(
    array_stride: u64,
    step_mode: wgpu::VertexStepMode,
    attributes: &[wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'_>> {
    Some(wgpu::VertexBufferLayout { array_stride, step_mode, attributes })
}

/// All pipelines, and the layouts of what they are given.
pub struct Pipelines {
    /// Camera and lamps.
    pub frame: BindGroupLayout,
    /// What composition reads.
    pub shading: BindGroupLayout,
    /// What the tone passes read.
    pub toning: BindGroupLayout,
    /// Depth prepass: of all triangles, and of fronts alone.
    pub prepass: [RenderPipeline; 2],
    volumes: [RenderPipeline; 3],
    masks: [RenderPipeline; 4],
    composition_module: ShaderModule,
    compositions: Vec<(Variant, RenderPipeline)>,
    /// Exposure of tiles, then of the picture.
    pub measure: [RenderPipeline; 2],
    /// Tone curve.
    pub develop: RenderPipeline,
}

impl Pipelines {
    /// All but composition, which depends on what a scene has.
    pub fn new(device: &Device) -> Pipelines {
        let frame = layout(device, "frame", &[(ShaderStages::VERTEX_FRAGMENT, UNIFORM), (ShaderStages::FRAGMENT, UNIFORM)]);
        let fragment = ShaderStages::FRAGMENT;
        let shading = layout(
            device,
            "shading",
            &[
                (fragment, texture(TextureSampleType::Uint, TextureViewDimension::D2)),
                (fragment, texture(FLOAT, TextureViewDimension::D2Array)),
                (fragment, texture(TextureSampleType::Uint, TextureViewDimension::D2)),
                (fragment, texture(FLOAT, TextureViewDimension::D2)),
                (fragment, texture(TextureSampleType::Uint, TextureViewDimension::D2)),
                (fragment, texture(FLOAT, TextureViewDimension::D2)),
                (fragment, texture(FLOAT, TextureViewDimension::D2)),
                (fragment, texture(TextureSampleType::Uint, TextureViewDimension::D2)),
                (fragment, texture(TextureSampleType::Uint, TextureViewDimension::D2)),
            ],
        );
        let flat = texture(FLOAT, TextureViewDimension::D2);
        let toning = layout(device, "tone", &[(fragment, UNIFORM), (fragment, flat), (fragment, flat)]);
        let plain = Recipe {
            label: "",
            module: &shader(device, "prepass", include_str!("prepass.wgsl")),
            functions: ["place", "identify"],
            groups: &[&frame],
            vertices: &[],
            front: wgpu::FrontFace::Ccw,
            cull: None,
            depth: None,
            target: (IDS, ColorWrites::ALL),
            constants: &[],
        };
        let prepass = [None, Some(wgpu::Face::Back)].map(|cull| {
            Recipe {
                label: "prepass",
                vertices: &PLACES,
                cull,
                depth: Some(wgpu::DepthStencilState {
                    depth_write_enabled: Some(true),
                    ..read_depth(CompareFunction::Greater, StencilFaceState::IGNORE, StencilFaceState::IGNORE)
                }),
                ..plain.clone()
            }
            .make(device)
        });
        let shadow = shader(device, "shadow", include_str!("shadow.wgsl"));
        let volume = |count: Count| {
            let (more, less) = (StencilOperation::IncrementWrap, StencilOperation::DecrementWrap);
            let state = |pass: StencilOperation, fail: StencilOperation| StencilFaceState {
                compare: CompareFunction::Always,
                fail_op: StencilOperation::Keep,
                depth_fail_op: fail,
                pass_op: pass,
            };
            let keep = StencilOperation::Keep;
            // In front of what is seen a front is an entry; behind it, a front is an entry that is not made.
            let [front, back] = match count {
                Count::Before => [state(more, keep), state(less, keep)],
                Count::Behind | Count::BehindTurned => [state(keep, less), state(keep, more)],
            };
            // Seen edge-on, sides are so steep that rounding pushes them in front of what they are behind; a thousandth of a pixel makes
            // up for it.
            let slope_scale = if count == Count::Before { -1.0 / 1024.0 } else { 0.0 };
            let bias = wgpu::DepthBiasState { slope_scale, ..Default::default() };
            let winding = if count == Count::BehindTurned { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw };
            Recipe {
                label: "shadow volume",
                module: &shadow,
                functions: ["throw_shadow", "count"],
                vertices: &[
                    stepped(16, wgpu::VertexStepMode::Vertex, &wgpu::vertex_attr_array![0 => Float32x4]),
                    stepped(16, wgpu::VertexStepMode::Instance, &wgpu::vertex_attr_array![1 => Float32x3, 2 => Float32]),
                ],
                front: winding,
                depth: Some(wgpu::DepthStencilState { bias, ..read_depth(CompareFunction::Greater, front, back) }),
                target: (MASKS, ColorWrites::empty()),
                ..plain.clone()
            }
            .make(device)
        };
        let mask = |channel: ColorWrites| {
            let zero = StencilFaceState {
                compare: CompareFunction::NotEqual,
                fail_op: StencilOperation::Keep,
                depth_fail_op: StencilOperation::Zero,
                pass_op: StencilOperation::Zero,
            };
            Recipe {
                label: "mask",
                module: &shadow,
                functions: ["cover", "shaded"],
                depth: Some(read_depth(CompareFunction::Always, zero, zero)),
                target: (MASKS, channel),
                ..plain.clone()
            }
            .make(device)
        };
        let tone_source = wgpu::ShaderSource::Wgsl(include_str!("tone.wgsl").into());
        let tone = device.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("tone"), source: tone_source });
        let toned = |label: &'static str, format: wgpu::TextureFormat| {
            Recipe {
                label,
                module: &tone,
                functions: ["cover", label],
                groups: &[&toning],
                target: (format, ColorWrites::ALL),
                ..plain.clone()
            }
            .make(device)
        };
        let measure = [toned("measure_tile", MEASURED), toned("measure_picture", MEASURED)];
        let develop = toned("develop", PICTURE);
        let volumes = [volume(Count::Before), volume(Count::Behind), volume(Count::BehindTurned)];
        let masks = [ColorWrites::RED, ColorWrites::GREEN, ColorWrites::BLUE, ColorWrites::ALPHA].map(mask);
        let composition_module = shader(device, "composition", include_str!("composition.wgsl"));
        Pipelines {
            prepass,
            volumes,
            masks,
            composition_module,
            compositions: Vec::new(),
            measure,
            develop,
            frame,
            shading,
            toning,
        }
    }

    /// The pipeline that counts this way.
    pub fn volume(&self, count: Count) -> &RenderPipeline {
        &self.volumes[count as usize]
    }

    /// The pipeline that writes channel 0 to 3 of a mask.
    pub fn mask(&self, channel: usize) -> &RenderPipeline {
        &self.masks[channel]
    }

    /// The composition for what a scene has, made when it is first needed.
    pub fn composition(&mut self, device: &Device, variant: Variant) -> RenderPipeline {
        if let Some((_, made)) = self.compositions.iter().find(|(known, _)| *known == variant) {
            return made.clone();
        }
        let made = Recipe {
            label: "composition",
            module: &self.composition_module,
            functions: [if variant.textured { "place" } else { "cover" }, "compose"],
            groups: &[&self.frame, &self.shading],
            vertices: if variant.textured { &PLACES } else { &[] },
            front: wgpu::FrontFace::Ccw,
            cull: None,
            depth: Some(wgpu::DepthStencilState {
                stencil: wgpu::StencilState::default(),
                ..read_depth(
                    if variant.textured { CompareFunction::Equal } else { CompareFunction::Always },
                    StencilFaceState::IGNORE,
                    StencilFaceState::IGNORE,
                )
            }),
            target: (LIGHT, ColorWrites::ALL),
            constants: &[
                ("TEXTURED", f64::from(u8::from(variant.textured))),
                ("GONIOMETRIC", f64::from(u8::from(variant.goniometric))),
                ("LAMPS", f64::from(variant.lamps)),
            ],
        }
        .make(device);
        self.compositions.push((variant, made.clone()));
        made
    }
}

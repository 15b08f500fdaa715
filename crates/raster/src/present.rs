//! The last picture, scaled into a part of a window, with outlines around what is marked. Twin of `present.wgsl`.
//!
//! Outlines come from the triangle numbers that every pixel has: an object's are one range, and where some of a pixel's neighbours are in
//! it and some are not, there is an edge. So they are drawn only where the object is seen, and only the part of the picture that its box
//! covers pays for them.

use crate::{
    camera::Camera,
    device::{Device, RasterError},
    geometry::Geometry,
    pipelines::{Recipe, UNIFORM, group, layout, texture},
    targets::Targets,
};
use bytemuck::{Pod, Zeroable};
use wgpu::{BindingResource, RenderPipeline, ShaderStages, TextureSampleType, TextureViewDimension};

/// An object whose outline is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Its number in the configuration. One that does not stand there has no outline.
    pub object: usize,
    /// sRGB, 0 to 1, and opacity.
    pub colour: [f32; 4],
}

/// Marks that are drawn at once; the same in `present.wgsl`.
pub const MOST_MARKS: usize = 8;

/// A mark as the shader reads it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuMark {
    colour: [f32; 4],
    first: u32,
    end: u32,
    unused: [u32; 2],
}

#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct GpuPresent {
    corner: [f32; 2],
    step: [f32; 2],
    marks: [GpuMark; MOST_MARKS],
    count: u32,
    unused: [u32; 3],
}

/// Which program draws into a target.
type Variant = (wgpu::TextureFormat, bool);

/// What presenting needs.
pub struct Presenter {
    layout: wgpu::BindGroupLayout,
    module: wgpu::ShaderModule,
    /// For pictures as large as the viewport, and for others.
    samplers: [wgpu::Sampler; 2],
    uniform: wgpu::Buffer,
    pipelines: Vec<(Variant, RenderPipeline)>,
}

impl Presenter {
    /// Pipelines are made when a format is first met.
    pub fn new(device: &Device) -> Result<Presenter, RasterError> {
        let fragment = ShaderStages::FRAGMENT;
        let filterable = TextureSampleType::Float { filterable: true };
        let bindings = [
            (fragment, UNIFORM),
            (fragment, texture(filterable, TextureViewDimension::D2)),
            (fragment, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
            (fragment, texture(TextureSampleType::Uint, TextureViewDimension::D2)),
        ];
        let source = wgpu::ShaderSource::Wgsl(include_str!("present.wgsl").into());
        let sampler = |filter| {
            let (mag_filter, min_filter) = (filter, filter);
            device.device.create_sampler(&wgpu::SamplerDescriptor { mag_filter, min_filter, ..Default::default() })
        };
        Ok(Presenter {
            layout: layout(device, "present", &bindings),
            module: device.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("present"), source }),
            samplers: [wgpu::FilterMode::Nearest, wgpu::FilterMode::Linear].map(sampler),
            uniform: device.buffer("present", size_of::<GpuPresent>() as u64, wgpu::BufferUsages::UNIFORM)?,
            pipelines: Vec::new(),
        })
    }

    /// Draws the picture of `targets`, which `camera` saw, into the part of the pass's target that `viewport` is (x, y, width, height; pixels).
    pub fn draw(
        &mut self,
        device: &Device,
        pass: &mut wgpu::RenderPass,
        target: &wgpu::Texture,
        format: wgpu::TextureFormat,
        [left, top, width, height]: [u32; 4],
        (targets, camera): (&Targets, &Camera),
        marks: &[Mark],
        geometry: &Geometry,
    ) {
        // What sticks out of the target is not drawn: a window may have become smaller since it was laid out.
        let inside = |first: u32, side: u32, most: u32| side.min(most.saturating_sub(first));
        let (across, down) = (inside(left, width, target.width()), inside(top, height, target.height()));
        if across == 0 || down == 0 {
            return;
        }
        let seen = marks.iter().filter_map(|mark| {
            let (thing, triangles) = geometry.thing(mark.object)?;
            let (first, end) = (triangles.start + 1, triangles.end + 1);
            Some((GpuMark { colour: mark.colour, first, end, unused: [0; 2] }, thing.bounds.in_picture(camera)?))
        });
        let mut marks = [GpuMark::zeroed(); MOST_MARKS];
        let mut parts = Vec::new();
        for ((mark, part), place) in seen.zip(&mut marks) {
            *place = mark;
            parts.push(part);
        }
        let uniform = GpuPresent {
            corner: [left as f32, top as f32],
            step: [1.0 / width as f32, 1.0 / height as f32],
            marks,
            count: parts.len() as u32,
            unused: [0; 3],
        };
        device.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            self.uniform.as_entire_binding(),
            BindingResource::TextureView(&view(&targets.picture)),
            BindingResource::Sampler(&self.samplers[usize::from(targets.size != [width, height])]),
            BindingResource::TextureView(&view(&targets.ids)),
        ];
        pass.set_bind_group(0, &group(device, &self.layout, &resources), &[]);
        pass.set_pipeline(&self.pipeline(device, (format, false)));
        pass.set_scissor_rect(left, top, across, down);
        pass.draw(0..3, 0..1);
        if !parts.is_empty() {
            pass.set_pipeline(&self.pipeline(device, (format, true)));
        }
        // Each part is drawn with all marks: where they overlap, the same twice. Lines lie up to a pixel outside, of this or of the picture.
        let [x, y] = [width.div_ceil(targets.size[0]) + 1, height.div_ceil(targets.size[1]) + 1];
        for part in parts {
            let [l, t, w, h] = part.pixels(width, height);
            let (right, bottom) = ((l + w + x).min(across), (t + h + y).min(down));
            let (l, t) = (l.saturating_sub(x), t.saturating_sub(y));
            if l < right && t < bottom {
                pass.set_scissor_rect(left + l, top + t, right - l, bottom - t);
                pass.draw(0..3, 0..1);
            }
        }
    }

    fn pipeline(&mut self, device: &Device, variant: Variant) -> RenderPipeline {
        if let Some((_, made)) = self.pipelines.iter().find(|(known, _)| *known == variant) {
            return made.clone();
        }
        let (format, marked) = variant;
        let number = |yes: bool| f64::from(u8::from(yes));
        let made = Recipe {
            label: "present",
            module: &self.module,
            functions: ["cover", "show"],
            groups: &[&self.layout],
            vertices: &[],
            front: wgpu::FrontFace::Ccw,
            cull: None,
            depth: None,
            target: (format, wgpu::ColorWrites::ALL),
            constants: &[("MARKED", number(marked)), ("LINEAR", number(format.is_srgb()))],
        }
        .make(device);
        self.pipelines.push((variant, made.clone()));
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Look, Parts, Renderer, Settings, targets::read};
    use lightmend_scene::{Configuration, Scene};
    use std::{path::Path, sync::Arc};
    use wgpu::TextureFormat;

    const SIZE: [u32; 2] = [64, 48];
    const WHOLE: [u32; 4] = [0, 0, SIZE[0], SIZE[1]];

    fn room() -> (Renderer, Arc<Scene>) {
        let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        let scene = Scene::read(&room).unwrap().0;
        let mut renderer = Renderer::new(Arc::new(Device::headless().unwrap())).unwrap();
        renderer.show(&Configuration::initial(&scene)).unwrap();
        (renderer, scene)
    }

    fn draw(renderer: &mut Renderer, scene: &Scene, grid: u32) -> Vec<[u8; 3]> {
        let look = Look::Photograph { exposure: None };
        let settings = Settings { width: SIZE[0], height: SIZE[1], grid, parts: Parts::RADIANCE, look };
        renderer.draw(&scene.cameras[0].1, &settings).unwrap();
        renderer.picture().unwrap()
    }

    /// The pixels of a target of `size`, and what they are at a place.
    struct Shown(Vec<[u8; 4]>, u32);

    impl Shown {
        fn at(&self, x: u32, y: u32) -> [u8; 3] {
            let [r, g, b, _] = self.0[(y * self.1 + x) as usize];
            [r, g, b]
        }
    }

    fn show(
        renderer: &mut Renderer,
        [width, height]: [u32; 2],
        format: TextureFormat,
        viewport: [u32; 4],
        marks: &[Mark],
    ) -> Shown {
        let device = renderer.device().clone();
        let target = device.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        renderer.present(&mut encoder, &view, format, viewport, marks).unwrap();
        device.queue.submit([encoder.finish()]);
        let bytes = read(&device, &target, 0).unwrap();
        Shown(bytes.as_chunks::<4>().0.to_vec(), width)
    }

    #[test]
    fn a_picture_is_shown_as_it_is() {
        let (mut renderer, scene) = room();
        let format = TextureFormat::Rgba8Unorm;
        let nothing = show(&mut renderer, SIZE, format, WHOLE, &[]);
        assert!(nothing.0.iter().all(|p| *p == [0, 0, 0, 255]), "nothing was drawn yet");
        let picture = draw(&mut renderer, &scene, 1);
        let whole = show(&mut renderer, SIZE, format, WHOLE, &[]);
        let same = |shown: &Shown, [left, top]: [u32; 2], [width, height]: [u32; 2]| {
            (0..80).all(|y| {
                (0..100).all(|x| {
                    let inside = x >= left && y >= top && x - left < SIZE[0] && y - top < SIZE[1];
                    let pixel = if inside { picture[((y - top) * SIZE[0] + x - left) as usize] } else { [0; 3] };
                    x >= width || y >= height || shown.at(x, y) == pixel
                })
            })
        };
        assert!(same(&whole, [0, 0], SIZE));
        // In a part of the target, sticking out of it, beside it, and of no size.
        let large = [100, 80];
        for [left, top] in [[20, 10], [70, 60], [100, 0], [3000, 4000]] {
            let part = show(&mut renderer, large, format, [left, top, SIZE[0], SIZE[1]], &[]);
            assert!(same(&part, [left, top], large), "{left}, {top}");
        }
        assert!(show(&mut renderer, large, format, [5, 5, 0, 9], &[]).0.iter().all(|p| *p == [0, 0, 0, 255]));
        // Other formats.
        let swapped = show(&mut renderer, SIZE, TextureFormat::Bgra8Unorm, WHOLE, &[]);
        assert!(swapped.0.iter().zip(&picture).all(|([b, g, r, _], p)| [*r, *g, *b] == *p));
        let encoded = show(&mut renderer, SIZE, TextureFormat::Rgba8UnormSrgb, WHOLE, &[]);
        assert!(encoded.0.iter().zip(&picture).all(|(e, p)| (0..3).all(|k| e[k].abs_diff(p[k]) <= 1)));
    }

    #[test]
    fn a_picture_is_scaled_linearly() {
        let (mut renderer, scene) = room();
        let picture = draw(&mut renderer, &scene, 1);
        for [width, height] in [[80, 60], [150, 70], [50, 40]] {
            let shown = show(&mut renderer, [160, 80], TextureFormat::Rgba8Unorm, [7, 9, width, height], &[]);
            for y in 0..height.min(71) {
                for x in 0..width {
                    let place = |k: u32, side: u32, of: u32| {
                        let at = ((k as f64 + 0.5) * f64::from(of) / f64::from(side) - 0.5).clamp(0.0, f64::from(of - 1));
                        (at.floor() as u32, (at.floor() as u32 + 1).min(of - 1), at.fract())
                    };
                    let ((x0, x1, fx), (y0, y1, fy)) = (place(x, width, SIZE[0]), place(y, height, SIZE[1]));
                    let pixel = |x: u32, y: u32, k: usize| f64::from(picture[(y * SIZE[0] + x) as usize][k]);
                    for k in 0..3 {
                        let row = |y| pixel(x0, y, k) * (1.0 - fx) + pixel(x1, y, k) * fx;
                        let wanted = row(y0) * (1.0 - fy) + row(y1) * fy;
                        // Drivers weigh in steps of 1/256.
                        assert!((f64::from(shown.at(x + 7, y + 9)[k]) - wanted).abs() <= 2.5, "{width}x{height}: {x}, {y}");
                    }
                }
            }
        }
    }

    #[test]
    fn marked_objects_have_outlines() {
        let (mut renderer, scene) = room();
        let [table, wardrobe] = ["table", "wardrobe"].map(|name| scene.objects.iter().position(|o| o.name == name).unwrap());
        let mark = |object, colour| Mark { object, colour };
        let marks = [mark(table, [0.0, 1.0, 0.0, 1.0]), mark(9999, [1.0; 4]), mark(wardrobe, [1.0, 0.0, 0.0, 0.5])];
        let format = TextureFormat::Rgba8Unorm;
        for (grid, scale) in [(1, 1), (1, 2), (2, 1)] {
            draw(&mut renderer, &scene, grid);
            let size = SIZE.map(|side| side * scale);
            let viewport = [6, 4, size[0], size[1]];
            let target = [size[0] + 9, size[1] + 9];
            let plain = show(&mut renderer, target, format, viewport, &[]);
            let unknown = show(&mut renderer, target, format, viewport, &marks[1..2]);
            assert!(plain.0 == unknown.0);
            let marked = show(&mut renderer, target, format, viewport, &marks);
            let seen = renderer.seen().unwrap();
            let object = |x: i64, y: i64| {
                let sample = |k: i64, side: u32| {
                    let k = k.clamp(0, i64::from(side) - 1) as u32;
                    ((2 * k + 1) * grid / (2 * scale)) as usize
                };
                seen[sample(y, size[1]) * (SIZE[0] * grid) as usize + sample(x, size[0])].map(|(id, _)| id)
            };
            let mut count = [0; 3];
            for (y, x) in (0..i64::from(size[1])).flat_map(|y| (0..i64::from(size[0])).map(move |x| (y, x))) {
                let mut wanted = plain.at(x as u32 + 6, y as u32 + 4).map(f64::from);
                for (n, mark) in marks.iter().enumerate() {
                    let corners = [(x - 1, y - 1), (x + 1, y - 1), (x - 1, y + 1), (x + 1, y + 1)];
                    let about = corners.iter().filter(|(x, y)| object(*x, *y) == Some(mark.object)).count();
                    if (1..4).contains(&about) {
                        count[n] += 1;
                        let alpha = f64::from(mark.colour[3]);
                        wanted = [0, 1, 2].map(|k| wanted[k] * (1.0 - alpha) + 255.0 * f64::from(mark.colour[k]) * alpha);
                    }
                }
                let got = marked.at(x as u32 + 6, y as u32 + 4).map(f64::from);
                assert!((0..3).all(|k| (got[k] - wanted[k]).abs() <= 1.01), "{grid}, {scale}: {x}, {y}: {got:?}, {wanted:?}");
            }
            assert!(count[0] > 40 && count[1] == 0 && count[2] > 40, "{count:?}");
        }
        // More than can be drawn: the first ones are.
        let many = [vec![marks[0]; MOST_MARKS], vec![marks[2]]].concat();
        let [few, many] = [&many[..1], &many].map(|marks| show(&mut renderer, SIZE, format, WHOLE, marks).0);
        assert!(few == many);
        let times = renderer.finish().unwrap();
        assert!(times.present > 0.0 || times.prepass == 0.0, "{times:?}");
    }
}

//! The flow of a frame: what stands where, its light, and the passes from depth to picture.

use crate::{
    camera::Camera,
    composition::{Parts, Variant},
    device::{Device, RasterError},
    frame::{Frame, Lamps},
    geometry::{Geometry, Thing},
    irradiance::Indirect,
    pipelines::{Pipelines, group},
    present::{Mark, Presenter},
    shadow::{Draw, Draws, Volumes},
    targets::{Targets, read},
    timing::{Pass, Stopwatch, Times},
    tone::{GpuTone, Look},
};
use lightmend_scene::{Configuration, Up, View};
use std::{sync::Arc, time::Instant};
use wgpu::{BindingResource, LoadOp, Operations, StoreOp};

/// How a picture is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Samples along each side of a pixel: 1 is none too many, 2 and 4 smooth edges of objects and shadows, at 4 and 16 times the cost.
    pub grid: u32,
    /// What is added up.
    pub parts: Parts,
    /// How it becomes a picture.
    pub look: Look,
}

/// A scene on a graphics device, seen by cameras.
pub struct Renderer {
    device: Arc<Device>,
    pipelines: Pipelines,
    geometry: Geometry,
    lamps: Lamps,
    volumes: Volumes,
    presenter: Presenter,
    targets: Option<Targets>,
    /// What saw the last picture.
    camera: Option<Camera>,
    frame: wgpu::Buffer,
    tone: wgpu::Buffer,
    stopwatch: Stopwatch,
    up: Up,
    reach: f64,
}

impl Renderer {
    /// Nothing to see yet.
    pub fn new(device: Arc<Device>) -> Result<Renderer, RasterError> {
        let uniform = wgpu::BufferUsages::UNIFORM;
        let renderer = Renderer {
            pipelines: Pipelines::new(&device),
            geometry: Geometry::new(&device)?,
            lamps: Lamps::new(&device)?,
            volumes: Volumes::new(&device)?,
            presenter: Presenter::new(&device)?,
            targets: None,
            camera: None,
            frame: device.buffer("frame", size_of::<Frame>() as u64, uniform)?,
            tone: device.buffer("tone", size_of::<GpuTone>() as u64, uniform)?,
            stopwatch: Stopwatch::new(&device),
            up: Up::Z,
            reach: 1.0,
            device,
        };
        renderer.device.check()?;
        Ok(renderer)
    }

    /// The device that draws.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// From now on this is what stands where and which lamps shine. Only what differs from before costs anything.
    pub fn show(&mut self, configuration: &Configuration) -> Result<(), RasterError> {
        self.up = configuration.scene().up;
        self.reach = configuration.reach();
        self.geometry.show(&self.device, configuration)?;
        self.lamps.show(&self.device, configuration)?;
        self.device.check()
    }

    /// From now on this is the indirect light. What is the same `Arc` as before costs nothing.
    pub fn light(&mut self, indirect: &Indirect) -> Result<(), RasterError> {
        self.geometry.light(&self.device, indirect)?;
        self.device.check()
    }

    /// What could not be drawn as the scene says, since the last call; each is told once.
    pub fn warnings(&mut self) -> Vec<String> {
        let mut new = std::mem::take(&mut self.geometry.warnings);
        new.append(&mut self.lamps.warnings);
        new
    }

    /// The camera's aspect and near plane.
    fn camera(&self, view: &View, settings: &Settings) -> Camera {
        Camera::new(view, self.up, f64::from(settings.width) / f64::from(settings.height), self.reach)
    }

    /// The closed object that the eye is inside of, if any: the camera then sees its inside, which no light reaches.
    pub fn inside(&self, view: &View) -> Option<&str> {
        self.geometry
            .things
            .iter()
            .find(|thing| !thing.hidden && thing.casters.iter().any(|caster| caster.holds(view.eye)))
            .map(|thing| thing.name.as_str())
    }

    /// Names of the channels of the masks: the lamps that are drawn, in order, as numbers in the configuration.
    pub fn drawn_lamps(&self) -> impl Iterator<Item = usize> + '_ {
        self.lamps.drawn.iter().map(|lamp| lamp.id)
    }

    /// Draws what `view` sees. The picture stays on the device until the next one.
    pub fn draw(&mut self, view: &View, settings: &Settings) -> Result<(), RasterError> {
        let start = Instant::now();
        let size = [settings.width, settings.height];
        let lamps = self.lamps.drawn.len();
        if !self.targets.as_ref().is_some_and(|targets| targets.fit(size, settings.grid, lamps)) {
            // The old ones first: two sets of a large picture may not fit.
            self.targets = None;
            self.targets = Some(Targets::new(&self.device, size, settings.grid, lamps)?);
        }
        let camera = self.camera(view, settings);
        self.camera = Some(camera);
        let Some(targets) = &self.targets else { return Ok(()) };
        let samples = targets.samples();
        let frame = Frame::new(&camera, samples, lamps as u32, settings.parts.bits());
        self.device.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
        let tone = GpuTone::new(settings.look, settings.grid);
        self.device.queue.write_buffer(&self.tone, 0, bytemuck::bytes_of(&tone));
        let draws = if settings.parts.direct() {
            self.volumes.draws(&self.device, &self.geometry, &self.lamps.drawn, &camera, samples)?
        } else {
            Vec::new()
        };
        self.stopwatch.prepared(start.elapsed());

        // From outside of what is closed only fronts are seen, unless the near plane cuts into it.
        let margin = 4.0 * camera.near_corners()[0].distance(camera.eye);
        let fronts = |thing: &Thing| thing.outwards && !thing.bounds.grown(margin).contains(camera.eye);
        let seen =
            [seen_vertices(&self.geometry, &camera, |thing| !fronts(thing)), seen_vertices(&self.geometry, &camera, fronts)];
        let textured = seen_vertices(&self.geometry, &camera, |thing| thing.textured);
        let goniometric = self.lamps.goniometric();
        let mut composition =
            |textured: bool| self.pipelines.composition(&self.device, Variant::new(textured, goniometric, lamps));
        let plain = composition(false);
        let with_textures = (!textured.is_empty()).then(|| composition(true));
        let device = &self.device;
        let camera_and_lamps =
            group(device, &self.pipelines.frame, &[self.frame.as_entire_binding(), self.lamps.buffer.as_entire_binding()]);
        let view_of = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let masks = targets.masks.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let (depth, ids, light, picture) =
            (view_of(&targets.depth), view_of(&targets.ids), view_of(&targets.light), view_of(&targets.picture));
        let shading = group(
            device,
            &self.pipelines.shading,
            &[
                BindingResource::TextureView(&ids),
                BindingResource::TextureView(&masks),
                BindingResource::TextureView(&self.geometry.triangles.view),
                BindingResource::TextureView(&self.geometry.irradiance.table.view),
                BindingResource::TextureView(&self.geometry.materials.view),
                BindingResource::TextureView(&self.lamps.cube_maps.view),
                BindingResource::TextureView(&self.geometry.uvs.view),
                BindingResource::TextureView(&self.geometry.texture_entries.view),
                BindingResource::TextureView(&self.geometry.texels.view),
            ],
        );
        let (tiles, exposure) = (view_of(&targets.tiles), view_of(&targets.exposure));
        let toning = |measured: &wgpu::TextureView| {
            let resources =
                [self.tone.as_entire_binding(), BindingResource::TextureView(&light), BindingResource::TextureView(measured)];
            group(device, &self.pipelines.toning, &resources)
        };

        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = begin(
                &mut encoder,
                "prepass",
                &ids,
                LoadOp::Clear(wgpu::Color::TRANSPARENT),
                Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Store }),
                    stencil_ops: Some(Operations { load: LoadOp::Clear(0), store: StoreOp::Discard }),
                }),
                self.stopwatch.render(Pass::Prepass),
            );
            pass.set_bind_group(0, &camera_and_lamps, &[]);
            pass.set_vertex_buffer(0, self.geometry.prepass.slice(..));
            for (pipeline, seen) in self.pipelines.prepass.iter().zip(seen) {
                pass.set_pipeline(pipeline);
                seen.into_iter().for_each(|vertices| pass.draw(vertices, 0..1));
            }
        }
        for (layer, group) in (0u32..).zip(draws.chunks(4)) {
            let mask = targets.masks.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            let mut pass = begin(
                &mut encoder,
                "shadow volumes",
                &mask,
                LoadOp::Clear(wgpu::Color::WHITE),
                Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: None,
                    stencil_ops: Some(Operations { load: LoadOp::Clear(0), store: StoreOp::Discard }),
                }),
                self.stopwatch.render_of(Pass::Shadows, layer as usize, draws.len().div_ceil(4)),
            );
            pass.set_bind_group(0, &camera_and_lamps, &[]);
            pass.set_vertex_buffer(0, self.geometry.volume.slice(..));
            pass.set_vertex_buffer(1, self.volumes.casts.slice(..));
            pass.set_index_buffer(self.volumes.arena.slice(..), wgpu::IndexFormat::Uint32);
            for (channel, Draws { parts, scissor, first }) in group.iter().enumerate() {
                for (instance, Draw { count, indices, scissor: [left, top, width, height], .. }) in (*first..).zip(parts) {
                    pass.set_pipeline(self.pipelines.volume(*count));
                    pass.set_scissor_rect(*left, *top, *width, *height);
                    pass.draw_indexed(indices.clone(), 0, instance..instance + 1);
                }
                let [left, top, width, height] = *scissor;
                if !parts.is_empty() {
                    pass.set_pipeline(self.pipelines.mask(channel));
                    pass.set_scissor_rect(left, top, width, height);
                    pass.draw(0..3, 0..1);
                }
            }
        }
        {
            let mut pass = begin(
                &mut encoder,
                "composition",
                &light,
                LoadOp::Clear(wgpu::Color::TRANSPARENT),
                Some(wgpu::RenderPassDepthStencilAttachment { view: &depth, depth_ops: None, stencil_ops: None }),
                self.stopwatch.render(Pass::Composition),
            );
            pass.set_bind_group(0, &camera_and_lamps, &[]);
            pass.set_bind_group(1, &shading, &[]);
            pass.set_vertex_buffer(0, self.geometry.prepass.slice(..));
            // Without triangles there is nothing that pixels could read.
            if !self.geometry.things.is_empty() {
                pass.set_pipeline(&plain);
                pass.draw(0..3, 0..1);
            }
            if let Some(with_textures) = &with_textures {
                pass.set_pipeline(with_textures);
                textured.into_iter().for_each(|vertices| pass.draw(vertices, 0..1));
            }
        }
        let clear = LoadOp::Clear(wgpu::Color::BLACK);
        if tone.measures() {
            // Each pass is given a texture that it does not draw into.
            for (n, (target, measured)) in [(&tiles, &exposure), (&exposure, &tiles)].into_iter().enumerate() {
                let mut pass =
                    begin(&mut encoder, "exposure", target, clear, None, self.stopwatch.render_of(Pass::Exposure, n, 2));
                pass.set_pipeline(&self.pipelines.measure[n]);
                pass.set_bind_group(0, &toning(measured), &[]);
                pass.draw(0..3, 0..1);
            }
        }
        {
            let mut pass = begin(&mut encoder, "tone", &picture, clear, None, self.stopwatch.render(Pass::Tone));
            pass.set_pipeline(&self.pipelines.develop);
            pass.set_bind_group(0, &toning(&exposure), &[]);
            pass.draw(0..3, 0..1);
        }
        self.stopwatch.resolve(&mut encoder);
        self.device.queue.submit([encoder.finish()]);
        self.device.check()
    }

    /// Draws the last picture, scaled, into the part of `target` that `viewport` is (x, y, width, height; pixels), with outlines of marked
    /// objects, 8 at most; the rest of `target`, whose format is `format`, becomes black. All of it, if nothing was drawn yet.
    /// Marks are of what was shown when the picture was drawn.
    pub fn present(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
        viewport: [u32; 4],
        marks: &[Mark],
    ) -> Result<(), RasterError> {
        let clear = LoadOp::Clear(wgpu::Color::BLACK);
        {
            let mut pass = begin(encoder, "present", target, clear, None, self.stopwatch.render(Pass::Present));
            if let (Some(targets), Some(camera)) = (&self.targets, &self.camera) {
                let (device, geometry) = (&self.device, &self.geometry);
                self.presenter.draw(device, &mut pass, target.texture(), format, viewport, (targets, camera), marks, geometry);
            }
        }
        self.stopwatch.resolve_present(encoder);
        self.device.check()
    }

    /// How many shadow volumes were made anew for the last picture: those of objects and lamps that moved, and those that were seen for the
    /// first time.
    pub fn volumes_made(&self) -> usize {
        self.volumes.made
    }

    /// How many bytes of indirect light the last [`light`](Self::light) wrote to the device: those of sides whose light changed, or of all
    /// sides if others are lit than before.
    pub fn uploaded_bytes(&self) -> u64 {
        self.geometry.irradiance.uploaded_bytes()
    }

    /// Waits until the picture is done, and says how long its passes took.
    pub fn finish(&mut self) -> Result<Times, RasterError> {
        self.device.wait()?;
        self.stopwatch.read(&self.device)
    }

    fn drawn(&self) -> Result<&Targets, RasterError> {
        self.targets.as_ref().ok_or_else(|| RasterError::Lost("nothing was drawn yet".into()))
    }

    /// The picture: sRGB bytes, row by row from the top.
    pub fn picture(&self) -> Result<Vec<[u8; 3]>, RasterError> {
        let bytes = read(&self.device, &self.drawn()?.picture, 0)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect())
    }

    /// The linear light of every sample (see [`Settings::grid`]), and 1 where something is seen; row by row from the top.
    pub fn samples(&self) -> Result<Vec<[f32; 4]>, RasterError> {
        let bytes = read(&self.device, &self.drawn()?.light, 0)?;
        Ok(bytes.as_chunks::<16>().0.iter().map(|texel| bytemuck::pod_read_unaligned(texel)).collect())
    }

    /// For every sample, the object (by number) and its triangle that are seen.
    pub fn seen(&self) -> Result<Vec<Option<(usize, usize)>>, RasterError> {
        let bytes = read(&self.device, &self.drawn()?.ids, 0)?;
        let ids = bytes.as_chunks::<4>().0.iter().map(|id| u32::from_le_bytes(*id));
        Ok(ids.map(|id| (id > 0).then(|| self.geometry.source(id - 1))).collect())
    }

    /// For every sample, whether the `n`-th of the [`drawn_lamps`](Self::drawn_lamps) is in sight.
    pub fn mask(&self, n: usize) -> Result<Vec<bool>, RasterError> {
        let bytes = read(&self.device, &self.drawn()?.masks, (n / 4) as u32)?;
        Ok(bytes.as_chunks::<4>().0.iter().map(|texel| texel[n % 4] > 0).collect())
    }

    /// The exposure that was measured for the picture, per cd/m².
    pub fn exposure(&self) -> Result<f32, RasterError> {
        let bytes = read(&self.device, &self.drawn()?.exposure, 0)?;
        Ok(bytemuck::pod_read_unaligned(&bytes[..4]))
    }
}

fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    target: &wgpu::TextureView,
    load: LoadOp<wgpu::Color>,
    depth: Option<wgpu::RenderPassDepthStencilAttachment>,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites>,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load, store: StoreOp::Store },
        })],
        depth_stencil_attachment: depth,
        timestamp_writes,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}

/// Vertices of what the camera may see and that `counts`, in as few runs as there are gaps.
fn seen_vertices(geometry: &Geometry, camera: &Camera, counts: impl Fn(&Thing) -> bool) -> Vec<std::ops::Range<u32>> {
    let mut runs: Vec<std::ops::Range<u32>> = Vec::new();
    let seen = |thing: &&Thing| !thing.hidden && counts(thing) && camera.may_see(&thing.bounds);
    for thing in geometry.things.iter().filter(seen) {
        match runs.last_mut() {
            Some(run) if run.end == thing.vertices.start => run.end = thing.vertices.end,
            _ => runs.push(thing.vertices.clone()),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use lightmend_scene::{Edit, Scene};
    use std::path::Path;

    #[test]
    fn volumes_of_what_stands_still_are_kept() {
        let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/room/room.ron");
        let scene = Scene::read(&room).unwrap().0;
        let before = Configuration::initial(&scene);
        let mut renderer = Renderer::new(Arc::new(Device::headless().unwrap())).unwrap();
        let look = Look::Photograph { exposure: None };
        let settings = Settings { width: 64, height: 48, grid: 1, parts: Parts::RADIANCE, look };
        let mut made = |configuration: &Configuration| {
            renderer.show(configuration).unwrap();
            renderer.draw(&scene.cameras[0].1, &settings).unwrap();
            renderer.volumes_made()
        };
        assert!(made(&before) > 100, "at first all are new");
        assert_eq!(made(&before), 0, "nothing moves");
        let to = DVec3::new(2.0, 3.0, 0.0);
        let moved = before.apply(&Edit::Move { object: "table".into(), to }).unwrap();
        // The table, two cups, the bowl and its fruit, for each of four lamps at most.
        assert!((1..=20).contains(&made(&moved)));
        let to = DVec3::new(1.9, 3.0, 1.85);
        let lamp = moved.apply(&Edit::MoveLamp { lamp: "pendant".into(), to }).unwrap();
        let count = made(&lamp);
        assert!((20..=50).contains(&count), "all of one lamp: {count}");
    }

    #[test]
    fn a_lost_device_is_told() {
        let view = View { eye: DVec3::Y, target: DVec3::ZERO, fov: 40.0 };
        let settings = |width| Settings { width, height: 8, grid: 1, parts: Parts::RADIANCE, look: Look::Plain };
        // Lost before anything was drawn, and between two frames; the second of another size needs new textures.
        for (before, after) in [(None, 8), (Some(8), 8), (Some(8), 16)] {
            let mut renderer = Renderer::new(Arc::new(Device::headless().unwrap())).unwrap();
            if let Some(width) = before {
                renderer.draw(&view, &settings(width)).unwrap();
                renderer.finish().unwrap();
            }
            renderer.device().lose();
            let drawn = renderer.draw(&view, &settings(after));
            let finished = drawn.and_then(|()| renderer.finish().map(|_| ()));
            assert!(matches!(finished, Err(RasterError::Lost(_))), "{finished:?}");
            let light = renderer.light(&Vec::new());
            assert!(matches!(light, Err(RasterError::Lost(_))), "{light:?}");
            assert!(renderer.picture().is_err() && renderer.samples().is_err() && renderer.exposure().is_err());
            assert!(matches!(Renderer::new(renderer.device().clone()), Err(RasterError::Lost(_))));
        }
    }
}

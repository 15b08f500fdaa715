//! Panels and menus over the room. Drawing them takes a processor as long as a third of the room does, and they seldom change: they are
//! kept as a texture and copied. What lies over the room itself, marks and messages, is little and drawn every time.

use egui::{Context, Rect, epaint::ClippedShape};
use lightmend_raster::{Device, Screen};
use std::time::{Duration, Instant};
use wgpu::{CommandEncoder, LoadOp, Texture, TextureUsages};

/// While something moves, panels may be so old: numbers that change with every frame need not be read with every frame.
const OLD: Duration = Duration::from_millis(200);

/// Where the room is in the window.
pub struct Layout {
    /// Points.
    pub room: Rect,
    /// The same in pixels: left, top, width, height.
    pub place: [u32; 4],
    /// Of the window, pixels.
    pub size: [u32; 2],
    /// Pixels per point.
    pub points: f32,
    /// Whether something moves.
    pub in_hurry: bool,
}

struct Kept {
    texture: Texture,
    shapes: Vec<ClippedShape>,
    room: Rect,
    points: f32,
    since: Instant,
}

/// Draws panels.
pub struct Panels {
    /// Draws their shapes.
    pub egui: egui_wgpu::Renderer,
    kept: Option<Kept>,
    /// What they should look like by now.
    due: Option<Vec<ClippedShape>>,
}

impl Panels {
    /// For a window of this format.
    pub fn new(device: &Device, format: wgpu::TextureFormat) -> Panels {
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        Panels { egui: egui_wgpu::Renderer::new(&device.device, format, options), kept: None, due: None }
    }

    /// Draws `shapes` over the room that `encoder` draws into `target`, and submits both.
    pub fn draw(
        &mut self,
        device: &Device,
        screen: &Screen,
        mut encoder: CommandEncoder,
        target: &Texture,
        context: &Context,
        shapes: &[ClippedShape],
        layout: &Layout,
    ) {
        let over_room = |shape: &ClippedShape| shape.clip_rect == layout.room;
        let (marks, panels): (Vec<ClippedShape>, Vec<ClippedShape>) = shapes.iter().cloned().partition(over_room);
        // An open menu, a tooltip or a question reaches into the room.
        let reaches = |shape: &ClippedShape| {
            let seen = shape.shape.visual_bounding_rect().intersect(shape.clip_rect);
            seen.is_positive() && seen.intersect(layout.room.shrink(1.0)).is_positive()
        };
        if !screen.takes_copies() || panels.iter().any(reaches) {
            return self.paint(device, encoder, target, LoadOp::Load, context, shapes.to_vec(), layout);
        }
        let fits = |kept: &Kept| {
            let texture = &kept.texture;
            ([texture.width(), texture.height()], kept.room, kept.points) == (layout.size, layout.room, layout.points)
        };
        self.due = None;
        match self.kept.as_ref().filter(|kept| fits(kept)) {
            Some(kept) if kept.shapes == panels => {}
            // A frame in a hurry shows them as they were; there may be time to draw them after it.
            Some(kept) if layout.in_hurry => self.due = (kept.since.elapsed() > OLD).then_some(panels),
            _ => self.keep(device, screen, context, panels, layout),
        }
        if let Some(kept) = &self.kept {
            let ([left, top, width, height], [whole_width, whole_height]) = (layout.place, layout.size);
            let (right, bottom) = (left + width, top + height);
            let strips = [
                [0, 0, whole_width, top],
                [0, bottom, whole_width, whole_height - bottom],
                [0, top, left, height],
                [right, top, whole_width - right, height],
            ];
            for [x, y, width, height] in strips.into_iter().filter(|strip| strip[2] > 0 && strip[3] > 0) {
                let origin = wgpu::Origin3d { x, y, z: 0 };
                let part =
                    |texture| wgpu::TexelCopyTextureInfo { texture, mip_level: 0, origin, aspect: wgpu::TextureAspect::All };
                let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
                encoder.copy_texture_to_texture(part(&kept.texture), part(target), size);
            }
        }
        self.paint(device, encoder, target, LoadOp::Load, context, marks, layout);
    }

    /// Draws what was put off, once a frame is shown.
    pub fn catch_up(&mut self, device: &Device, screen: &Screen, context: &Context, layout: &Layout) {
        if let Some(panels) = self.due.take() {
            self.keep(device, screen, context, panels, layout);
        }
    }

    /// Draws panels into the texture that is copied from.
    fn keep(&mut self, device: &Device, screen: &Screen, context: &Context, panels: Vec<ClippedShape>, layout: &Layout) {
        let [width, height] = layout.size;
        let same_size = |kept: &Kept| [kept.texture.width(), kept.texture.height()] == layout.size;
        let texture = self.kept.take().filter(same_size).map(|kept| kept.texture).unwrap_or_else(|| {
            device.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("panels"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: screen.format(),
                usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
                view_formats: &[],
            })
        });
        // Submitted before the rest: both use the same buffers.
        let own = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.paint(device, own, &texture, LoadOp::Clear(wgpu::Color::BLACK), context, panels.clone(), layout);
        self.kept = Some(Kept { texture, shapes: panels, room: layout.room, points: layout.points, since: Instant::now() });
    }

    /// Draws `shapes`, and submits all that `encoder` holds.
    fn paint(
        &mut self,
        device: &Device,
        mut encoder: CommandEncoder,
        target: &Texture,
        load: LoadOp<wgpu::Color>,
        context: &Context,
        shapes: Vec<ClippedShape>,
        layout: &Layout,
    ) {
        let primitives = context.tessellate(shapes, layout.points);
        let descriptor = egui_wgpu::ScreenDescriptor { size_in_pixels: layout.size, pixels_per_point: layout.points };
        let more = self.egui.update_buffers(&device.device, &device.queue, &mut encoder, &primitives, &descriptor);
        {
            let view = target.create_view(&wgpu::TextureViewDescriptor::default());
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("panels"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            self.egui.render(&mut pass.forget_lifetime(), &primitives, &descriptor);
        }
        device.queue.submit(more.into_iter().chain([encoder.finish()]));
    }
}

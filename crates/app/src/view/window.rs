//! The window: events in, frames out, at the rate that was asked for.
//!
//! A frame takes all events that have come, lets the desk act on them, draws the room if it is seen otherwise than before, and waits
//! until it is shown; so what the mouse did is in the next frame that is begun after it. Nothing here waits for photons: their light is
//! read by a thread of its own and taken when it is there. While nothing changes, nothing is drawn.

mod requests;

use super::{
    desk::{Desk, HOVERED, Pace, Request, SELECTED},
    dialogs,
    governor::{Governor, Quality},
    light::Ready,
    overlay::{Layout, Panels},
    report::Report,
    session::{Selection, Start},
};
use crate::{PoolArguments, failure::Failure, frames, progress};
use egui::{Color32, Context, ViewportId};
use egui_winit::winit::{
    application::ApplicationHandler,
    dpi::LogicalSize,
    event::{ElementState, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy},
    window::{Window, WindowId},
};
use lightmend_photon::solver::Method;
use lightmend_raster::{Device, Mark, RasterError, Renderer, Screen, Settings};
use lightmend_scene::View;
use std::{
    collections::VecDeque,
    sync::Arc,
    time::{Duration, Instant},
};

/// There is new light.
#[derive(Debug, Clone, Copy)]
pub struct Wake;

/// All that is lost with a device.
struct Graphics {
    device: Arc<Device>,
    screen: Screen,
    renderer: Renderer,
    panels: Panels,
    egui: egui_winit::State,
    context: Context,
}

/// What the picture on the device shows.
#[derive(Clone, PartialEq)]
struct Drawn {
    revision: u64,
    view: View,
    settings: Settings,
}

/// The program while its window is open.
pub struct App {
    pub desk: Desk,
    pub report: Report,
    pub failure: Option<Failure>,
    start: Start,
    pool: PoolArguments,
    size: [u32; 2],
    proxy: EventLoopProxy<Wake>,
    window: Option<Arc<Window>>,
    graphics: Option<Graphics>,
    governor: Governor,
    drawn: Option<Drawn>,
    quality: Quality,
    /// The light in the picture, and when it came there.
    light: Option<Arc<Ready>>,
    lit: Instant,
    /// Something happened that the next frame shows.
    stirred: bool,
    /// When egui wants another frame.
    egui_wants: Option<Instant>,
    last_frame: Instant,
    /// Frames that were shown, of the last second.
    shown: VecDeque<Instant>,
    durations: VecDeque<f64>,
    /// A person did something that no frame has shown yet.
    event: Option<Instant>,
    /// Devices lost in a row, without a frame between them.
    lost: u32,
    title: String,
    asked_about_kept: bool,
}

/// More devices than this in a row are not lost by chance.
const MOST_LOST: u32 = 3;

/// Light that is right and sharpens is shown this often.
const SHARPER: Duration = Duration::from_secs(1);

impl App {
    /// Before its window is open.
    pub fn new(desk: Desk, start: Start, pool: PoolArguments, size: [u32; 2], proxy: EventLoopProxy<Wake>) -> App {
        App {
            governor: Governor::new(desk.fps, true),
            desk,
            report: Report::default(),
            failure: None,
            start,
            pool,
            size,
            proxy,
            window: None,
            graphics: None,
            drawn: None,
            quality: Quality { eighths: 8, grid: 1 },
            light: None,
            lit: Instant::now(),
            stirred: true,
            egui_wants: None,
            last_frame: Instant::now(),
            shown: VecDeque::new(),
            durations: VecDeque::new(),
            event: None,
            lost: 0,
            title: String::new(),
            asked_about_kept: false,
        }
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), Failure> {
        let window = match &self.window {
            Some(window) => window.clone(),
            None => {
                let [width, height] = self.size;
                let attributes =
                    Window::default_attributes().with_title("Lightmend").with_inner_size(LogicalSize::new(width, height));
                let window = event_loop.create_window(attributes).map_err(|e| {
                    Failure::failed(format!("no window can be opened: {e}; `lightmend frames` draws without one"))
                })?;
                self.window.insert(Arc::new(window)).clone()
            }
        };
        let (device, screen) = Screen::new(window.clone(), window.inner_size().into())?;
        let context = Context::default();
        context.set_theme(egui::Theme::Dark);
        let egui = egui_winit::State::new(
            context.clone(),
            ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(device.largest_side() as usize),
        );
        let panels = Panels::new(&device, screen.format());
        let mut renderer = Renderer::new(device.clone())?;
        renderer.show(&self.desk.session.configuration)?;
        self.desk.driver = device.name.clone();
        self.governor = Governor::new(self.desk.fps, device.on_processor);
        self.graphics = Some(Graphics { device, screen, renderer, panels, egui, context });
        (self.drawn, self.light, self.stirred) = (None, None, true);
        // The new panels know of no button that is down: nobody would tell of its release.
        self.desk.viewport.let_go(&mut self.desk.session);
        Ok(())
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, failure: Failure) {
        let kept = self.desk.session.keep().map(|path| format!("what was not saved is kept in {}", path.display()));
        let failure = kept.map_or(Failure::failed(&failure), |kept| Failure::failed(&failure).with(&kept));
        self.failure.get_or_insert(failure);
        event_loop.exit();
    }

    /// A frame, or what went wrong with it.
    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        match self.try_frame(event_loop) {
            Ok(()) => {}
            Err(RasterError::Lost(why)) if self.lost < MOST_LOST => {
                self.lost += 1;
                self.desk.session.messages.warn(format!("the graphics device was lost and is taken anew: {why}"));
                self.graphics = None;
                if let Err(failure) = self.open(event_loop) {
                    self.fail(event_loop, failure);
                }
            }
            // What was added last is more than the device can hold.
            Err(error @ (RasterError::TooLarge { .. } | RasterError::Lamps { .. }))
                if self.desk.session.history.last_done().is_some() =>
            {
                self.desk.session.undo();
                self.desk.session.messages.fail(error.to_string());
                self.stirred = true;
            }
            Err(error) => self.fail(event_loop, error.into()),
        }
    }

    fn try_frame(&mut self, event_loop: &ActiveEventLoop) -> Result<(), RasterError> {
        let (Some(window), Some(mut graphics)) = (self.window.clone(), self.graphics.take()) else { return Ok(()) };
        let start = Instant::now();
        let seconds = (start - self.last_frame).as_secs_f64();
        let event = self.event.take();
        self.stirred = false;
        let input = graphics.egui.take_egui_input(&window);
        let mut walks = false;
        let desk = &mut self.desk;
        let output = graphics.context.run_ui(input, |ui| walks = desk.ui(ui, seconds));
        graphics.egui.handle_platform_output(&window, output.platform_output);
        let delay = output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        self.desk.pace.desk = start.elapsed().as_secs_f64() * 1000.0;
        self.egui_wants = delay.and_then(|delay| Instant::now().checked_add(delay));
        self.stirred |= walks || self.desk.session.playback.is_some();
        self.governor.fps = self.desk.fps;

        let mut textures = output.textures_delta;
        let result = self.draw(&window, &mut graphics, &output.shapes, &textures, output.pixels_per_point);
        match &result {
            Ok(Some((room, layout))) => {
                self.lost = 0;
                self.account(start, *room, event);
                graphics.panels.catch_up(&graphics.device, &graphics.screen, &graphics.context, layout);
            }
            // Nothing is shown: there is time.
            Ok(None) => std::thread::sleep(Duration::from_millis(10)),
            Err(_) => {}
        }
        textures.free.iter().for_each(|id| graphics.panels.egui.free_texture(id));
        textures.clear();
        self.graphics = Some(graphics);
        result?;
        self.answer(event_loop, &window)?;
        let title = self.desk.title();
        if title != self.title {
            window.set_title(&title);
            self.title = title;
        }
        self.last_frame = start;
        Ok(())
    }

    /// Draws the room if need be, and the window. How long the room took (none if it was left as it was), and where it is; `None` if
    /// nothing can be shown.
    fn draw(
        &mut self,
        window: &Window,
        graphics: &mut Graphics,
        shapes: &[egui::epaint::ClippedShape],
        textures: &egui::TexturesDelta,
        points: f32,
    ) -> Result<Option<(Option<Duration>, Layout)>, RasterError> {
        let Graphics { device, screen, renderer, panels, context, .. } = graphics;
        let wanted: [u32; 2] = window.inner_size().into();
        if screen.size() != wanted {
            screen.resize(device, wanted);
        }
        for (id, deltas) in &textures.set {
            for delta in deltas {
                panels.egui.update_texture(&device.device, &device.queue, *id, delta);
            }
        }
        let Some(target) = screen.frame(device)? else {
            return Ok(None);
        };
        let size = screen.size();
        let rect = self.desk.viewport.rect;
        let pixel = |at: f32, most: u32| ((at * points).round().max(0.0) as u32).min(most);
        let [left, top] = [pixel(rect.left(), size[0]), pixel(rect.top(), size[1])];
        let place =
            [left, top, pixel(rect.right(), size[0]).saturating_sub(left), pixel(rect.bottom(), size[1]).saturating_sub(top)];
        let room = if place[2] > 0 && place[3] > 0 { Self::room(self, renderer, [place[2], place[3]])? } else { None };

        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let view = target.texture.create_view(&wgpu::TextureViewDescriptor::default());
        renderer.present(&mut encoder, &view, screen.format(), place, &self.marks())?;
        let layout = Layout { room: rect, place, size, points, in_hurry: self.governor.is_moving() };
        panels.draw(device, screen, encoder, &target.texture, context, shapes, &layout);
        window.pre_present_notify();
        screen.present(device, target);
        // The next frame begins with what the person did until this one was there, not until it was begun.
        device.wait()?;
        Ok(Some((room, layout)))
    }

    /// Draws the room unless the picture shows it already. How long that took.
    fn room(&mut self, renderer: &mut Renderer, size: [u32; 2]) -> Result<Option<Duration>, RasterError> {
        let start = Instant::now();
        let session = &self.desk.session;
        let (revision, view) = (session.revision(), session.navigation.view());
        if self.drawn.as_ref().is_some_and(|drawn| drawn.revision != revision || drawn.view != view) {
            self.governor.moves();
        }
        // Light that came in is shown when it is time for it.
        let ready = session.light.ready();
        let coming = self.coming(ready.as_deref());
        let new = ready.clone().filter(|ready| !self.light.as_ref().is_some_and(|shown| Arc::ptr_eq(shown, ready)));
        let pause = match coming {
            true => self.governor.pause_for_light(),
            // Light that is right and only sharpens does not keep the machine busy.
            false => ready.filter(|ready| ready.snapshot.grows).map_or(Duration::ZERO, |_| SHARPER),
        };
        let lit = new.filter(|_| self.light.is_none() || self.lit.elapsed() >= pause);
        // Twice as many samples along each side may be more than a texture can have.
        let too_large = |quality: Quality| size.iter().any(|side| side * quality.grid > renderer.device().largest_side());
        let quality = if self.drawn.is_none() || self.governor.is_moving() || lit.is_some() || self.governor.wants_finer(coming) {
            self.governor.quality(coming)
        } else {
            self.quality
        };
        let quality = if too_large(quality) { Quality { grid: 1, ..quality } } else { quality };
        let shown = self.shown_settings(quality.pixels(size), quality.grid);
        let wanted = Drawn { revision, view, settings: shown };
        if self.drawn.as_ref() == Some(&wanted) && lit.is_none() {
            return Ok(None);
        }
        renderer.show(&session.configuration)?;
        if let Some(ready) = lit {
            renderer.light(&ready.indirect)?;
            if let Method::Groups { refused: Some(why), .. } = ready.snapshot.method {
                let cost = "photons that an edit makes wrong are searched for, which takes several times as long";
                self.desk.session.messages.warn(format!("{why} (--memory): {cost}"));
            }
            (self.light, self.lit) = (Some(ready), Instant::now());
        }
        renderer.draw(&view, &shown)?;
        let times = renderer.finish()?;
        let took = start.elapsed();
        self.governor.drew(quality, took);
        self.quality = quality;
        self.drawn = Some(wanted);
        for warning in renderer.warnings() {
            self.desk.session.messages.warn(warning);
        }
        let first_light = self.light.as_ref().is_some_and(|ready| ready.snapshot.photons >= ready.snapshot.pool_photons);
        if self.desk.range.is_none() && self.desk.found_range.is_none() && first_light {
            let ranged = self.desk.show.ranged(&shown, true, || renderer.samples());
            // A scale that cannot be found is the usual one.
            self.desk.found_range = ranged.ok().flatten().and_then(|settings| frames::Range::of(settings.look));
            self.stirred |= self.desk.found_range.is_some();
        }
        self.desk.pace = Pace { times, pixels: [shown.width, shown.height], samples: shown.grid, ..self.desk.pace };
        Ok(Some(took))
    }

    /// Whether more light will come by itself.
    fn coming(&self, ready: Option<&Ready>) -> bool {
        let session = &self.desk.session;
        let paused = session.solver.controls().paused;
        ready.is_none_or(|ready| !(ready.snapshot.exact || paused) || ready.snapshot.edits < session.edits())
    }

    fn shown_settings(&self, size: [u32; 2], grid: u32) -> Settings {
        let desk = &self.desk;
        desk.show.settings(size, grid, desk.range.or(desk.found_range), desk.exposure)
    }

    /// Outlines: what is selected, what the pointer is over.
    fn marks(&self) -> Vec<Mark> {
        let desk = &self.desk;
        let colour = |colour: Color32| colour.to_normalized_gamma_f32();
        let mark = |selection: Option<Selection>, shade: Color32| match selection {
            Some(Selection::Object(object)) if desk.session.configuration.has_object(object) => {
                Some(Mark { object, colour: colour(shade) })
            }
            _ => None,
        };
        let movable = |s: &Selection| matches!(s, Selection::Object(id) if desk.session.configuration.has_object(*id) && desk.session.configuration.object(*id).movable);
        let hovered = desk.viewport.hovered.filter(movable).filter(|h| Some(*h) != desk.session.selection);
        let hovered = hovered.filter(|_| !desk.viewport.is_busy());
        [mark(hovered, HOVERED), mark(desk.session.selection, SELECTED)].into_iter().flatten().collect()
    }

    fn account(&mut self, start: Instant, room: Option<Duration>, event: Option<Instant>) {
        let now = Instant::now();
        let took = (now - start).as_secs_f64() * 1000.0;
        self.desk.pace.showing = took - self.desk.pace.desk - room.map_or(0.0, |room| room.as_secs_f64() * 1000.0);
        self.shown.push_back(now);
        while self.shown.front().is_some_and(|at| now - *at > Duration::from_secs(1)) {
            self.shown.pop_front();
        }
        if room.is_some() {
            self.durations.push_back(took);
            if self.durations.len() > 100 {
                self.durations.pop_front();
            }
            self.desk.pace.frame = took;
            self.desk.pace.longest = self.durations.iter().copied().fold(0.0, f64::max);
        }
        self.desk.pace.fps = if self.governor.is_moving() { self.shown.len() as f64 } else { 0.0 };
        self.report.frame(&self.desk, now, took, room, event);
    }

    /// When the next frame is due; `None` if nothing needs one.
    fn due(&self) -> Option<Instant> {
        let soon = self.last_frame + self.governor.period();
        let session = &self.desk.session;
        let mut due: Vec<Instant> = Vec::new();
        if self.stirred {
            due.push(soon);
        }
        due.extend(self.egui_wants.map(|wanted| wanted.max(soon)));
        let new = session.light.ready().is_some_and(|ready| !self.light.as_ref().is_some_and(|shown| Arc::ptr_eq(shown, &ready)));
        if new && self.desk.viewport.rect.is_positive() {
            due.push((self.lit + self.governor.pause_for_light()).max(soon));
        }
        let coming = self.coming(self.light.as_deref());
        if self.drawn.is_some() && self.desk.viewport.rect.is_positive() {
            due.extend(self.governor.finer_at(coming));
            due.extend(self.governor.wants_finer(coming).then_some(soon));
        }
        if session.keeps_waiting() {
            due.push(self.last_frame + Duration::from_millis(200));
        }
        due.into_iter().min()
    }
}

impl ApplicationHandler<Wake> for App {
    fn exiting(&mut self, _: &ActiveEventLoop) {
        // What is still to be written takes a while: no frozen window stands there meanwhile.
        (self.graphics, self.window) = (None, None);
    }

    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.graphics.is_none()
            && let Err(failure) = self.open(event_loop)
        {
            return self.fail(event_loop, failure);
        }
        if !std::mem::replace(&mut self.asked_about_kept, true) {
            self.desk.dialog = dialogs::kept_before(&self.desk.session.path.clone());
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, _: Wake) {}

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let WindowEvent::RedrawRequested = event {
            return self.frame(event_loop);
        }
        let (Some(window), Some(graphics)) = (&self.window, &mut self.graphics) else { return };
        self.stirred |= graphics.egui.on_window_event(window, &event).repaint;
        match event {
            WindowEvent::CloseRequested => {
                self.desk.quit();
                self.stirred = true;
                // A window that is not shown draws no frame that would ask or obey.
                if let Some(Request::Quit { thrown_away }) = self.desk.requests.last() {
                    let thrown_away = *thrown_away;
                    self.quit(event_loop, thrown_away);
                } else {
                    window.set_minimized(false);
                    window.focus_window();
                }
            }
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } | WindowEvent::Occluded(false) => {
                self.stirred = true
            }
            WindowEvent::CursorMoved { .. }
            | WindowEvent::MouseWheel { .. }
            | WindowEvent::MouseInput { state: ElementState::Pressed, .. } => {
                self.event.get_or_insert_with(Instant::now);
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if progress::interrupted() {
            return self.fail(event_loop, Failure::failed("interrupted"));
        }
        let Some(window) = &self.window else { return };
        // Ctrl-C on the terminal is noticed at least so often.
        let patience = Instant::now() + Duration::from_millis(300);
        let due = self.due().map_or(patience, |due| due.min(patience));
        let hidden = window.is_minimized() == Some(true) || window.inner_size().width == 0 || window.inner_size().height == 0;
        if !hidden && self.due().is_some_and(|due| due <= Instant::now()) {
            window.request_redraw();
            // Some compositors ask for no frame of a window that they hide.
            event_loop.set_control_flow(ControlFlow::WaitUntil(patience));
        } else {
            event_loop.set_control_flow(ControlFlow::WaitUntil(if hidden { patience } else { due }));
        }
        // Without frames time still passes: changes are kept, scripts play.
        if self.last_frame.elapsed() > Duration::from_millis(300) {
            self.desk.session.tick();
        }
    }
}

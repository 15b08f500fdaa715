//! What the desk asks of the window: pictures, other scenes, the end.

use super::{App, Wake};
use crate::{
    failure::Failure,
    frames, output,
    view::{
        desk::Request,
        dialogs,
        session::{Session, Start},
    },
};
use egui_winit::winit::{
    event_loop::ActiveEventLoop,
    window::{Fullscreen, Window},
};
use lightmend_raster::RasterError;
use lightmend_scene::Scene;
use std::path::{Path, PathBuf};

impl App {
    /// What the desk asked for.
    pub(super) fn answer(&mut self, event_loop: &ActiveEventLoop, window: &Window) -> Result<(), RasterError> {
        for request in std::mem::take(&mut self.desk.requests) {
            self.stirred = true;
            match request {
                Request::Quit { thrown_away } => self.quit(event_loop, thrown_away),
                Request::FullScreen => {
                    let fullscreen = window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                    window.set_fullscreen(fullscreen);
                }
                Request::RestartGraphics => {
                    if let Some(graphics) = &self.graphics {
                        graphics.device.lose();
                    }
                }
                Request::Open { scene, save_as, thrown_away } => match self.session(&scene, &save_as) {
                    Ok(session) => self.take(session, thrown_away, scene == save_as),
                    Err(failure) => {
                        self.desk.session.messages.fail(failure.to_string());
                        if scene != save_as {
                            self.desk.dialog = dialogs::kept_before(&save_as);
                        }
                    }
                },
                Request::Picture { path, exr } => {
                    let written = self.picture(&path, exr);
                    let messages = &mut self.desk.session.messages;
                    match written {
                        Ok(()) => messages.say(format!("Written: {}", path.display())),
                        Err(failure) => messages.fail(failure.to_string()),
                    }
                    self.drawn = None;
                    if let Some(graphics) = &self.graphics {
                        graphics.device.check()?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The end. What is not saved was thrown away, or there is nothing.
    pub(super) fn quit(&mut self, event_loop: &ActiveEventLoop, thrown_away: bool) {
        self.desk.session.leave(thrown_away);
        event_loop.exit();
    }

    /// Another scene instead of this one. `asks` about what was kept of an earlier run of it.
    pub(super) fn take(&mut self, mut session: Session, thrown_away: bool, asks: bool) {
        let old = &mut self.desk.session;
        if let Some(record) = old.record.clone() {
            match old.write_recording(&record) {
                // What follows is about another scene: a file of its own.
                Ok(()) => session.record = Some(next_name(&record)),
                Err(error) => session.messages.fail(error.to_string()),
            }
        }
        old.leave(thrown_away);
        self.desk.take(session);
        if asks {
            self.desk.dialog = dialogs::kept_before(&self.desk.session.path);
        }
        (self.drawn, self.light) = (None, None);
    }

    pub(super) fn session(&self, scene: &Path, save_as: &Path) -> Result<Session, Failure> {
        let (read, warnings) = Scene::read(scene)?;
        let proxy = self.proxy.clone();
        // The loop may be over by then: nobody needs to be woken any more.
        let wake = move || {
            let _ = proxy.send_event(Wake);
        };
        let start = Start { pool: self.pool.pool(&read)?, ..self.start };
        let mut session = Session::start(read, save_as.to_owned(), start, wake)?;
        warnings.iter().for_each(|warning| session.messages.warn(warning.to_string()));
        if scene != save_as {
            session.differs_from_file();
        }
        Ok(session)
    }

    /// What is seen, with smooth edges, in the window's own pixels.
    pub(super) fn picture(&mut self, path: &Path, exr: bool) -> Result<(), Failure> {
        let Some(graphics) = &mut self.graphics else { return Ok(()) };
        let points = graphics.context.pixels_per_point();
        let rect = self.desk.viewport.rect;
        let size = [rect.width(), rect.height()].map(|side| (side * points).round().max(1.0) as u32);
        let view = self.desk.session.navigation.view();
        let settings = self.desk.show.settings(size, 2, self.desk.range.or(self.desk.found_range), self.desk.exposure);
        let renderer = &mut graphics.renderer;
        if exr {
            return frames::exr::write(path, renderer, &view, &settings, &self.desk.session.configuration);
        }
        renderer.draw(&view, &settings)?;
        let pixels = renderer.picture()?.into_flattened();
        let picture =
            image::RgbImage::from_raw(size[0], size[1], pixels).ok_or_else(|| Failure::failed("the picture has no pixels"))?;
        output::png(path, &frames::with_legend(picture, self.desk.show, &settings)?)
    }
}

/// `walk.ron`, `walk-2.ron`, `walk-3.ron`.
fn next_name(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let (stem, number) =
        match stem.rsplit_once('-').and_then(|(stem, number)| Some((stem.to_owned(), number.parse::<u64>().ok()?))) {
            Some((stem, number)) => (stem, number + 1),
            None => (stem, 2),
        };
    path.with_file_name(format!("{stem}-{number}")).with_extension(path.extension().unwrap_or_default())
}

//! A film of the frames, if ffmpeg is installed.

use crate::failure::Failure;
use image::RgbImage;
use std::{
    io::Write,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
};

/// Its name in the folder.
pub const FILE: &str = "film.mp4";

/// ffmpeg at work.
pub struct Film {
    child: Child,
    beside: PathBuf,
}

impl Film {
    /// Starts ffmpeg; `None` if it is not there.
    pub fn start(out: &Path, fps: f64) -> Option<Film> {
        let beside = out.join(format!(".film.{}.part", std::process::id()));
        let mut command = Command::new("ffmpeg");
        command.args([
            "-loglevel",
            "error",
            "-y",
            "-f",
            "image2pipe",
            "-codec:v",
            "ppm",
            "-framerate",
            &fps.to_string(),
            "-i",
            "-",
        ]);
        // H.264 in this form has sides of even numbers of pixels.
        command.args(["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]);
        // Ctrl-C on the terminal is for us: the film ends with the last finished frame.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command.args(["-pix_fmt", "yuv420p", "-f", "mp4"]).arg(&beside);
        let child = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()?;
        Some(Film { child, beside })
    }

    /// Adds a frame.
    pub fn add(&mut self, picture: &RgbImage) {
        if let Some(stdin) = &mut self.child.stdin {
            let header = format!("P6\n{} {}\n255\n", picture.width(), picture.height());
            // If ffmpeg has gone away, its exit status says so at the end.
            let _ = stdin.write_all(header.as_bytes()).and_then(|()| stdin.write_all(picture));
        }
    }

    /// Ends the film; its name, or `None` with a warning, unless `quiet`, if ffmpeg failed.
    pub fn finish(mut self, out: &Path, quiet: bool) -> Result<Option<&'static str>, Failure> {
        drop(self.child.stdin.take());
        let done = self.child.wait().is_ok_and(|status| status.success()) && self.beside.is_file();
        if !done {
            // What it left is of no use.
            let _ = std::fs::remove_file(&self.beside);
            if !quiet {
                eprintln!("warning: ffmpeg failed: there is no film, but the frames are there");
            }
            return Ok(None);
        }
        let path = out.join(FILE);
        std::fs::rename(&self.beside, &path)
            .map_err(|e| Failure::failed(format!("{}: cannot be written: {e}", path.display())))?;
        Ok(Some(FILE))
    }
}

//! A screen without a monitor, a mouse and a keyboard on it: Xvfb, and events by the XTEST extension, which programs cannot tell from
//! those of hands.

use image::RgbImage;
use std::{
    io::{BufRead, BufReader},
    path::Path,
    process::{Child, Command, Stdio},
    sync::{Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};
use x11rb::{
    connection::Connection,
    protocol::{
        xproto::{
            AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ConnectionExt, ImageFormat, InputFocus, KEY_PRESS_EVENT,
            KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, Window,
        },
        xtest::ConnectionExt as XTest,
    },
    rust_connection::RustConnection,
};

/// Pixels.
pub const SIZE: [u16; 2] = [1280, 800];

/// One at a time: two programs that draw on two cores would wait for each other.
static ONE: Mutex<()> = Mutex::new(());

/// An X server of its own.
pub struct Screen {
    _one: MutexGuard<'static, ()>,
    server: Child,
    /// For `DISPLAY`.
    pub display: String,
    x: RustConnection,
    root: Window,
}

/// Keys by their X11 names.
pub mod keys {
    pub const ESCAPE: u32 = 0xff1b;
    pub const F1: u32 = 0xffbe;
    pub const F12: u32 = 0xffc9;
    pub const CONTROL: u32 = 0xffe3;
    pub const SHIFT: u32 = 0xffe1;
}

impl Screen {
    /// `None`, and a line that says so, if there is no Xvfb.
    pub fn start() -> Option<Screen> {
        let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-screen", "0", &format!("{}x{}x24", SIZE[0], SIZE[1]), "-nolisten", "tcp"]);
        let Ok(mut server) = server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn() else {
            eprintln!("SKIPPED: there is no Xvfb (apt-get install xvfb)");
            return None;
        };
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let (x, screen) = x11rb::connect(Some(&display)).unwrap();
        let root = x.setup().roots[screen].root;
        Some(Screen { _one: one, server, display, x, root })
    }

    fn fake(&self, kind: u8, detail: u8, x: i16, y: i16) {
        self.x.xtest_fake_input(kind, detail, 0, self.root, x, y, 0).unwrap().check().unwrap();
    }

    /// The pointer is now here, pixels.
    pub fn point(&self, [x, y]: [i32; 2]) {
        self.fake(MOTION_NOTIFY_EVENT, 0, x as i16, y as i16);
    }

    /// A button goes down: 1 left, 2 middle, 3 right, 4 and 5 the wheel up and down.
    pub fn press(&self, button: u8) {
        self.fake(BUTTON_PRESS_EVENT, button, 0, 0);
    }

    /// And up.
    pub fn release(&self, button: u8) {
        self.fake(BUTTON_RELEASE_EVENT, button, 0, 0);
    }

    /// A click with the left button.
    pub fn click(&self, at: [i32; 2]) {
        self.point(at);
        pause(60);
        self.press(1);
        pause(40);
        self.release(1);
    }

    /// A drag with a button, in steps, like a hand.
    pub fn drag(&self, button: u8, from: [i32; 2], to: [i32; 2], steps: i32) {
        self.point(from);
        pause(100);
        self.press(button);
        for step in 1..=steps {
            self.point([0, 1].map(|i| from[i] + (to[i] - from[i]) * step / steps));
            pause(30);
        }
        self.release(button);
    }

    fn keycode(&self, keysym: u32) -> u8 {
        let setup = self.x.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let map = self.x.get_keyboard_mapping(first, last - first + 1).unwrap().reply().unwrap();
        let per = usize::from(map.keysyms_per_keycode);
        let place = map.keysyms.chunks(per).position(|syms| syms.first() == Some(&keysym)).unwrap();
        first + place as u8
    }

    /// A key goes down. Letters by their lower case.
    pub fn key_down(&self, keysym: u32) {
        self.fake(KEY_PRESS_EVENT, self.keycode(keysym), 0, 0);
    }

    /// And up.
    pub fn key_up(&self, keysym: u32) {
        self.fake(KEY_RELEASE_EVENT, self.keycode(keysym), 0, 0);
    }

    /// A key, with others held.
    pub fn key(&self, held: &[u32], keysym: u32) {
        held.iter().for_each(|k| self.key_down(*k));
        self.key_down(keysym);
        pause(30);
        self.key_up(keysym);
        held.iter().rev().for_each(|k| self.key_up(*k));
        pause(60);
    }

    /// What is on the screen.
    pub fn picture(&self) -> RgbImage {
        let image = self.x.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, SIZE[0], SIZE[1], !0).unwrap().reply().unwrap();
        let rgb = image.data.chunks_exact(4).flat_map(|bgrx| [bgrx[2], bgrx[1], bgrx[0]]).collect();
        RgbImage::from_raw(u32::from(SIZE[0]), u32::from(SIZE[1]), rgb).unwrap()
    }

    /// A part of the screen, quickly.
    pub fn part(&self, at: [i32; 2], size: u16) -> Vec<u8> {
        let [x, y] = at.map(|v| v as i16);
        self.x.get_image(ImageFormat::Z_PIXMAP, self.root, x, y, size, size, !0).unwrap().reply().unwrap().data
    }

    /// What is on the screen once nothing has changed there for two seconds: light is exact, edges are smooth, messages are gone.
    pub fn still(&self) -> RgbImage {
        let (start, mut since, mut last) = (Instant::now(), Instant::now(), self.picture());
        while since.elapsed() < Duration::from_secs(2) && start.elapsed() < Duration::from_secs(60) {
            pause(200);
            let now = self.picture();
            if now != last {
                (since, last) = (Instant::now(), now);
            }
        }
        last
    }

    /// Keeps what is on the screen.
    pub fn keep(&self, path: &Path) {
        self.picture().save(path).unwrap();
    }

    /// The program's window and its title; it has the keyboard from then on.
    fn window(&self) -> Option<(Window, String)> {
        let name = self.x.intern_atom(false, b"_NET_WM_NAME").unwrap().reply().unwrap().atom;
        let children = self.x.query_tree(self.root).unwrap().reply().unwrap().children;
        children.into_iter().find_map(|window| {
            let title = self.x.get_property(false, window, name, AtomEnum::ANY, 0, 200).ok()?.reply().ok()?;
            let title = String::from_utf8(title.value).ok()?;
            title.contains("Lightmend").then_some((window, title))
        })
    }

    /// What the window is called; nothing if there is none.
    pub fn title(&self) -> String {
        self.window().map_or(String::new(), |(_, title)| title)
    }

    /// Gives the program's window the keyboard.
    pub fn focus(&self) {
        if let Some((window, _)) = self.window() {
            self.x.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap().check().unwrap();
        }
    }

    /// Makes the window so large.
    pub fn resize(&self, [width, height]: [u32; 2]) {
        if let Some((window, _)) = self.window() {
            let size = x11rb::protocol::xproto::ConfigureWindowAux::new().width(width).height(height);
            self.x.configure_window(window, &size).unwrap().check().unwrap();
        }
    }

    /// Takes the window off the screen, or puts it back.
    pub fn map(&self, shown: bool) {
        if let Some((window, _)) = self.window() {
            match shown {
                true => self.x.map_window(window).unwrap().check().unwrap(),
                false => self.x.unmap_window(window).unwrap().check().unwrap(),
            }
        }
    }

    /// Waits until the window's title says something.
    pub fn wait_for_title(&self, what: &str) {
        self.wait(&format!("a title with '{what}'"), || self.title().contains(what));
    }

    /// Waits until something is so; a minute is more than anything takes, also on a busy machine.
    pub fn wait(&self, what: &str, so: impl Fn() -> bool) {
        let start = Instant::now();
        while !so() {
            if start.elapsed() > Duration::from_secs(60) {
                let picture = super::program::pictures().join("waited_in_vain.png");
                self.keep(&picture);
                panic!("waited in vain for {what}; the title is '{}'; see {}", self.title(), picture.display());
            }
            pause(50);
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // It holds nothing that anyone needs.
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Milliseconds.
pub fn pause(milliseconds: u64) {
    std::thread::sleep(Duration::from_millis(milliseconds));
}

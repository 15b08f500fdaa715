//! How the light is: what is still wrong, how fast it is mended, how sure it is, and how the work goes on.

use super::chart;
use crate::view::{commands::Command, desk::Desk, light::Ready};
use egui::{ComboBox, ProgressBar, Slider, Ui, vec2};
use lightmend_photon::solver::{Method, Order};
use std::{
    collections::VecDeque,
    time::{Duration, Instant},
};

/// Photons and rays a second, over the last second or two.
#[derive(Debug, Default)]
pub struct Rates {
    seen: VecDeque<(Instant, u64, u64)>,
}

impl Rates {
    /// Work done so far.
    fn note(&mut self, photons: u64, rays: u64) {
        if self.seen.back().is_none_or(|last| (last.1, last.2) != (photons, rays)) {
            self.seen.push_back((Instant::now(), photons, rays));
        }
        while self.seen.len() > 2 && self.seen.front().is_some_and(|first| first.0.elapsed() > Duration::from_millis(1500)) {
            self.seen.pop_front();
        }
    }

    /// Photons and rays a second; none while nothing is traced.
    fn rates(&self) -> Option<[f64; 2]> {
        let (first, last) = (self.seen.front()?, self.seen.back()?);
        let seconds = (last.0 - first.0).as_secs_f64();
        let idle = last.0.elapsed() > Duration::from_millis(700);
        (seconds > 0.05 && !idle).then(|| [(last.1 - first.1) as f64 / seconds, (last.2 - first.2) as f64 / seconds])
    }
}

/// What is offered as the goal of sharpening where there was none, a share.
const FINEST: f64 = 0.01;

/// How much of the pool is still to be shot, per cent.
pub fn outstanding_percent(ready: &Ready) -> f64 {
    100.0 * ready.snapshot.outstanding_photons as f64 / ready.snapshot.pool_photons.max(1) as f64
}

/// "1.2 M".
fn short(count: f64) -> String {
    match count {
        c if c >= 1e7 => format!("{:.0} M", c / 1e6),
        c if c >= 1e6 => format!("{:.1} M", c / 1e6),
        c if c >= 1e4 => format!("{:.0} k", c / 1e3),
        c if c >= 1e3 => format!("{:.1} k", c / 1e3),
        c => format!("{c:.0}"),
    }
}

/// The line at the bottom of the window.
pub fn state_line(desk: &mut Desk, ui: &mut Ui) {
    let ready = desk.session.light.ready();
    ui.horizontal(|ui| {
        match &ready {
            None => {
                ui.label("The first photons are on their way");
            }
            Some(ready) => {
                let snapshot = &ready.snapshot;
                if desk.session.is_exact(snapshot) {
                    let sharpens = if snapshot.grows { ", sharpening" } else { "" };
                    ui.label(format!("Light: exact{sharpens}"))
                        .on_hover_text("To the bit what a fresh solution of this scene with as many photons gives");
                } else if snapshot.photons < snapshot.pool_photons {
                    ui.label(format!(
                        "Light: {} of {} photons shot",
                        short(snapshot.photons as f64),
                        short(snapshot.pool_photons as f64)
                    ));
                } else {
                    let percent = outstanding_percent(ready);
                    let paused = if desk.session.solver.controls().paused { ", paused" } else { "" };
                    let eye = if desk.session.is_complete_for_the_eye(ready) { "complete for the eye, " } else { "" };
                    ui.label(format!("Light: {eye}{percent:.0} % of the photons outstanding{paused}")).on_hover_text(
                        "Complete for the eye: from here nobody will see the rest of the repair, as far as can be told from what it brought so far",
                    );
                }
            }
        }
        ui.separator();
        if let Some(playback) = &desk.session.playback {
            ui.label(format!("{}: {:.0} %", playback.title, 100.0 * playback.progress()));
            ui.separator();
        }
        let what = match desk.session.selection {
            None => "Click something to select it; F1: keys and mouse",
            Some(_) => "Drag: move · Shift: up and down · Ctrl: anywhere · wheel: turn · Ctrl+Z: undo",
        };
        ui.weak(what);
    });
}

/// All of it.
pub fn panel(desk: &mut Desk, ui: &mut Ui) {
    if let Some(ready) = desk.session.light.ready() {
        numbers(desk, ui, &ready);
        chart::recovery(ui, &ready.trace, vec2(ui.available_width(), 110.0));
    }
    controls(desk, ui);
}

fn numbers(desk: &mut Desk, ui: &mut Ui, ready: &Ready) {
    let snapshot = &ready.snapshot;
    desk.rates.note(snapshot.work.photons, snapshot.work.rays);
    let rates = desk.rates.rates();
    let outstanding = snapshot.outstanding_photons as f64;
    let share = 1.0 - outstanding / snapshot.pool_photons.max(1) as f64;
    let text = match snapshot.exact {
        true => "exact".to_owned(),
        false if desk.session.is_complete_for_the_eye(ready) => format!("complete for the eye, {:.1} % right", 100.0 * share),
        false => format!("{:.1} % right", 100.0 * share),
    };
    ui.add(ProgressBar::new(share as f32).text(text));
    egui::Grid::new("numbers").num_columns(2).show(ui, |ui| {
        let mut line = |name: &str, value: String, hint: &str| {
            ui.label(name).on_hover_text(hint);
            ui.label(value);
            ui.end_row();
        };
        line(
            "Pool",
            format!("{} photons", short(snapshot.photons as f64)),
            "Shot so far, each once; those that became wrong are re-shot",
        );
        let groups = match snapshot.method {
            Method::Groups { stale, .. } => format!(", {stale} groups"),
            Method::Ledger { .. } => String::new(),
        };
        line(
            "Outstanding",
            format!("{} photons{groups}", short(outstanding)),
            "Photons that have not been shot, and those that may have become wrong",
        );
        let to_exact = match rates {
            _ if snapshot.exact => "now".to_owned(),
            Some([photons, _]) if photons > 0.0 => format!("{:.1} s", outstanding / photons),
            _ => "–".to_owned(),
        };
        line("Exact in", to_exact, "At the rate of the last second");
        line(
            "Error",
            format!("{:.1} %", 100.0 * ready.median_error),
            "Estimated error of the indirect light, as it is drawn, when all photons are right: half of all surfaces are nearer to the truth. Four times the photons about halve it",
        );
        let (records, hint) = match snapshot.method {
            Method::Ledger { bytes } => (
                format!("{}B", short(bytes as f64)),
                "Records of photons' paths: what an edit makes wrong is looked up in them (--memory)".to_owned(),
            ),
            Method::Groups { refused: None, .. } => {
                ("none".to_owned(), "Nothing can be moved, or no memory was given: wrong photons are searched for by pilots".to_owned())
            }
            Method::Groups { refused: Some(why), .. } => {
                ("none".to_owned(), format!("{why} (--memory): wrong photons are searched for by pilots, which takes several times as long"))
            }
        };
        line("Records", records, &hint);
        let per_second = |n: Option<f64>| n.map_or("–".to_owned(), |n| format!("{}/s", short(n)));
        line("Photons", per_second(rates.map(|r| r[0])), "Shot or re-shot");
        line("Rays", per_second(rates.map(|r| r[1])), "Through the trees; a photon takes two to four, a re-shot one in both scenes");
    });
}

fn controls(desk: &mut Desk, ui: &mut Ui) {
    let mut controls = desk.session.solver.controls();
    let before = controls;
    ui.horizontal(|ui| {
        let title = if controls.paused { "Go on" } else { "Pause repair" };
        let hint = "Paused: photons stay as they were shot, and all time is left for frames. Going on: what became wrong is re-shot. (Space)";
        if ui.button(title).on_hover_text(hint).clicked() {
            desk.run(Command::Pause);
        }
        let hint = "Throws all light away and shoots the pool anew: at first there is only noise, everywhere. Repair keeps what is right, and comes to the same bits. (Ctrl+R)";
        if ui.button("Start over").on_hover_text(hint).clicked() {
            desk.run(Command::StartOver);
        }
    });
    controls.paused = desk.session.solver.controls().paused;
    let names = [(Order::Adaptive, "adaptive"), (Order::Urgent, "visible change first"), (Order::Shuffled, "shuffled")];
    let shown = names.iter().find(|(order, _)| *order == controls.order).map_or("", |(_, name)| name);
    ui.horizontal(|ui| {
        ui.label("Order");
        ComboBox::from_id_salt("order").selected_text(shown).show_ui(ui, |ui| {
            for (order, name) in names {
                ui.selectable_value(&mut controls.order, order, name);
            }
        })
        .response
        .on_hover_text(
            "Which groups of photons are re-shot first. Visible change first: what the camera sees and what changed most (V·P of the paper). Shuffled: all alike; a long drag looks better on its way, and with records the rest can be foreseen from what was repaired. Adaptive: shuffled with records; without, shuffled while something moves, visible change first when it rests",
        );
    });
    let mut milliseconds = controls.iteration.as_secs_f64() * 1000.0;
    let slider = Slider::new(&mut milliseconds, 1.0..=100.0).logarithmic(true).suffix(" ms").max_decimals(0).text("iteration");
    let hint = "How long photons are traced before edits and the camera are looked at again. Longer: somewhat more photons a second; shorter: light follows an edit sooner";
    if ui.add(slider).on_hover_text(hint).changed() {
        controls.iteration = Duration::from_secs_f64(milliseconds / 1000.0);
    }
    let mut percent = 100.0 * controls.error.unwrap_or(FINEST);
    ui.horizontal(|ui| {
        let mut sharpens = controls.error.is_some();
        ui.checkbox(&mut sharpens, "sharpen to").on_hover_text(
            "Once nothing is wrong more photons are shot until the estimated error is no more than this, or the memory for their records is full. \
             Half of it takes four times the photons",
        );
        let slider = Slider::new(&mut percent, 0.1..=10.0).logarithmic(true).suffix(" %").max_decimals(1);
        ui.add_enabled(sharpens, slider);
        controls.error = sharpens.then_some(percent / 100.0);
    });
    let slider = Slider::new(&mut controls.iterations, 1..=20).text("iterations a frame");
    let hint = "After so many the new light is shown. More: less time goes into showing it; fewer: it comes in smaller steps";
    ui.add(slider).on_hover_text(hint);
    if controls != before {
        desk.session.solver.control(controls);
        desk.session.light.nudge();
    }
}

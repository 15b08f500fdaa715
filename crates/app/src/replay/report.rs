//! What `replay` says of its chapters: on the terminal, as JSON, CSV and figures.

use super::{Chapter, drag, views};
use crate::{
    Common,
    failure::Failure,
    figure::{self, Axes, Curve, Panel},
    output::{self, say},
};
use lightmend_photon::recovery::{Moment, reached};
use serde_json::{Map, Value, json};
use std::{io::Write, path::Path};

const SHARES: [(&str, f64); 4] = [("50", 0.5), ("90", 0.9), ("99", 0.99), ("100", 1.0)];

/// A table of one chapter.
pub fn print(chapter: &Chapter) {
    let share = chapter.relevant as f64 / chapter.photons as f64 * 100.0;
    say(&format!("\n{}: {} relevant photons ({share:.3} %)", chapter.title, chapter.relevant));
    let unit = chapter.oracle_rays();
    say(&format!(
        "{:<10} {:>36}  {:>8}  bits",
        "order",
        if unit.is_some() { "rays to 50/90/99/100 %, × oracle" } else { "rays to 50/90/99/100 %" },
        "seconds"
    ));
    for track in &chapter.tracks {
        let multiples: Vec<String> = SHARES
            .iter()
            .map(|(_, share)| {
                let rays = reached(&track.moments, *share, chapter.relevant).work.rays as f64;
                unit.map_or(format!("{rays}"), |u| format!("{:.2}", rays / (u as f64 * share)))
            })
            .collect();
        let seconds = track.moments.last().map_or(0.0, |m| m.seconds);
        let bits = if track.bit_equal { "equal" } else { "DIFFER" };
        say(&format!("{:<10} {:>36}  {seconds:>8.2}  {bits}", track.order, multiples.join(" / ")));
        if let Some(beside) = &track.beside {
            let replayed = track.moments.last().map_or(0, |m| m.replayed);
            let (ms, each) = (beside.scan_seconds * 1e3, beside.bytes as f64 / chapter.photons.max(1) as f64);
            let marked = beside.marked;
            say(&format!(
                "{:<10} scan {ms:.1} ms, {marked} photons marked, {replayed} hits replayed, {each:.1} bytes a photon",
                ""
            ));
        }
    }
}

/// All chapters, in the contract's form.
pub fn json(chapters: &[Chapter]) -> Value {
    chapters.iter().enumerate().map(|(number, chapter)| chapter_json(number, chapter)).collect()
}

/// Writes CSV files and figures.
pub fn write(out: &Path, scene: &str, chapters: &[Chapter], work: u64, common: &Common) -> Result<(), Failure> {
    output::write(&out.join("recovery.csv"), |file| write_csv(file, chapters))?;
    if chapters.iter().any(|chapter| !chapter.views.is_empty()) {
        output::write(&out.join("views.csv"), |file| views::write_csv(file, chapters))?;
    }
    let panels: Vec<Panel> = chapters.iter().map(|chapter| panel(scene, chapter)).collect();
    let mut figures = vec![("recovery", figure::write(out, "recovery", &panels, None)?.left_out)];
    let drags: Vec<Panel> = chapters.iter().filter_map(|c| c.drag.as_ref().map(|d| drag::panel(scene, c, d, work))).collect();
    if !drags.is_empty() {
        output::write(&out.join("drag.csv"), |file| drag::write_csv(file, chapters))?;
        figures.push(("drag", figure::write(out, "drag", &drags, None)?.left_out));
    }
    let views: Vec<Panel> = chapters.iter().flat_map(views::panels).collect();
    if !views.is_empty() {
        figures.push(("views", figure::write(out, "views", &views, None)?.left_out));
    }
    for (stem, left_out) in figures {
        if common.talks() && !chapters.is_empty() {
            say(&format!("figure: {}", out.join(format!("{stem}.png")).display()));
        }
        if left_out > 0 && !common.quiet {
            eprintln!("warning: {stem}.png shows the first edits only; {left_out} more are in {stem}.csv");
        }
    }
    Ok(())
}

fn panel(scene: &str, chapter: &Chapter) -> Panel {
    let oracle = chapter.oracle_rays();
    let (unit, relevant) = (oracle.unwrap_or(1) as f64, chapter.relevant.max(1) as f64);
    let point = |m: &Moment| (m.work.rays as f64 / unit, m.repaired as f64 / relevant * 100.0);
    Panel {
        title: format!("{scene}, {} ({} of {} photons relevant)", chapter.title, chapter.relevant, chapter.photons),
        across: if oracle.is_some() { "rays traced, multiples of the oracle's total".into() } else { "rays traced".into() },
        upwards: "relevant photons repaired, %".into(),
        axes: Axes::LogX,
        curves: chapter.tracks.iter().map(|t| Curve { name: t.order, points: t.moments.iter().map(point).collect() }).collect(),
    }
}

fn chapter_json(number: usize, chapter: &Chapter) -> Value {
    let orders: Map<String, Value> = chapter
        .tracks
        .iter()
        .map(|track| {
            let of = |value: fn(&Moment) -> Value| -> Map<String, Value> {
                SHARES.iter().map(|(name, share)| (name.to_string(), value(&reached(&track.moments, *share, chapter.relevant)))).collect()
            };
            let mut value = json!({
                "photons": of(|m| m.work.photons.into()), "rays": of(|m| m.work.rays.into()), "seconds": of(|m| m.seconds.into()),
                "drained": track.moments.last().map(|m| json!({ "photons": m.work.photons, "rays": m.work.rays, "seconds": m.seconds })),
                "bit_equal_to_fresh": track.bit_equal,
            });
            if let Some(beside) = &track.beside {
                value["replayed"] = of(|m| m.replayed.into()).into();
                value["scan_seconds"] = beside.scan_seconds.into();
                value["marked_photons"] = beside.marked.into();
                value["bytes"] = beside.bytes.into();
            }
            (track.order.to_owned(), value)
        })
        .collect();
    let mut value = json!({ "edit": number, "title": chapter.title, "relevant_photons": chapter.relevant, "orders": orders });
    if let Some(frames) = &chapter.drag {
        value["drag"] = drag::json(frames, chapter.last_step);
    }
    if !chapter.views.is_empty() {
        value["views"] = views::json(&chapter.views);
    }
    value
}

fn write_csv(out: &mut impl Write, chapters: &[Chapter]) -> std::io::Result<()> {
    writeln!(out, "edit,order,photons,rays,seconds,repaired,relevant,replayed")?;
    for (number, chapter) in chapters.iter().enumerate() {
        for track in &chapter.tracks {
            for m in &track.moments {
                let Moment { work, seconds, replayed, repaired } = m;
                writeln!(
                    out,
                    "{number},{},{},{},{seconds:.6},{repaired},{},{replayed}",
                    track.order, work.photons, work.rays, chapter.relevant
                )?;
            }
        }
    }
    Ok(())
}

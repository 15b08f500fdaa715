//! The same figures for people and programs: a table on the terminal, CSV, JSON.

use super::{
    Section,
    curve::{Point, Reached, Track},
    jobs::Job,
    judge::Errors,
    readout::READOUTS,
    state::State,
};
use lightmend_photon::shooting::Work;
use serde_json::{Map, Value, json};
use std::io::Write;

/// "3.21 %".
pub fn percent(value: f64) -> String {
    let percent = value * 100.0;
    format!("{percent:.*} %", if percent < 1.0 { 3 } else { 2 })
}

/// "0.123", or "1.2 ms" where that is little.
pub fn seconds(value: f64) -> String {
    match value {
        0.0 => "0".into(),
        v if v < 0.1 => format!("{:.1} ms", v * 1e3),
        v => format!("{v:.2} s"),
    }
}

/// Seconds until complete for the eye.
pub fn eye(track: &Track) -> String {
    track.complete_for_the_eye().map_or("–".into(), |point| seconds(point.seconds))
}

/// Tables of a state, one for each way to read the light.
pub fn text(job: &Job, state: &State) -> String {
    let (photons, own) = &state.reference;
    let mut lines = vec![
        String::new(),
        format!(
            "{}, {}: reference of {photons} photons, its own nRMSE {}",
            job.scene.name,
            state.title,
            percent(own.measures.nrmse)
        ),
    ];
    for (n, readout) in READOUTS.iter().enumerate() {
        let columns = ["near", "eye", "exact", "nRMSE first", "last", "visible", "FLIP"].map(|c| format!("{c:>12}")).concat();
        lines.push(format!("{:<14}{columns}  bits", readout.name));
        for track in &state.tracks {
            let (Some(first), Some(last)) = (track.points.first(), track.drained()) else { continue };
            let Errors { measures, visible, flip } = &last.errors[n];
            let cells = [
                track.near_drained(n).map_or("-".into(), |near| seconds(near.seconds)),
                eye(track),
                seconds(last.seconds),
                percent(first.errors[n].measures.nrmse),
                percent(measures.nrmse),
                visible.map_or("-".into(), percent),
                flip.map_or("-".into(), |flip| format!("{flip:.4}")),
            ];
            let bits = if track.bit_equal { "equal" } else { "DIFFER" };
            lines.push(format!("{:<14}{}  {bits}", track.order, cells.map(|c| format!("{c:>12}")).concat()));
        }
    }
    lines.join("\n")
}

fn errors_json(errors: &Errors) -> Map<String, Value> {
    let Errors { measures, visible, flip } = errors;
    let value = json!({
        "nrmse": measures.nrmse, "relmse": measures.relmse, "median": measures.median, "percentile_95": measures.percentile_95,
        "visible": visible, "flip": flip,
    });
    value.as_object().cloned().unwrap_or_default()
}

fn point_json(point: &Point, readout: usize) -> Value {
    let mut value = errors_json(&point.errors[readout]);
    value.insert("photons".into(), point.work.photons.into());
    value.insert("rays".into(), point.work.rays.into());
    value.insert("replayed".into(), point.replayed.into());
    value.insert("seconds".into(), point.seconds.into());
    value.into()
}

fn track_json(track: &Track) -> Value {
    let readouts: Map<String, Value> = READOUTS
        .iter()
        .enumerate()
        .map(|(n, readout)| {
            let near = track.near_drained(n).map(|Reached { seconds, rays }| json!({ "seconds": seconds, "rays": rays }));
            let curve: Vec<Value> = track.points.iter().map(|point| point_json(point, n)).collect();
            let drained = track.drained().map(|point| point_json(point, n));
            (readout.name.to_owned(), json!({ "near_drained": near, "drained": drained, "curve": curve }))
        })
        .collect();
    let eye = track.complete_for_the_eye().map(|point| json!({ "seconds": point.seconds, "rays": point.work.rays }));
    let noticed: Vec<Option<f64>> = track.points.iter().map(|point| point.noticed).collect();
    json!({ "bit_equal_to_fresh": track.bit_equal, "readouts": readouts, "complete_for_the_eye": eye, "noticed": noticed })
}

/// A scene's part of summary.json.
pub fn json(section: &Section) -> Value {
    let Section { job, states } = section;
    let state_json = |state: &State| {
        let balance = &state.balance;
        let orders: Map<String, Value> = state.tracks.iter().map(|t| (t.order.to_owned(), track_json(t))).collect();
        json!({
            "script": state.edit.as_ref().map(|(script, _)| script), "edit": state.edit.as_ref().map(|(_, edit)| edit),
            "title": state.title,
            "reference": { "photons": state.reference.0, "own": errors_json(&state.reference.1) },
            "balance": {
                "emitted": balance.photons, "absorbed": balance.absorbed, "escaped": balance.escaped, "cut": balance.cut,
                "mean": balance.mean, "standard_error": balance.standard_error, "exact": state.balanced,
            },
            "orders": orders,
        })
    };
    json!({
        "scene": job.scene.name, "file": job.scene.path, "cells": job.scene.cells(), "triangles": job.scene.triangles(),
        "photons": job.pool.photons(), "ng": job.pool.groups(), "r": job.ratio, "copies": job.pool.copies(),
        "camera": job.scene.cameras.first().map(|(name, _)| name),
        "states": states.iter().map(state_json).collect::<Vec<_>>(),
    })
}

fn optional(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| format!("{value:.8}"))
}

fn errors_csv(errors: &Errors) -> String {
    let Errors { measures: m, visible, flip } = errors;
    let figures = [m.nrmse, m.relmse, m.median, m.percentile_95].map(|value| format!("{value:.8}")).join(",");
    format!("{figures},{},{}", optional(*visible), optional(*flip))
}

/// "room,table,0": of the cold start the script and the edit are empty.
fn key(section: &Section, state: &State) -> String {
    let edit = state.edit.as_ref().map_or(",".into(), |(script, edit)| format!("{script},{edit}"));
    format!("{},{edit}", section.job.stem)
}

const ERRORS: &str = "nrmse,relmse,median,percentile_95,visible,flip";

fn each(sections: &[Section]) -> impl Iterator<Item = (String, &Track, usize)> {
    let states = sections.iter().flat_map(|section| section.states.iter().map(move |state| (key(section, state), state)));
    states.flat_map(|(key, state)| {
        state.tracks.iter().flat_map(move |track| {
            (0..READOUTS.len()).map({
                let key = key.clone();
                move |n| (key.clone(), track, n)
            })
        })
    })
}

/// table.csv: a line per state, order and way to read the light.
pub fn write_table(out: &mut impl Write, sections: &[Section]) -> std::io::Result<()> {
    writeln!(
        out,
        "scene,script,edit,order,readout,seconds_near_drained,rays_near_drained,seconds_complete_for_the_eye,seconds,rays,bit_equal_to_fresh,{ERRORS}"
    )?;
    for (key, track, n) in each(sections) {
        let near = track.near_drained(n);
        let (near_seconds, near_rays) =
            (optional(near.map(|n| n.seconds)), near.map_or(String::new(), |n| format!("{:.0}", n.rays)));
        if let Some(Point { work, seconds, errors, .. }) = track.drained() {
            let (order, readout, errors) = (track.order, READOUTS[n].name, errors_csv(&errors[n]));
            let (bits, eye) = (track.bit_equal, optional(track.complete_for_the_eye().map(|point| point.seconds)));
            writeln!(out, "{key},{order},{readout},{near_seconds},{near_rays},{eye},{seconds:.6},{},{bits},{errors}", work.rays)?;
        }
    }
    Ok(())
}

/// curves.csv: a line per checkpoint.
pub fn write_curves(out: &mut impl Write, sections: &[Section]) -> std::io::Result<()> {
    writeln!(out, "scene,script,edit,order,readout,photons,rays,replayed,seconds,{ERRORS},noticed")?;
    for (key, track, n) in each(sections) {
        for Point { work, replayed, seconds, errors, noticed } in &track.points {
            let (order, readout, errors) = (track.order, READOUTS[n].name, errors_csv(&errors[n]));
            let (Work { photons, rays }, noticed) = (work, optional(*noticed));
            writeln!(out, "{key},{order},{readout},{photons},{rays},{replayed},{seconds:.6},{errors},{noticed}")?;
        }
    }
    Ok(())
}

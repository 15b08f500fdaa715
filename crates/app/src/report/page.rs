//! The page: tables and plots in one file that needs no other.

use super::{
    Machine, Section,
    curve::Track,
    plot::{Figures, note},
    readout::READOUTS,
    state::State,
    table::{eye, percent, seconds},
};
use std::io::{self, Write};

const STYLE: &str = "body{font:15px/1.45 sans-serif;max-width:1260px;margin:2em auto;padding:0 1em;color:#222}\
    table{border-collapse:collapse;margin:.6em 0 1.4em}td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #ddd}\
    td:first-child,th:first-child{text-align:left}figure{margin:1em 0}svg{max-width:100%;height:auto}\
    figcaption,.small{font-size:13px;color:#555}h2{margin-top:2.2em;border-bottom:2px solid #222}h3{margin-top:2em}";

const WORDS: &str = "<p>Errors are of indirect irradiance, over both sides of all mesh elements, each by its area, against a reference: \
    two solutions of other scrambles of the sequence with many more photons, whose difference tells the reference's own error. It is taken \
    out of nRMSE, relMSE and visible error. <b>nRMSE</b>: RMS of the error ÷ RMS of the reference, three channels together. \
    <b>relMSE</b>: mean of error² ÷ (reference² + 0.01 · mean²). <b>Median</b> and <b>95th percentile</b>: of |error| ÷ reference, where the \
    reference exceeds 5 % of its mean; relMSE and both are of illuminance. <b>Visible error</b>: nRMSE over the pixels of the scene's first camera. <b>FLIP</b>: mean of the error map \
    of that camera's frame against the frame that the reference lights, at the same exposure.</p>\
    <p><b>Near</b>: seconds of work until nRMSE is at most 1.1 times that of the exact light, and stays so; 0 where the old light already is. \
    <b>Eye</b>: seconds until complete for the eye: until, at a checkpoint, one could notice in no more than one pixel in a thousand of the first camera's picture that the reconstructed light is not \
    the exact one, and so it stays. The step of luminance that is just noticed is that of Ward Larson et al. 1997 times the threshold elevation of the texture there; \
    files that end in _noticed.png map it, and where the old light can be told by it. <b>Exact</b>: seconds until every integer bucket is that of a fresh solution of the edited scene. The clock stands still while errors are measured. \
    <b>ledger</b> replays recorded paths; <b>stateless</b> is Algorithm 1 of Dmitriev et al. 2002; <b>random</b> re-tests all photons in \
    random order; <b>restart</b> starts over from nothing. One run each: seconds vary by some per cent, all else does not.</p>";

/// Writes the page; `figures` are those of all states, in order.
pub fn write(out: &mut impl Write, machine: &Machine, sections: &[Section], figures: &[Figures]) -> io::Result<()> {
    let names: Vec<String> = sections.iter().map(|section| escape(&section.job.scene.name)).collect();
    writeln!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Speed against error: {}</title>",
        names.join(", ")
    )?;
    writeln!(out, "<style>{STYLE}</style></head><body>\n<h1>Speed against error: {}</h1>", names.join(", "))?;
    writeln!(
        out,
        "<p>Lightmend {}, {} threads, {}.</p>",
        env!("CARGO_PKG_VERSION"),
        machine.threads,
        escape(&machine.processor)
    )?;
    writeln!(out, "{WORDS}")?;
    let mut figures = figures.iter();
    for section in sections {
        let job = &section.job;
        writeln!(
            out,
            "<h2>{}</h2>\n<p>{} photons in {} groups (R = {}), {} elements, {} triangles{}.</p>",
            escape(&job.scene.name),
            job.pool.photons(),
            job.pool.groups(),
            job.ratio,
            job.scene.cells(),
            job.scene.triangles(),
            job.scene.cameras.first().map_or(String::new(), |(name, _)| format!(", first camera “{}”", escape(name))),
        )?;
        for readout in 0..READOUTS.len() {
            overview(out, section, readout)?;
        }
        for (state, figures) in section.states.iter().zip(figures.by_ref()) {
            chapter(out, machine, section, state, figures)?;
        }
    }
    writeln!(out, "</body></html>")
}

/// Seconds until near and exact, a line per edit.
fn overview(out: &mut impl Write, section: &Section, readout: usize) -> io::Result<()> {
    let edits = || section.states.iter().filter(|state| state.edit.is_some());
    let Some(first) = edits().next() else { return Ok(()) };
    writeln!(out, "<table><tr><th>edit: near / eye / exact, {}</th>", READOUTS[readout].name)?;
    for track in &first.tracks {
        writeln!(out, "<th>{}</th>", track.order)?;
    }
    writeln!(out, "<th>nRMSE before</th><th>exact</th></tr>")?;
    for state in edits() {
        writeln!(out, "<tr><td>{}</td>", escape(&state.title))?;
        for known in &first.tracks {
            let cell = |track: &Track| {
                let near = track.near_drained(readout).map_or("–".into(), |near| seconds(near.seconds));
                format!("{near} / {} / {}", eye(track), track.drained().map_or("–".into(), |last| seconds(last.seconds)))
            };
            let track = state.tracks.iter().find(|track| track.order == known.order);
            writeln!(out, "<td>{}</td>", track.map_or("–".into(), cell))?;
        }
        // What is seen before any work is the old light, but of a restart.
        let before = state.tracks.iter().find(|track| track.order != "restart").and_then(|track| track.points.first());
        let exact = state.tracks.first().and_then(Track::drained);
        let nrmse =
            |point: Option<&super::curve::Point>| point.map_or("–".into(), |p| percent(p.errors[readout].measures.nrmse));
        writeln!(out, "<td>{}</td><td>{}</td></tr>", nrmse(before), nrmse(exact))?;
    }
    writeln!(out, "</table>")
}

/// One state: its table, its plots, its balance.
fn chapter(out: &mut impl Write, machine: &Machine, section: &Section, state: &State, figures: &Figures) -> io::Result<()> {
    writeln!(out, "<h3>{}</h3>", escape(&state.title))?;
    for (n, readout) in READOUTS.iter().enumerate() {
        writeln!(
            out,
            "<table><tr><th>{}</th><th>near</th><th>eye</th><th>exact</th><th>rays</th><th>nRMSE</th><th>relMSE</th><th>median</th>\
             <th>95th percentile</th><th>visible error</th><th>FLIP</th><th>bits</th></tr>",
            readout.name
        )?;
        for track in &state.tracks {
            let Some(last) = track.drained() else { continue };
            let errors = &last.errors[n];
            let m = &errors.measures;
            writeln!(
                out,
                "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.5}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>\
                 <td>{}</td></tr>",
                track.order,
                track.near_drained(n).map_or("–".into(), |near| seconds(near.seconds)),
                eye(track),
                seconds(last.seconds),
                last.work.rays,
                percent(m.nrmse),
                m.relmse,
                percent(m.median),
                percent(m.percentile_95),
                errors.visible.map_or("–".into(), percent),
                errors.flip.map_or("–".into(), |flip| format!("{flip:.4}")),
                if track.bit_equal { "equal" } else { "<b>differ</b>" },
            )?;
        }
        writeln!(out, "</table>")?;
    }
    let caption = escape(&note(machine, section, state));
    writeln!(out, "<figure>{}<figcaption>{caption}</figcaption></figure>", figures.nrmse)?;
    writeln!(
        out,
        "<details><summary>visible error, relative errors, relMSE, FLIP</summary><figure>{}<figcaption>{caption}</figcaption></figure></details>",
        figures.others
    )?;
    let balance = &state.balance;
    let channels: Vec<String> =
        balance.mean.iter().zip(balance.standard_error).map(|(mean, se)| format!("{mean:.5} ± {se:.5}")).collect();
    writeln!(
        out,
        "<p class=\"small\">Energy: {} photons emitted = {} absorbed + {} escaped + {} cut; surfaces absorb Σ (1 − ρ) · incident and the rest is lost: {} \
         of what was emitted in red, green, blue. Buckets hold {} what these photons deposit.</p>",
        balance.photons,
        balance.absorbed,
        balance.escaped,
        balance.cut,
        channels.join(", "),
        if state.balanced { "exactly" } else { "<b>not</b>" },
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_break_the_page() {
        assert_eq!(escape("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
    }
}

//! Plots: error against rays and against seconds, log-log.

use super::{
    Machine, Section,
    curve::{NEAR, Point, Track},
    judge::Errors,
    readout::READOUTS,
    state::State,
};
use crate::{
    failure::Failure,
    figure::{self, Axes, BOUND, Curve, Panel},
    output,
};
use std::path::Path;

/// The figures of a state, as SVG.
pub struct Figures {
    /// nRMSE by each way to read the light.
    pub nrmse: String,
    /// All other measures.
    pub others: String,
}

/// What is plotted, and how it is called.
struct Measure {
    name: &'static str,
    of: fn(&Errors) -> Option<f64>,
}

const NRMSE: Measure = Measure { name: "nRMSE", of: |e| Some(e.measures.nrmse) };

const OTHERS: [Measure; 5] = [
    Measure { name: "visible error", of: |e| e.visible },
    Measure { name: "median relative error", of: |e| Some(e.measures.median) },
    Measure { name: "95th percentile of relative error", of: |e| Some(e.measures.percentile_95) },
    Measure { name: "relMSE", of: |e| Some(e.measures.relmse) },
    Measure { name: "mean FLIP of the frame", of: |e| e.flip },
];

/// A quantity along x.
struct Effort {
    name: &'static str,
    of: fn(&Point) -> f64,
}

const EFFORTS: [Effort; 2] = [Effort { name: "rays", of: |p| p.work.rays as f64 }, Effort { name: "seconds", of: |p| p.seconds }];

/// Writes each state's figures as SVG and PNG, and its map of what could be noticed as PNG; returns the figures in order.
pub fn write(out: &Path, machine: &Machine, sections: &[Section]) -> Result<Vec<Figures>, Failure> {
    let mut all = Vec::new();
    for section in sections {
        for state in &section.states {
            let note = note(machine, section, state);
            let stem = format!("{}_{}", section.job.stem, state.stem());
            let title = format!("{}, {}", section.job.scene.name, state.title);
            let draw = |stem: &str, measures: &[Measure]| {
                let panels: Vec<Panel> = measures.iter().flat_map(|measure| panels(&title, state, measure)).collect();
                figure::write(out, stem, &panels, Some(&note)).map(|figure| figure.svg)
            };
            let nrmse = draw(&format!("{stem}_nrmse"), &[NRMSE])?;
            let others = draw(&format!("{stem}_others"), &OTHERS)?;
            if let Some(map) = &state.map {
                output::png(&out.join(format!("{stem}_noticed.png")), map)?;
            }
            all.push(Figures { nrmse, others });
        }
    }
    Ok(all)
}

/// What a figure must say to be understood by itself.
pub fn note(machine: &Machine, section: &Section, state: &State) -> String {
    let job = &section.job;
    format!(
        "{}: {} photons, {} elements, {} threads, {}. Reference: {} photons, its own nRMSE {:.2} %. \
         On the left edge nothing was traced yet.",
        job.scene.name,
        job.pool.photons(),
        job.scene.cells(),
        machine.threads,
        machine.processor,
        state.reference.0,
        state.reference.1.measures.nrmse * 100.0,
    )
}

fn panels(title: &str, state: &State, measure: &Measure) -> Vec<Panel> {
    let mut panels = Vec::new();
    for (n, readout) in READOUTS.iter().enumerate() {
        for effort in &EFFORTS {
            let traced = || state.tracks.iter().flat_map(|t| &t.points).map(effort.of).filter(|x| *x > 0.0);
            let (first, last) = (traced().fold(f64::INFINITY, f64::min), traced().fold(0.0, f64::max));
            // Nothing was traced at 0, which has no place on a logarithmic axis.
            let edge = if first.is_finite() { first / 1.5 } else { 1.0 };
            let points = |track: &Track| {
                let of = |point: &Point| Some(((effort.of)(point).max(edge), (measure.of)(&point.errors[n])?));
                track.points.iter().filter_map(of).collect::<Vec<_>>()
            };
            let mut curves: Vec<Curve> =
                state.tracks.iter().map(|track| Curve { name: track.order, points: points(track) }).collect();
            curves.retain(|curve| !curve.points.is_empty());
            let drained = state.tracks.first().and_then(Track::drained).and_then(|point| (measure.of)(&point.errors[n]));
            if let Some(drained) = drained.filter(|_| measure.name == NRMSE.name) {
                let limit = NEAR * drained;
                curves.push(Curve { name: BOUND, points: vec![(edge, limit), (last.max(edge), limit)] });
            }
            if !curves.is_empty() {
                panels.push(Panel {
                    title: title.to_owned(),
                    across: effort.name.into(),
                    upwards: format!("{}, {}", measure.name, readout.name),
                    axes: Axes::LogLog,
                    curves,
                });
            }
        }
    }
    panels
}

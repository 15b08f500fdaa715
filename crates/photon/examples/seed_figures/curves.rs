//! Figures 5 and 7 of the seed: relevant photons repaired against time and against rays, one group size against the other and one
//! ratio of pilots against the other.

use crate::{
    chart::{Curve, Panel, Stroke},
    measure::{Moment, reached},
    picture::{BLUE, GREEN, GREY, INK, OCHRE, RED},
};

/// One repair, and what is told of it.
pub struct Course {
    /// For the legend.
    pub name: String,
    /// Its moments in the order of Algorithm 1, the edit first.
    pub moments: Vec<Moment>,
    /// The same groups if pilots knew all.
    pub perfect: Vec<Moment>,
    /// The same groups if all pilots were shot before any corrective photon.
    pub pilots_first: Vec<Moment>,
}

const COLOURS: [plotters::style::RGBColor; 4] = [RED, BLUE, GREEN, OCHRE];

/// From here on the axis counts thousands of photons.
const MANY: u64 = 20_000;

struct Scale {
    photons: f64,
    upwards: String,
}

impl Scale {
    fn new(relevant: u64) -> Scale {
        let (photons, unit) = if relevant >= MANY { (1e-3, ", thousands") } else { (1.0, "") };
        Scale { photons, upwards: format!("relevant photons repaired{unit}") }
    }

    fn of(&self, repaired: u64) -> f64 {
        repaired as f64 * self.photons
    }
}

fn last(moments: &[Moment]) -> Moment {
    moments.last().copied().unwrap_or_default()
}

/// The horizontal line of the seed's Figure 5, and the course of random order (dotted in its Figure 7).
fn guides(relevant: u64, scale: &Scale, end: f64) -> [Curve; 2] {
    let top = scale.of(relevant);
    let total = format!("all {relevant} relevant photons");
    [
        Curve { name: total, colour: INK, stroke: Stroke::Solid, points: vec![(0.0, top), (end, top)] },
        Curve { name: "random order".into(), colour: GREY, stroke: Stroke::Dotted, points: vec![(0.0, 0.0), (end, top)] },
    ]
}

/// Repaired photons against seconds.
pub fn against_time(title: &str, courses: &[Course], relevant: u64) -> Panel {
    let scale = Scale::new(relevant);
    // Random order takes as long as the courses, which all trace the same photons; they differ by what else the machine does.
    let end = courses.iter().map(|c| last(&c.moments).seconds).sum::<f64>() / courses.len().max(1) as f64;
    let curves = courses.iter().zip(COLOURS).map(|(course, colour)| Curve {
        name: course.name.clone(),
        colour,
        stroke: Stroke::Solid,
        points: course.moments.iter().map(|m| (m.seconds, scale.of(m.repaired))).collect(),
    });
    let curves = curves.chain(guides(relevant, &scale, end)).collect();
    Panel { title: title.into(), across: "time since the edit, s (one thread)".into(), upwards: scale.upwards, curves }
}

/// Repaired photons against rays. With `limits`, also what the same groups would allow.
pub fn against_rays(title: &str, courses: &[Course], relevant: u64, limits: bool) -> Panel {
    let scale = Scale::new(relevant);
    let end = courses.first().map_or(0.0, |c| last(&c.moments).rays as f64 * 1e-6);
    let points = |moments: &[Moment]| moments.iter().map(|m| (m.rays as f64 * 1e-6, scale.of(m.repaired))).collect();
    let mut curves = Vec::new();
    for (course, colour) in courses.iter().zip(COLOURS) {
        let name = course.name.clone();
        curves.push(Curve { name, colour, stroke: Stroke::Solid, points: points(&course.moments) });
        if limits {
            let limits = [
                ("all pilots first", Stroke::Dashed, &course.pilots_first),
                ("pilots know all", Stroke::Dotted, &course.perfect),
            ];
            for (what, stroke, moments) in limits {
                curves.push(Curve { name: format!("{}, {what}", course.name), colour, stroke, points: points(moments) });
            }
        }
    }
    curves.extend(guides(relevant, &scale, end));
    Panel { title: title.into(), across: "rays traced since the edit, millions".into(), upwards: scale.upwards, curves }
}

/// Shares of the relevant photons that the tables tell.
const SHARES: [f64; 4] = [0.25, 0.5, 0.75, 0.9];

/// A row of the table of rays: what each share cost, % of all the rays of the repair.
pub fn row(course: &Course, relevant: u64) -> String {
    let all = last(&course.moments).rays as f64;
    let shares = |moments: &[Moment]| {
        let cost = SHARES.map(|share| format!("{:.1}", 100.0 * reached(moments, share, relevant).rays as f64 / all));
        cost.join(" / ")
    };
    let [own, first, perfect] = [&course.moments, &course.pilots_first, &course.perfect].map(|moments| shares(moments));
    format!("{} | {own} | {first} | {perfect} | {:.1}", course.name, last(&course.moments).seconds)
}

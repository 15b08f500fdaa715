//! The seed's §7: "tracing changed photon paths twice introduces an overhead which on average was below 25 % (some initial segments of
//! the photon path may be the same and can be computed only once)". It does not say 25 % of what; here is each reading.

use crate::{
    curves::Course,
    measure::{Fact, reached, relevant},
};

/// Sums over the relevant photons of one edit, in rays.
#[derive(Debug, Clone, Copy, Default)]
pub struct Twice {
    photons: u64,
    old: u64,
    new: u64,
    both: u64,
    /// By the segment that first meets what changed: 1, 2, 3, 4 and more.
    met_on: [u64; 4],
}

impl Twice {
    /// Adds them up.
    pub fn of(facts: &[Fact]) -> Twice {
        let mut sum = Twice { photons: relevant(facts), ..Twice::default() };
        for fact in facts.iter().filter(|fact| fact.relevant) {
            sum.old += u64::from(fact.old);
            sum.new += u64::from(fact.new);
            sum.both += u64::from(fact.both);
            sum.met_on[fact.met_on.clamp(1, 4) as usize - 1] += 1;
        }
        sum
    }

    /// Both with the common beginning once, over the new paths alone: %.
    pub fn over_new(&self) -> f64 {
        100.0 * (self.both as f64 / self.new.max(1) as f64 - 1.0)
    }

    /// A row of the table: per photon L_old, L_new, both; what it costs over the new path alone, with the common beginning traced
    /// twice and once; what tracing it once saves; the overhead over all the work until 50, 90 and 100 % were repaired.
    pub fn row(&self, name: &str, course: &Course) -> String {
        let each = |rays: u64| rays as f64 / self.photons.max(1) as f64;
        let whole = self.old + self.new;
        let of_work = [0.5, 0.9, 1.0].map(|share| {
            let at = reached(&course.moments, share, self.photons);
            format!("{:.1}", 100.0 * at.saved_by_store as f64 / (at.rays - at.saved_by_store).max(1) as f64)
        });
        let met_on = self.met_on.map(|n| format!("{:.0}", 100.0 * n as f64 / self.photons.max(1) as f64));
        format!(
            "{name} | {} | {} | {:.2} | {:.2} | {:.2} | {:.0} | {:.0} | {:.0} | {}",
            self.photons,
            met_on.join(" / "),
            each(self.old),
            each(self.new),
            each(self.both),
            100.0 * (whole as f64 / self.new.max(1) as f64 - 1.0),
            self.over_new(),
            100.0 * (1.0 - self.both as f64 / whole.max(1) as f64),
            of_work.join(" / "),
        )
    }
}

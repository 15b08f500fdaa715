//! The states of a scene, one after the other: the cold start, then each script's edits, every one repaired in every order.

use super::{
    curve::{Ended, OrderArgument, Track, follow},
    jobs::{FIRST_HITS, Job},
    judge::{Errors, Instruments, Judge, fresh},
};
use crate::{
    Common,
    failure::Failure,
    replay::{LEDGER_LIMIT, title},
};
use lightmend_photon::{
    balance::Balance,
    body::TreePreset,
    course::Course,
    ledger::{LedgerSolution, Refused},
    path::Rules,
    solution::Solution,
    world::World,
};
use lightmend_scene::Configuration;
use std::sync::Arc;

/// What was measured in one state.
pub struct State {
    /// The script and the number of the edit in it; of the cold start none.
    pub edit: Option<(String, usize)>,
    /// What was done.
    pub title: String,
    /// Photons of the reference, and its own errors.
    pub reference: (u64, Errors),
    /// What became of a fresh solution's photons.
    pub balance: Balance,
    /// Whether the fresh solution holds exactly these photons' deposits and ends.
    pub balanced: bool,
    /// The orders.
    pub tracks: Vec<Track>,
    /// What could be noticed from the first camera, and where it can be before any repair.
    pub map: Option<image::RgbImage>,
}

impl State {
    /// Whether the light is what it must be to the bit.
    pub fn holds(&self) -> bool {
        self.balanced && self.tracks.iter().all(|track| track.bit_equal)
    }

    /// A name for its files.
    pub fn stem(&self) -> String {
        self.edit.as_ref().map_or("cold".into(), |(script, edit)| format!("{script}_{edit}"))
    }
}

/// Exact light, with a ledger where there is room for one.
type Drained = (Solution, Option<LedgerSolution>);

/// Measures the states of a scene.
pub struct Measurer<'a> {
    pub job: &'a Job,
    pub orders: &'a [OrderArgument],
    pub common: &'a Common,
}

impl Measurer<'_> {
    /// Measures all states until interrupted; each is given away when it is done.
    pub fn measure(&self, instruments: &mut Instruments, done: &mut dyn FnMut(State)) -> Result<(), Failure> {
        let configuration = Configuration::initial(&self.job.scene);
        let world = Arc::new(World::new(&configuration, TreePreset::default()));
        let Some((state, start)) = self.cold_start(&world, instruments)? else { return Ok(()) };
        done(state);
        for (script, moves) in &self.job.scripts {
            let mut configuration = configuration.clone();
            let mut drained = start.clone();
            for (number, timed) in moves.edits.iter().enumerate() {
                configuration = configuration.apply(&timed.edit)?;
                let edit = Some((script.clone(), number));
                let title = format!("{script}, edit {number}: {}", title(&timed.edit));
                let Some((state, next)) = self.edit(edit, title, &drained, &configuration, instruments)? else {
                    return Ok(());
                };
                done(state);
                drained = next;
            }
        }
        Ok(())
    }

    fn cold_start(&self, world: &Arc<World>, instruments: &mut Instruments) -> Result<Option<(State, Drained)>, Failure> {
        let pool = self.job.pool;
        let Some(mut judge) = Judge::new(self.job, world, instruments, self.common.quiet)? else { return Ok(None) };
        let rules = Arc::new(Rules { sequence: pool.sequence(), first_hits: FIRST_HITS });
        let mut courses = vec![("no ledger", Course::restart(pool, rules, world.clone()))];
        if self.orders.contains(&OrderArgument::Ledger) {
            match LedgerSolution::begin(pool, world.clone(), FIRST_HITS, LEDGER_LIMIT) {
                Ok(begun) => courses.push(("ledger", Course::recording(pool, begun))),
                Err(refused) => self.leave_ledger_out(&refused),
            }
        }
        self.run(None, "cold start".into(), courses, None, &mut judge, world)
    }

    fn edit(
        &self,
        edit: Option<(String, usize)>,
        title: String,
        (drained, ledger): &Drained,
        configuration: &Configuration,
        instruments: &mut Instruments,
    ) -> Result<Option<(State, Drained)>, Failure> {
        let after = Arc::new(drained.world().moved_to(configuration));
        let Some(mut judge) = Judge::new(self.job, &after, instruments, self.common.quiet)? else { return Ok(None) };
        let courses = self.orders.iter().filter_map(|order| {
            let course = match order {
                OrderArgument::Ledger => Course::ledger(ledger.as_ref()?),
                OrderArgument::Stateless => Course::stateless(drained),
                OrderArgument::Random => Course::random(drained),
                OrderArgument::Restart => Course::restart(self.job.pool, drained.rules().clone(), after.clone()),
            };
            Some((order.name(), course))
        });
        self.run(edit, title, courses.collect(), Some(&after), &mut judge, &after)
    }

    /// Follows each course and compares what it ends with; also the exact light, for the next edit.
    fn run(
        &self,
        edit: Option<(String, usize)>,
        title: String,
        courses: Vec<(&'static str, Course)>,
        after: Option<&Arc<World>>,
        judge: &mut Judge,
        world: &World,
    ) -> Result<Option<(State, Drained)>, Failure> {
        let quiet = self.common.quiet;
        let Some((fresh, balance)) = fresh(self.job, world, quiet) else { return Ok(None) };
        judge.ends_with(fresh.buckets(), fresh.pool().photons());
        let old = courses.iter().find(|(order, _)| *order != OrderArgument::Restart.name()).or(courses.first());
        let map = match old {
            Some((_, course)) => judge.map(course.light(), course.photons_shot())?,
            None => None,
        };
        let (mut tracks, mut drained, mut kept) = (Vec::new(), None, None);
        for (order, course) in courses {
            let (points, course) = match follow(course, after, judge, &format!("{title}, {order}"), quiet)? {
                Ended::Exact(points, course) => (points, course),
                Ended::Interrupted => return Ok(None),
                Ended::Refused(refused) => {
                    self.leave_ledger_out(&refused);
                    continue;
                }
            };
            let wrong =
                || Failure::failed(format!("{title}, {order}: the light is not exact in the end: this is a bug in Lightmend"));
            let (solution, ledger) = course.finish().ok_or_else(wrong)?;
            tracks.push(Track { order, points, bit_equal: solution.equals(&fresh) });
            kept = kept.or(ledger);
            drained = drained.or(Some(solution));
        }
        let Some(drained) = drained else {
            return Err(Failure::failed(format!("{title}: no order was left; name others with --orders")));
        };
        let ends = fresh.tallies().iter().fold([0; 3], |[a, b, c], t| [a + t.absorbed, b + t.escaped, c + t.cut]);
        let balanced = balance.is_whole()
            && balance.is_held_by(fresh.buckets())
            && ends.map(|end| end as u64) == [balance.absorbed, balance.escaped, balance.cut];
        let reference = (judge.reference_photons(), judge.own());
        Ok(Some((State { edit, title, reference, balance, balanced, tracks, map }, (drained, kept))))
    }

    fn leave_ledger_out(&self, refused: &Refused) {
        if !self.common.quiet {
            eprintln!("warning: {refused}: the order \"ledger\" is left out");
        }
    }
}

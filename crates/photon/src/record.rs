//! What is kept of paths while photons follow them: light for the buckets and how they ended, what a camera may see, or all of it, to compare.

use crate::{
    bucket::{Address, Buckets, Deposit, Full, energy},
    importance::Gaze,
    path::{End, Record, cell},
    triangle::Hit,
    world::World,
};
use glam::Vec3;

/// How much of a path matters to a camera: the view importance V of Dmitriev et al. 2002, §5.3.
#[derive(Debug, Clone, Copy, Default)]
pub struct Watch<'g> {
    /// Which hits count; none without a camera.
    pub gaze: Option<&'g Gaze>,
    /// What they come to.
    pub seen: u64,
    /// Traversals of the trees.
    pub rays: u64,
}

impl Record for Watch<'_> {
    fn hit(&mut self, hit: &Hit, _: u8, _: Vec3, _: u16, _: bool, _: &World) {
        if let Some(gaze) = self.gaze {
            self.seen += u64::from(gaze.hit(hit));
        }
    }

    fn end(&mut self, _: End, _: Vec3, _: u16) {}

    fn ray(&mut self) {
        self.rays += 1;
    }
}

impl<R: Record> Record for &mut R {
    #[inline(always)]
    fn hit(&mut self, hit: &Hit, side: u8, throughput: Vec3, lamp: u16, deposits: bool, world: &World) {
        (**self).hit(hit, side, throughput, lamp, deposits, world);
    }

    #[inline(always)]
    fn end(&mut self, end: End, throughput: Vec3, lamp: u16) {
        (**self).end(end, throughput, lamp);
    }

    #[inline(always)]
    fn ray(&mut self) {
        (**self).ray();
    }
}

/// Two records of one path.
impl<A: Record, B: Record> Record for (&mut A, &mut B) {
    fn hit(&mut self, hit: &Hit, side: u8, throughput: Vec3, lamp: u16, deposits: bool, world: &World) {
        self.0.hit(hit, side, throughput, lamp, deposits, world);
        self.1.hit(hit, side, throughput, lamp, deposits, world);
    }

    fn end(&mut self, end: End, throughput: Vec3, lamp: u16) {
        self.0.end(end, throughput, lamp);
        self.1.end(end, throughput, lamp);
    }

    fn ray(&mut self) {
        self.0.ray();
        self.1.ray();
    }
}

/// Counts that balance: emitted = absorbed + escaped + cut. Signed, since a re-shot photon takes its old end back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Photons that a surface took.
    pub absorbed: i64,
    /// Photons that met nothing.
    pub escaped: i64,
    /// Photons whose path was cut.
    pub cut: i64,
    /// Energy of the escaped ones, per channel, in units of 2⁻²⁴ of a photon.
    pub escaped_energy: [i64; 3],
    /// Energy of the cut ones.
    pub cut_energy: [i64; 3],
}

impl Tally {
    /// Adds another tally.
    pub fn add(&mut self, other: &Tally) {
        self.absorbed += other.absorbed;
        self.escaped += other.escaped;
        self.cut += other.cut;
        for c in 0..3 {
            self.escaped_energy[c] += other.escaped_energy[c];
            self.cut_energy[c] += other.cut_energy[c];
        }
    }
}

/// What paths leave behind, to be added to buckets and tallies.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outcome {
    /// Deposits, in order.
    pub deposits: Vec<Deposit>,
    /// Ends, per lamp.
    pub tallies: Vec<Tally>,
    /// Traversals of the trees.
    pub rays: u64,
    negative: bool,
}

impl Outcome {
    /// Nothing yet; `negative` if paths are to be taken back.
    pub fn new(lamps: usize, negative: bool) -> Outcome {
        Outcome { deposits: Vec::new(), tallies: vec![Tally::default(); lamps], rays: 0, negative }
    }

    /// Adds a deposit.
    #[inline(always)]
    pub(crate) fn deposit(&mut self, to: Address, throughput: Vec3) {
        self.deposits.push(Deposit { to, energy: energy(throughput) });
    }

    /// Nothing again.
    pub fn clear(&mut self, lamps: usize) {
        self.deposits.clear();
        self.tallies.clear();
        self.tallies.resize(lamps, Tally::default());
        self.rays = 0;
    }
}

/// Takes back what is to be taken back and adds the rest: all of it, or nothing if it does not fit.
pub(crate) fn book<'o>(
    outcomes: impl Iterator<Item = &'o Outcome> + Clone,
    buckets: &mut Buckets,
    tallies: &mut [Tally],
) -> Result<(), Full> {
    let of_sign =
        |negative: bool| outcomes.clone().filter(move |outcome| outcome.negative == negative).map(|outcome| &*outcome.deposits);
    buckets.exchange(of_sign(true), of_sign(false))?;
    for outcome in outcomes {
        tallies.iter_mut().zip(&outcome.tallies).for_each(|(sum, tally)| sum.add(tally));
    }
    Ok(())
}

impl Record for Outcome {
    #[inline(always)]
    fn hit(&mut self, hit: &Hit, side: u8, throughput: Vec3, lamp: u16, deposits: bool, _: &World) {
        if deposits {
            self.deposit(Address { object: hit.triangle.object() as u32, cell: cell(hit), side, lamp }, throughput);
        }
    }

    #[inline(always)]
    fn end(&mut self, end: End, throughput: Vec3, lamp: u16) {
        let sign = if self.negative { -1 } else { 1 };
        let tally = &mut self.tallies[usize::from(lamp)];
        let (count, sum) = match end {
            End::Absorbed => {
                tally.absorbed += sign;
                return;
            }
            End::Escaped => (&mut tally.escaped, &mut tally.escaped_energy),
            End::Cut => (&mut tally.cut, &mut tally.cut_energy),
        };
        *count += sign;
        sum.iter_mut().zip(energy(throughput)).for_each(|(sum, energy)| *sum += sign * i64::from(energy));
    }

    fn ray(&mut self) {
        self.rays += 1;
    }
}

/// A hit of a path and what it deposits, to compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Footprint {
    triangle: (u64, u32),
    side: u8,
    position: [u32; 3],
    // The same place of the world can be another element of an object that slid within its own surface.
    cell: u32,
    energy: [u32; 3],
    lamp: u16,
    deposits: bool,
}

/// The hits of a path, to compare.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Trail {
    hits: Vec<Footprint>,
    end: Option<(End, [u32; 3], u16)>,
    /// Traversals of the trees.
    pub rays: u64,
}

impl Trail {
    /// Whether another path differs in a hit, a deposit or its end.
    pub fn differs(&self, other: &Trail) -> bool {
        self.hits != other.hits || self.end != other.end
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.hits.clear();
        self.end = None;
        self.rays = 0;
    }
}

impl Record for Trail {
    fn hit(&mut self, hit: &Hit, side: u8, throughput: Vec3, lamp: u16, deposits: bool, _: &World) {
        let position = hit.triangle.point(hit.weights).to_array().map(f32::to_bits);
        let (cell, energy) = (cell(hit), energy(throughput));
        self.hits.push(Footprint { triangle: hit.triangle.order(), side, position, cell, energy, lamp, deposits });
    }

    fn end(&mut self, end: End, throughput: Vec3, lamp: u16) {
        self.end = Some((end, energy(throughput), lamp));
    }

    fn ray(&mut self) {
        self.rays += 1;
    }
}

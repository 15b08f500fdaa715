//! Figure 6 of the seed: two groups of photons that reflect diffusely once and then meet the moving object, seen from above and from
//! the side.

use crate::{
    measure::Fact,
    picture::{BLUE, Drawn, FONT, GREEN, GREY, INK, OCHRE, Picture, RED},
};
use glam::{DVec3, Vec3};
use lightmend_photon::{
    path::{End, Record, Rules, trace},
    pool::{GroupId, PhotonIndex, Pool},
    triangle::Hit,
    world::World,
};
use lightmend_scene::{Configuration, Up};
use plotters::{coord::Shift, prelude::*};
use std::collections::{BTreeMap, BTreeSet};

/// A group and its corrective photons.
pub struct Bundle {
    pub group: GroupId,
    /// Corrective photons in all.
    pub photons: usize,
    /// Those that meet what changed after one bounce.
    pub after_a_bounce: usize,
    /// Lamp, first and second hit of each, and whether it is one of those.
    paths: Vec<(Vec<DVec3>, bool)>,
}

/// Hits of a path.
#[derive(Default)]
struct Hits(Vec<Vec3>);

impl Record for Hits {
    fn hit(&mut self, hit: &Hit, _: u8, _: Vec3, _: u16, _: bool, _: &World) {
        self.0.push(hit.triangle.point(hit.weights));
    }
    fn end(&mut self, _: End, _: Vec3, _: u16) {}
    fn ray(&mut self) {}
}

/// The two groups with most corrective photons that first meet what changed on their second segment; the second leaves its lamp
/// elsewhere than the first (another residue by `directions`, the part of N_g that divides what leaves the lamps).
pub fn best_two(pool: &Pool, facts: &[Fact], rules: &Rules, after: &World, directions: u32) -> Vec<Bundle> {
    let correctives = |g: GroupId| pool.photons_of(g).filter(|i| !pool.is_pilot(*i));
    let meets = |i: PhotonIndex| facts[i.0 as usize].relevant && facts[i.0 as usize].met_on == 2;
    let mut groups: Vec<(usize, GroupId)> =
        (0..pool.groups()).map(GroupId).map(|g| (correctives(g).filter(|i| meets(*i)).count(), g)).collect();
    groups.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    let Some(first) = groups.first().copied() else { return Vec::new() };
    let second = groups.iter().find(|(_, g)| g.0 % directions != first.1.0 % directions).copied();
    let bundle = |(after_a_bounce, group): (usize, GroupId)| {
        let paths = correctives(group).filter_map(|photon| {
            let (lamp, _) = after.choice().choose(rules.sequence.value(photon.0, 0))?;
            let mut hits = Hits::default();
            trace(rules, after, photon, &mut hits);
            let start = after.lamps()[lamp].position;
            let points = std::iter::once(start).chain(hits.0.iter().take(2).map(|p| p.as_dvec3())).collect();
            Some((points, meets(photon)))
        });
        let paths: Vec<_> = paths.collect();
        Bundle { group, photons: paths.len(), after_a_bounce, paths }
    };
    [Some(first), second].into_iter().flatten().map(bundle).collect()
}

/// The picture: plan above, elevation below, to one scale.
pub struct Plan {
    title: String,
    up: Up,
    low: DVec3,
    high: DVec3,
    still: Vec<[DVec3; 2]>,
    stood: Vec<[DVec3; 2]>,
    stands: Vec<[DVec3; 2]>,
    bundles: Vec<Bundle>,
}

/// An edge and the normals of the triangles that share it.
struct Edge {
    ends: [DVec3; 2],
    normals: Vec<DVec3>,
}

/// Edges of an object where surfaces meet at an angle or end, metres.
fn outline(configuration: &Configuration, id: usize) -> Vec<[DVec3; 2]> {
    let motion = configuration.object_motion(id);
    let mesh = &configuration.object(id).mesh;
    let key = |p: DVec3| (p * 1e4).round().to_array().map(|x| x as i64);
    let mut edges: BTreeMap<[[i64; 3]; 2], Edge> = BTreeMap::new();
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t).map(|p| motion.point(p));
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for side in 0..3 {
            let ends = [corners[side], corners[(side + 1) % 3]];
            let mut name = ends.map(key);
            name.sort();
            edges.entry(name).or_insert(Edge { ends, normals: Vec::new() }).normals.push(normal);
        }
    }
    let bends = |normals: &[DVec3]| normals.len() == 1 || normals.iter().any(|n| n.dot(normals[0]) < 0.9);
    edges.into_values().filter(|edge| bends(&edge.normals)).map(|edge| edge.ends).collect()
}

impl Plan {
    pub fn new(title: String, before: &World, after: &World, bundles: Vec<Bundle>) -> Plan {
        let changed = before.difference(after).objects;
        let [was, is] = [before, after].map(World::configuration);
        let of = |configuration: &Configuration, moved: bool| -> Vec<[DVec3; 2]> {
            let ids = configuration.objects().map(|(id, _)| id).filter(|id| changed.contains(id) == moved);
            ids.flat_map(|id| outline(configuration, id)).collect()
        };
        let still = of(is, false);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let points = bundles.iter().flat_map(|b| b.paths.iter().flat_map(|(points, _)| points));
        for point in still.iter().flatten().chain(points) {
            (low, high) = (low.min(*point), high.max(*point));
        }
        Plan { title, up: is.scene().up, low, high, still, stood: of(was, true), stands: of(is, true), bundles }
    }

    /// Across, into the plan, upwards.
    fn turned(&self, p: DVec3) -> DVec3 {
        match self.up {
            Up::Z => p,
            Up::Y => DVec3::new(p.x, -p.z, p.y),
        }
    }

    /// The corners of what is drawn, lowest first, metres.
    fn bounds(&self) -> [DVec3; 2] {
        let [a, b] = [self.low, self.high].map(|p| self.turned(p));
        [a.min(b), a.max(b)]
    }

    fn pixels_per_metre(&self) -> f64 {
        let [low, high] = self.bounds();
        f64::from(WIDTH - 2 * MARGIN) / (high.x - low.x).max(1e-3)
    }
}

const WIDTH: u32 = 840;
const MARGIN: u32 = 20;
/// Above the plan, for title and legend.
const HEAD: u32 = 120;
/// Edges that would be drawn shorter than this are left out, pixels.
const SHORTEST: f64 = 9.0;

impl Picture for Plan {
    fn size(&self) -> (u32, u32) {
        let [low, high] = self.bounds();
        let tall = (high.y - low.y + high.z - low.z) * self.pixels_per_metre();
        (WIDTH, HEAD + 2 * MARGIN + tall as u32)
    }

    fn draw<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let [low, high] = self.bounds();
        let scale = self.pixels_per_metre();
        let plan_bottom = f64::from(HEAD) + (high.y - low.y) * scale;
        let elevation_bottom = plan_bottom + f64::from(MARGIN) + (high.z - low.z) * scale;
        self.legend(area)?;
        let across = |p: DVec3| (f64::from(MARGIN) + (p.x - low.x) * scale).round() as i32;
        self.view(area, &|p| (across(p), (plan_bottom - (p.y - low.y) * scale).round() as i32))?;
        self.view(area, &|p| (across(p), (elevation_bottom - (p.z - low.z) * scale).round() as i32))
    }
}

const GROUPS: [RGBColor; 2] = [RED, BLUE];

impl Plan {
    fn view<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>, at: &impl Fn(DVec3) -> (i32, i32)) -> Drawn<B> {
        let place = |p: DVec3| at(self.turned(p));
        let outlines = [
            (&self.still, GREY.mix(0.35).stroke_width(1)),
            (&self.stood, OCHRE.stroke_width(1)),
            (&self.stands, GREEN.stroke_width(2)),
        ];
        for (edges, style) in outlines {
            let drawn: BTreeSet<[(i32, i32); 2]> = edges
                .iter()
                .map(|ends| {
                    let mut ends = ends.map(place);
                    ends.sort();
                    ends
                })
                .filter(|[a, b]| f64::from(a.0 - b.0).hypot(f64::from(a.1 - b.1)) >= SHORTEST)
                .collect();
            for ends in drawn {
                area.draw(&PathElement::new(ends, style))?;
            }
        }
        for (bundle, colour) in self.bundles.iter().zip(GROUPS) {
            // What met the object on the way is drawn last, over the rest.
            for found in [false, true] {
                for (points, _) in bundle.paths.iter().filter(|(_, meets)| *meets == found) {
                    let points: Vec<_> = points.iter().map(|p| place(*p)).collect();
                    let strength = if found { 0.85 } else { 0.25 };
                    area.draw(&PathElement::new(
                        points[..points.len().min(2)].to_vec(),
                        colour.mix(strength * 0.5).stroke_width(1),
                    ))?;
                    if let [_, bounce, end] = points[..] {
                        area.draw(&PathElement::new(vec![bounce, end], colour.mix(strength).stroke_width(1)))?;
                        if found {
                            area.draw(&Circle::new(end, 2, colour.filled()))?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn legend<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let mut y = 14;
        area.draw(&Text::new(self.title.as_str(), (MARGIN as i32, y), (FONT, 17).into_font().color(&INK)))?;
        let groups = self.bundles.iter().zip(GROUPS).map(|(bundle, colour)| {
            let Bundle { group, photons, after_a_bounce, .. } = bundle;
            let text = format!(
                "group {}: of {photons} corrective photons {after_a_bounce} meet the object, or the place it left, after one bounce (strong; dots: where they land)",
                group.0
            );
            (text, colour)
        });
        let places = [("what was moved, where it stands now".to_string(), GREEN), ("and where it stood".to_string(), OCHRE)];
        for (text, colour) in groups.chain(places) {
            y += 22;
            let line = vec![(MARGIN as i32, y + 7), (MARGIN as i32 + 24, y + 7)];
            area.draw(&PathElement::new(line, colour.stroke_width(3)))?;
            area.draw(&Text::new(text, (MARGIN as i32 + 32, y), (FONT, 14).into_font().color(&INK)))?;
        }
        Ok(())
    }
}

//! The hybrid is whole: direct light from the rasteriser and indirect light from the buckets are the light of photons alone.
//!
//! A pool whose first hits always count and the same pool with first hits as the lamps say differ by the direct light that is the
//! rasteriser's to draw. It is compared with what the rasteriser does draw, element by element, each side by itself, over all pixels of a
//! view that sees the whole element.

mod solved;

use glam::DVec3;
use lightmend_scene::{Direct, Up};
use lightmend_tests::{Builder, count, own_scene_untextured};
use solved::Hybrid;

/// The direct light is whole, and mistakes of one per cent or of the side would be found; so is the indirect light, on at least `sides`
/// sides of objects that are seen as a whole.
fn check(name: &str, hybrid: &Hybrid, sides: usize) {
    let right = hybrid.compare_direct(|side| side, 1.0);
    right.print(name);
    assert!(right.elements > 500, "{right:?}");
    // Photons of a low-discrepancy sequence scatter less than each by itself: χ² stays below 1 per element.
    assert!(right.chi_squared() < 1.0 && right.worst.abs() < 4.0, "{right:?}");
    // For the same reason this is generous, and the total, of millions of photons, could be off by 0.1 % by chance.
    assert!(right.mean().abs() < 3.0 && right.total().abs() < 0.005, "{right:?}");
    // Where nothing is drawn nothing arrives; a sliver of light between pixels would bring a photon or two.
    assert!(right.dark > 0 && right.dark_hits < 0.1 * right.dark as f64, "{right:?}");
    for (mistake, wrong) in
        [("1 % too much", hybrid.compare_direct(|side| side, 1.01)), ("1 % too little", hybrid.compare_direct(|side| side, 0.99))]
    {
        wrong.print(mistake);
        assert!(wrong.mean().abs() > 3.0 && wrong.total().abs() > 0.005, "{mistake}: {wrong:?}");
    }
    let wrong = hybrid.compare_direct(|side| 1 - side, 1.0);
    assert!(wrong.chi_squared() > 10.0 && wrong.worst.abs() > 10.0, "sides swapped: {wrong:?}");
    assert!(hybrid.check_indirect(name) >= sides);
}

#[test]
fn the_cornell_box_is_whole() {
    let eyes = [[1.0, 1.0, 1.0], [0.3, 0.4, 1.5], [1.7, 0.4, 0.6], [1.0, 1.7, 1.7]];
    check("cornell", &Hybrid::new(&own_scene_untextured("cornell"), &eyes, count(4_000_000, 40_000_000)), 4);
}

#[test]
fn the_room_is_whole() {
    let eyes = [[3.0, 2.5, 1.6], [0.8, 1.2, 1.4], [5.2, 3.6, 1.3], [2.9, 3.9, 0.5]];
    check("room", &Hybrid::new(&own_scene_untextured("room"), &eyes, count(4_000_000, 40_000_000)), 1);
}

/// Brighter to one side than to the other.
const LOPSIDED: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 4 3 1 2 0 0 0\n1 1 10\n0 30 60 120\n0 90 180\n\
    100 90 80 10\n100 60 40 30\n100 50 20 5\n";

#[test]
fn both_sides_of_thin_plates_are_whole() {
    // y up; lamps on both sides of the plates, one of them turned with its carrier, one left to the photons.
    let mut builder = Builder::default()
        .cuboid("room", 0.6, [0.0; 3], [3.0, 2.2, 2.6], true)
        .rectangle("upright", 0.5, [1.4, 0.5, 0.6], [0.3, 0.0, 1.3], [0.0, 1.1, 0.2])
        .rectangle("lying", 0.7, [0.3, 0.6, 0.4], [0.8, 0.1, 0.0], [0.0, 0.2, 0.9])
        .cuboid("carrier", 0.4, [-0.1; 3], [0.1; 3], false)
        .lamp([0.7, 1.6, 1.3], 60.0)
        .lamp([2.4, 1.3, 1.1], 40.0)
        .lamp([0.2, 0.25, 0.1], 1.0)
        .lamp([2.2, 0.5, 2.2], 30.0);
    (builder.file.up, builder.file.cell) = (Up::Y, 0.15);
    builder.file.objects[3].position = DVec3::new(0.6, 0.15, 0.6);
    builder.file.objects[3].rotation = DVec3::new(25.0, 40.0, -15.0);
    builder.file.lamps[2].on = Some("carrier".into());
    builder.file.lamps[2].photometry = Some("lopsided.ies".into());
    builder.file.lamps[2].rotation = DVec3::new(150.0, 20.0, 70.0);
    builder.file.lamps[3].direct = Direct::Photons;
    let scene = builder.build(&[("lopsided.ies", LOPSIDED)]);
    let hybrid = Hybrid::new(&scene, &[[1.9, 1.1, 0.5], [0.7, 1.2, 2.2], [0.9, 0.3, 1.6]], count(2_000_000, 20_000_000));
    check("plates", &hybrid, 4);
    let [front, back] = hybrid.compare_direct(|side| side, 1.0).sides;
    assert!(front > 100 && back > 100, "{front}, {back}");
}

//! Cases of masks that must be right, and what is told of them.

use lightmend_scene::{Configuration, View};
use lightmend_tests::{
    masks::{Compared, Excuse, Light, Picture, Tally, draw},
    pixels::renderer,
    rays::Rays,
};
use std::{fmt::Write, path::PathBuf};

/// What stands somewhere, and where it is looked at from.
pub struct Case {
    /// What it is.
    pub name: String,
    /// Shown one after the other by one renderer; all their lamps are compared.
    pub shown: Vec<Configuration>,
    /// Names and cameras.
    pub views: Vec<(String, View)>,
    /// Pixels.
    pub size: [u32; 2],
}

/// Leaves the mask, what was expected, and the difference (red; yellow at edges); names the three.
fn leave_pictures(compared: &Compared, name: &str, mask: &[bool], [width, height]: [u32; 2]) -> String {
    let grey = |l: &Light| match l {
        Light::Nothing => [40, 40, 60],
        Light::Away => [60, 60, 90],
        Light::Grazing => [90, 60, 90],
        Light::Shadow => [0; 3],
        Light::Lit => [255; 3],
    };
    let expected: Vec<[u8; 3]> = compared.expected.iter().map(grey).collect();
    let drawn: Vec<[u8; 3]> = mask.iter().map(|m| if *m { [255; 3] } else { [0; 3] }).collect();
    let mut difference: Vec<[u8; 3]> = expected.iter().map(|p| p.map(|c| c / 3)).collect();
    for (pixel, excuse) in &compared.differ {
        difference[*pixel] = if *excuse == Excuse::None { [255, 0, 0] } else { [255, 255, 0] };
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let name: String = name.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    let write = |what: &str, pixels: &[[u8; 3]]| {
        let path = folder.join(format!("shadows_{name}_{what}.png"));
        image::save_buffer(&path, pixels.as_flattened(), width, height, image::ColorType::Rgb8).unwrap();
        path.display().to_string()
    };
    [write("mask", &drawn), write("expected", &expected), write("difference", &difference)].join(", ")
}

/// Compares all masks of a case, and says which are wrong.
fn check_case(case: &Case, faults: &mut Vec<String>) -> Tally {
    let mut renderer = renderer();
    let mut sum = Tally::default();
    for (step, configuration) in case.shown.iter().enumerate() {
        renderer.show(configuration).unwrap();
        let rays = Rays::new(configuration);
        for (view_name, view) in &case.views {
            draw(&mut renderer, view, case.size);
            let picture = Picture::new(&rays, view, case.size, &renderer.seen().unwrap());
            let lamps: Vec<usize> = renderer.drawn_lamps().collect();
            for (n, lamp) in lamps.into_iter().enumerate() {
                let mask = renderer.mask(n).unwrap();
                let compared = picture.compare(&mask, lamp);
                let tally = compared.tally(case.size[0] as usize);
                if tally.wrong > 0 {
                    let name = format!("{} {step}, camera {view_name}, {}", case.name, configuration.lamp(lamp).name);
                    let pictures = leave_pictures(&compared, &name, &mask, case.size);
                    faults.push(format!("{name}: {} wrong pixels: {pictures}", tally.wrong));
                }
                sum += tally;
            }
        }
    }
    sum
}

/// Compares all masks of all cases, prints a table, and fails if a pixel is wrong without an excuse.
pub fn check(title: &str, cases: impl IntoIterator<Item = Case>) {
    let head = "masks    facing    lit  at an edge  grazing  wrong: at edges  on outlines  elsewhere";
    let mut table = format!("\n{title:<44} {head}\n");
    let mut faults = Vec::new();
    let mut all = Tally::default();
    for case in cases {
        let sum = check_case(&case, &mut faults);
        row(&mut table, &case.name, &sum);
        all += sum;
    }
    row(&mut table, "all", &all);
    println!("{table}");
    assert!(faults.is_empty(), "{} masks are wrong:\n{}", faults.len(), faults.join("\n"));
    assert!(all.lit > 0 && all.lit < all.facing, "neither light nor shadow is missing");
    // Excuses are rare: of the pixels that face a lamp, one in 20,000 is wrong at an edge, one in a million on an outline, and one
    // in 50 is too grazing to be compared.
    let within = |n: usize, one_in: usize| n * one_in <= all.facing;
    assert!(within(all.wrong_at_edges, 20_000) && within(all.wrong_on_outlines, 1_000_000) && within(all.grazing, 50));
}

fn row(table: &mut String, name: &str, tally: &Tally) {
    let Tally { masks, facing, grazing, wrong_at_edges, wrong_on_outlines, wrong, .. } = tally;
    let share = |n: usize| 100.0 * n as f64 / (*facing).max(1) as f64;
    let (lit, edges) = (share(tally.lit), share(tally.edges));
    let wrong = format!("{wrong_at_edges:>15} {wrong_on_outlines:>12} {wrong:>10}");
    writeln!(table, "{name:<44} {masks:>5} {facing:>9} {lit:>5.1}% {edges:>10.2}% {grazing:>8} {wrong}").unwrap();
}

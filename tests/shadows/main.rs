//! Shadows are right: the rasteriser's masks against ray-traced visibility, pixel by pixel over pixels that face the lamp.
//!
//! More than one pixel away from where visibility really changes, no pixel may be wrong. Pixels at edges are counted and printed; so
//! are the few in ten million that lie on the very outline of what they see, as exactly as rasterisers count.

mod check;
mod places;
mod shapes;

use check::{Case, check};
use glam::DVec3;
use lightmend_scene::{Configuration, Edit, Scene, View};
use lightmend_tests::{
    count,
    masks::{Excuse, Light, Picture, draw},
    own_scene,
    pixels::renderer,
    rays::Rays,
};
use std::sync::Arc;

/// Pixels of a picture.
fn size(usual: [u64; 2]) -> [u32; 2] {
    [count(usual[0], 640) as u32, count(usual[1], 480) as u32]
}

fn case(name: &str, scene: &Arc<Scene>, mut views: Vec<(String, View)>, usual: [u64; 2], random: u64) -> Case {
    views.extend(places::random_views(scene, random));
    Case { name: name.into(), shown: vec![Configuration::initial(scene)], views, size: size(usual) }
}

#[test]
fn masks_of_our_scenes_are_right() {
    let own = |name: &str| {
        let scene = own_scene(name);
        case(name, &scene, scene.cameras.clone(), [320, 240], count(4, 30))
    };
    check("our scenes", ["cornell", "room", "house"].map(own));
}

#[test]
fn masks_of_built_shapes_are_right() {
    let cases = shapes::all().into_iter().map(|(name, scene)| case(name, &scene, places::about(&scene), [240, 180], count(2, 8)));
    check("built shapes", cases);
}

#[test]
fn masks_of_other_peoples_furniture_are_right() {
    let Some(corpus) = std::env::var_os("LIGHTMEND_CORPUS") else {
        println!("skipped: LIGHTMEND_CORPUS is not set");
        return;
    };
    let cases = shapes::furniture(corpus.as_ref())
        .map(|(name, scene)| case(&name, &scene, places::about(&scene), [240, 180], count(0, 8)));
    check("furniture", cases);
}

#[test]
fn masks_follow_edits() {
    // Volumes are kept from frame to frame: each edit here makes some of them wrong.
    let scene = own_scene("room");
    let edits = [
        Edit::Move { object: "table".into(), to: DVec3::new(2.2, 2.6, 0.0) },
        Edit::Turn { object: "floor lamp".into(), to: DVec3::new(0.0, 0.0, 100.0) },
        Edit::MoveLamp { lamp: "pendant".into(), to: DVec3::new(2.3, 2.5, 1.5) },
        Edit::Duplicate { object: "pouf".into(), name: "another".into(), to: DVec3::new(3.3, 2.2, 0.4) },
        Edit::Switch { lamp: "ceiling light".into(), on: false },
        Edit::Remove { object: "sofa".into() },
        Edit::Switch { lamp: "ceiling light".into(), on: true },
        Edit::Move { object: "table".into(), to: DVec3::new(1.9, 3.0, 0.0) },
    ];
    let mut shown = vec![Configuration::initial(&scene)];
    for edit in &edits {
        let next = shown.last().unwrap().apply(edit).unwrap();
        shown.push(next);
    }
    let views = scene.cameras[..2].to_vec();
    check("edits", [Case { name: "room".into(), shown, views, size: size([240, 180]) }]);
}

/// Share of the pixels that face a lamp of `scene` where `change`d masks are wrong.
fn noticed(scene: &Arc<Scene>, change: impl Fn(Vec<Vec<bool>>) -> Vec<Vec<bool>>) -> f64 {
    let configuration = Configuration::initial(scene);
    let (mut renderer, rays) = (renderer(), Rays::new(&configuration));
    renderer.show(&configuration).unwrap();
    let view = &scene.cameras[0].1;
    draw(&mut renderer, view, [160, 120]);
    let picture = Picture::new(&rays, view, [160, 120], &renderer.seen().unwrap());
    let lamps: Vec<usize> = renderer.drawn_lamps().collect();
    let masks: Vec<Vec<bool>> = (0..lamps.len()).map(|n| renderer.mask(n).unwrap()).collect();
    let compared = change(masks).into_iter().zip(lamps).map(|(mask, lamp)| picture.compare(&mask, lamp));
    let (wrong, facing) = compared.fold((0, 0), |(wrong, facing), compared| {
        let facing_now = compared.expected.iter().filter(|l| matches!(l, Light::Lit | Light::Shadow)).count();
        (wrong + compared.excused(Excuse::None), facing + facing_now)
    });
    wrong as f64 / facing as f64
}

#[test]
fn a_wrong_mask_is_noticed() {
    let scene = own_scene("room");
    assert_eq!(noticed(&scene, |masks| masks), 0.0);
    let swapped = noticed(&scene, |mut masks| {
        masks.rotate_left(1);
        masks
    });
    let mirrored = noticed(&scene, |mut masks| {
        masks.iter_mut().for_each(|mask| mask.chunks_mut(160).for_each(<[bool]>::reverse));
        masks
    });
    let moved = noticed(&scene, |mut masks| {
        masks.iter_mut().for_each(|mask| mask.rotate_left(3));
        masks
    });
    println!(
        "wrong masks: another lamp's {swapped:.3}, mirrored {mirrored:.3}, three pixels to the left {moved:.4} of the pixels"
    );
    assert!(swapped > 0.1 && mirrored > 0.1 && moved > 1e-3);
}

//! 8. Grazing and degenerate views: the rasteriser's masks against ray-traced visibility (`tests/shadows`).

use glam::DVec3;
use lightmend_scene::{Configuration, View};
use lightmend_tests::{
    Builder, count,
    masks::{Excuse, Picture, draw},
    pixels::renderer,
    rays::Rays,
    table::Row,
};

pub fn rows() -> Vec<Row> {
    let lamp = DVec3::new(0.7, 0.9, 2.1);
    let (low, high) = (DVec3::new(1.6, 1.1, 0.0), DVec3::new(2.3, 1.7, 0.8));
    let scene = Builder::default()
        .cuboid("room", 0.6, [0.0; 3], [4.0, 3.0, 2.5], true)
        .cuboid("box", 0.6, low.to_array(), high.to_array(), false)
        .rectangle("sheet", 0.6, [2.8, 0.8, 0.5], [0.6, 0.0, 0.0], [0.0, 0.7, 0.0])
        .lamp(lamp.to_array(), 100.0)
        .build(&[]);
    let configuration = Configuration::initial(&scene);
    let rays = Rays::new(&configuration);
    let mut renderer = renderer();
    renderer.show(&configuration).unwrap();
    let size = [count(160, 640) as u32, count(120, 480) as u32];
    let edge = DVec3::new(high.x, high.y, high.z);
    let on_volume = edge + (edge - lamp) * 0.15;
    let view = |eye: DVec3, target: DVec3| View { eye, target, fov: 70.0 };
    let views = [
        ("on the edge of a shadow volume", view(on_volume, DVec3::new(1.0, 1.2, 0.3))),
        ("inside a box", view((low + high) / 2.0, DVec3::new(3.5, 2.5, 1.0))),
        ("in the plane of a box's top", view(DVec3::new(0.3, 1.4, high.z), DVec3::new(3.0, 1.4, high.z))),
        ("in the plane of a sheet", view(DVec3::new(0.3, 1.1, 0.5), DVec3::new(3.0, 1.1, 0.5))),
        ("silhouette edge seen end-on", view(DVec3::new(0.3, low.y, high.z), DVec3::new(3.0, low.y, high.z))),
        ("lamp exactly at the camera", view(lamp, (low + high) / 2.0)),
        ("lamp straight ahead, far wall behind it", view(DVec3::new(3.7, 0.9, 2.1), lamp)),
        ("straight down from the lamp", view(lamp, lamp - DVec3::Z)),
    ];
    let mut rows = Vec::new();
    for (case, view) in views {
        draw(&mut renderer, &view, size);
        let broken = renderer.samples().unwrap().iter().flatten().filter(|x| !x.is_finite()).count();
        let picture = Picture::new(&rays, &view, size, &renderer.seen().unwrap());
        let lamps: Vec<usize> = renderer.drawn_lamps().collect();
        let (mut wrong, mut edges) = (0, 0);
        for (n, lamp) in lamps.into_iter().enumerate() {
            let compared = picture.compare(&renderer.mask(n).unwrap(), lamp);
            wrong += compared.excused(Excuse::None);
            edges += compared.excused(Excuse::Edge);
        }
        rows.push(Row::exactly(
            case,
            "pixels of the mask that are wrong, a pixel and more from any edge; numbers not finite",
            "0; 0".to_owned(),
            "ray-traced visibility",
            format!("{wrong}; {broken}"),
        ));
        let pixels = f64::from(size[0] * size[1]);
        rows.push(Row::at_most(
            case,
            "share of pixels that are wrong within a pixel of an edge",
            "ray-traced visibility",
            edges as f64 / pixels,
            1e-3,
        ));
    }
    rows
}

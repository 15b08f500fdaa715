//! Cut polygons keep area and winding, and nothing crashes.

use proptest::prelude::*;

use super::*;

fn cut(corners: &[DVec3]) -> Vec<[u32; 3]> {
    let mut out = Vec::new();
    Cutter::default().cut(corners, &mut out);
    out
}

fn twice_area(corners: &[DVec3], [a, b, c]: [u32; 3]) -> DVec3 {
    let [a, b, c] = [a, b, c].map(|i| corners[i as usize]);
    (b - a).cross(c - a)
}

/// Twice the enclosed area along the normal.
fn newell(corners: &[DVec3]) -> DVec3 {
    (2..corners.len()).map(|i| (corners[i - 1] - corners[0]).cross(corners[i] - corners[0])).sum()
}

/// Area, winding and outline are those of the polygon, and no triangle is flat.
fn assert_exact(corners: &[DVec3]) {
    let triangles = cut(corners);
    assert_eq!(triangles.len(), corners.len() - 2, "{corners:?} → {triangles:?}");
    let whole = newell(corners);
    let mut sum = 0.0;
    for &t in &triangles {
        let part = twice_area(corners, t);
        assert!(part.dot(whole) > 0.0, "{corners:?}: {t:?} is turned over");
        assert!(!has_no_area(t.map(|i| corners[i as usize])));
        sum += part.length();
    }
    assert!((sum - whole.length()).abs() <= 1e-9 * whole.length(), "{sum} ≠ {}", whole.length());
    // Each side of the outline is the side of a triangle: no cracks to neighbours.
    for i in 0..corners.len() as u32 {
        let side = (i, (i + 1) % corners.len() as u32);
        assert!(triangles.iter().any(|&[a, b, c]| [(a, b), (b, c), (c, a)].contains(&side)), "{side:?} is lost");
    }
}

fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
    points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

#[test]
fn convex_quads_are_halved_from_the_first_corner() {
    let quad = flat(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
    assert_eq!(cut(&quad), [[0, 1, 2], [0, 2, 3]]);
    let back: Vec<DVec3> = quad.iter().rev().copied().collect();
    assert_eq!(cut(&back), [[0, 1, 2], [0, 2, 3]]);
    let bent = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.4), DVec3::Y];
    assert_eq!(cut(&bent), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn concave_polygons_are_not_fans() {
    assert_exact(&flat(&[[0.0, 0.0], [2.0, -1.0], [0.5, 0.0], [2.0, 1.0]]));
    let comb =
        [[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [4.0, 3.0], [4.0, 1.0], [3.0, 1.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [0.0, 3.0]];
    assert_exact(&flat(&comb));
    assert_exact(&flat(&comb).into_iter().rev().collect::<Vec<_>>());
    assert_exact(&flat(&comb).into_iter().map(|p| DVec3::new(0.0, p.x, p.y) + 1e4).collect::<Vec<_>>());
}

#[test]
fn corners_on_a_side_are_kept() {
    assert_exact(&flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]));
    assert_exact(&flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]]));
    let many: Vec<[f64; 2]> =
        (0..10).map(|i| [f64::from(i) * 0.1, 0.0]).chain([[1.0, 0.0], [1.0, 0.5], [1.0, 1.0], [0.0, 1.0]]).collect();
    assert_exact(&flat(&many));
    let tilted: Vec<DVec3> = flat(&many).iter().map(|p| DVec3::new(0.6 * p.x, 0.8 * p.x, p.y) / 3.0).collect();
    assert_exact(&tilted);
}

#[test]
fn repeated_corners_change_nothing() {
    let quad = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    let triangles = cut(&quad);
    assert_eq!(triangles.len(), 1);
    assert_eq!(twice_area(&quad, triangles[0]), DVec3::Z);
}

#[test]
fn polygons_without_area_give_flat_triangles() {
    for points in [&[[0.0, 0.0]; 5][..], &[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]] {
        let corners = flat(points);
        let triangles = cut(&corners);
        assert!(!triangles.is_empty());
        assert!(triangles.iter().all(|t| has_no_area(t.map(|i| corners[i as usize]))));
    }
}

#[test]
fn area_is_judged_at_any_scale() {
    let triangle = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 1e-6, 0.0)];
    for scale in [1e-300, 1e-9, 1.0, 1e9, 1e300, f64::MAX] {
        assert!(!has_no_area(triangle.map(|p| p * scale)), "{scale}");
        assert!(has_no_area([DVec3::ZERO, DVec3::X, DVec3::X * 0.5].map(|p| p * scale)), "{scale}");
    }
    assert!(has_no_area([DVec3::ONE, DVec3::ONE, DVec3::X]));
    assert!(has_no_area([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 1e-15, 0.0)]));
}

proptest! {
    #[test]
    fn star_shaped_polygons_keep_their_area(
        radii in prop::collection::vec(0.1..10.0, 4..60),
        normal in [-1.0..1.0, -1.0..1.0, -1.0..1.0_f64],
        offset in -1000.0..1000.0,
    ) {
        let normal = DVec3::from(normal);
        prop_assume!(normal.length() > 0.1);
        let (u, v) = normal.normalize().any_orthonormal_pair();
        let step = std::f64::consts::TAU / radii.len() as f64;
        let corners: Vec<DVec3> = radii.iter().enumerate().map(|(i, r)| {
            let (sin, cos) = (i as f64 * step).sin_cos();
            offset + r * (cos * u + sin * v)
        }).collect();
        assert_exact(&corners);
    }

    #[test]
    fn skylines_with_many_corners_on_a_side_keep_their_outline(
        heights in prop::collection::vec(1..4_u8, 2..20),
        turn in prop::option::of(0.0..std::f64::consts::TAU),
    ) {
        let end = heights.len() as f64;
        let ground = (0..heights.len()).map(|i| [i as f64, 0.0]);
        let mut roof = vec![[end, 0.0]];
        for (i, &height) in heights.iter().enumerate().rev() {
            for corner in [[i as f64 + 1.0, f64::from(height)], [i as f64, f64::from(height)]] {
                if roof.last() != Some(&corner) {
                    roof.push(corner);
                }
            }
        }
        let outline: Vec<[f64; 2]> = ground.chain(roof).collect();
        // Turned, the corners on a side are so up to rounding alone.
        let (sin, cos) = turn.unwrap_or(0.0).sin_cos();
        let corners: Vec<DVec3> = flat(&outline).iter().map(|p| DVec3::new(p.y * sin + 7.0, p.x, p.y * cos)).collect();
        assert_exact(&corners);
        let corners: Vec<DVec3> =
            flat(&outline).iter().map(|p| DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, 0.3 * p.x)).collect();
        assert_exact(&corners);
    }

    #[test]
    fn polygons_of_any_kind_do_not_crash(points in prop::collection::vec([0..4_i8, 0..4_i8, 0..2_i8], 3..40)) {
        let corners: Vec<DVec3> = points.iter().map(|p| DVec3::from(p.map(f64::from))).collect();
        for t in cut(&corners) {
            prop_assert!(t.iter().all(|&i| (i as usize) < corners.len()));
        }
    }

    #[test]
    fn numbers_of_any_size_do_not_crash(points in prop::collection::vec([-1.7e308..1.7e308_f64, -1e-300..1e-300, -1.0..1.0], 3..12)) {
        let corners: Vec<DVec3> = points.into_iter().map(DVec3::from).collect();
        prop_assert!(!cut(&corners).is_empty());
    }
}

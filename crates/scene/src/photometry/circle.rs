//! What the horizontal angles of an LM-63 file say about symmetry, and the file's planes unfolded to the whole circle.
//!
//! ANSI/IESNA LM-63-2002, §5.14: the last horizontal angle of a type C file states the symmetry. Also accepted: a full
//! circle whose closing plane at 360° is left out, as many programs write it.

/// Symmetry of a lamp about its vertical planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symmetry {
    /// One plane: the same all around.
    Axial,
    /// Planes 0..90: mirrored in both the C 0-180 and the C 90-270 plane.
    Quadrant,
    /// Planes 0..180: mirrored in the C 0-180 plane.
    Bilateral,
    /// Planes 90..270: mirrored in the C 90-270 plane.
    BilateralAcross,
    /// Planes around the whole circle.
    Full,
}

/// Angles as near as this to 90, 180, 270 or 360 are meant to be that, degrees.
const SNAP: f64 = 1e-6;

/// The planes of the whole circle: (C in degrees, strictly increasing from 0 to 360; plane of the file).
pub(super) type Planes = Vec<(f64, usize)>;

/// The symmetry that the (strictly increasing) horizontal angles state; the reason when they state none.
pub(super) fn symmetry(angles: &mut [f64]) -> Result<Symmetry, String> {
    for angle in angles.iter_mut() {
        let quarter = (*angle / 90.0).round() * 90.0;
        if (*angle - quarter).abs() < SNAP {
            *angle = quarter;
        }
    }
    let (first, last) = (angles[0], angles[angles.len() - 1]);
    match (first, last) {
        _ if angles.len() == 1 => Ok(Symmetry::Axial),
        (0.0, 90.0) => Ok(Symmetry::Quadrant),
        (0.0, 180.0) => Ok(Symmetry::Bilateral),
        (90.0, 270.0) => Ok(Symmetry::BilateralAcross),
        (0.0, last) if last > 180.0 && last <= 360.0 => Ok(Symmetry::Full),
        _ => Err(format!(
            "the horizontal angles run from {first} to {last}: type C needs 0 alone, 0 to 90, 0 to 180, 90 to 270 or 0 to 360 degrees"
        )),
    }
}

/// The planes of the file mirrored to the whole circle. A `BilateralAcross` file must have a plane at 180.
pub(super) fn unfold(angles: &[f64], symmetry: Symmetry) -> Planes {
    let own: Planes = angles.iter().copied().zip(0..).collect();
    match symmetry {
        Symmetry::Axial => vec![(0.0, 0), (360.0, 0)],
        Symmetry::Quadrant => mirrored(mirrored(own, 90.0), 180.0),
        Symmetry::Bilateral => mirrored(own, 180.0),
        Symmetry::BilateralAcross => {
            let before = own.iter().rev().filter(|p| p.0 <= 180.0).map(|&(c, k)| (180.0 - c, k));
            let after = own.iter().rev().filter(|p| p.0 >= 180.0).skip(1).map(|&(c, k)| (540.0 - c, k));
            before.chain(own.iter().skip(1).copied()).chain(after).collect()
        }
        Symmetry::Full => {
            let open = own.last().is_some_and(|p| p.0 < 360.0);
            own.into_iter().chain(open.then_some((360.0, 0))).collect()
        }
    }
}

/// The planes and, past the last one, their mirror images in the plane at `mirror` degrees.
fn mirrored(mut planes: Planes, mirror: f64) -> Planes {
    let images: Planes = planes.iter().rev().skip(1).map(|&(c, k)| (2.0 * mirror - c, k)).collect();
    planes.extend(images);
    planes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unfolded(angles: &[f64]) -> (Symmetry, Planes) {
        let mut angles = angles.to_vec();
        let s = symmetry(&mut angles).unwrap();
        (s, unfold(&angles, s))
    }

    #[test]
    fn every_symmetry_unfolds() {
        assert_eq!(unfolded(&[0.0]), (Symmetry::Axial, vec![(0.0, 0), (360.0, 0)]));
        let (s, planes) = unfolded(&[0.0, 30.0, 90.0]);
        assert_eq!(s, Symmetry::Quadrant);
        let want = [(0., 0), (30., 1), (90., 2), (150., 1), (180., 0), (210., 1), (270., 2), (330., 1), (360., 0)];
        assert_eq!(planes, want);
        let (s, planes) = unfolded(&[0.0, 45.0, 180.0000004]);
        assert_eq!((s, planes), (Symmetry::Bilateral, vec![(0.0, 0), (45.0, 1), (180.0, 2), (315.0, 1), (360.0, 0)]));
        let (s, planes) = unfolded(&[90.0, 120.0, 180.0, 250.0, 270.0]);
        assert_eq!(s, Symmetry::BilateralAcross);
        let want = [(0., 2), (60., 1), (90., 0), (120., 1), (180., 2), (250., 3), (270., 4), (290., 3), (360., 2)];
        assert_eq!(planes, want);
        let open = unfolded(&[0.0, 120.0, 240.0]);
        assert_eq!(open, (Symmetry::Full, vec![(0.0, 0), (120.0, 1), (240.0, 2), (360.0, 0)]));
        let closed = unfolded(&[0.0, 120.0, 240.0, 360.0]);
        assert_eq!(closed, (Symmetry::Full, vec![(0.0, 0), (120.0, 1), (240.0, 2), (360.0, 3)]));
    }

    #[test]
    fn other_ranges_are_refused() {
        for angles in [vec![0.0, 45.0], vec![-90.0, 90.0], vec![10.0, 350.0], vec![0.0, 170.0], vec![0.0, 370.0]] {
            assert!(symmetry(&mut angles.clone()).is_err(), "{angles:?}");
        }
    }
}

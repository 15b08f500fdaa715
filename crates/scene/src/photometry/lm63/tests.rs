//! The reader: accepted forms, warnings, malformed and damaged files.

use super::*;
use glam::DVec3;
use proptest::prelude::*;

const BILATERAL: &str = "IESNA:LM-63-1995\r\n[TEST] by TILT meter\r\n[MANUFAC] B\u{fc}ro\r\nTILT=NONE\r\n\
    1, 1000 2. 3,3 1 1 .5 -.5 0\r\n.5\t1 1e2\r\n0 45. 9e1\r\n0 90 180\r\n\
    1 2 3\r\n4 5 6\r\n7 8\r\n9\r\n";

fn parse(text: &str) -> Result<(Photometry, Vec<Warning>), SceneError> {
    Photometry::parse(text.as_bytes(), Path::new("lamp.ies"))
}

/// The text with its `TILT=NONE` and numbers, for one vertical table of 0, 45, 90.
fn table(horizontal: &str, planes: &str) -> String {
    let count = horizontal.split_whitespace().count();
    format!("TILT=NONE\n1 -1 1 3 {count} 1 2 0 0 0\n1 1 0\n0 45 90\n{horizontal}\n{planes}\n")
}

#[test]
fn factors_separators_and_line_ends() {
    let (p, warnings) = parse(BILATERAL).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!((p.vertical(), p.horizontal()), (&[0.0, 45.0, 90.0][..], &[0.0, 90.0, 180.0, 270.0, 360.0][..]));
    assert_eq!(p.symmetry(), Symmetry::Bilateral);
    // multiplier 2, ballast factor .5
    assert_eq!((p.candela_at(180.0, 90.0), p.candela_at(270.0, 45.0), p.max_candela()), (9.0, 5.0, 9.0));
    let latin1: Vec<u8> = BILATERAL.chars().map(|c| c as u8).collect();
    let lines_end = |end| BILATERAL.replace("\r\n", end);
    for same in [lines_end("\n"), lines_end("\r"), format!("{BILATERAL}END\n\u{1a}")] {
        assert_eq!(parse(&same).unwrap(), (p.clone(), vec![]));
    }
    assert_eq!(Photometry::parse(&latin1, Path::new("lamp.ies")).unwrap().0, p);
}

#[test]
fn open_circles_and_lamps_measured_across() {
    let (p, _) = parse(&table("0 120 240", "1 1 1 2 2 2 4 4 4")).unwrap();
    assert_eq!((p.symmetry(), p.candela_at(300.0, 10.0)), (Symmetry::Full, 2.5));
    let (p, _) = parse(&table("90 170 270", "1 1 1 9 9 9 5 5 5")).unwrap();
    assert_eq!(p.horizontal(), [0.0, 10.0, 90.0, 170.0, 180.0, 270.0, 360.0]);
    assert_eq!(p.symmetry(), Symmetry::BilateralAcross);
    for (c, mirror) in [(0.0, 180.0), (10.0, 170.0), (45.0, 135.0), (-80.0, 260.0), (355.0, 185.0)] {
        assert!((p.candela_at(c, 45.0) - p.candela_at(mirror, 45.0)).abs() < 1e-12, "{c}");
    }
    assert!((p.candela_at(0.0, 0.0) - 8.6).abs() < 1e-12);
}

#[test]
fn warnings_tell_what_is_left_out() {
    let tilt = "TILT=INCLUDE\n1\n2\n0 90\n1 .9\n";
    let text = table("0", "1 2 3").replace("TILT=NONE\n", tilt);
    for (text, part) in [
        (text, "TILT=INCLUDE"),
        (table("0", "0 0 0"), "no light"),
        (table("0", "1 2 3 made by hand"), "ignored"),
        (table("0", "1 2 3").replace("1 1 0\n", "1 .8 0\n"), "0.8 is not applied"),
        (table("0 90 200", "1 2 3 1 2 3 1 2 3"), "end at 200"),
        (table("0 180 360", "1 2 3 1 2 3 1 2 4"), "differ by 1"),
    ] {
        let (p, warnings) = parse(&text).unwrap();
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].0.starts_with("lamp.ies: ") && warnings[0].0.contains(part), "{warnings:?}");
        assert!(p.sample(0.3, 0.4).is_normalized());
    }
    let dark = parse(&table("0", "0 0 0")).unwrap().0;
    assert_eq!((dark.luminous_flux(), dark.sample(0.9, 0.9)), (0.0, DVec3::NEG_Z));
    let text = format!("IES:LM-63-2019\n{}", table("0", "1 2 3").replace("1 1 0\n", "1 1.00001 0\n"));
    assert_eq!(parse(&text).unwrap().1, []);
}

#[test]
fn malformed_files_name_the_line() {
    let good = table("0 90", "1 2 3\n4 5 6");
    assert!(parse(&good).is_ok());
    let with = |from: &str, to: &str| {
        assert!(good.contains(from));
        good.replacen(from, to, 1)
    };
    for (text, line, part) in [
        (String::new(), 1, "no TILT="),
        ("IESNA91\n[TEST] x\n".into(), 3, "no TILT="),
        (with("TILT=NONE", "TILT=lamp.tlt"), 1, "write TILT=NONE"),
        ("TILT=NONE".into(), 1, "the file ends before the number of lamps"),
        ("TILT=INCLUDE\n1\n1000000000\n0".into(), 4, "the file ends before a tilt angle"),
        (with("1 -1 1 3", "file -1 1 3"), 2, "found 'file'"),
        (with("3 2 1 2", "3.5 2 1 2"), 2, "vertical angles is 3.5"),
        (with("3 2 1 2", "3 -2 1 2"), 2, "horizontal angles is -2"),
        (with("3 2 1 2", "1 2 1 2"), 2, "two or more"),
        (with("3 2 1 2", "99999999 99999999 1 2"), 2, "too short"),
        (with("3 2 1 2", "1e300 2 1 2"), 2, "is 1"),
        (with("3 2 1 2", "3 2 2 2"), 2, "only type C"),
        (with("3 2 1 2", "3 2 3 2"), 2, "(A)"),
        (with("1 1 0\n", "-1 1 0\n"), 3, "is -1"),
        // 0 candela times infinity would be no number.
        (table("0 90", "0 0 0 4 5 6").replace("1 -1 1 3", "1 -1 1e200 3").replace("\n1 1 0", "\n1e200 1 0"), 3, "is inf"),
        (with("0 45 90", "0 90 45"), 4, "angles must increase"),
        (with("0 45 90", "0 45 45"), 4, "angles must increase"),
        (with("0 45 90", "-45 45 90"), 4, "0 to 180"),
        (with("0 45 90", "0 45 200"), 4, "0 to 180"),
        (with("\n0 90\n", "\n0 100\n"), 5, "run from 0 to 100"),
        (with("4 5 6", "4 5"), 8, "5 candela values; the counts in line 2 ask for 6"),
        (with("4 5 6", "4 5 6 7"), 7, "more candela"),
        (with("4 5 6", "4 -5 6"), 7, "-5 is not"),
        (with("4 5 6", "4 1e31 6"), 7, "1e31 is not"),
        (with("4 5 6", "4 nan 6"), 7, "found 'nan'"),
        (with("4 5 6", "4 inf 6"), 7, "found 'inf'"),
        (with("4 5 6", "4 \u{1f4a1} 6"), 7, "found"),
    ] {
        let SceneError::Line { line: at, what, .. } = parse(&text).unwrap_err() else { panic!("{text}") };
        assert!(at == line.to_string() && what.contains(part), "{text}\n{at}: {what}");
        assert!(!what.contains('\n'));
    }
}

#[test]
fn missing_and_endless_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lamp.ies");
    assert!(matches!(Photometry::read(&path), Err(SceneError::Read { .. })));
    std::fs::File::create(&path).unwrap().set_len(MAX_BYTES + 1).unwrap();
    assert!(matches!(Photometry::read(&path), Err(SceneError::Content { .. })));
}

/// Whatever is read can be sampled.
fn survives(bytes: &[u8]) {
    if let Ok((p, _)) = Photometry::parse(bytes, Path::new("lamp.ies")) {
        for k in 0..64 {
            let d = p.sample(k as f64 / 64.0, (k as f64 * 0.618) % 1.0);
            assert!(d.is_normalized() && (p.luminous_flux() == 0.0 || p.candela(d) > 0.0), "{d}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..Default::default() })]

    #[test]
    fn damaged_files_do_not_panic(
        cut in 0..400_usize,
        flips in prop::collection::vec((0..400_usize, any::<u8>()), 0..6),
        digits in prop::collection::vec((0..400_usize, prop::sample::select(b"0123456789.-+e, \n".to_vec())), 0..6),
    ) {
        for source in [BILATERAL.to_string(), table("0 90", "1 2 0\n0 0 6"), table("0 90 180 270", "1 2 3 4 5 6 7 8 9 0 0 0")] {
            let mut bytes = source.into_bytes();
            for &(at, byte) in flips.iter().chain(&digits) {
                let n = bytes.len();
                bytes[at % n] = byte;
            }
            survives(&bytes);
            bytes.truncate(cut);
            survives(&bytes);
        }
    }

    #[test]
    fn noise_does_not_panic(noise in prop::collection::vec(any::<u8>(), 0..200)) {
        survives(&noise);
        survives(&[b"TILT=NONE\n1 1 1 2 1 1 1 0 0 0 1 1 1 ", &noise[..]].concat());
    }
}

//! What could be noticed: textures that hide errors, and what cameras see of a repair.

use crate::desk::Desk;

#[test]
fn every_texture_gets_a_map_of_what_it_hides() {
    let desk = Desk::new();
    let room = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/room/room.ron");
    let told = desk.done(&format!("check {room} --masking maps"));
    let line =
        told.lines().find(|line| line.starts_with("rug ") && line.matches(", ").count() == 2).expect("the ROOM's only texture");
    let elevations: Vec<f64> = line.rsplit("  ").next().unwrap().split(", ").map(|t| t.parse().unwrap()).collect();
    assert!(elevations.len() == 3 && elevations.iter().all(|t| *t > 1.2 && *t < 10.0), "{line}");
    let maps: Vec<_> = std::fs::read_dir(desk.path("maps")).unwrap().map(|f| f.unwrap().path()).collect();
    let [map] = &maps[..] else { panic!("{maps:?}") };
    // The texture on the left, its map on the right: neither is of one colour.
    let picture = image::open(map).unwrap().to_luma8();
    let width = picture.width() / 2;
    for half in [0, width] {
        let values = || (0..width * width).map(|k| picture.get_pixel(half + k % width, k / width).0[0]);
        assert!(values().max().unwrap() - values().min().unwrap() > 20, "{half}");
    }
    // A scene without textures has none.
    desk.done("check cornell.ron --masking none");
    assert_eq!(std::fs::read_dir(desk.path("none")).unwrap().count(), 0);
}

#[test]
fn what_cameras_see_of_a_repair_ends_right() {
    let desk = Desk::new();
    desk.moves(&["Move(object: \"short box\", to: (1.5, 0.45, 0.0))"]);
    desk.done("replay cornell.ron --photons 20000 --script m.ron --out seen --views --orders ledger,stateless --quiet");
    let csv = desk.read("seen/views.csv");
    let rows: Vec<Vec<&str>> = csv.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let ways: std::collections::BTreeSet<[&str; 2]> = rows.iter().map(|row| [row[2], row[3]]).collect();
    assert!(ways.iter().any(|way| way[0] == "ledger") && ways.iter().any(|way| way[0] == "stateless"), "{ways:?}");
    for way in ways {
        let of_way: Vec<_> = rows.iter().filter(|row| [row[2], row[3]] == way).collect();
        let number = |row: &[&str], column: usize| row[column].parse::<f64>().unwrap();
        let (first, last) = (of_way[0], of_way[of_way.len() - 1]);
        // What is foreseen without the right light is known of a ledger alone, and never says too early that nobody will notice.
        let foreseen = |row: &[&str]| row[9].parse::<f64>().ok();
        assert_eq!((foreseen(first), foreseen(last)), (None, (way[0] == "ledger").then_some(0.0)), "{way:?}");
        if way[0] == "ledger" {
            assert!(of_way.iter().any(|row| foreseen(row) > Some(0.01)), "{way:?}");
            let foresees = |row: &[&str]| foreseen(row).is_some_and(|share| share <= 0.0005);
            let told = of_way.windows(2).find(|rows| rows.iter().all(|row| foresees(row))).unwrap();
            assert!(number(told[1], 8) <= 0.001, "{way:?}: {told:?}");
        }
        assert_eq!([4, 6, 8].map(|column| number(first, column) > 0.0), [false, true, true], "{way:?}: {first:?}");
        assert_eq!([6, 7, 8].map(|column| number(last, column)), [0.0; 3], "{way:?}: exact light differs in nothing");
    }
}

//! A saved solution goes on to the bits of one go, and is refused where it does not fit.

use crate::desk::Desk;
use lightmend_photon::{
    bucket::{Bucket, Full, MOST_DEPOSITS},
    saved::Saved,
};
use lightmend_scene::{Configuration, Scene};

#[test]
fn resuming_gives_the_bits_of_one_go() {
    let desk = Desk::new();
    desk.done("solve cornell.ron --photons 30000 --quiet --dump whole.txt");
    desk.done("solve cornell.ron --photons 11000 --quiet --out first");
    desk.done("solve cornell.ron --photons 30000 --quiet --resume first/solution.light --out second --dump parts.txt");
    assert!(desk.read("whole.txt") == desk.read("parts.txt"));
    desk.done("solve cornell.ron --photons 30000 --quiet --resume second/solution.light --dump same.txt");
    assert!(desk.read("whole.txt") == desk.read("same.txt"));
}

#[test]
fn light_that_cannot_be_counted_is_told() {
    let desk = Desk::new();
    desk.done("solve cornell.ron --photons 20000 --quiet --out saved");
    let cornell = Configuration::initial(&Scene::read(&desk.path("cornell.ron")).unwrap().0);
    let mut saved = Saved::read(&std::fs::read(desk.path("saved/solution.light")).unwrap(), &cornell).unwrap();
    let (at, bucket) = saved.buckets.lit().next().unwrap();
    saved.buckets.set(at, Bucket { hits: MOST_DEPOSITS, ..bucket });
    let mut file = Vec::new();
    saved.write(&cornell, &mut file).unwrap();
    desk.write("full.light", file);
    let run = desk.run("solve cornell.ron --photons 30000 --quiet --resume full.light --out out");
    let line = format!("lightmend: {Full}; 20000 were kept\n");
    assert_eq!((run.status, run.stderr), (Some(2), line));
    assert!(desk.path("out/solution.light").exists(), "what there is is written");
}

#[test]
fn what_does_not_fit_is_refused() {
    let desk = Desk::new();
    desk.done("solve cornell.ron --photons 20000 --quiet --out saved");
    desk.refuses(
        "solve cornell.ron --photons 10000 --resume saved/solution.light",
        &["solution.light", "has 20000 photons already"],
    );
    desk.refuses("solve cornell.ron --scramble 7 --resume saved/solution.light", &["solution.light", "--scramble"]);
    desk.refuses("solve cornell.ron --resume saved/summary.json", &["summary.json", "damaged"]);
    desk.refuses("solve cornell.ron --resume gone.light", &["gone.light", "cannot be read"]);
    // Dimming is read-out only; another reflectance is another scene.
    desk.change("intensity: (", "off: true, intensity: (");
    desk.done("solve cornell.ron --photons 20000 --quiet --resume saved/solution.light");
    desk.change("0.725", "0.7");
    desk.refuses("solve cornell.ron --resume saved/solution.light", &["solution.light", "another scene"]);
}

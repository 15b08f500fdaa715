//! Same input, same bits: however often, on however many threads, repaired or shot anew.

use crate::desk::Desk;

/// Equal, without printing megabytes if not.
fn same(desk: &Desk, a: &str, b: &str) {
    let (first, second) = (desk.read(a), desk.read(b));
    assert!(first.lines().count() > 1000, "{a} is no solution: {} lines", first.lines().count());
    assert!(first == second, "{a} and {b} differ");
}

#[test]
fn a_solution_depends_on_nothing_but_its_input() {
    let desk = Desk::new();
    for (name, threads) in [("first", ""), ("again", ""), ("one", "--threads 1"), ("two", "--threads 2"), ("four", "--threads 4")]
    {
        desk.done(&format!("solve cornell.ron --photons 20000 --quiet --dump {name}.tsv {threads}"));
    }
    for name in ["again.tsv", "one.tsv", "two.tsv", "four.tsv"] {
        same(&desk, "first.tsv", name);
    }
    // Groups order the work of a repair: a fresh solution is the same in any.
    desk.done("solve cornell.ron --photons 20000 --quiet --ng 6 --r 3 --dump groups.tsv");
    same(&desk, "first.tsv", "groups.tsv");
    desk.done("solve cornell.ron --photons 20000 --quiet --scramble 2 --dump other.tsv");
    assert!(desk.read("first.tsv") != desk.read("other.tsv"), "another permutation, another solution");
}

/// The invariant that Lightmend is built around.
#[test]
fn repaired_light_is_fresh_light() {
    let desk = Desk::new();
    desk.moves(&[
        "Move(object: \"short box\", to: (1.5, 0.45, 0.0))",
        "Turn(object: \"tall box\", to: (0.0, 0.0, 48.0))",
        "Drag(object: \"short box\", to: (1.2, 0.5, 0.3), step: 0.05, seconds: 1.0)",
    ]);
    desk.done("apply cornell.ron --script m.ron --quiet --out after.ron");
    desk.done("solve after.ron --photons 20000 --quiet --dump fresh.tsv");
    desk.done("replay cornell.ron --photons 20000 --quiet --script m.ron --out out --dump repaired.tsv");
    same(&desk, "fresh.tsv", "repaired.tsv");
    for edit in desk.json("out/summary.json")["edits"].as_array().expect("edits") {
        for (order, told) in edit["orders"].as_object().expect("orders") {
            assert_eq!(told["bit_equal_to_fresh"], true, "{order}");
        }
    }
}

#[test]
fn there_and_back_restores_the_first_bits() {
    let desk = Desk::new();
    desk.moves(&["Move(object: \"short box\", to: (1.5, 0.45, 0.0))", "Move(object: \"short box\", to: (1.32, 0.68, 0.0))"]);
    desk.done("solve cornell.ron --photons 20000 --quiet --dump first.tsv");
    desk.done("replay cornell.ron --photons 20000 --quiet --orders stateless --script m.ron --out out --dump back.tsv");
    same(&desk, "first.tsv", "back.tsv");
}

#[test]
fn an_applied_scene_finds_its_meshes_from_anywhere() {
    let desk = Desk::new();
    desk.folder("far/away");
    desk.folder("near");
    desk.moves(&["Move(object: \"short box\", to: (1.5, 0.45, 0.0))"]);
    desk.done("apply cornell.ron --script m.ron --quiet --out after.ron");
    desk.done("apply cornell.ron --script m.ron --quiet --out far/away/after.ron");
    desk.moves(&[]);
    desk.done("apply far/away/after.ron --script m.ron --quiet --out near/after.ron");
    for (scene, dump) in [("after.ron", "a.tsv"), ("far/away/after.ron", "b.tsv"), ("near/after.ron", "c.tsv")] {
        desk.done(&format!("solve {scene} --photons 20000 --quiet --dump {dump}"));
    }
    same(&desk, "a.tsv", "b.tsv");
    same(&desk, "a.tsv", "c.tsv");
}

#[test]
fn the_clock_ends_a_run_that_can_be_repeated() {
    let desk = Desk::new();
    desk.done("solve cornell.ron --seconds 0.2 --quiet --out out --dump clock.tsv");
    let summary = desk.json("out/summary.json");
    assert_eq!(summary["interrupted"], false);
    desk.done(&format!("solve cornell.ron --photons {} --quiet --dump again.tsv", summary["photons"]));
    same(&desk, "clock.tsv", "again.tsv");
}

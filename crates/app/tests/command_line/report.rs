//! `lightmend report`: its files and keys, errors that do not depend on threads, and input that it refuses.

use crate::desk::Desk;
use serde_json::Value;

const SMALL: &str = "--photons 20000 --reference-photons 80000";

/// A desk on which the Cornell box stands as our scenes do, with two moves of one edit each.
fn desk() -> Desk {
    let desk = Desk::new();
    desk.folder("box/moves");
    for name in ["cornell.ron", "box.obj", "short_box.obj", "tall_box.obj"] {
        desk.write(&format!("box/{}", name.replace("cornell", "box")), desk.bytes(name));
    }
    desk.write("box/moves/b_turn.ron", "(edits: [(at: 0.0, edit: Turn(object: \"tall box\", to: (0.0, 0.0, 48.0)))])");
    desk.write("box/moves/a_move.ron", "(edits: [(at: 0.0, edit: Move(object: \"short box\", to: (1.5, 0.45, 0.0)))])");
    desk
}

fn array<'a>(value: &'a Value, key: &str) -> &'a Vec<Value> {
    value[key].as_array().unwrap_or_else(|| panic!("no list {key}"))
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

/// The summary without what depends on the clock or the machine.
fn timeless(mut value: Value) -> Value {
    match &mut value {
        Value::Object(known) => {
            ["seconds", "threads", "processor"].iter().for_each(|key| {
                known.remove(*key);
            });
            known.values_mut().for_each(|v| *v = timeless(v.take()));
        }
        Value::Array(all) => all.iter_mut().for_each(|v| *v = timeless(v.take())),
        _ => {}
    }
    value
}

#[test]
fn what_is_written_is_what_is_documented() {
    let desk = desk();
    let printed = desk.done(&format!("report box/box.ron {SMALL} --out out --json"));
    let summary = desk.json("out/summary.json");
    assert_eq!(serde_json::from_str::<Value>(&printed).expect("one JSON document"), summary);
    assert_eq!(keys(&summary), ["interrupted", "processor", "scenes", "threads"]);
    let scene = &summary["scenes"][0];
    assert_eq!(keys(scene), ["camera", "cells", "copies", "file", "ng", "photons", "r", "scene", "states", "triangles"]);
    let states = array(scene, "states");
    let names: Vec<(&Value, &Value)> = states.iter().map(|s| (&s["script"], &s["edit"])).collect();
    assert_eq!(names, [(&Value::Null, &Value::Null), (&"a_move".into(), &0.into()), (&"b_turn".into(), &0.into())]);
    for state in states {
        assert_eq!(keys(state), ["balance", "edit", "orders", "reference", "script", "title"]);
        let balance = &state["balance"];
        assert_eq!(keys(balance), ["absorbed", "cut", "emitted", "escaped", "exact", "mean", "standard_error"]);
        assert_eq!((&balance["emitted"], &balance["exact"]), (&20_000.into(), &true.into()));
        for (mean, se) in array(balance, "mean").iter().zip(array(balance, "standard_error")) {
            let off = (mean.as_f64().expect("a number") - 1.0) / se.as_f64().expect("a number");
            assert!(off.abs() < 4.0, "{off} standard errors");
        }
        let orders = keys(&state["orders"]);
        let wanted: &[&str] =
            if state["script"].is_null() { &["ledger", "no ledger"] } else { &["ledger", "random", "restart", "stateless"] };
        assert_eq!(orders, wanted);
        let mut drained: Vec<Value> = Vec::new();
        for order in orders {
            let told = &state["orders"][order];
            assert_eq!(told["bit_equal_to_fresh"], true, "{order}");
            let noticed = array(told, "noticed");
            assert_eq!(noticed[noticed.len() - 1], 0.0, "{order}: exact light differs in nothing");
            let complete = told["complete_for_the_eye"]["rays"].as_u64().expect("a number");
            let at = array(&told["readouts"]["raw"], "curve").iter().position(|p| p["rays"] == complete).expect("a checkpoint");
            assert!(noticed[at..].iter().all(|share| share.as_f64() <= Some(1e-3)), "{order}");
            assert!(noticed[0].as_f64() > Some(0.01) && noticed[at - 1].as_f64() > Some(1e-3), "{order}: {noticed:?}");
            assert_eq!(keys(&told["readouts"]), ["raw", "reconstructed"]);
            let raw = &told["readouts"]["raw"];
            let nrmse = |readout: &str| told["readouts"][readout]["drained"]["nrmse"].as_f64().expect("a number");
            assert!(nrmse("reconstructed") < nrmse("raw"), "{order}");
            assert_eq!(keys(raw), ["curve", "drained", "near_drained"]);
            let curve = array(raw, "curve");
            assert!(curve.len() >= 4, "{order}: {} checkpoints", curve.len());
            assert_eq!(curve.last(), Some(&raw["drained"]));
            let rays: Vec<u64> = curve.iter().map(|p| p["rays"].as_u64().expect("a number")).collect();
            assert!(rays[0] == 0 && rays.is_sorted_by(|a, b| a < b), "{order}: {rays:?}");
            assert!(raw["near_drained"]["rays"].as_f64().expect("a number") <= rays[rays.len() - 1] as f64);
            let mut last = raw["drained"].clone();
            ["photons", "rays", "replayed", "seconds"].iter().for_each(|key| {
                last.as_object_mut().expect("an object").remove(*key);
            });
            assert_eq!(keys(&last), ["flip", "median", "nrmse", "percentile_95", "relmse", "visible"]);
            drained.push(last);
        }
        // The same light has the same errors, and few photons have some.
        assert!(drained.windows(2).all(|pair| pair[0] == pair[1]), "{drained:?}");
        let nrmse = drained[0]["nrmse"].as_f64().expect("a number");
        assert!((0.01..1.0).contains(&nrmse), "{nrmse}");
    }
    let restart = array(&states[1]["orders"]["restart"]["readouts"]["raw"], "curve");
    assert_eq!(restart[0]["median"], 1.0, "before the first photon all light is missing");

    let mut files =
        vec!["curves.csv", "index.html", "summary.json", "table.csv"].into_iter().map(str::to_owned).collect::<Vec<_>>();
    for state in ["cold", "a_move_0", "b_turn_0"] {
        files.extend(
            ["nrmse", "others"].iter().flat_map(|kind| ["png", "svg"].map(|e| format!("{}_{state}_{kind}.{e}", stem(scene)))),
        );
        files.push(format!("{}_{state}_noticed.png", stem(scene)));
    }
    files.sort();
    assert_eq!(desk.names("out"), files);
    let page = desk.read("out/index.html");
    assert!(!page.replace("http://www.w3.org/2000/svg", "").contains("http"), "a link");
    assert!(page.contains("</html>") && page.matches("<svg").count() == 6);
    assert_eq!(
        desk.read("out/table.csv").lines().count(),
        1 + 2 * (2 + 4 + 4),
        "a header, and each order twice: raw and reconstructed"
    );
}

fn stem(scene: &Value) -> String {
    scene["scene"].as_str().expect("a name").replace(' ', "_")
}

#[test]
fn errors_against_rays_do_not_depend_on_threads() {
    let desk = desk();
    let run = |threads: u32| {
        desk.done(&format!(
            "report box/box.ron --script box/moves/a_move.ron {SMALL} --quiet --threads {threads} --out out{threads}"
        ));
        timeless(desk.json(&format!("out{threads}/summary.json")))
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(array(&one["scenes"][0], "states").len(), 2);
    assert!(one == three, "one and three threads differ");
}

#[test]
fn a_scene_without_moves_gets_the_cold_start() {
    let desk = Desk::new();
    let said = desk.done(&format!("report cornell.ron {SMALL} --orders stateless --out out"));
    assert!(said.contains("cold start") && said.contains("index.html"), "{said}");
    let summary = desk.json("out/summary.json");
    let states = array(&summary["scenes"][0], "states");
    assert_eq!(states.len(), 1);
    assert_eq!(keys(&states[0]["orders"]), ["no ledger"]);
}

#[test]
fn bad_input_is_told_before_any_work() {
    let desk = desk();
    desk.refuses("report --out out", &["<SCENE>"]);
    desk.refuses("report box/box.ron", &["--out <DIR>"]);
    desk.refuses("report box/box.ron absent.ron --out out", &["absent.ron"]);
    desk.refuses("report box/box.ron --out out --orders oracle", &["'oracle'", "ledger, stateless, random, restart"]);
    for number in ["19999", "99999999999999999"] {
        let told = format!("report box/box.ron --photons 20000 --reference-photons {number} --out out");
        desk.refuses(&told, &["--reference-photons", number, "20000"]);
    }
    desk.refuses("report box/box.ron --reference-photons -1 --out out", &["--reference-photons", "'-1'"]);
    desk.write("bad.ron", "(edits: [(at: 0.0, edit: Move(object: \"short bo\", to: (1.5, 0.45, 0.0)))])");
    desk.refuses("report box/box.ron --script bad.ron --out out", &["bad.ron", "'short bo'", "did you mean 'short box'?"]);
    desk.write("box/moves/c.ron", "(edits: [");
    desk.refuses("report cornell.ron box/box.ron --out out", &["c.ron"]);
}

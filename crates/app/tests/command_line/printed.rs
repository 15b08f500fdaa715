//! What scripts rely on: the JSON on standard output, silence, keys, headers, and warnings that come once.

use crate::desk::Desk;
use serde_json::Value;

/// A desk with what every command needs.
fn desk() -> Desk {
    let desk = Desk::new();
    desk.moves(&["Move(object: \"short box\", to: (1.5, 0.45, 0.0))", "Turn(object: \"tall box\", to: (0.0, 0.0, 48.0))"]);
    desk.write("points.csv", "x,y,z,nx,ny,nz\n1,0.2,0,0,0,1\n0,1,1,1,0,0\n");
    desk
}

const COMMANDS: [&str; 7] = [
    "solve cornell.ron --photons 20000 --out solved --dump solved.tsv",
    "replay cornell.ron --photons 20000 --script m.ron --out replayed --dump replayed.tsv",
    "apply cornell.ron --script m.ron --out after.ron",
    "probe cornell.ron --photons 20000 --points points.csv --out read.csv",
    "check cornell.ron",
    "import box.obj --out new.ron --reflectance white=0.7,0.7,0.7 --lamp 1,1,1,100",
    "reference cornell.ron --points points.csv --out traced.csv --paths 1000",
];

#[test]
fn json_is_one_document_and_nothing_else() {
    let desk = desk();
    for command in COMMANDS {
        let told = desk.run(&format!("{command} --json"));
        assert_eq!(told.status, Some(0), "{command}: {}", told.stderr);
        // `from_str` refuses anything but white space before and after the document.
        let value: Value = serde_json::from_str(&told.stdout).unwrap_or_else(|e| panic!("{command}: {e}: {}", told.stdout));
        assert!(value.is_object(), "{command}");
    }
    for (folder, command) in [("solved", COMMANDS[0]), ("replayed", COMMANDS[1])] {
        let printed: Value = serde_json::from_str(&desk.done(&format!("{command} --json"))).expect("one JSON document");
        assert_eq!(printed, desk.json(&format!("{folder}/summary.json")), "{command}");
    }
}

#[test]
fn quiet_prints_nothing() {
    let desk = desk();
    for command in COMMANDS {
        assert_eq!(desk.done(&format!("{command} --quiet")), "", "{command}");
    }
}

#[test]
fn results_are_named_on_standard_output() {
    let desk = desk();
    for (command, result) in
        COMMANDS.iter().zip(["solved/front.png", "replayed/recovery.png", "after.ron", "read.csv", "", "new.ron", "traced.csv"])
    {
        let run = desk.run(command);
        assert!(run.status == Some(0) && run.stdout.contains(result), "{command}: {}", run.stdout);
        assert!(result.is_empty() || desk.path(result).is_file(), "{command}");
    }
}

#[test]
fn help_and_version_are_no_failures() {
    let desk = Desk::new();
    assert!(desk.done("--version").starts_with("lightmend "));
    for command in ["", "solve", "frames", "replay", "apply", "probe", "check", "import", "reference"] {
        let help = desk.done(&format!("{command} --help"));
        assert!(help.contains("Usage: lightmend"), "{help}");
    }
}

#[test]
fn replay_keeps_the_contract() {
    let desk = desk();
    desk.done(&format!("{} --quiet --threads 2", COMMANDS[1]));
    let summary = desk.json("replayed/summary.json");
    assert_eq!((&summary["scene"], &summary["photons"], &summary["threads"]), (&"cornell".into(), &20_000.into(), &2.into()));
    let edits = summary["edits"].as_array().expect("edits");
    assert_eq!(edits.len(), 2);
    for (number, edit) in edits.iter().enumerate() {
        assert_eq!(edit["edit"], number);
        let relevant = edit["relevant_photons"].as_u64().expect("a number");
        assert!(relevant > 0 && relevant < 20_000);
        let orders = edit["orders"].as_object().expect("orders");
        assert_eq!(orders.keys().collect::<Vec<_>>(), ["ledger", "oracle", "random", "restart", "stateless"]);
        for (order, told) in orders {
            for unit in ["photons", "rays", "seconds"] {
                let reached = ["50", "90", "99", "100"].map(|share| told[unit][share].as_f64().expect("a number"));
                assert!(reached.is_sorted() && reached[3] > 0.0, "{order}, {unit}: {reached:?}");
            }
            assert_eq!(told["bit_equal_to_fresh"], true, "{order}");
        }
        let ledger = &orders["ledger"];
        let numbers = ["scan_seconds", "marked_photons", "bytes"].map(|what| ledger[what].as_f64().expect("a number"));
        assert!(numbers.iter().all(|n| *n > 0.0) && ledger["replayed"]["100"].as_u64() > Some(0));
        assert!(ledger["rays"]["100"].as_u64() < orders["oracle"]["rays"]["100"].as_u64());
        // The limit of re-shooting: exactly the relevant photons.
        assert_eq!(orders["oracle"]["photons"]["100"], relevant);
    }
    for name in ["recovery.csv", "recovery.svg", "recovery.png"] {
        assert!(desk.path(&format!("replayed/{name}")).is_file(), "{name}");
    }
}

#[test]
fn orders_are_those_asked_for() {
    let desk = desk();
    desk.done("replay cornell.ron --photons 20000 --script m.ron --out out --quiet --orders random,oracle,random");
    let summary = desk.json("out/summary.json");
    let orders = summary["edits"][0]["orders"].as_object().expect("orders");
    assert_eq!(orders.keys().collect::<Vec<_>>(), ["oracle", "random"]);
    let header = "edit,order,photons,rays,seconds,repaired,relevant,replayed";
    let csv = desk.read("out/recovery.csv");
    assert_eq!(csv.lines().next(), Some(header));
    let ends = csv.lines().filter(|l| l.starts_with("0,random,0,")).count();
    assert!(ends <= 1, "an order named twice is run once");
}

#[test]
fn points_keep_the_contract() {
    let desk = desk();
    for (command, file) in [(COMMANDS[3], "read.csv"), (COMMANDS[6], "traced.csv")] {
        desk.done(command);
        let read = desk.read(file);
        let mut lines = read.lines();
        let header = "x,y,z,nx,ny,nz,direct_r,direct_g,direct_b,indirect_r,indirect_g,indirect_b,\
                      indirect_se_r,indirect_se_g,indirect_se_b,illuminance";
        assert_eq!(lines.next(), Some(header));
        let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|v| v.parse().expect("a number")).collect()).collect();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[1][..6], [0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
        // The floor at (1, 0.2): the lamp, 1.9 m above and 0.8 m aside, is in sight.
        let squared = 1.9f64 * 1.9 + 0.8 * 0.8;
        let direct = [170.0, 155.0, 125.0].map(|cd| cd * 1.9 / squared.powf(1.5));
        assert!(rows[0][6..9].iter().zip(direct).all(|(v, expected)| (v - expected).abs() < 1e-3), "{:?} {direct:?}", rows[0]);
        for row in &rows {
            let sum = |c: usize| row[6 + c] + row[9 + c];
            let illuminance = 0.2126 * sum(0) + 0.7152 * sum(1) + 0.0722 * sum(2);
            assert!((row[15] - illuminance).abs() < 1e-4, "{row:?}");
            assert!(row[9..15].iter().all(|v| *v > 0.0), "{row:?}");
        }
    }
}

#[test]
fn solving_goes_on_to_the_error_that_is_asked_for() {
    let desk = desk();
    let solve = |error: &str| -> Value {
        serde_json::from_str(&desk.done(&format!("solve cornell.ron --error {error} --json"))).expect("JSON")
    };
    let (coarse, fine) = (solve("0.1"), solve("0.05"));
    let [error, finer] = [&coarse, &fine].map(|told| told["median_error"].as_f64().expect("a number"));
    assert!(error <= 0.1 && (0.03..=0.05).contains(&finer), "{error} {finer}");
    assert!(coarse["photons"].as_u64() <= fine["photons"].as_u64());
}

#[test]
fn reference_goes_on_to_the_error_that_is_asked_for() {
    let desk = desk();
    let told =
        |command: &str| -> Value { serde_json::from_str(&desk.done(&format!("{command} --json"))).expect("one JSON document") };
    let reached = told("reference cornell.ron --points points.csv --out traced.csv --error 0.02");
    assert!(reached["worst_relative_error"].as_f64() <= Some(0.02) && reached["missed"] == 0, "{reached}");
    let capped = told("reference cornell.ron --points points.csv --out traced.csv --error 0.001 --paths 10000");
    assert!(capped["missed"] == 2 && capped["paths"] == 2 * 10_240, "{capped}");
}

#[test]
fn warnings_come_once() {
    let desk = Desk::new();
    // Parts of one file with the same missing material and a missing material file.
    let walls = desk.read("box.obj");
    desk.write("box.obj", format!("mtllib gone.mtl\n{walls}"));
    desk.change("\"white\": (reflectance: (0.725, 0.71, 0.68)),", "");
    for command in ["check cornell.ron", "solve cornell.ron --photons 20000", "solve cornell.ron --photons 20000 --json"] {
        let run = desk.run(command);
        assert_eq!(run.status, Some(0), "{}", run.stderr);
        let lines: Vec<&str> = run.stderr.lines().collect();
        assert!(lines.iter().all(|l| l.starts_with("warning: ")), "{}", run.stderr);
        // The file that is gone, and the one material that nobody defines; red and green are in the scene file.
        assert_eq!(lines.len(), 2, "{command}: {}", run.stderr);
        assert!(lines[0].contains("box.obj") && lines[0].contains("`gone.mtl`"), "{}", run.stderr);
        assert!(lines[1].contains("cornell.ron") && lines[1].contains("'white' is defined nowhere"), "{}", run.stderr);
    }
    let run = desk.run("check cornell.ron --quiet");
    assert_eq!((run.status, run.stderr.as_str()), (Some(0), ""), "silence includes warnings");
}

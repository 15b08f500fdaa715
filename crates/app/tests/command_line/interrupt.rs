//! Ctrl-C keeps what is done.

use crate::desk::Desk;
use std::{
    process::{Child, Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

/// Far more than an interrupted run needs, even beside other work; far less than the whole run.
const PATIENCE: Duration = Duration::from_secs(60);

/// Starts a run, waits until it is under way, presses Ctrl-C and waits for its end. Returns its status, standard output and standard
/// error.
fn interrupted(desk: &Desk, arguments: &str) -> (Option<i32>, String, String) {
    let mut child = desk.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program runs");
    until(&mut child, |child| listens(child.id()));
    sleep(Duration::from_millis(300));
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(kill.success());
    until(&mut child, |child| child.try_wait().expect("the program can be waited for").is_some());
    let output = child.wait_with_output().expect("the program has ended");
    let text = |bytes| String::from_utf8(bytes).expect("the program prints UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Whether a process catches Ctrl-C: signal 2 in the mask that Linux tells of it.
fn listens(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0");
    u64::from_str_radix(mask.trim(), 16).expect("a hexadecimal number") & 0b10 != 0
}

fn until(child: &mut Child, done: impl Fn(&mut Child) -> bool) {
    let start = Instant::now();
    while !done(child) {
        if start.elapsed() > PATIENCE {
            let _ = child.kill();
            panic!("still waiting after {PATIENCE:?}");
        }
        sleep(Duration::from_millis(20));
    }
}

/// A run that Ctrl-C ended: it failed, says so in one line, and left no half file.
fn ended_cleanly(desk: &Desk, status: Option<i32>, stderr: &str) {
    assert_eq!(status, Some(1), "{stderr}");
    assert!(stderr.starts_with("lightmend: interrupted") && stderr.lines().count() == 1, "{stderr}");
    no_half_file(desk);
}

/// A script that moves a box to and fro, 400 edits.
fn to_and_fro(desk: &Desk) {
    let there_and_back =
        ["Move(object: \"short box\", to: (1.5, 0.45, 0.0))", "Move(object: \"short box\", to: (1.32, 0.68, 0.0))"];
    desk.moves(&there_and_back.repeat(200));
}

fn no_half_file(desk: &Desk) {
    let parts: Vec<_> = desk.content().into_keys().filter(|p| p.extension().is_some_and(|e| e == "part")).collect();
    assert!(parts.is_empty(), "{parts:?}");
}

#[test]
fn solve_keeps_its_photons() {
    let desk = Desk::new();
    let (status, stdout, stderr) = interrupted(&desk, "solve cornell.ron --photons 2000000000 --out out --dump dump.tsv --json");
    assert_eq!(status, Some(1), "{stderr}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    assert!(stderr.starts_with("lightmend: interrupted; "), "{stderr}");
    let summary = desk.json("out/summary.json");
    assert_eq!(summary["interrupted"], true);
    assert_eq!(serde_json::from_str::<serde_json::Value>(&stdout).expect("one JSON document"), summary);
    assert!(desk.path("out/front.png").is_file());
    no_half_file(&desk);
    // What was kept is the whole truth about that many photons.
    let photons = summary["photons"].as_u64().expect("a number");
    assert!(photons > 0 && photons < 2_000_000_000);
    desk.done(&format!("solve cornell.ron --photons {photons} --quiet --dump again.tsv"));
    assert!(desk.read("again.tsv") == desk.read("dump.tsv"), "{photons} photons");
}

#[test]
fn replay_keeps_whole_edits() {
    let desk = Desk::new();
    to_and_fro(&desk);
    let (status, _, stderr) =
        interrupted(&desk, "replay cornell.ron --photons 200000 --orders stateless --script m.ron --out out --quiet");
    ended_cleanly(&desk, status, &stderr);
    // Either the initial light was not yet done, and nothing is kept, or the edits so far are.
    if desk.path("out/summary.json").exists() {
        let summary = desk.json("out/summary.json");
        assert_eq!(summary["interrupted"], true);
        assert!(summary["edits"].as_array().expect("edits").len() < 400);
    }
}

#[test]
fn report_keeps_whole_states() {
    let desk = Desk::new();
    to_and_fro(&desk);
    let (status, _, stderr) =
        interrupted(&desk, "report cornell.ron --photons 20000 --orders stateless --script m.ron --out out --quiet");
    ended_cleanly(&desk, status, &stderr);
    // Either the first state was not yet done, and nothing is kept, or the states so far are.
    if desk.path("out/summary.json").exists() {
        let summary = desk.json("out/summary.json");
        assert_eq!(summary["interrupted"], true);
        let states = summary["scenes"][0]["states"].as_array().expect("states").len();
        assert!((1..401).contains(&states) && desk.read("out/index.html").matches("<h3>").count() == states);
    }
}

#[test]
fn frames_keeps_whole_frames() {
    let desk = Desk::new();
    desk.script(&[(10_000.0, "Move(object: \"short box\", to: (1.5, 0.45, 0.0))")], &[]);
    let (status, stdout, stderr) =
        interrupted(&desk, "frames cornell.ron --size 64x48 --photons 20000 --script m.ron --out out --json");
    ended_cleanly(&desk, status, &stderr);
    // Either the initial light was not yet done, and nothing is kept, or the frames so far are.
    if desk.path("out/summary.json").exists() {
        let summary = desk.json("out/summary.json");
        assert_eq!(summary["interrupted"], true);
        assert_eq!(serde_json::from_str::<serde_json::Value>(&stdout).expect("one JSON document"), summary);
        let frames = summary["frames"].as_array().expect("frames");
        for frame in frames {
            desk.picture(&format!("out/{}", frame["file"].as_str().expect("a name")));
        }
        let drawn = desk.names("out").into_iter().filter(|name| name.starts_with("frame_")).count();
        assert_eq!(drawn, frames.len());
        assert!(stderr.contains(&format!("{drawn} finished frame")), "{stderr}");
    }
}

#[test]
fn reference_keeps_points_that_are_known() {
    let desk = Desk::new();
    let points = "1,0.2,0,0,0,1\n".repeat(50);
    desk.write("points.csv", format!("x,y,z,nx,ny,nz\n{points}"));
    let (status, stdout, stderr) =
        interrupted(&desk, "reference cornell.ron --points points.csv --paths 100000000 --out read.csv --json");
    ended_cleanly(&desk, status, &stderr);
    // Either no point had enough batches, and nothing is kept, or those that had are.
    if desk.path("read.csv").exists() {
        let rows = desk.read("read.csv").lines().count() - 1;
        let summary: serde_json::Value = serde_json::from_str(&stdout).expect("one JSON document");
        assert!(summary["points"] == rows && rows >= 1, "{summary}");
        assert!(stderr.contains(&format!("{rows} of 50 points")), "{stderr}");
    }
}

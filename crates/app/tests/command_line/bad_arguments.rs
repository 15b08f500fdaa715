//! Arguments that cannot be meant.

use crate::desk::Desk;

#[test]
fn unknown_arguments() {
    Desk::new().refuses("solve cornell.ron --fotons 20000", &["'--fotons'", "'--photons'", "--help"]);
    Desk::new().refuses("mend cornell.ron", &["'mend'", "--help"]);
    Desk::new().refuses("replay cornell.ron", &["--script <MOVES>", "--out <DIR>"]);
    Desk::new().refuses(
        "replay cornell.ron --script m.ron --out out --orders backwards",
        &["'backwards'", "stateless, random, oracle, restart"],
    );
}

#[test]
fn pool_smaller_than_its_groups() {
    let desk = Desk::new();
    for photons in [0, 1151] {
        desk.refuses(&format!("solve cornell.ron --photons {photons} --dump d"), &["--photons", "at least 1152"]);
    }
    desk.refuses("solve cornell.ron --photons 20000 --ng 1000 --r 100", &["--photons", "at least 100000"]);
    desk.refuses("solve cornell.ron --photons -5", &["--photons", "'-5'"]);
    desk.refuses("solve cornell.ron --photons 99999999999999", &["--photons", "too many", "limit"]);
    desk.refuses("solve cornell.ron --ng 0", &["--ng", "'0'"]);
    desk.done("solve cornell.ron --photons 1152");
}

#[test]
fn impossible_numbers() {
    let desk = Desk::new();
    for seconds in ["-1", "0", "nan", "inf", "soon"] {
        desk.refuses(&format!("solve cornell.ron --seconds {seconds}"), &["--seconds"]);
    }
    desk.refuses("solve cornell.ron --seconds 1 --photons 20000", &["--seconds", "--photons"]);
    for error in ["0", "-1", "some"] {
        desk.refuses(&format!("solve cornell.ron --error {error}"), &["--error", error]);
    }
    desk.refuses("solve cornell.ron --error 0.1 --photons 20000", &["--error", "--photons"]);
    desk.refuses("solve cornell.ron --threads 0", &["--threads", "'0'"]);
    desk.write("points.csv", "x,y,z,nx,ny,nz\n1,0.2,0,0,0,1\n");
    for error in ["0", "1", "-1", "nan", "some"] {
        desk.refuses(&format!("reference cornell.ron --points points.csv --out r.csv --error {error}"), &["--error", error]);
    }
    for paths in ["0", "-5", "99999999999999", "many"] {
        desk.refuses(&format!("reference cornell.ron --points points.csv --out r.csv --paths {paths}"), &["--paths", paths]);
    }
}

#[test]
fn impossible_imports() {
    let desk = Desk::new();
    let refused = |argument: &str, told: &[&str]| desk.refuses(&format!("import box.obj --out new.ron --quiet {argument}"), told);
    for lamp in ["1,2,3", "1,2,3,4,5", "a,2,3,4", "1,2,3,nan", "1;2;3;4"] {
        refused(&format!("--lamp {lamp}"), &["--lamp", lamp, "4 numbers"]);
    }
    refused("--lamp 1,2,3,-4", &["--lamp", "-4 candela"]);
    for scale in ["-1", "0", "nan"] {
        refused(&format!("--scale {scale}"), &["--scale", "positive"]);
    }
    refused("--scale 1e9", &["--scale", "1e6 m"]);
    refused("--cell -0.1", &["--cell", "positive"]);
    refused("--up x", &["--up", "'x'"]);
    refused("--reflectance white=2,2,2", &["--reflectance", "0 to 1"]);
    refused("--reflectance floo=0.5,0.5,0.5", &["--reflectance", "'floo'", "did you mean 'floor'?"]);
    refused("--movable ceilin", &["--movable", "'ceilin'", "did you mean 'ceiling'?"]);
}

//! Points that cannot be probed.

use crate::desk::Desk;

const COMMANDS: [&str; 2] = [
    "probe cornell.ron --points points.csv --out read.csv --photons 20000",
    "reference cornell.ron --points points.csv --out read.csv --paths 1000",
];

fn refused(points: impl AsRef<[u8]>, told: &[&str]) {
    let desk = Desk::new();
    desk.write("points.csv", points);
    COMMANDS.iter().for_each(|command| desk.refuses(command, told));
}

#[test]
fn missing_file() {
    COMMANDS.iter().for_each(|command| Desk::new().refuses(command, &["points.csv", "No such file"]));
}

#[test]
fn bad_header() {
    for points in ["", "x,y,z\n1,1,0\n", "1,1,0,0,0,1\n"] {
        refused(points, &["points.csv:1:", "x,y,z,nx,ny,nz"]);
    }
}

#[test]
fn bad_lines() {
    for line in ["1,1,0,0,0", "1,1,0,0,0,1,7", "1,1,0,0,0,up"] {
        refused(format!("x,y,z,nx,ny,nz\n1,0.2,0,0,0,1\n{line}\n"), &["points.csv:3:", "six numbers"]);
    }
    for line in ["1,1,0,0,0,2", "1,1,nan,0,0,1", "1,1,0,0,0,nan"] {
        refused(format!("x,y,z,nx,ny,nz\n{line}\n"), &["points.csv:2:", "the normal must have length 1"]);
    }
    refused(b"\xff\xfe", &["points.csv", "UTF-8"]);
}

#[test]
fn far_from_any_surface() {
    refused("x,y,z,nx,ny,nz\n1,0.2,0,0,0,1\n1,1,0.5,0,0,1\n", &["points.csv:3:", "no surface", "[1, 1, 0.5]", "move the point"]);
}

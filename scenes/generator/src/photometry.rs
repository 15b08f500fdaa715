//! Photometric files of lamps that do not exist: IESNA LM-63-2002, type C, absolute candela.
//!
//! Six lobes that between them use every symmetry a reader meets: axial ones that end at 90°, axial ones over the whole sphere, one
//! of four equal quadrants, and one that is symmetric about the plane C = 0–180 only.

/// A luminous intensity distribution: file name, what it is, C angles, last γ in degrees, and candela of (C, γ) in degrees.
pub struct Diagram {
    /// File name without its ending.
    pub name: &'static str,
    what: &'static str,
    /// Diameter of the round opening, metres.
    diameter: f64,
    c: Vec<f64>,
    gamma_end: f64,
    candela: fn(f64, f64) -> f64,
}

/// The diagrams of the house.
pub fn house() -> Vec<Diagram> {
    vec![
        Diagram {
            name: "panel",
            what: "square ceiling panel, four quadrants, 520 cd straight down, 900 cd at 45 degrees along C = 0",
            diameter: 0.5,
            c: (0..=9).map(|i| 10.0 * i as f64).collect(),
            gamma_end: 90.0,
            // A Lambertian panel whose grooves throw more light to its ends than to its sides.
            candela: |c, g| cos(g) * (520.0 + (1500.0 * cos(c).powi(2) + 700.0 * sin(c).powi(2)) * sin(g).powi(2)),
        },
        Diagram {
            name: "standing",
            what: "standing lamp with a shade open above and below, 330 cd down, 420 cd up, 60 cd to the sides",
            diameter: 0.06,
            c: vec![0.0],
            gamma_end: 180.0,
            candela: |_, g| 60.0 + if g < 90.0 { 270.0 * cos(g) } else { 360.0 * -cos(g) },
        },
    ]
}

/// The diagrams of the room.
pub fn room() -> Vec<Diagram> {
    vec![
        Diagram {
            name: "diffuser",
            what: "ceiling diffuser, Lambertian, 900 cd straight down",
            diameter: 0.4,
            c: vec![0.0],
            gamma_end: 90.0,
            candela: |_, g| 900.0 * cos(g),
        },
        Diagram {
            name: "pendant",
            what: "pendant with an open top, 420 cd down and 180 cd up",
            diameter: 0.36,
            c: vec![0.0],
            gamma_end: 180.0,
            // The small constant is what shines through the shade's seam: the diagram has no hole at 90 degrees.
            candela: |_, g| 420.0 * cos(g).max(0.0).powf(1.5) + 180.0 * (-cos(g)).max(0.0).powi(2) + 8.0,
        },
        Diagram {
            name: "reading",
            what: "reading lamp, axial downlight, cos^4, 480 cd straight down",
            diameter: 0.3,
            c: vec![0.0],
            gamma_end: 90.0,
            candela: |_, g| 480.0 * cos(g).powi(4),
        },
        Diagram {
            name: "washer",
            what: "wall washer, lobe of 900 cd leant by 35 degrees towards C = 0",
            diameter: 0.12,
            c: (0..=18).map(|i| 10.0 * i as f64).collect(),
            gamma_end: 90.0,
            // The cosine of the angle to the lobe's axis, which lies at (C 0, gamma 35), and a skirt that goes to zero at 90 degrees.
            candela: |c, g| {
                let axis = cos(35.0) * cos(g) + sin(35.0) * sin(g) * cos(c);
                cos(g).sqrt() * (900.0 * axis.max(0.0).powi(6) + 90.0 * cos(g))
            },
        },
    ]
}

fn cos(degrees: f64) -> f64 {
    // cos 90° is 6e-17, and its square root would no longer print as zero.
    if degrees == 90.0 { 0.0 } else { degrees.to_radians().cos() }
}

fn sin(degrees: f64) -> f64 {
    degrees.to_radians().sin()
}

impl Diagram {
    /// The text of the file: γ in steps of 5°, one line of candela per C plane.
    pub fn ies(&self) -> String {
        let gammas: Vec<f64> = (0..=(self.gamma_end / 5.0) as usize).map(|i| 5.0 * i as f64).collect();
        let line = |values: &mut dyn Iterator<Item = String>| values.collect::<Vec<_>>().join(" ") + "\n";
        let mut s = String::from("IESNA:LM-63-2002\n");
        s += &format!(
            "[TEST] computed, no measurement\n[TESTLAB] lightmend-scenes\n[ISSUEDATE] 2026-01-01\n[MANUFAC] Lightmend\n[LUMINAIRE] {}\nTILT=NONE\n",
            self.what
        );
        // One lamp, absolute photometry (-1), factor 1, type C (1), metres (2), a round opening (negative width, length 0).
        s += &format!("1 -1 1 {} {} 1 2 -{} 0 0\n1 1 {}\n", gammas.len(), self.c.len(), self.diameter, 20);
        s += &line(&mut gammas.iter().map(|g| format!("{g:.0}")));
        s += &line(&mut self.c.iter().map(|c| format!("{c:.0}")));
        for &c in &self.c {
            s += &line(&mut gammas.iter().map(|&g| format!("{:.2}", (self.candela)(c, g))));
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_hold_as_many_candela_as_they_announce() {
        for d in room().into_iter().chain(house()) {
            let text = d.ies();
            let (_, numbers) = text.split_once("TILT=NONE\n").expect("a tilt line");
            let numbers: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().expect("a number")).collect();
            let (v, h) = (numbers[3] as usize, numbers[4] as usize);
            assert_eq!(numbers.len(), 13 + v + h + v * h, "{}", d.name);
            assert!(numbers[13 + v + h..].iter().all(|&c| (0.0..2000.0).contains(&c)), "{}", d.name);
            assert!(text.lines().all(|l| l.len() <= 256), "{}", d.name);
        }
    }
}

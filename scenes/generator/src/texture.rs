//! The rug's picture, a woven pattern in four yarns, and the paper of the papered room, written as PNG.

use std::io::Cursor;

use image::{ImageError, ImageFormat, RgbImage};

const SIDE: u32 = 256;

/// sRGB bytes of the yarns: ground, border, figure, accent.
const YARNS: [[u8; 3]; 4] = [[148, 52, 46], [36, 52, 92], [222, 200, 160], [196, 140, 62]];

/// The PNG file of the rug: 256 × 256, sRGB.
///
/// # Errors
/// When the encoder fails.
pub fn rug() -> Result<Vec<u8>, ImageError> {
    let picture = RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let yarn = YARNS[yarn(x as i32, y as i32)];
        // Over and under: the weave lies two threads in the light, two in the shade.
        let shade = if (x / 2 + y / 2) % 2 == 0 { 1.0 } else { 0.88 };
        image::Rgb(yarn.map(|c| (c as f64 * shade).round() as u8))
    });
    png(&picture)
}

/// The PNG file of a paper of two by two checks, with stripes within: 256 × 256, sRGB.
///
/// # Errors
/// When the encoder fails.
pub fn checks() -> Result<Vec<u8>, ImageError> {
    const INKS: [[u8; 3]; 2] = [[232, 222, 200], [96, 112, 104]];
    let picture = RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let shade = if x / 4 % 2 == 0 { 1.0 } else { 0.92 };
        image::Rgb(INKS[((2 * x / SIDE + 2 * y / SIDE) % 2) as usize].map(|c| (f64::from(c) * shade).round() as u8))
    });
    png(&picture)
}

fn png(picture: &RgbImage) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// Which yarn lies on top: a border with a zigzag, a field of small diamonds and three large ones.
fn yarn(x: i32, y: i32) -> usize {
    let last = SIDE as i32 - 1;
    // Knots are four pixels wide, so edges are stepped as in a real carpet.
    let (kx, ky) = (x / 4 * 4, y / 4 * 4);
    let edge = kx.min(last - x / 4 * 4 - 3).min(ky).min(last - y / 4 * 4 - 3);
    let along = if kx.min(last - kx) < ky.min(last - ky) { ky } else { kx };
    match edge {
        0..8 => 1,
        8..12 => 2,
        12..36 => {
            let zigzag = (along % 24 - 12).abs() + 16;
            if (edge - zigzag).abs() <= 3 { 3 } else { 1 }
        }
        36..40 => 2,
        _ => {
            let large = (0..3).map(|i| (kx - 64 - 64 * i).abs() * 3 / 2 + (ky - 128).abs() / 2).min().unwrap_or(0);
            let small = (kx % 32 - 16).abs() + (ky % 32 - 16).abs();
            match large {
                0..8 => 3,
                8..16 => 1,
                16..28 => 2,
                28..32 => 1,
                _ if small <= 4 => 2,
                _ => 0,
            }
        }
    }
}

//! One hash for everything that must look random and be the same everywhere.

/// splitmix64's output function (Steele, Lea, Flood 2014).
#[inline]
pub fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A hash of a name.
pub fn of_name(name: &str) -> u64 {
    name.bytes().fold(mix(name.len() as u64), |hash, byte| mix(hash ^ u64::from(byte)))
}

/// Fisher–Yates with a fixed seed.
pub fn shuffle<T>(things: &mut [T]) {
    let mut state = 0x5eed;
    for i in (1..things.len()).rev() {
        state = mix(state);
        things.swap(i, (state % (i as u64 + 1)) as usize);
    }
}
